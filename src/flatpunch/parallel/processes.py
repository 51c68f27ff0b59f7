"""Points solved in processes of this machine: those of one that dies are tried again in a new one."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from multiprocessing.connection import wait

from flatpunch.parallel.work import Function, Item, Outcome, Waiting, call_packed, solve_chunk
from flatpunch.parallel.worker import Report, Worker

RETIRED = 5000
"""Points after which a new worker takes the place of one, which frees what it has gathered; half as many start workers often."""


def in_processes(
    function: Function, items: Sequence[Item], workers: int, tries: int
) -> Iterator[list[tuple[Item, Outcome]]]:
    """Yield outcomes as they come, a list of at least one at a time.

    A new process must be able to import the function. A point that takes its process down with it is tried `tries` times.
    """
    count = min(workers, len(items))
    waiting = Waiting(items, count, tries)
    with_main = any(b"__main__" in pickle.dumps(thing) for thing in (function, items[0].point))
    team = [_Member(name, function, with_main) for name in range(count)]
    try:
        for member in team:
            member.give(waiting.take(member.name))
        while busy := [member for member in team if member.items]:
            for connection in wait([member.worker.pipe for member in busy]):
                member = next(m for m in busy if m.worker.pipe is connection)
                outcomes = member.answer()
                if outcomes is None:
                    why = member.worker.obituary()
                    given_up = waiting.lose(member.items, alone=len(member.items) == 1)
                    team[member.name] = member = _Member(member.name, function, with_main)
                    if given_up:
                        yield [(item, Outcome(None, f"{why}, {tries} times in a row")) for item in given_up]
                else:
                    done = list(zip(member.items, outcomes, strict=False))
                    waiting.give_back(member.items[len(done) :])
                    waiting.learn(outcomes)
                    yield done
                    member.solved += len(done)
                    if member.solved >= RETIRED:
                        member.worker.end()
                        team[member.name] = member = _Member(member.name, function, with_main)
                member.give(waiting.take(member.name))
            for member in team:  # what was lost or given back may wait while others have nothing to do
                if not member.items:
                    member.give(waiting.take(member.name))
    finally:
        for member in team:
            member.worker.end()


class _Member:
    """A worker and the items it is at."""

    def __init__(self, name: int, function: Function, with_main: bool) -> None:
        self.name, self.solved, self._ready = name, 0, False
        self.items: list[Item] = []
        self.worker = Worker(partial(_solving, function), f"flatpunch-{name}", with_main=with_main)

    def give(self, items: list[Item]) -> None:
        """Hand over points, if there are any."""
        self.items = items
        if items:
            self.worker.give([pickle.dumps(item.point) for item in items])

    def answer(self) -> list[Outcome] | None:
        """Outcomes of the points it had, in order and perhaps not of all; None if it has died."""
        try:
            if not self._ready:
                problem = self.worker.problem()
                if problem is not None:
                    raise RuntimeError(f"The worker processes cannot load what they are to call: {problem}")
                self._ready = True
            found: list[Outcome] = self.worker.answer()[1]
        except (EOFError, OSError):
            if not self._ready:
                raise RuntimeError(
                    f"A worker process ended before its first point ({self.worker.obituary()}). Functions and points that a "
                    "script defines are loaded by running it again: keep its calls under `if __name__ == '__main__':`."
                ) from None
            return None
        return found


def _solving(function: Function) -> Callable[[Report, Sequence[bytes]], list[Outcome]]:
    """Make what a worker calls: it solves a chunk of pickled points."""
    return partial(_solve, partial(call_packed, function))


def _solve(called: Function, report: Report, points: Sequence[bytes]) -> list[Outcome]:
    return solve_chunk(called, points)
