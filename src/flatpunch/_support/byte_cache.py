"""Results kept in memory for the next call, bounded by their bytes in the whole process.

`functools.lru_cache` counts entries, but a flat punch on one layer takes some kB and the tables of a thin skin tens of MB. The
functions decorated with `byte_cached` share one limit; when it is exceeded, the entries used longest ago are dropped.

An entry is measured when it is made. Many grow afterwards: punch families and series sample new panels when these are first
read, and report it (`grown`). When the sum exceeds the limit, all entries are measured again, from the one used last on, what
several hold once; those beyond three quarters of the limit are dropped. Small ones stay: a table of forces is a few kB, and
hundreds of series of MB each were solved for it.
"""

from __future__ import annotations

import functools
import gc
import os
import sys
import threading
import types
from collections.abc import Callable, Hashable
from typing import Any, Generic, ParamSpec, TypeVar

import numpy as np

LIMIT_VARIABLE = "FLATPUNCH_CACHE_MB"
"""Environment variable with the limit in MB."""

DEFAULT_MB = 200.0
"""Limit where the environment sets none; half as much is noticed where more than ten media are used in turn."""

P = ParamSpec("P")
R = TypeVar("R")

_NOT_COUNTED = (type, types.ModuleType, types.BuiltinFunctionType, types.CodeType, types.FrameType)


class _Entry:
    __slots__ = ("home", "key", "used", "value")

    def __init__(self, home: dict[Hashable, _Entry], key: Hashable, value: object) -> None:
        self.home, self.key, self.value, self.used = home, key, value, 0


class ByteCache:
    """Entries of several functions under one limit [bytes]; None reads the environment when the first entry is made."""

    def __init__(self, limit: int | None = None) -> None:
        self._limit = limit
        self._lock = threading.RLock()
        self._entries: dict[int, _Entry] = {}
        self._uses = 0
        self.bytes = 0
        self._measured = 0

    @property
    def limit(self) -> int:
        """Bytes of all entries together."""
        if self._limit is None:
            self._limit = int(1e6 * _megabytes())
        return self._limit

    def use(self, entry: _Entry) -> Any:
        """Return the value of an entry, which becomes the one used last."""
        self._uses += 1
        entry.used = self._uses
        return entry.value

    def add(self, home: dict[Hashable, _Entry], key: Hashable, value: object) -> Any:
        """Keep a value; return it, or that which another thread has kept under this key in the meantime."""
        with self._lock:
            if key in home:
                return self.use(home[key])
            entry = home[key] = _Entry(home, key, value)
            self._entries[id(entry)] = entry
            self.bytes += size_of([key, value], set())
            # what is in use may exceed the limit by itself: then it is measured only when it has grown by as much again
            if self.bytes > max(self.limit, self._measured + self.limit / 4):
                self.use(entry)
                self._shrink()
            return self.use(entry)

    def grown(self, more: int) -> None:
        """Count bytes by which an entry has grown."""
        self.bytes += more

    def clear(self, home: dict[Hashable, _Entry]) -> None:
        """Drop all entries of one function."""
        with self._lock:
            for entry in list(home.values()):
                self._drop(entry)

    def _shrink(self) -> None:
        """Measure all entries, and drop those beyond three quarters of the limit but for the one used last and small ones.

        Small are those below half of what each might have, so that all of them together take no more than half.
        """
        seen, cyclic = set[int](), False
        kept = 3 * self.limit // 4
        last, *others = sorted(self._entries.values(), key=lambda entry: -entry.used)
        total = size_of([last.key, last.value], seen)
        sizes = [size_of([entry.key, entry.value], seen) for entry in others]
        small = kept / (2 * len(self._entries))
        total += sum(size for size in sizes if size < small)
        for entry, size in zip(others, sizes, strict=True):
            if size < small:
                continue
            if total + size <= kept:
                total += size
            else:
                self._drop(entry)
                cyclic = cyclic or _may_refer_to_itself(entry.value)
        self.bytes = self._measured = total
        if cyclic:
            # series refer to themselves through the functions they sample: only a collection frees them
            gc.collect()

    def _drop(self, entry: _Entry) -> None:
        entry.home.pop(entry.key, None)
        self._entries.pop(id(entry), None)


PROCESS = ByteCache()
"""The cache of this process."""


class ByteCached(Generic[P, R]):
    """A function whose results are kept; see `byte_cached`."""

    def __init__(self, function: Callable[P, R], cache: ByteCache) -> None:
        self._function, self._cache = function, cache
        self._kept: dict[Hashable, _Entry] = {}
        functools.update_wrapper(self, function)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> R:
        """Return what was kept, or call the function."""
        key = (args, *kwargs.items()) if kwargs else args
        try:
            entry = self._kept.get(key)
        except TypeError:
            # an unhashable part, such as a user's own indenter: nothing is kept
            return self._function(*args, **kwargs)
        if entry is not None:
            kept: R = self._cache.use(entry)
            return kept
        made: R = self._cache.add(self._kept, key, self._function(*args, **kwargs))
        return made

    def __reduce__(self) -> str:
        """Other processes find the function by its name."""
        return str(vars(self)["__qualname__"])

    def cache_clear(self) -> None:
        """Drop the results of this function."""
        self._cache.clear(self._kept)


def byte_cached(function: Callable[P, R], cache: ByteCache = PROCESS) -> ByteCached[P, R]:
    """Decorate a function: its results for hashable arguments are kept within the limit of the process."""
    return ByteCached(function, cache)


def _may_refer_to_itself(value: object) -> bool:
    """Whether only a collection may free it; arrays and tuples of them are free at once, and a collection takes 0.1 s."""
    return any(map(gc.is_tracked, value if isinstance(value, tuple) else (value,)))


def size_of(things: list[object], seen: set[int]) -> int:
    """Bytes of objects and of everything they hold, but for the identities in `seen`, which grows.

    Arrays count with the memory of the array that they are views of; code, classes and modules do not count.
    """
    waiting, total = list(things), 0
    while waiting:
        found = waiting.pop()
        while isinstance(found, np.ndarray) and isinstance(found.base, np.ndarray):
            found = found.base
        if id(found) in seen or isinstance(found, _NOT_COUNTED):
            continue
        seen.add(id(found))
        if isinstance(found, np.ndarray):
            total += found.nbytes
        elif isinstance(found, types.FunctionType):
            waiting += [found.__closure__, found.__defaults__]
        else:
            total += sys.getsizeof(found)
            waiting += gc.get_referents(found)
    return total


def _megabytes() -> float:
    text = os.environ.get(LIMIT_VARIABLE, "")
    try:
        found = float(text) if text else DEFAULT_MB
    except ValueError:
        found = -1.0
    if not 0 <= found < float("inf"):
        raise ValueError(
            f"{LIMIT_VARIABLE} = {text[:100]!r} in the environment must be a number of megabytes >= 0, as in "
            f"{LIMIT_VARIABLE}={DEFAULT_MB:g}."
        )
    return found
