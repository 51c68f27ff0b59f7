"""A process of this machine that makes one call at a time, and the pipe to it: tables, sweeps and the page calculate with these.

A call is stopped by ending its process. Each process has a pipe of its own, so that one that dies costs only the call that it was
at; and processes end by themselves when this one is gone, however it ended: their pipe is closed then. (A pool of
`concurrent.futures` or loky breaks as a whole when one of its processes dies or is ended.)
"""

from __future__ import annotations

import contextlib
import multiprocessing
import pickle
import signal
import sys
import time
import types
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from typing import Any

from flatpunch.parallel.interruption import left_to_parent, unheard_by_children
from flatpunch.parallel.threads import one_thread

_fresh = multiprocessing.get_context("spawn")  # forked threads of a numerical library may hang

_PAUSE = 0.1
"""Seconds between two reports of progress: a pipe that is not read as fast as it is written would hold the calculation up."""

Report = Callable[[int, int], None]


class Worker:
    """A process and the pipe to it.

    The process calls `prepare` once, which it must be able to import; what that returns is called with (report, *arguments) for
    each `give`. `with_main` runs the script of this process there again, because calls need what it defines; `shares` lets calls
    start processes of their own.
    """

    def __init__(
        self, prepare: Callable[[], Callable[..., object]], name: str, *, with_main: bool = False, shares: bool = False
    ) -> None:
        self.pipe, end = _fresh.Pipe()
        self._process = _fresh.Process(target=_serve, args=(end,), name=name, daemon=not shares)
        with one_thread(), unheard_by_children(), contextlib.nullcontext() if with_main else _no_main():
            self._process.start()
        end.close()  # the process holds it now: when it dies, the pipe says so
        self._send(prepare)

    def problem(self) -> str | None:
        """Wait until it is prepared; return why it cannot be. EOFError or OSError if it has died."""
        found: str | None = self.pipe.recv()
        return found

    def give(self, *arguments: object) -> None:
        """Hand over a call."""
        self._send(arguments)

    def _send(self, thing: object) -> None:
        data = pickle.dumps(thing)
        with contextlib.suppress(OSError):  # it is dead; that shows where its answer is awaited
            self.pipe.send_bytes(data)

    def answer(self) -> tuple[bool, Any]:
        """Wait for (True, what the call returned) or (False, (steps done, steps in all)); EOFError or OSError if it has died."""
        found: tuple[bool, object] = self.pipe.recv()
        return found

    def obituary(self) -> str:
        """How the process ended."""
        self._process.join()
        code = self._process.exitcode or 0
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return f"WorkerLost: its process ended with {how}"

    def end(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        with contextlib.suppress(OSError):
            self.pipe.close()
        self._process.join(5)


def _serve(pipe: Connection) -> None:
    """Make the calls that come through the pipe until it is closed."""
    left_to_parent()
    last = 0.0

    def report(done: int, total: int) -> None:
        nonlocal last
        if time.monotonic() - last > _PAUSE or done == total:
            last = time.monotonic()
            pipe.send((False, (done, total)))

    with contextlib.suppress(EOFError, OSError):
        try:
            call = pipe.recv()()
        except (AttributeError, ImportError, pickle.UnpicklingError) as error:
            pipe.send(f"{type(error).__name__}: {error}")
            return
        pipe.send(None)
        while True:
            given = pipe.recv()
            pipe.send((True, call(report, *given)))


@contextlib.contextmanager
def _no_main() -> Iterator[None]:
    """Start processes without the script that runs here, which they would load again: unguarded scripts work too."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = types.ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main
