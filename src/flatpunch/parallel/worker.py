"""Processes of this machine that make calls, by loky: those of `map_calls`, and those of the page.

Each worker is an executor of loky with a single process, so that one that dies costs only the call that it was at, and a call is
stopped by ending its process. Functions go to it by value where a script defines them, which is not run again. Workers end with
this process, however it ends, and leave Ctrl-C to it.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future
from multiprocessing.connection import Connection
from typing import Any

from flatpunch._support.threads import ONE_THREAD
from flatpunch.parallel.interruption import held, left_to_parent, unheard_by_children

PAUSE = 0.1
"""Seconds between two reports of progress."""

_IDLE = 120
"""Seconds after which a kept worker process ends; then the next call has to start it again."""


class Worker:
    """A process that makes one call at a time, started with the first; `idle` seconds after its last call it ends."""

    def __init__(self, idle: float | None = None) -> None:
        from loky import ProcessPoolExecutor

        # loky replaces a process that has grown, which is no news for those who wait for results
        warnings.filterwarnings("ignore", "A worker (was restarted|stopped) ", UserWarning, "loky")
        self._heard, said = multiprocessing.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(
            1, timeout=idle, initializer=_begin, initargs=(said, os.getpid()), env=ONE_THREAD
        )

    def submit(self, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Start a call; BrokenExecutor where the process was lost since the last one."""
        self.progress()
        with held(), unheard_by_children():
            future: Future[Any] = self._pool.submit(function, *arguments)
        return future

    def progress(self) -> tuple[int, int] | None:
        """Steps done and steps in all, as last reported by the call; None where nothing new was."""
        last = None
        with contextlib.suppress(OSError, EOFError):
            while self._heard.poll():
                last = self._heard.recv()
        return last

    def end(self) -> None:
        """End the process, whatever it does."""
        self._pool.shutdown(wait=True, kill_workers=True)


_said: Connection | None = None
_last = 0.0


def _begin(said: Connection, parent: int) -> None:
    """First call in a worker process."""
    global _said
    _said = said
    left_to_parent(parent)


def report(done: int, total: int) -> None:
    """In a worker process: report the progress of a call, not more often than it is read."""
    global _last
    if _said is not None and (time.monotonic() - _last > PAUSE or done == total):
        _last = time.monotonic()
        _said.send((done, total))


def how_it_ended(error: BrokenExecutor) -> str:
    """How a process was lost; loky names the signal, if there was one, in its message."""
    named = [name.name for name in signal.Signals if f"{name.name}(" in str(error)]
    return "its process ended " + (f"with signal {named[0]}" if named else "unexpectedly")


_kept: list[Worker] = []
_lock = threading.Lock()


@contextlib.contextmanager
def processes(count: int, *, kept: bool = False) -> Iterator[Processes]:
    """So many worker processes, at an error ended at once; `kept` leaves them to the next round of calls."""
    team = Processes(count, kept)
    try:
        yield team
    except BaseException:  # Ctrl-C too: no worker may go on for a caller that has left; raised again
        team.end()
        raise
    team.leave()


def dismiss() -> None:
    """End the workers that are kept for the next round."""
    with _lock:
        ending = _kept.copy()
        _kept.clear()
    for worker in ending:
        worker.end()


class Processes:
    """A team of worker processes, each started with its first call."""

    shared = False

    def __init__(self, count: int, kept: bool) -> None:
        self._count, self._keep, self._workers = count, kept, dict[int, Worker]()

    def size(self) -> int:
        """Processes."""
        return self._count

    def submit(self, slot: int, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Start a call."""
        if slot not in self._workers:
            with _lock:
                free = _kept.pop() if self._keep and _kept else None
            self._workers[slot] = free or Worker(_IDLE if self._keep else None)
        return self._workers[slot].submit(function, *arguments)

    def replace(self, slot: int) -> None:
        """End a worker; the next call starts another."""
        if worker := self._workers.pop(slot, None):
            worker.end()

    def lost(self, error: BaseException) -> str | None:
        """How a worker was lost."""
        return how_it_ended(error) if isinstance(error, BrokenExecutor) else None

    def wait(self) -> None:
        """A process that is lost is noticed at once."""

    def leave(self) -> None:
        """Keep the workers, none of which has anything to do, for the next team."""
        if not self._keep:
            self.end()
            return
        with _lock:
            _kept.extend(self._workers.values())

    def end(self) -> None:
        """End all workers."""
        for worker in self._workers.values():
            worker.end()
