"""The command `flatpunch design`: numbers of a case that give a prescribed contact or the largest load."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flatpunch.cli.terminal import (
    CaseFile,
    Output,
    PlotOption,
    StyleOption,
    command,
    drawn,
    progress,
    say,
    say_notes,
    say_table,
    write_all,
)

if TYPE_CHECKING:
    from flatpunch.contact import Method
    from flatpunch.designs import Design
    from flatpunch.files import Case


@command("design")
def design(
    case: CaseFile,
    csv: Annotated[Path | None, typer.Option(help="Table of the numbers found as CSV."), Output((".csv",))] = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Find the numbers of a case that give what its table [bold]design[/bold] prescribes.

    A force, depth, stiffness or contact radius, at one load or along a curve; or the largest load before failure.
    """
    from flatpunch.designs import design
    from flatpunch.files import read_case

    read = read_case(case)
    asked = read.design
    if asked is None:
        raise ValueError("the case has no table [design]; it names what to vary and what is prescribed.")
    with progress(read.title or "Design", asked.starts) as step:
        found = design(
            read.medium,
            read.indenter,
            vary=asked.vary,
            objective=asked.objective,
            limits=asked.limits,
            starts=asked.starts,
            method=None if read.indenter.round else _method(read),
            progress=lambda done, total: step(f"start {done} of {total}"),
        )
    _print(read.title, found)
    picture = drawn("plots.design:figure", found, title=read.title, style=style)
    write_all((csv, lambda path: _table(found, path)), (plot, picture))


def _method(case: Case) -> Method | None:
    """All but the refined method have derivatives under tips that are not round."""
    from flatpunch.contact import method_of

    chosen = None if case.method is None else method_of(case.method)
    return None if chosen is None or chosen.name == "refined" else chosen


def _table(found: Design, path: Path) -> None:
    """Write a line for each varied number, SI."""
    import pandas as pd

    from flatpunch._support.whole_file import write_whole

    columns = ["name", "unit", "start", "found", "low", "high", "at_bound"]
    rows = [[getattr(each, column) for column in columns] for each in found.values]
    write_whole(path, pd.DataFrame(rows, columns=columns).to_csv(index=False, lineterminator="\n").encode())


def _print(title: str, found: Design) -> None:
    from flatpunch.designs.targets import UNITS

    rows = []
    for each in found.values:
        start, value, low, high = (_written(n, each.unit) for n in (each.start, each.found, each.low, each.high))
        bound = {"low": "lower bound", "high": "upper bound"}.get(each.at_bound, "")
        rows.append((each.name, start, value, f"{low} to {high}", bound))
    headings = ("number", "start", "found", "bounds", "at")
    say_table(title or "Design", headings, rows, f"{found.evaluations} contacts solved", left=(0, 4))
    if not found.control:
        before, after = (_written(float(each[0]), "N") for each in (found.before, found.achieved))
        say(f"Critical load {after}, before the design {before}.")
    else:
        unit, at = UNITS[found.quantity], UNITS[found.control]
        for place, *numbers in zip(found.at, found.achieved, found.wanted, found.before, strict=True):
            achieved, wanted, before = (_written(float(each), unit) for each in numbers)
            where = f"{found.quantity} at {found.control} {_written(float(place), at)}"
            say(f"{where}: {achieved}, prescribed {wanted}, before {before}")
    say_notes(found.notes)


def _written(value: float, unit: str) -> str:
    """A number with a readable unit; angles in degrees."""
    from flatpunch.files.units import text

    if unit == "rad":
        return f"{math.degrees(value):.4g} deg"
    return text(value, unit) if unit in ("m", "Pa", "N", "N/m") else f"{value:.4g} {unit}".rstrip()
