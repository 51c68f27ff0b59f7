"""What the commands share: messages for bad input and interrupts, the progress bar, and printing of lines.

Bad input ends with status 2 and one readable message, an interrupt (Ctrl-C) with status 130.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Literal, Protocol

import typer
from rich.console import Console

from flatpunch._support.messages import message, wants_traceback

CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)]
StyleOption = Annotated[
    Literal["screen", "one-column", "two-columns"],
    typer.Option("--style", help="Sizes of the picture: for the screen, or one or two columns of a journal."),
]
PICTURES = (".png", ".pdf", ".svg")
"""Endings of pictures."""


class Step(Protocol):
    """What a command calls when it begins with something."""

    def __call__(self, what: str, advance: int = 1) -> None:
        """Show what is being done; `advance` steps were done before it."""


@contextmanager
def friendly(interrupted: str = "No file was left half-written.") -> Iterator[None]:
    """Turn bad input into one message and status 2, and Ctrl-C into one line and status 130.

    Errors of the package itself are reported as such, in one line; see `flatpunch._support.messages`.

    Parameters
    ----------
    interrupted : str
        What an interrupt leaves behind.
    """
    try:
        yield
    except KeyboardInterrupt:
        typer.echo(f"\nInterrupted. {interrupted}".rstrip(), err=True)
        raise typer.Exit(130) from None
    except (typer.Exit, typer.Abort, BrokenPipeError):
        raise
    except Exception as error:
        if wants_traceback():
            raise
        typer.echo(f"Error: {message(error)}", err=True)
        raise typer.Exit(2) from None


@contextmanager
def progress(title: str, total: int) -> Iterator[Step]:
    """Show a bar on the terminal while the work lasts; in a pipe or a log there is none."""
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=total)
        started = False

        def step(what: str, advance: int = 1) -> None:
            nonlocal started
            bar.update(task, description=f"{title}: {what}", advance=advance if started else 0)
            started = True

        yield step


def say(text: str) -> None:
    """Print a line as it is: not wrapped, no markup."""
    Console().print(text, markup=False, highlight=False, soft_wrap=True)


def say_written(paths: Iterable[Path]) -> None:
    """Name the files that were written, if any."""
    names = ", ".join(map(str, paths))
    if names:
        say(f"Written: {names}")
