"""How many threads linear algebra takes beside small grids."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache

from threadpoolctl import ThreadpoolController

from flatpunch.bem.operator import THREADED


@lru_cache(maxsize=1)
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


@contextmanager
def fitting_threads(cells: int) -> Iterator[None]:
    """One thread of linear algebra while solving on grids of so few cells that more would wait for each other.

    On 256 x 256 cells two threads took 1.4 to 1.8 times as long as one: they stay awake between the many small products.
    """
    if cells >= THREADED:
        yield
        return
    with _libraries().limit(limits=1, user_api="blas"):
        yield
