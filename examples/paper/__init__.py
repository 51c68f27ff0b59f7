"""The case studies of Forsbach and Willert (2023): figures 2 to 12 by the fast methods and by boundary elements."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from flatpunch._support.threads import one_blas_thread

if TYPE_CHECKING:
    from flatpunch._support.progress import Report as Progress
    from paper.report import Report

__all__ = ["FIGURES", "reproduce", "wanted_figures"]

FIGURES = tuple(range(2, 13))
"""The paper's figures that hold numbers."""


def reproduce(
    folder: Path,
    *,
    quick: bool = False,
    figures: tuple[int, ...] = FIGURES,
    jobs: int = 0,
    progress: Progress | None = None,
    step: Callable[[str], None] | None = None,
) -> Report:
    """Solve what is missing, draw the figures, write tables and the page.

    Parameters
    ----------
    folder : Path
        Where everything goes; solved points are kept in its folder `points`.
    quick : bool
        Few points on coarse grids.
    figures : tuple of int
        Numbers of the paper's figures; those that share their solutions (2 and 3, 4 and 5, ...) come together.
    jobs : int
        Number of processes; 0 is one for each core.
    progress : callable, optional
        Called with (points there, points wanted).
    step : callable, optional
        Called with what is being drawn.

    Returns
    -------
    Report
        Deviations and statements with their numbers.

    See Also
    --------
    flatpunch.sweep : Studies of your own.

    Examples
    --------
    >>> from pathlib import Path
    >>> from paper import reproduce
    >>> report = reproduce(Path("paper"), quick=True, figures=(10,), jobs=1)
    >>> print((Path("paper") / "figure_10.png").is_file())
    True
    """
    # the command line imports this module; drawing is imported when something is drawn
    from flatpunch.parallel import cores
    from paper import plan as plans
    from paper.points import Store
    from paper.report import make

    plan = plans.quick() if quick else plans.full()
    folder.mkdir(parents=True, exist_ok=True)
    store = Store(folder / "points")
    # the matrices are small: on busy cores a second thread for them made the drawing ten times slower
    with one_blas_thread():
        store.solve(plan.points(figures), jobs or cores(), progress)
        return make(plan, figures, store, folder, step or (lambda what: None))


def wanted_figures(text: str) -> tuple[int, ...]:
    """Turn "2,3" or "6-9" into figure numbers."""
    found: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d+)\s*(?:-\s*(\d+)\s*)?", part)
        numbers = range(int(match[1]), int(match[2] or match[1]) + 1) if match else range(0)
        if not numbers or not set(numbers) <= set(FIGURES):
            raise ValueError(
                f"figures = {text!r} must name figures from {FIGURES[0]} to {FIGURES[-1]}, such as 2,3 or 6-9."
            )
        found |= set(numbers)
    return tuple(sorted(found))
