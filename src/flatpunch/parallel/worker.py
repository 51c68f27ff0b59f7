"""Processes of this machine that make calls, by loky: those of `map_calls`, and those of the page; and what Ctrl-C is to them.

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
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from typing import Any

from flatpunch._support.threads import ONE_THREAD


@contextlib.contextmanager
def held() -> Iterator[None]:
    """Let Ctrl-C wait until the block is done, so that what is finished is also kept.

    Only the main thread hears it, and only a handler of Python's can be put back: elsewhere nothing changes.
    """
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield
        return
    came: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
        if came:
            signal.raise_signal(signal.SIGINT)


@contextlib.contextmanager
def unheard_by_children() -> Iterator[None]:
    """Start processes that do not hear Ctrl-C from their first instruction on, not only when they have loaded what they call.

    They inherit the mask of the thread that starts them, which hears what came meanwhile afterwards. Windows hands nothing down.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from loky.backend import resource_tracker as trackers_of_loky

    # processes of the libraries, started now, since their start takes the mask away
    resource_tracker.ensure_running()
    trackers_of_loky.ensure_running()
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)


def left_to_parent(parent: int) -> None:
    """Ignore Ctrl-C from now on, in a worker, which reaches all processes of a terminal; end as soon as the parent has."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a parent that was killed cannot end its workers, and they may be at a long point
    threading.Thread(target=_end_with_parent, args=(parent,), daemon=True).start()


def _end_with_parent(parent: int) -> None:
    """Check once a second: workers that loky starts do not know their parent. Windows keeps the number of a parent that ended."""
    first = parent if hasattr(os, "fork") else os.getppid()
    while os.getppid() == first:
        time.sleep(1.0)
    os._exit(1)


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
