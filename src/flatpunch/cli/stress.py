"""The command `flatpunch stress`: fields of the last step of a case, and its first failure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from flatpunch.cli.examples import examples
from flatpunch.cli.terminal import StyleOption, friendly, progress, say, say_written

if TYPE_CHECKING:
    from flatpunch.files import Case
    from flatpunch.files.stresses import Stresses


def add_commands(app: typer.Typer) -> None:
    """Register the command on the command line."""

    @app.command(epilog=examples("stress"))
    def stress(
        case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)],
        output: Annotated[Path | None, typer.Option("--output", "-o", help="Result file: .nc (NetCDF).")] = None,
        csv: Annotated[Path | None, typer.Option(help="Table of the points as CSV.")] = None,
        plot: Annotated[Path | None, typer.Option(help="Picture: .png, .pdf or .svg.")] = None,
        style: StyleOption = "screen",
    ) -> None:
        """Compute the stresses inside the body at the last step of a case, and the load of its first failure.

        A table [bold]stress[/bold] of the case file names points, friction, residual stresses and strengths; without it
        the section y = 0 is shown.
        """
        with friendly():
            from flatpunch._support.whole_file import check_target

            check_target("--output", output, (".nc",))
            check_target("--csv", csv, (".csv",))
            check_target("--plot", plot, (".png", ".pdf", ".svg"))
            from flatpunch.files import read_case

            _run(read_case(case), output, csv, plot, style)


def _run(case: Case, output: Path | None, csv: Path | None, plot: Path | None, style: str) -> None:
    from flatpunch.files import save
    from flatpunch.files.results import write
    from flatpunch.files.stresses import stress_csv, stresses

    written: list[Path] = []
    with progress(case.title or "Stress", 1 + sum(path is not None for path in (output, csv, plot))) as step:
        step("solving")
        found = stresses(case)
        if output is not None:
            step(f"writing {output.name}")
            written.append(save(found.fields, output))
        if csv is not None:
            step(f"writing {csv.name}")
            write(csv, stress_csv(found.fields).encode("utf-8"))
            written.append(csv)
        if plot is not None:
            step(f"drawing {plot.name}")
            written.append(_draw(case, found, plot, style))
    _print(case, found)
    say_written(written)


def _draw(case: Case, found: Stresses, plot: Path, style: str) -> Path:
    from flatpunch.plots import fields as pictures
    from flatpunch.plots.result import save_figure

    drawn = pictures.figure(
        found.fields,
        case.medium,
        case.indenter,
        found.contact,
        strengths=found.strengths,
        title=case.title,
        style=style,
    )
    return save_figure(drawn, plot)


def _print(case: Case, found: Stresses) -> None:
    from rich.table import Table

    from flatpunch.files.stresses import STRESS_COLUMNS, first_failure_lines, stress_rows
    from flatpunch.files.units import text

    attrs = found.fields.attrs
    title = f"{case.title or 'Stress'}: force {text(attrs['force'], 'N')}, depth {text(attrs['depth'], 'm')}"
    table = Table(
        title=title, title_justify="left", caption=f"friction {attrs['friction']:g}, method {attrs['method']}"
    )
    for heading in STRESS_COLUMNS:
        table.add_column(heading, justify="right")
    for row in stress_rows(found.fields):
        table.add_row(*row)
    out = Console()
    out.print(table)
    say(f"Estimated error of stresses: {attrs['stress_error']:.1g} of the largest pressure.")
    for line in first_failure_lines(found.first) if found.first is not None else ():
        say(line)
    for line in str(attrs.get("notes", "")).splitlines():
        out.print(f"Note: {line}", style="yellow", markup=False, highlight=False)
