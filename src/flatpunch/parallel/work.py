"""The queue of calls that are still to be made, and the calls themselves in a worker process.

Calls go out in chunks that last about a tenth of a second, so that thousands of short ones cost no more than their own time,
and long ones go one by one. Calls of one group (the same body, say) go to the same worker one after the other, which finds in
its caches what they share. Groups with the highest cost come first, so that no long one is left for the end.
"""

from __future__ import annotations

import pickle
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from flatpunch._support.threads import one_thread

_BUDGET = 0.1
"""Seconds of work handed to a worker at once; half as many make it wait more often."""

_one_at_a_time = threading.Lock()


@dataclass(frozen=True, slots=True)
class Missing:
    """What a call that returned nothing leaves: the reason."""

    reason: str


@dataclass(frozen=True, slots=True)
class Item:
    """The number of a call, its group and cost."""

    index: int
    group: Hashable = None
    cost: float = 1.0


def call_chunk(work: bytes, packed: Sequence[bytes]) -> tuple[list[Any], float]:
    """In a worker: call a pickled function with pickled arguments until the time for a chunk is over, at least once.

    Returns what the calls returned, in order, or why they did not (`Missing`), and the seconds taken. One chunk at a time in a
    process: warnings and the threads of numerical libraries are settings of the whole process.
    """
    with _one_at_a_time, one_thread():
        function = _loaded(work)
        start, found = time.perf_counter(), [_called(function, packed[0])]
        for argument in packed[1:]:
            if time.perf_counter() - start > _BUDGET:
                break
            found.append(_called(function, argument))
        return found, time.perf_counter() - start


@lru_cache(maxsize=1)
def _loaded(work: bytes) -> Callable[[Any], Any]:
    """The function, unpickled once for all chunks: it carries what its calls have in common."""
    function: Callable[[Any], Any] = pickle.loads(work)
    return function


def _called(function: Callable[[Any], Any], packed: bytes) -> Any:
    """One that cannot be unpickled fails as any other."""
    try:
        return function(pickle.loads(packed))
    except Exception as error:
        return Missing(f"{type(error).__name__}: {error}")


class Waiting:
    """Items that wait for so many workers: no chunk takes more than the share of one worker in what is left of its group.

    An item may lose its worker `tries` times before it is given up.
    """

    def __init__(self, items: Iterable[Item], workers: int, tries: int) -> None:
        groups: dict[Hashable, list[Item]] = {}
        for item in items:
            groups.setdefault(item.group, []).append(item)
        ordered = sorted(groups.items(), key=lambda pair: -sum(item.cost for item in pair[1]))
        # sorted by cost only where costs differ: neighbours share most, and stay together
        self._groups = {name: deque(sorted(found, key=lambda item: -item.cost)) for name, found in ordered}
        self._group_of: dict[Hashable, Hashable] = {}
        self._suspects: deque[Item] = deque()
        self._lost: dict[int, int] = {}
        self._workers, self._tries, self._seconds = workers, tries, _BUDGET

    def __bool__(self) -> bool:
        """Whether an item waits."""
        return bool(self._groups or self._suspects)

    def take(self, worker: Hashable, *, suspects: bool = True) -> list[Item]:
        """Return the next items for a worker, none when nothing is left; a suspect goes alone, and only when the rest is out."""
        group = self._group_for(worker)
        if group is None:
            return [self._suspects.popleft()] if suspects and self._suspects else []
        self._group_of[worker] = group[0]
        name, queue = group
        size = min(64, int(_BUDGET / self._seconds), len(queue) // self._workers)
        taken = [queue.popleft() for _ in range(max(size, 1))]
        if not queue:
            del self._groups[name]
        return taken

    def take_one(self, worker: Hashable, *, suspects: bool) -> Item | None:
        """Return the next item for a worker that makes a single call at a time."""
        taken = self.take(worker, suspects=suspects)
        self.give_back(taken[1:])
        return taken[0] if taken else None

    def _group_for(self, worker: Hashable) -> tuple[Hashable, deque[Item]] | None:
        """The group it is at; or else the most costly one that no worker has; or else the one with the most items left."""
        at = self._group_of.get(worker)
        if at in self._groups:
            return at, self._groups[at]
        taken = set(self._group_of.values())
        free = [pair for pair in self._groups.items() if pair[0] not in taken]
        return free[0] if free else max(self._groups.items(), key=lambda pair: len(pair[1]), default=None)

    def give_back(self, items: Iterable[Item]) -> None:
        """Put back items that no worker has begun."""
        for item in reversed(list(items)):
            self._groups.setdefault(item.group, deque()).appendleft(item)

    def lose(self, items: Sequence[Item], *, alone: bool) -> list[Item]:
        """Put items back whose worker was lost: suspects, tried one by one at the end.

        `alone` says that nothing else can have been the reason, which counts as one try. Those tried often enough are returned
        instead.
        """
        for item in items:
            self._lost[item.index] = self._lost.get(item.index, 0) + alone
        given_up = [item for item in items if self._lost[item.index] >= self._tries]
        self._suspects.extend(item for item in items if item not in given_up)
        return given_up

    def suspected(self, item: Item) -> bool:
        """Whether its worker was lost before."""
        return item.index in self._lost

    def learn(self, calls: int, seconds: float) -> None:
        """Take note of how long so many calls took together."""
        for _ in range(calls):
            self._seconds += 0.2 * (max(seconds / calls, 1e-6) - self._seconds)
