"""Points solved in processes of this machine.

Each worker has a pipe of its own to this process. So a worker that dies costs only the points it had, which are tried again in
a new one; and workers end by themselves when this process is gone, however it ended: their pipe is closed then. (A pool of
`concurrent.futures` breaks as a whole when one process dies, and its processes outlive a killed parent.)
"""

from __future__ import annotations

import contextlib
import multiprocessing
import pickle
import signal
import sys
import types
from collections.abc import Iterator, Sequence
from functools import partial
from multiprocessing.connection import Connection, wait
from typing import Any

from flatpunch.parallel.interruption import left_to_parent, unheard_by_children
from flatpunch.parallel.threads import one_thread
from flatpunch.parallel.work import Function, Item, Outcome, Waiting, call_packed, solve_chunk

fresh = multiprocessing.get_context("spawn")  # forked threads of a numerical library may hang

RETIRED = 5000
"""Points after which a new worker takes the place of one, which frees what it has gathered; half as many start workers often."""


def in_processes(
    function: Function, items: Sequence[Item], workers: int, tries: int
) -> Iterator[list[tuple[Item, Outcome]]]:
    """Yield outcomes as they come, a list of at least one at a time.

    Parameters
    ----------
    function : callable
        Point -> numbers by name; importable by a new process.
    items : sequence of Item
        Points to solve.
    workers : int
        Number of processes.
    tries : int
        How often a point is tried that takes its process down with it.
    """
    count = min(workers, len(items))
    waiting = Waiting(items, count, tries)
    with_main = any(of_main(pickle.dumps(thing)) for thing in (function, items[0].point))
    team = [_Worker(name, function, with_main) for name in range(count)]
    try:
        for worker in team:
            worker.give(waiting.take(worker.name))
        while busy := [worker for worker in team if worker.items]:
            for connection in wait([worker.pipe for worker in busy]):
                worker = next(w for w in busy if w.pipe is connection)
                outcomes = worker.answer()
                if outcomes is None:
                    why = worker.obituary()
                    given_up = waiting.lose(worker.items, alone=len(worker.items) == 1)
                    team[worker.name] = worker = _Worker(worker.name, function, with_main)
                    if given_up:
                        yield [(item, Outcome(None, f"{why}, {tries} times in a row")) for item in given_up]
                else:
                    done = list(zip(worker.items, outcomes, strict=False))
                    waiting.give_back(worker.items[len(done) :])
                    waiting.learn(outcomes)
                    yield done
                    worker.solved += len(done)
                    if worker.solved >= RETIRED:
                        worker.end()
                        team[worker.name] = worker = _Worker(worker.name, function, with_main)
                worker.give(waiting.take(worker.name))
            for worker in team:  # what was lost or given back may wait while others have nothing to do
                if not worker.items:
                    worker.give(waiting.take(worker.name))
    finally:
        for worker in team:
            worker.end()


class _Worker:
    """A process, the pipe to it, and the items it is at."""

    def __init__(self, name: int, function: Function, with_main: bool) -> None:
        self.name, self._ready = name, False
        self.items: list[Item] = []
        self.solved = 0
        self.pipe, end = fresh.Pipe()
        self._process = fresh.Process(target=_work, args=(end,), name=f"flatpunch-{name}", daemon=True)
        with one_thread(), unheard_by_children(), contextlib.nullcontext() if with_main else no_main():
            self._process.start()
        end.close()  # the process holds it now: when it dies, the pipe says so
        self._send(function)

    def give(self, items: list[Item]) -> None:
        """Hand over points, if there are any."""
        self.items = items
        if items:
            self._send([pickle.dumps(item.point) for item in items])

    def _send(self, thing: Any) -> None:
        data = pickle.dumps(thing)
        with contextlib.suppress(OSError):  # it is dead; that shows where its answer is awaited
            self.pipe.send_bytes(data)

    def answer(self) -> list[Outcome] | None:
        """Outcomes of the points it had, in order and perhaps not of all; None if it has died."""
        try:
            if not self._ready:
                problem = self.pipe.recv()
                if problem is not None:
                    raise RuntimeError(f"The worker processes cannot load what they are to call: {problem}")
                self._ready = True
            found: list[Outcome] = self.pipe.recv()
        except (EOFError, OSError):
            if not self._ready:
                raise RuntimeError(
                    f"A worker process ended before its first point ({self.obituary()}). Functions and points that a script "
                    "defines are loaded by running it again: keep its calls under `if __name__ == '__main__':`."
                ) from None
            return None
        return found

    def obituary(self) -> str:
        """How the process ended."""
        self._process.join()
        code = self._process.exitcode or 0
        how = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        return f"WorkerLost: its process ended with {how}"

    def end(self) -> None:
        """Stop the process, whatever it does."""
        self.pipe.close()
        self._process.kill()
        self._process.join()
        self._process.close()


def _work(pipe: Connection) -> None:
    """Solve what comes through the pipe until it is closed."""
    left_to_parent()
    with contextlib.suppress(EOFError, OSError):
        try:
            function = pipe.recv()
        except (AttributeError, ImportError, pickle.UnpicklingError) as error:
            pipe.send(f"{type(error).__name__}: {error}")
            return
        pipe.send(None)
        while True:
            pipe.send(solve_chunk(partial(call_packed, function), pipe.recv()))


def of_main(packed: bytes) -> bool:
    """Whether a new process needs the script that runs here to understand what was pickled."""
    return b"__main__" in packed


@contextlib.contextmanager
def no_main() -> Iterator[None]:
    """Start processes without the script that runs here, which they would load again: unguarded scripts work too."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = types.ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main
