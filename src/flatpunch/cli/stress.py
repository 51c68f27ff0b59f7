"""The command `flatpunch stress`: fields of the last step of a case, and its first failure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flatpunch.cli.terminal import (
    CaseFile,
    NetCDFOption,
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
    from flatpunch.files.cases import Case
    from flatpunch.files.stresses import Stresses


@command("stress")
def stress(
    case: CaseFile,
    output: NetCDFOption = None,
    csv: Annotated[Path | None, typer.Option(help="Table of the points as CSV."), Output((".csv",))] = None,
    plot: PlotOption = None,
    style: StyleOption = "screen",
) -> None:
    """Compute the stresses inside the body at the last step of a case, and the load of its first failure.

    A table [bold]stress[/bold] of the case file names points, friction, residual stresses and strengths; without it
    the section y = 0 is shown.
    """
    from flatpunch.files import read_case, save
    from flatpunch.files.results import write
    from flatpunch.files.stresses import stress_csv, stresses

    read = read_case(case)
    with progress(read.title or "Stress", 1) as step:
        step("solving")
        found = stresses(read)
    _print(read, found)
    about = {"strengths": found.strengths, "title": read.title, "style": style}
    write_all(
        (output, lambda path: save(found.fields, path)),
        (csv, lambda path: write(path, stress_csv(found.fields).encode("utf-8"))),
        (plot, drawn("plots.fields:figure", found.fields, read.medium, read.indenter, found.contact, **about)),
    )


def _print(case: Case, found: Stresses) -> None:
    from flatpunch.files.stresses import STRESS_COLUMNS, first_failure_lines, load_lines, stress_rows
    from flatpunch.files.units import text

    attrs = found.fields.attrs
    title = f"{case.title or 'Stress'}: force {text(attrs['force'], 'N')}, depth {text(attrs['depth'], 'm')}"
    if found.peaks is not None:
        about = f"friction {attrs['friction']:g}, method {attrs['method']}"
        say_table(title, STRESS_COLUMNS, stress_rows(found), about)
    else:
        adhesive = case.physics.work_of_adhesion is not None
        why = "infinite at the rim of an adhesive contact" if adhesive else "not searched under this tip"
        say(f"{title}. Largest stresses are {why}; see the points of the result.")
    say(f"Estimated error of stresses: {attrs['stress_error']:.1g} of the size of the pressure.")
    for line in first_failure_lines(found.first) if found.first is not None else ():
        say(line)
    for line in load_lines(found.loads) if found.loads is not None else ():
        say(line)
    say_notes(str(attrs.get("notes", "")).splitlines())
