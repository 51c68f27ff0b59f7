"""`map_calls`: many independent calls in worker processes of this machine, or on a Dask cluster, by one loop.

A team (`Team`) is what makes the calls: `worker.processes` by loky, `cluster.cluster` by Dask. Results come as they are made. A
call whose worker is lost is made by another worker; a call that costs one worker after the other is given up, and no other with
it.

Calls go out in chunks that last about a tenth of a second, so that thousands of short ones cost no more than their own time,
and long ones go one by one. Calls of one group (the same body, say) go to the same worker one after the other, which finds in
its caches what they share. Groups with the highest cost come first, so that no long one is left for the end.
"""

from __future__ import annotations

import pickle
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Future
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Generic, Protocol, TypeVar

from flatpunch._support.threads import one_thread

_BUDGET = 0.1
"""Seconds of work handed to a worker at once; half as many make it wait more often."""

_SHORTEST = 1e-6
"""Seconds that a call takes at least, which bounds the calls that are handed out at once."""

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
        size = min(int(_BUDGET / self._seconds), len(queue) // self._workers)
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
            self._lost[item.index] = self._lost.get(item.index, 0) + alone
        given_up = [item for item in items if self._lost[item.index] >= self._tries]
        self._suspects.extend(item for item in items if item not in given_up)
        return given_up

    def suspected(self, item: Item) -> bool:
        """Whether its worker was lost before."""
        return item.index in self._lost

    def learn(self, calls: int, seconds: float) -> None:
        """Take note of how long so many calls took together, as the next ones may."""
        self._seconds = max(seconds / calls, _SHORTEST)


_TICK = 1.0
"""Seconds without a result after which a team is asked whether anybody works."""

_HERE = "here"

Given = TypeVar("Given")
Found = TypeVar("Found")

Chunk = tuple[list[Item], "Future[Any]"]
"""Calls and their future."""


class Team(Protocol):
    """Workers that take chunks of calls; a slot holds one chunk at a time."""

    @property
    def shared(self) -> bool:
        """Whether a lost worker may have had calls of several slots, so that only a call sent alone is known to be the reason."""

    def size(self) -> int:
        """Slots at present; ConnectionError where there can be no more workers."""

    def submit(self, slot: int, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Start a call; BrokenExecutor or OSError where the worker of the slot is lost or cannot be started."""

    def replace(self, slot: int) -> None:
        """End the worker of a slot; the next call starts another."""

    def lost(self, error: BaseException) -> str | None:
        """Return how the worker of a call was lost; None where the call itself could not be made."""

    def wait(self) -> None:
        """Called when nothing has come for a while: report where nobody works."""


def map_calls(
    function: Callable[[Given], Found],
    arguments: Sequence[Given],
    team: AbstractContextManager[Team] | None,
    *,
    here: Callable[[Given], Found] | None = None,
    describe: Callable[[int], Item] = Item,
    tries: int = 3,
) -> Iterator[list[tuple[int, Found | Missing]]]:
    """Yield (index of the argument, function(argument)) as they come, at least one at a time.

    Parameters
    ----------
    function : callable
        Can be pickled, by value where a script defines it. In workers an exception becomes `Missing`.
    arguments : sequence
        One a call; they are pickled one by one.
    team : context manager of a Team, or None
        Who makes the calls; None makes them all in this process, in order.
    here : callable, optional
        What this process calls meanwhile, with the same arguments; its exceptions are raised. Where workers cannot be had, it
        makes all calls.
    describe : callable
        Index -> group and cost of a call.
    tries : int
        How often a call is made that costs its worker, before it is `Missing`.

    Raises
    ------
    OSError, ConnectionError
        Where no worker can be started or reached. What was made until then is yielded first, on KeyboardInterrupt too.
    """
    own = here or function
    try:
        work = None if team is None else _pickled(function)
    except (pickle.PicklingError, AttributeError, TypeError):
        if here is None:
            raise
        team = None
    if team is None or work is None:
        for index, argument in enumerate(arguments):
            yield [(index, own(argument))]
        return
    with team as workers:
        items = map(describe, range(len(arguments)))
        calls = _Calls(work, arguments, workers, items, here, tries)
        try:
            yield from calls.outcomes()
        except (Exception, KeyboardInterrupt):
            yield from calls.rest()
            raise
        finally:
            calls.open = False


def _pickled(thing: object) -> bytes:
    import cloudpickle

    data: bytes = cloudpickle.dumps(thing)
    return data


class _Calls(Generic[Given, Found]):
    """Calls under way. A worker that has finished gets its next chunk at once, in the thread that brings its results."""

    def __init__(
        self,
        work: bytes,
        arguments: Sequence[Given],
        team: Team,
        items: Iterable[Item],
        here: Callable[[Given], Found] | None,
        tries: int,
    ) -> None:
        self._work, self._arguments, self._team, self._here, self._tries = work, arguments, team, here, tries
        self._waiting = Waiting(items, team.size() + (here is not None), tries)
        self._lock = threading.RLock()
        self._running: dict[Future[Any], tuple[int, list[Item]]] = {}
        self._ended: queue.SimpleQueue[Chunk] = queue.SimpleQueue()
        self.open, self._alone = True, False

    def outcomes(self) -> Iterator[list[tuple[int, Found | Missing]]]:
        """Results as they come, until there are no more; a call in this process comes before waiting for one elsewhere."""
        self._fill()
        while self._left():
            chunk = self._next(0.0)
            if chunk is None and (own := self._own()):
                yield own
            elif chunk is None and (chunk := self._next(_TICK)) is None:
                self._team.wait()
                self._fill()
            if chunk is not None and (found := self._settled(*chunk)):
                yield found

    def _next(self, seconds: float) -> Chunk | None:
        """A chunk that is back, waited for so long."""
        with suppress(queue.Empty):
            return self._ended.get(timeout=seconds)
        return None

    def rest(self) -> Iterator[list[tuple[int, Found | Missing]]]:
        self.open = False
        while (chunk := self._next(0.0)) is not None:
            if _error(chunk[1]) is None:
                yield _pairs(*chunk)

    def _left(self) -> bool:
        with self._lock:
            return bool(self._running or self._waiting or not self._ended.empty())

    def _own(self) -> list[tuple[int, Found | Missing]]:
        """A call in this process, if there is one to make."""
        if self._here is None:
            return []
        with self._lock:
            items = self._waiting.take(_HERE, suspects=self._alone)
            self._waiting.give_back(items[1:])
        return [(item.index, self._here(self._arguments[item.index])) for item in items[:1]]

    def _fill(self) -> None:
        """Give all workers something to do, those too that have joined meanwhile."""
        size = self._team.size()
        with self._lock:
            busy = {slot for slot, _ in self._running.values()}
            try:
                for slot in sorted(set(range(size)) - busy):
                    try:
                        self._give(slot)
                    except BrokenExecutor:
                        self._team.replace(slot)
                        self._give(slot)
            except OSError:
                # no process can be started; this one may go on alone
                if self._here is None:
                    raise
                self._alone = not self._running

    def _give(self, slot: int) -> None:
        items = self._waiting.take(slot, suspects=not (self._team.shared and self._running))
        if not items:
            return
        try:
            future = self._team.submit(
                slot, call_chunk, self._work, [_pickled(self._arguments[item.index]) for item in items]
            )
        # an interrupt too: what was taken waits again, for this process or another worker
        except BaseException:
            self._waiting.give_back(items)
            raise
        self._running[future] = slot, items
        future.add_done_callback(self._came)

    def _came(self, future: Future[Any]) -> None:
        """A chunk is back, in a thread of the team: take note of it and hand out the next one."""
        with self._lock:
            slot, items = self._running.pop(future)
            if self.open and _error(future) is None:
                found, seconds = future.result()
                self._waiting.learn(len(found), seconds)
                self._waiting.give_back(items[len(found) :])
                # a worker lost just now is replaced by `_fill`
                with suppress(BrokenExecutor, OSError):
                    self._give(slot)
            self._ended.put((items, future))

    def _settled(self, items: list[Item], future: Future[Any]) -> list[tuple[int, Found | Missing]]:
        """Results of a chunk; of one that was lost, those that are given up."""
        if (error := _error(future)) is None:
            return _pairs(items, future)
        why = self._team.lost(error)
        if why is None:  # not of the function, whose exceptions are results: it could not be called at all
            self._fill()
            return [(item.index, Missing(f"{type(error).__name__}: {error}")) for item in items]
        with self._lock:
            alone = len(items) == 1 and (not self._team.shared or self._waiting.suspected(items[0]))
            given_up = self._waiting.lose(items, alone=alone)
        self._fill()
        times = f", {self._tries} times in a row" if self._tries > 1 else ""
        return [(item.index, Missing(f"WorkerLost: {why}{times}")) for item in given_up]


def _pairs(items: Sequence[Item], future: Future[Any]) -> list[tuple[int, Any]]:
    """Results by the index of their calls; the last calls of a chunk may not have been made."""
    return [(item.index, found) for item, found in zip(items, future.result()[0], strict=False)]


def _error(future: Future[Any]) -> BaseException | None:
    try:
        return future.exception()
    except CancelledError as error:
        return error
