"""The command `flatpunch design`: numbers of a case that give a prescribed contact or the largest load."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from flatpunch.cli.examples import examples
from flatpunch.cli.terminal import StyleOption, friendly, progress, say, say_written

if TYPE_CHECKING:
    from flatpunch.contact import Method, MethodName
    from flatpunch.design import Design
    from flatpunch.files import Case


def add_commands(app: typer.Typer) -> None:
    """Register the command on the command line."""

    @app.command(epilog=examples("design"))
    def design(
        case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)],
        csv: Annotated[Path | None, typer.Option(help="Table of the numbers found as CSV.")] = None,
        plot: Annotated[Path | None, typer.Option(help="Picture: .png, .pdf or .svg.")] = None,
        style: StyleOption = "screen",
    ) -> None:
        """Find the numbers of a case that give what its table [bold]design[/bold] prescribes.

        A force, depth, stiffness or contact radius, at one load or along a curve; or the largest load before failure.
        """
        with friendly():
            from flatpunch._support.whole_file import check_target

            check_target("--csv", csv, (".csv",))
            check_target("--plot", plot, (".png", ".pdf", ".svg"))
            from flatpunch.files import read_case

            _run(read_case(case), csv, plot, style)


def _run(case: Case, csv: Path | None, plot: Path | None, style: str) -> None:
    from flatpunch.design import design

    asked = case.design
    if asked is None:
        raise ValueError("the case has no table [design]; it names what to vary and what is prescribed.")
    written: list[Path] = []
    steps = asked.starts + sum(path is not None for path in (csv, plot))
    with progress(case.title or "Design", steps) as step:
        found = design(
            case.medium,
            case.indenter,
            vary=asked.vary,
            objective=asked.objective,
            limits=asked.limits,
            starts=asked.starts,
            method=None if case.indenter.round else _method(case),
            progress=lambda done, total: step(f"start {done} of {total}"),
        )
        if csv is not None:
            step(f"writing {csv.name}")
            written.append(_table(found, csv))
        if plot is not None:
            step(f"drawing {plot.name}")
            written.append(_draw(case, found, plot, style))
    _print(case, found)
    say_written(written)


def _method(case: Case) -> Method | MethodName | None:
    """All but the refined method have derivatives under tips that are not round."""
    from flatpunch.contact import method_of

    if case.method is None:
        return None
    chosen = method_of(case.method)
    return None if chosen.name == "refined" else chosen


def _table(found: Design, path: Path) -> Path:
    """Write a line for each varied number, SI."""
    import pandas as pd

    from flatpunch._support.whole_file import whole_file

    columns = ("name", "unit", "start", "found", "low", "high", "at_bound")
    rows = [[getattr(each, column) for column in columns] for each in found.values]
    with whole_file(path) as temporary:
        pd.DataFrame(rows, columns=list(columns)).to_csv(temporary, index=False, lineterminator="\n")
    return path


def _draw(case: Case, found: Design, plot: Path, style: str) -> Path:
    from flatpunch.plots.design import figure
    from flatpunch.plots.result import save_figure

    return save_figure(figure(found, title=case.title, style=style), plot)


def _print(case: Case, found: Design) -> None:
    from rich.table import Table

    table = Table(title=case.title or "Design", title_justify="left", caption=f"{found.evaluations} contacts solved")
    for heading in ("number", "start", "found", "bounds", "at"):
        table.add_column(heading, justify="left" if heading in ("number", "at") else "right")
    for each in found.values:
        start, value, low, high = (
            _written(number, each.unit) for number in (each.start, each.found, each.low, each.high)
        )
        bound = {"low": "lower bound", "high": "upper bound"}.get(each.at_bound, "")
        table.add_row(each.name, start, value, f"{low} to {high}", bound)
    out = Console()
    out.print(table)
    _print_achieved(found)
    for note in found.notes:
        out.print(f"Note: {note}", style="yellow", markup=False, highlight=False)


def _print_achieved(found: Design) -> None:
    from flatpunch.design.targets import UNITS

    if not found.control:
        before, after = (_written(float(each[0]), "N") for each in (found.before, found.achieved))
        say(f"Critical load {after}, before the design {before}.")
        return
    unit, at = UNITS[found.quantity], UNITS[found.control]
    for place, wanted, achieved, before in zip(found.at, found.wanted, found.achieved, found.before, strict=True):
        say(
            f"{found.quantity} at {found.control} {_written(float(place), at)}: {_written(float(achieved), unit)}, prescribed "
            f"{_written(float(wanted), unit)}, before {_written(float(before), unit)}"
        )


def _written(value: float, unit: str) -> str:
    """A number with a readable unit; angles in degrees."""
    import math

    from flatpunch.files.units import text

    if unit == "rad":
        return f"{math.degrees(value):.4g} deg"
    if unit in ("m", "Pa", "N", "N/m"):
        return text(value, unit)
    return f"{value:.4g} {unit}".rstrip()
