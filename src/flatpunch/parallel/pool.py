"""A few long calls shared with worker processes that are kept for the next ones.

The processes are loky's reusable executor: they are started when first worth it, and end when idle. This process works too. What
a worker does not return, for whatever reason, is called here, so that errors and warnings appear where the caller sees them.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import sys
import warnings
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from functools import lru_cache
from typing import Any, TypeVar

from flatpunch._support.threads import allowed_threads
from flatpunch.parallel.interruption import left_to_parent, unheard_by_children
from flatpunch.parallel.threads import one_thread

FEWEST = 4
"""Calls for which processes are started: with half as many, loading the package takes longer than the calls saved."""

MOST = 3
"""Worker processes at most: twice as many hold another 300 MB, for rounds of some eight calls."""


_PROCESS = os.getpid()

Common = TypeVar("Common")
Given = TypeVar("Given")
Found = TypeVar("Found")


def shared_out(
    function: Callable[[Common, Given], Found],
    common: Common,
    items: Sequence[Given],
    *,
    done: Callable[[Found], None] = lambda outcome: None,
    helped: bool = True,
) -> list[Found]:
    """Return function(common, item) of every item, in order, called here and in worker processes.

    The function is of a module, and what it returns depends on its arguments only; each worker unpickles `common` once. Workers
    begin with the last item: put those that take long at the end. `done` is called here with each outcome. `helped` says whether
    workers may take part, each of which needs as much memory as this process.
    """
    futures: dict[int, Future[Found]] = {}
    waiting, found = deque(range(len(items))), dict[int, Found]()

    def settle(index: int, outcome: Found) -> None:
        found[index] = outcome
        done(outcome)

    work = _packed(function, common) if helped and len(items) >= FEWEST and _may_start() else None
    try:
        if work is not None:
            _share(work, items, waiting, futures)
        while len(found) < len(items):
            for index in [i for i, future in list(futures.items()) if future.done() and i not in found]:
                settle(index, _outcome(futures[index], function, common, items[index]))
            pending = [future for i, future in list(futures.items()) if i not in found]
            own = _popped(waiting.popleft)
            if own is not None:
                settle(own, function(common, items[own]))
            elif pending:
                wait(pending, return_when=FIRST_COMPLETED)
        return [found[index] for index in range(len(items))]
    except BaseException:  # Ctrl-C too: no worker process may go on for a caller that has left; raised again below
        if futures:
            dismiss()
        raise


def dismiss() -> None:
    """End the worker processes, whatever they do."""
    from loky import get_reusable_executor

    get_reusable_executor(max_workers=1).shutdown(wait=True, kill_workers=True)


def _may_start() -> bool:
    """Whether this process has cores to spare and may have children: neither a fork nor a worker itself."""
    own = os.getpid() == _PROCESS and not multiprocessing.current_process().daemon
    return own and not getattr(sys, "frozen", False) and allowed_threads() > 1


def _packed(function: Callable[[Common, Given], Found], common: Common) -> bytes | None:
    """Function and first argument for another process; None where it could not load them."""
    try:
        packed = pickle.dumps((function, common))
    except (pickle.PicklingError, AttributeError, TypeError):
        return None
    # a worker process does not run the script of this one
    return None if b"__main__" in packed else packed


def _share(work: bytes, items: Sequence[object], waiting: deque[int], futures: dict[int, Future[Found]]) -> None:
    """Give each worker the last call that waits, and the next one whenever it has finished one."""
    from loky import get_reusable_executor

    workers = min(allowed_threads() - 1, MOST)
    # seconds after which an idle worker process ends; then the next round has to start it again
    executor = get_reusable_executor(max_workers=workers, timeout=120, initializer=left_to_parent)

    def give(_: Future[Found] | None = None) -> None:
        index = _popped(waiting.pop)
        if index is None:
            return
        try:
            futures[index] = executor.submit(_call, work, items[index])
        except (RuntimeError, OSError):
            # the workers are lost or cannot be started: this process calls what is left
            waiting.append(index)
        else:
            futures[index].add_done_callback(give)

    with one_thread(), unheard_by_children():
        for _ in range(workers):
            give()


def _popped(pop: Callable[[], int]) -> int | None:
    """Next call, which two threads take; None if there is none."""
    with contextlib.suppress(IndexError):
        return pop()
    return None


def _outcome(future: Future[Found], function: Callable[[Common, Given], Found], common: Common, item: Given) -> Found:
    """Outcome of a worker, or of a call here if it has none."""
    try:
        return future.result()
    except Exception:  # whatever the call raised there, it raises again here, where the caller sees it
        return function(common, item)


@lru_cache(maxsize=1)
def _loaded(work: bytes) -> Any:
    return pickle.loads(work)


def _call(work: bytes, item: object) -> object:
    """Call in a worker; what warns fails here, and is called again where the caller sees the warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", DeprecationWarning)
        function, common = _loaded(work)
        return function(common, item)
