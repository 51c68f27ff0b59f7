"""`map_calls`: many independent calls in worker processes of this machine, or on a Dask cluster, by one loop.

A team (`Team`) is what makes the calls: `worker.processes` by loky, `cluster.cluster` by Dask. Results come as they are made. A
call whose worker is lost is made by another worker; a call that costs one worker after the other is given up, and no other with
it.
"""

from __future__ import annotations

import pickle
import queue
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Future
from contextlib import AbstractContextManager, suppress
from typing import Any, Generic, Protocol, TypeVar

from flatpunch.parallel.work import Item, Missing, Waiting, call_chunk

RETIRED = 5000
"""Calls after which a new process takes the place of a worker, which frees what it has gathered."""

_TICK = 1.0
"""Seconds without a result after which a team is asked whether anybody works."""

_HERE = "here"

Given = TypeVar("Given")
Found = TypeVar("Found")

Chunk = tuple[int, list[Item], "Future[Any]"]
"""Slot, calls and their future."""


class Team(Protocol):
    """Workers that take chunks of calls; a slot holds one chunk at a time."""

    @property
    def shared(self) -> bool:
        """Whether a lost worker may have had calls of several slots, so that only a call sent alone is known to be the reason."""
        ...

    def size(self) -> int:
        """Slots at present; ConnectionError where there can be no more workers."""
        ...

    def submit(self, slot: int, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Start a call; BrokenExecutor or OSError where the worker of the slot is lost or cannot be started."""
        ...

    def replace(self, slot: int) -> None:
        """End the worker of a slot; the next call starts another."""
        ...

    def lost(self, error: BaseException) -> str | None:
        """Return how the worker of a call was lost; None where the call itself could not be made."""
        ...

    def wait(self) -> None:
        """Called when nothing has come for a while: report where nobody works."""
        ...


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
            calls.close()


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
        self._made: dict[int, int] = {}
        self._open, self._alone = True, False

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
        """Results that have come meanwhile."""
        self._open = False
        while (chunk := self._next(0.0)) is not None:
            if _error(chunk[2]) is None:
                yield _pairs(*chunk[1:])

    def close(self) -> None:
        """Hand out nothing any more."""
        with self._lock:
            self._open = False

    def _left(self) -> bool:
        with self._lock:
            return bool(self._running or self._waiting or not self._ended.empty())

    def _own(self) -> list[tuple[int, Found | Missing]]:
        """A call in this process, if there is one to make."""
        if self._here is None:
            return []
        with self._lock:
            item = self._waiting.take_one(_HERE, suspects=self._alone)
        return [] if item is None else [(item.index, self._here(self._arguments[item.index]))]

    def _fill(self) -> None:
        """Give all workers something to do, those too that have joined meanwhile."""
        size = self._team.size()
        with self._lock:
            busy = {slot for slot, _ in self._running.values()}
            try:
                for slot in sorted(set(range(size)) - busy):
                    self._give_anew(slot)
            except OSError:
                # no process can be started; this one may go on alone
                if self._here is None:
                    raise
                self._alone = not self._running

    def _give_anew(self, slot: int) -> None:
        """Give a chunk to a worker, or to another in its place where it was lost or has made many calls."""
        if self._made.get(slot, 0) >= RETIRED:
            self._made[slot] = 0
            self._team.replace(slot)
        try:
            self._give(slot)
        except BrokenExecutor:
            self._team.replace(slot)
            self._give(slot)

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
            if self._open and _error(future) is None:
                found, seconds = future.result()
                self._waiting.learn(len(found), seconds)
                self._waiting.give_back(items[len(found) :])
                self._made[slot] = self._made.get(slot, 0) + len(found)
                if self._made[slot] < RETIRED:
                    # a worker lost just now is replaced by `_fill`
                    with suppress(BrokenExecutor, OSError):
                        self._give(slot)
            self._ended.put((slot, items, future))

    def _settled(self, slot: int, items: list[Item], future: Future[Any]) -> list[tuple[int, Found | Missing]]:
        """Results of a chunk; of one that was lost, those that are given up."""
        error = _error(future)
        if error is None:
            if self._made.get(slot, 0) >= RETIRED:
                self._fill()
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
