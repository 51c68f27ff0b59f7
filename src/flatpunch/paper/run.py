"""Solve the missing points in parallel, one process per core and one thread in each.

Points of one row (body, indenter, size) go to one process together: they share the indenter and the kernel. Every finished point
is on disk before the next one starts, so an interrupt loses at most one point per process.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, wait
from contextlib import contextmanager
from pathlib import Path

from flatpunch.paper.points import Point, Store, solve

Progress = Callable[[int, int], None]

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_POLL = 0.3


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def solve_missing(points: list[Point], store: Store, jobs: int, progress: Progress | None = None) -> int:
    """Solve what is not in the store; the number of points solved.

    Parameters
    ----------
    points : list of Point
        All points wanted.
    store : Store
        Where they are kept.
    jobs : int
        Number of processes; 1 works in this one.
    progress : callable, optional
        Called with (points there, points wanted).
    """
    missing, wanted = store.missing(points), len(set(points))
    report = progress or (lambda done, total: None)
    report(wanted - len(missing), wanted)
    rows = _rows(missing)
    if not rows:
        return 0
    if jobs == 1:
        for row in rows:
            for point in row:
                solve([point], store)
                report(wanted - len(store.missing(missing)), wanted)
        return len(missing)
    # forked threads of a numerical library may hang; fresh processes do not
    fresh = multiprocessing.get_context("spawn")
    with _one_thread(), ProcessPoolExecutor(min(jobs, len(rows)), fresh) as pool:
        try:
            pending = {pool.submit(_solve_row, row, store.folder) for row in rows}
            while pending:
                done, pending = wait(pending, timeout=_POLL)
                for future in done:
                    future.result()
                report(wanted - len(store.missing(missing)), wanted)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return len(missing)


def _solve_row(row: list[Point], folder: Path) -> int:
    return solve(row, Store(folder))


def _rows(points: list[Point]) -> list[list[Point]]:
    """Points of the same body, indenter and size, those with the most cells first so that no long one comes last."""
    rows: dict[tuple[object, ...], list[Point]] = {}
    for point in points:
        rows.setdefault((point.body, point.shape, point.eccentricity, point.cells), []).append(point)
    return sorted(rows.values(), key=lambda row: -sum(p.cells**2 * (4 if p.fields else 1) for p in row))


@contextmanager
def _one_thread() -> Iterator[None]:
    """Environment for the new processes: as many threads as processes would fight over the cores."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def elapsed(start: float) -> str:
    """Seconds since `start`, readable."""
    seconds = time.monotonic() - start
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.1f} min"
