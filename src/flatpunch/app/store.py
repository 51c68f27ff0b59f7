"""What the page keeps in memory, the oldest first to go: results of cases by their form, and files that were uploaded."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Generic, TypeVar

Kept = TypeVar("Kept")


class Store(Generic[Kept]):
    """Things by name, up to so many bytes together; `size` gives the bytes of one."""

    def __init__(self, most: int, size: Callable[[Kept], int]) -> None:
        self._most, self._size = most, size
        self._things: OrderedDict[str, Kept] = OrderedDict()
        self._total = 0
        self._lock = threading.Lock()

    def put(self, name: str, thing: Kept) -> None:
        """Keep a thing; one of the same name is replaced."""
        with self._lock:
            self._drop(name)
            self._things[name] = thing
            self._total += self._size(thing)
            while self._total > self._most and len(self._things) > 1:
                self._drop(next(iter(self._things)))

    def get(self, name: str) -> Kept | None:
        """Return a thing, which becomes the youngest; None if it is not here, or no longer."""
        with self._lock:
            if name in self._things:
                self._things.move_to_end(name)
            return self._things.get(name)

    def _drop(self, name: str) -> None:
        thing = self._things.pop(name, None)
        self._total -= 0 if thing is None else self._size(thing)
