"""One piece of work: what is asked, what comes back, and the queue of what is still to do.

Points go out in chunks that last about a tenth of a second, so that thousands of short ones cost no more than their own time,
and long ones go one by one. Points of one group (the same body, say) go to the same worker one after the other, which finds in
its caches what they share. Groups with the highest cost come first, so that no long one is left for the end.
"""

from __future__ import annotations

import pickle
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch._support.readable import readable
from flatpunch.parallel.threads import one_thread

Numbers = Mapping[str, Any]
"""Numbers, texts and arrays by name."""

Function = Callable[[Any], Numbers]

_BUDGET = 0.1
"""Seconds of work handed to a worker at once; half as many make it wait more often."""

_one_at_a_time = threading.Lock()


@readable
@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a point.

    Attributes
    ----------
    numbers : mapping or None
        Arrays and scalars by name; None where it failed.
    reason : str
        Why it failed, type and message of the exception; empty where it did not.
    seconds : float
        Time it took.

    See Also
    --------
    flatpunch.parallel.Solved : Holds them by name.

    Examples
    --------
    >>> from flatpunch.parallel import solve_points
    >>> def inverse(x):
    ...     return {"inverse": 1 / x}
    >>> solved = solve_points(inverse, [4.0, 0.0], workers=1)
    >>> print(solved[0].numbers["inverse"], solved[1].reason)
    0.25 ZeroDivisionError: float division by zero
    """

    numbers: Numbers | None
    reason: str = ""
    seconds: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether there are numbers."""
        return self.numbers is not None


@dataclass(frozen=True, slots=True)
class Item:
    """A point on its way: its key, group and cost."""

    key: str
    point: object
    group: Hashable = None
    cost: float = 1.0


def solve_one(function: Function, point: object) -> Outcome:
    """Call the function; an exception is the outcome of this point and of no other."""
    start = time.perf_counter()
    try:
        numbers = {str(name): _plain(str(name), value) for name, value in function(point).items()}
    except Exception as error:
        return Outcome(None, f"{type(error).__name__}: {error}", time.perf_counter() - start)
    return Outcome(numbers, "", time.perf_counter() - start)


def _plain(name: str, value: object) -> object:
    """Return an array or NumPy scalar, as it will be read back from a file."""
    array = np.asarray(value)
    if array.dtype.hasobject:
        raise TypeError(
            f"the result {name!r} is a {type(value).__name__}, which cannot be kept: return numbers, texts and arrays."
        )
    return array[()]


def call_packed(function: Function, packed: bytes) -> Numbers:
    """Unpack a point where it is solved: one that cannot be unpacked is then a record like any other that fails."""
    return function(pickle.loads(packed))


def solve_chunk(function: Function, points: Sequence[object]) -> list[Outcome]:
    """Solve points until the time for a chunk is over, at least one; the outcomes of those solved, in order.

    One chunk at a time in a process: warnings and the threads of numerical libraries are settings of the whole process.
    """
    with _one_at_a_time, one_thread():
        start, found = time.perf_counter(), [solve_one(function, points[0])]
        for point in points[1:]:
            if time.perf_counter() - start > _BUDGET:
                break
            found.append(solve_one(function, point))
    return found


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
        self._lost: dict[str, int] = {}
        self._workers, self._tries, self._seconds = workers, tries, _BUDGET

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
            self._lost[item.key] = self._lost.get(item.key, 0) + alone
        given_up = [item for item in items if self._lost[item.key] >= self._tries]
        self._suspects.extend(item for item in items if item not in given_up)
        return given_up

    def suspected(self, item: Item) -> bool:
        """Whether its worker was lost before."""
        return item.key in self._lost

    def learn(self, outcomes: Iterable[Outcome]) -> None:
        """Take note of how long points last."""
        for outcome in outcomes:
            self._seconds += 0.2 * (max(outcome.seconds, 1e-6) - self._seconds)
