"""Progress of long calculations: a bar when asked for, or whatever the caller listens with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Report = Callable[[int, int], None]
"""Called with (steps done, steps in all); 0 in all where the number is not known."""

_listener: ContextVar[Report | None] = ContextVar("flatpunch_progress", default=None)


@contextmanager
def listening(report: Report) -> Iterator[None]:
    """Hear of the progress of every calculation inside, for a display of one's own."""
    token = _listener.set(report)
    try:
        yield
    finally:
        _listener.reset(token)


@contextmanager
def reporting(title: str, progress: bool | Report | None) -> Iterator[Report]:
    """What a calculation calls after each step: the caller's function, a bar on the terminal (True), or a listener (None)."""
    if callable(progress):
        yield progress
    elif progress:
        with _bar(title) as report:
            yield report
    else:
        yield _listener.get() or (lambda done, total: None)


@contextmanager
def _bar(title: str) -> Iterator[Report]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as display:
        task = display.add_task(title, total=None)
        yield lambda done, total: display.update(task, completed=done, total=total or None)
