"""How many threads linear algebra takes beside small grids and large ones."""

from __future__ import annotations

from contextlib import AbstractContextManager

from flatpunch._threads import given_blas_threads, one_blas_thread
from flatpunch.bem.operator import THREADED


def fitting_threads(cells: int) -> AbstractContextManager[None]:
    """One thread of linear algebra while solving on grids of so few cells that more would wait for each other.

    On 256 x 256 cells two threads took 1.4 to 1.8 times as long as one: they stay awake between the many small products.
    """
    return given_blas_threads() if cells >= THREADED else one_blas_thread()
