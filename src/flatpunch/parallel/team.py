"""Processes that help this one with a handful of long calls, started when first worth it and kept for the next.

Some tenths of a second of work each are too few for workers of their own (`processes`), which would be gone again when they have
loaded what they call. Helpers load it while this process already works, take a share of what is left, and stay for a while.
Nothing depends on them: what they do not bring back, for whatever reason, is called here.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import sys
import threading
import warnings
from collections import deque
from collections.abc import Callable, Sequence
from importlib import import_module
from multiprocessing.connection import Connection, wait
from typing import Any

from flatpunch._threads import allowed_threads
from flatpunch.parallel.interruption import left_to_parent, unheard_by_children
from flatpunch.parallel.processes import fresh, no_main, of_main
from flatpunch.parallel.threads import one_thread

_MOST = 3
"""Helpers at most: rounds are of some eight calls, and each helper holds a hundred megabytes."""
_FEWEST = 4
"""Calls for which helpers are started; those that are there help with two."""
_AHEAD = 2
"""Calls that a helper has at hand, so that it need not wait until this process looks up from its own."""
_SMALL = 2**14
"""Bytes of a call that certainly fit into a pipe."""
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


def call_helpers(module: str, common: Any, calls: int) -> None:
    """Let helpers load a module while there is other work to do, where so many calls of `shared_out` will follow.

    `common` is what they will share: where other processes would not understand it there are none.
    """
    if calls < _FEWEST or allowed_threads() < 2 or not _team.lock.acquire(blocking=False):
        return
    try:
        if _packed(common):
            _team.called(calls, module)
    finally:
        _team.lock.release()


class _Team:
    """The helpers of this process."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self._helpers: list[_Helper] = []
        self._owner = os.getpid()

    def called(self, calls: int, module: str) -> list[_Helper]:
        """Helpers for so many calls of a module's function; new ones if that is worth it."""
        if self._owner != os.getpid():  # a fork, whose parent's they are
            self._helpers, self._owner = [], os.getpid()
        self._helpers = [helper for helper in self._helpers if helper.alive]
        wanted = min(allowed_threads(), calls, _MOST + 1) - 1
        if calls >= _FEWEST and not multiprocessing.current_process().daemon and not getattr(sys, "frozen", False):
            with contextlib.suppress(OSError):
                while len(self._helpers) < wanted:
                    self._helpers.append(_Helper(module))
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
        helpers, waiting = self.called(len(items), module), deque(range(len(items)))
        case = packed[:2]
        own: list[int] = []
        found: dict[int, Any] = {}
        with contextlib.ExitStack() as unless_finished:
            # where it ends early, they are at what nobody waits for any more
            unless_finished.callback(self.dismiss)
            while len(found) < len(items):
                for helper in helpers:
                    for index, outcome in helper.answers():
                        if outcome is None:
                            own.append(index)
                        else:
                            found[index] = outcome[0]
                            done(outcome[0])
                # the longest that are left: one for each that is idle, one for this process, then what they have at hand
                self._hand_out(helpers, waiting, case, packed, idle=True)
                mine = own.pop() if own else waiting.pop() if waiting else None
                self._hand_out(helpers, waiting, case, packed, idle=False)
                if mine is not None:
                    found[mine] = call(items[mine])
                elif len(found) < len(items):
                    wait([helper.pipe for helper in helpers if helper.at])
            unless_finished.pop_all()
        return [found[index] for index in range(len(items))]

    @staticmethod
    def _hand_out(
        helpers: list[_Helper], waiting: deque[int], case: list[bytes], packed: list[bytes], *, idle: bool
    ) -> None:
        """Give calls that wait to helpers that are idle, or to others as well."""
        for helper in helpers:
            while waiting and not (idle and helper.at) and helper.takes(len(waiting), len(packed[2 + waiting[-1]])):
                index = waiting.pop()
                helper.give(case, index, packed[2 + index])

    def dismiss(self) -> None:
        """Let all helpers go."""
        for helper in self._helpers:
            helper.end()
        self._helpers = []


class _Helper:
    """A process, the pipe to it, and the indices of the calls it has."""

    def __init__(self, module: str) -> None:
        self.pipe, end = fresh.Pipe()
        self.at: list[int] = []
        self._case: list[bytes] | None = None
        self._ready = False
        self._process = fresh.Process(target=_help, args=(end,), name="flatpunch-helper", daemon=True)
        with one_thread(), unheard_by_children(), no_main():
            self._process.start()
        end.close()
        self._send(module)

    @property
    def alive(self) -> bool:
        return bool(self._process.is_alive())

    def takes(self, waiting: int, size: int) -> bool:
        """Whether it may have one more of those that wait, of so many bytes; the last is left to whoever is free.

        A busy helper does not read: what it gets ahead must fit into the pipe, or both would wait for each other.
        """
        ahead = len(self.at) < _AHEAD and waiting > 1 and size < _SMALL
        return self._ready and self.alive and (not self.at or ahead)

    def give(self, case: list[bytes], index: int, item: bytes) -> None:
        """Hand over a call: its item, and function and common part if these are others than last time."""
        self.at.append(index)
        self._send((None if case == self._case else case, index, item))
        self._case = case

    def _send(self, thing: Any) -> None:
        with contextlib.suppress(OSError):  # it is gone; that shows where its answer is awaited
            self.pipe.send(thing)

    def answers(self) -> list[tuple[int, tuple[Any] | None]]:
        """What it has brought by now: index, and (outcome,) or None where it has none to show."""
        found: list[tuple[int, tuple[Any] | None]] = []
        try:
            while self.pipe.poll():
                index, outcome = self.pipe.recv()
                if index is None:
                    self._ready = True
                    continue
                self.at.remove(index)
                found.append((index, outcome))
        except (EOFError, OSError):
            found += [(index, None) for index in self.at]
            self.at, self._ready = [], False
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


def _help(pipe: Connection) -> None:
    """Answer calls that come through the pipe, until it is closed or nothing comes any more."""
    left_to_parent()
    with contextlib.suppress(EOFError, OSError):
        # where that fails this process is gone
        import_module(pipe.recv())
        known: tuple[Any, ...] = ()
        pipe.send((None, None))
        while pipe.poll(_IDLE):
            case, index, item = pipe.recv()
            outcome = None
            with contextlib.suppress(Exception), warnings.catch_warnings():
                # what fails or warns is called again where the caller hears of it
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", DeprecationWarning)
                if case is not None:
                    known = ()  # which answers nothing, should the next line fail
                    known = tuple(pickle.loads(part) for part in case)
                function, common = known
                outcome = (function(common, pickle.loads(item)),)
            pipe.send((index, outcome))
