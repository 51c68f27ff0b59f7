"""The command `flatpunch paper`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from flatpunch.cli.terminal import friendly


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
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    from flatpunch._support.whole_file import made_folder
    from flatpunch.paper import reproduce, wanted_figures

    start, console = time.monotonic(), Console(stderr=True)
    with friendly("Finished points are kept; the same command goes on from there."):
        numbers = wanted_figures(figures)
        made_folder("--output", output)
        columns = (
            SpinnerColumn(),
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
        )
        with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
            task = bar.add_task("planning", total=None)
            report = reproduce(
                output,
                quick=quick,
                figures=numbers,
                jobs=jobs,
                progress=lambda done, total: bar.update(
                    task, completed=done, total=total, description="boundary elements"
                ),
                step=lambda what: bar.update(task, description=what),
            )
    for statement in report.statements:
        typer.echo(f"{statement.name}: {statement.verdict}")
        typer.echo(f"    {statement.finding}")
    typer.echo(f"Written: {output / 'index.html'} ({_elapsed(start)})")


def _elapsed(start: float) -> str:
    """Seconds since `start`, readable."""
    seconds = time.monotonic() - start
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.1f} min"
