"""Threads of linear algebra: one while its matrices are small, and threads of our own where there are many of these.

Threads of BLAS stay awake and wait for each other between products. Where other work keeps the cores busy each wait lasts until
the system lets the other thread run again: on two busy cores a curve took four to twenty times as long as with one thread.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache

from threadpoolctl import ThreadpoolController, threadpool_limits

_WORTHWHILE = 2e8
"""Floating-point operations for which another thread is started: 5 to 10 ms."""


def cores() -> int:
    """Cores that this process may use, which on a shared machine are fewer than it has."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def allowed_threads() -> int:
    """Threads or processes for one call: the cores this process may use, or OMP_NUM_THREADS if that is less."""
    limit = os.environ.get("OMP_NUM_THREADS", "")
    return min(cores(), int(limit)) if limit.isdigit() and int(limit) > 0 else cores()


class _Given(threading.local):
    """Threads that linear algebra had when this thread of the program asked for one; None while it does not."""

    before: int | None = None


_given = _Given()


@lru_cache(maxsize=2)
def _selected(scipy_loaded: bool) -> ThreadpoolController:
    return ThreadpoolController().select(user_api="blas")


def _libraries() -> ThreadpoolController:
    # SciPy brings a library of its own, which is there only once it is imported
    return _selected("scipy.linalg" in sys.modules)


def _now() -> int:
    return max((library.num_threads for library in _libraries().lib_controllers), default=1)


def threads() -> int:
    """Threads that linear algebra was given: by the cores of the machine, by the environment, or by threadpoolctl."""
    return _now() if _given.before is None else _given.before


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep linear algebra at one thread; of several threads of a program, threadpoolctl listens to the first that asked."""
    if _given.before is not None:
        yield
        return
    _given.before = _now()
    try:
        with _libraries().limit(limits=1):
            yield
    finally:
        _given.before = None


@contextmanager
def given_blas_threads() -> Iterator[None]:
    """Give linear algebra its threads back for a while, where its matrices are large."""
    if _given.before is None:
        yield
        return
    before, _given.before = _given.before, None
    try:
        with _libraries().limit(limits=before):
            yield
    finally:
        _given.before = before


def in_threads(function: Callable[[int], None], count: int, operations: float) -> None:
    """Call function(i) for i = 0 ... count - 1, with one thread of linear algebra each, in as many threads as it was given.

    `operations` are those of all calls together; threads that would have less than a few milliseconds to do are not started.
    """
    several = min(threads(), count, int(operations / _WORTHWHILE))
    with one_blas_thread():
        if several < 2 or _now() > 1:
            for i in range(count):
                function(i)
            return
        with ThreadPoolExecutor(several) as pool:
            for _ in pool.map(function, range(count)):
                pass


ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "BLIS_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMEXPR_NUM_THREADS",
    ),
    "1",
)
"""Environment of worker processes: as many processes as cores do not compete for them."""


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep libraries that are loaded, and by the environment those loaded later and in new processes, at one thread."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        with threadpool_limits(1):
            yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
