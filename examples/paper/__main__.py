"""Compute the figures of Forsbach and Willert (2023) and compare the methods with boundary elements.

In the folder `examples`: python -m paper --quick --figures 2,3 --output figures
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from flatpunch._support.whole_file import made_folder
from flatpunch.cli.terminal import friendly, progress
from paper import reproduce, wanted_figures

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def paper(
    quick: Annotated[
        bool, typer.Option("--quick", help="Few points on coarse grids: the whole page in less than a minute.")
    ] = False,
    figures: Annotated[str, typer.Option(help="Figures to make, e.g. 2,3 or 6-9.")] = "2-12",
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for figures, tables and the page.")] = Path(
        "paper-figures"
    ),
    jobs: Annotated[int, typer.Option(help="Processes; 0 takes one for each core.", min=0)] = 0,
) -> None:
    """Compute the figures of Forsbach and Willert (2023) and compare the methods with boundary elements.

    Figures as PNG and PDF, their data as CSV, and index.html with all of them, the deviations, and the paper's statements.
    Finished boundary element solutions stay in the folder: after an interrupt the same command goes on from there.
    """
    start = time.monotonic()
    kept = "Finished points are kept; the same command goes on from there."
    with friendly(kept, program=Path(__file__).parent), progress("Figures", 1) as step:
        numbers = wanted_figures(figures)
        made_folder("--output", output)
        report = reproduce(
            output,
            quick=quick,
            figures=numbers,
            jobs=jobs,
            progress=lambda done, total: step(f"boundary elements, {done} of {total}", advance=0),
            step=lambda what: step(what, advance=0),
        )
    for statement in report.statements:
        typer.echo(f"{statement.name}: {statement.verdict}")
        typer.echo(f"    {statement.finding}")
    typer.echo(f"Written: {output / 'index.html'} ({time.monotonic() - start:.0f} s)")


if __name__ == "__main__":
    app()
