"""Processes that help this one with a handful of long calls, started when first worth it and kept for the next.

Some tenths of a second of work each are too few for workers of their own (`processes`), which would be gone again when they have
loaded what they call. Helpers load it while this process already works, take a share of what is left, and stay for a while.
Each has all calls of a round, and a counter that all share says which is next: whoever is free takes it and waits for nobody.
Nothing depends on helpers: what they do not bring back, for whatever reason, is called here.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import sys
import threading
import warnings
from collections.abc import Callable, Sequence
from importlib import import_module
from multiprocessing.connection import Connection, wait
from typing import Any

from flatpunch._support.threads import allowed_threads
from flatpunch.parallel.interruption import left_to_parent, unheard_by_children
from flatpunch.parallel.processes import fresh, no_main, of_main
from flatpunch.parallel.threads import one_thread

_MOST = 3
"""Helpers at most: rounds are of some eight calls, and each helper holds a hundred megabytes."""
_FEWEST = 4
"""Calls for which helpers are started; those that are there help with two."""
_SMALL = 2**14
"""Bytes of calls that certainly fit into a pipe, whose other end does not read yet."""
_STUCK = 1.0
"""Seconds after which the counter counts as lost: with a process that was killed while it counted."""
_IDLE = 120.0
"""Seconds after which a helper that is not called goes."""


def shared_out(
    function: Callable[[Any, Any], Any],
    common: Any,
    items: Sequence[Any],
    *,
    done: Callable[[Any], None] = lambda outcome: None,
    helped: bool = True,
) -> list[Any]:
    """Return function(common, item) of every item, in order, called here and in helpers.

    Parameters
    ----------
    function : callable
        Of a module; what it returns depends on nothing but its arguments.
    common : object
        What all calls share; unpickled once.
    items : sequence
        One for each call. The last are called first: put those that take long at the end.
    done : callable, optional
        Called here with each outcome as it comes.
    helped : bool
        Whether helpers may take part, each of which needs as much memory as this process.
    """

    def call(item: Any) -> Any:
        outcome = function(common, item)
        done(outcome)
        return outcome

    if not helped or len(items) < 2 or allowed_threads() < 2 or not _team.lock.acquire(blocking=False):
        return [call(item) for item in items]
    try:
        packed = _packed(function, common, *items)
        return (
            _team.shared(call, function.__module__, items, packed, done) if packed else [call(item) for item in items]
        )
    finally:
        _team.lock.release()


def call_helpers(module: str, common: Any, calls: int, *, meanwhile: Sequence[str] = ()) -> None:
    """Let helpers load a module while there is other work to do, where so many calls of `shared_out` will follow.

    `common` is what they will share: where other processes would not understand it there are none. Modules that this process
    needs only after these calls are loaded `meanwhile`: once helpers are at the first of them.
    """
    if calls < _FEWEST or allowed_threads() < 2 or not _team.lock.acquire(blocking=False):
        return
    try:
        if _packed(common) and _team.called(calls, module):
            _team.meanwhile += meanwhile
    finally:
        _team.lock.release()


class _Turns:
    """The counter of the calls of a round, the last first; shared by all processes."""

    def __init__(self) -> None:
        self._state = fresh.Array("q", 2)  # number of the round, calls taken

    def start(self, number: int) -> bool:
        """Begin a round; False if the counter is lost."""
        if not self._state.get_lock().acquire(timeout=_STUCK):
            return False
        self._state[:] = [number, 0]
        self._state.get_lock().release()
        return True

    def take(self, number: int, calls: int) -> int | None:
        """Index of the next call of a round; None if there is none any more, or another round has begun."""
        if not self._state.get_lock().acquire(timeout=_STUCK):
            return None
        now, taken = self._state[:]
        if now == number and taken < calls:
            self._state[1] = taken + 1
        self._state.get_lock().release()
        return calls - 1 - taken if now == number and taken < calls else None


class _Team:
    """The helpers of this process."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.meanwhile: list[str] = []
        self._helpers: list[_Helper] = []
        self._turns: _Turns | None = None
        self._round = 0
        self._owner = os.getpid()

    def called(self, calls: int, module: str) -> list[_Helper]:
        """Helpers for so many calls of a module's function; new ones if that is worth it."""
        if self._owner != os.getpid():  # a fork, whose parent's they are
            self._helpers, self._turns, self._owner = [], None, os.getpid()
        self._helpers = [helper for helper in self._helpers if helper.alive]
        wanted = min(allowed_threads(), calls, _MOST + 1) - 1
        if calls >= _FEWEST and not multiprocessing.current_process().daemon and not getattr(sys, "frozen", False):
            with contextlib.suppress(OSError):
                self._turns = self._turns or _Turns()
                while len(self._helpers) < wanted:
                    self._helpers.append(_Helper(module, self._turns))
        return self._helpers[:wanted]

    def shared(
        self,
        call: Callable[[Any], Any],
        module: str,
        items: Sequence[Any],
        packed: list[bytes],
        done: Callable[[Any], None],
    ) -> list[Any]:
        """Outcomes of all items, in order; what a helper did not bring back is called here."""
        helpers, turns = self.called(len(items), module), self._turns
        self._round += 1
        if turns is None or not helpers or not turns.start(self._round):
            self.dismiss()
            return [call(item) for item in items]
        lost: list[int] = []
        found: dict[int, Any] = {}
        with contextlib.ExitStack() as unless_finished:
            # where it ends early, they are at what nobody waits for any more
            unless_finished.callback(self.dismiss)
            while len(found) < len(items):
                for helper in helpers:
                    for index, outcome in helper.answers(self._round):
                        if outcome is None:
                            lost.append(index)
                        else:
                            found[index] = outcome[0]
                            done(outcome[0])
                    helper.join(self._round, packed[:2], packed[2:])
                while self.meanwhile:
                    import_module(self.meanwhile.pop())
                mine = lost.pop() if lost else turns.take(self._round, len(items))
                if mine is not None:
                    found[mine] = call(items[mine])
                elif busy := [helper.pipe for helper in helpers if helper.busy]:
                    if len(found) < len(items):
                        wait(busy)
                else:
                    # taken by helpers that are gone
                    lost = [index for index in range(len(items)) if index not in found]
            unless_finished.pop_all()
        return [found[index] for index in range(len(items))]

    def dismiss(self) -> None:
        """Let all helpers go."""
        for helper in self._helpers:
            helper.end()
        self._helpers, self._turns, self.meanwhile = [], None, []


class _Helper:
    """A process, the pipe to it, and what it is at."""

    def __init__(self, module: str, turns: _Turns) -> None:
        self.pipe, end = fresh.Pipe()
        self.busy = False
        self._case: list[bytes] | None = None
        self._ready, self._round = False, 0
        self._process = fresh.Process(target=_help, args=(end, turns), name="flatpunch-helper", daemon=True)
        with one_thread(), unheard_by_children(), no_main():
            self._process.start()
        end.close()
        self._send(module)

    @property
    def alive(self) -> bool:
        return bool(self._process.is_alive())

    def join(self, number: int, case: list[bytes], items: list[bytes]) -> None:
        """Let it take part in a round: hand over all items, and function and common part if these are others than last time.

        What is handed over before it reads must fit into the pipe.
        """
        if self._round == number or not self.alive or not (self._ready or sum(map(len, case + items)) < _SMALL):
            return
        self._round, self.busy = number, True
        self._send((None if case == self._case else case, number, items))
        self._case = case

    def _send(self, thing: Any) -> None:
        with contextlib.suppress(OSError):  # it is gone; that shows where its answer is awaited
            self.pipe.send(thing)

    def answers(self, number: int) -> list[tuple[int, tuple[Any] | None]]:
        """What it has brought of a round by now: index, and (outcome,) or None where it has none to show."""
        found: list[tuple[int, tuple[Any] | None]] = []
        try:
            while self.pipe.poll():
                self._ready = True
                of_round, index, outcome = self.pipe.recv()
                if of_round != number:
                    continue
                if index is None:
                    self.busy = False
                else:
                    found.append((index, outcome))
        except (EOFError, OSError):
            self.busy = self._ready = False
        return found

    def end(self) -> None:
        """Stop it, whatever it does."""
        self.pipe.close()
        self._process.kill()
        self._process.join()
        self._process.close()


_team = _Team()


def _packed(*things: Any) -> list[bytes]:
    """The things for another process; none if it would not understand one of them.

    They must be made of what can be pickled, and nothing of the script that runs here.
    """
    try:
        packed = [pickle.dumps(thing) for thing in things]
    except (pickle.PicklingError, AttributeError, TypeError):
        return []
    return [] if any(of_main(part) for part in packed) else packed


def _help(pipe: Connection, turns: _Turns) -> None:
    """Answer calls that come through the pipe, until it is closed or nothing comes any more."""
    left_to_parent()
    with contextlib.suppress(EOFError, OSError):
        # where that fails this process is gone
        import_module(pipe.recv())
        known: tuple[Any, ...] = ()
        pipe.send((0, None, None))
        while pipe.poll(_IDLE):
            case, number, items = pipe.recv()
            if case is not None:
                known = ()  # which answers nothing, should the next line fail
                with contextlib.suppress(Exception):
                    known = tuple(pickle.loads(part) for part in case)
            while known and (index := turns.take(number, len(items))) is not None:
                outcome = None
                with contextlib.suppress(Exception), warnings.catch_warnings():
                    # what fails or warns is called again where the caller hears of it
                    warnings.simplefilter("error")
                    warnings.simplefilter("ignore", DeprecationWarning)
                    function, common = known
                    outcome = (function(common, pickle.loads(items[index])),)
                pipe.send((number, index, outcome))
            pipe.send((number, None, None))
