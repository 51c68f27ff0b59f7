"""Functions of log(beta), sampled once on Chebyshev panels and kept.

All properties of a medium's flat punches are analytic in log(beta). Panels are a decade wide where the contact is small against
every length of the medium and a quarter of one where it is large: larger radii cost more, and a panel should not reach far beyond
what is read. They are halved until their series end.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.numerics.chebyshev import NODES, polynomials, tail
from flatpunch.numerics.piecewise import Piece, PiecewiseChebyshev
from flatpunch.punch.matrix import RESOLVED, effective_beta

TOLERANCE = 1e-10
"""Tail above which a panel is halved; a tenth of it is below rounding, ten times as much shows in slopes."""


_WIDTHS = np.array([4, 2, 1, 2])
"""Widths of panels in quarters of a decade, with growing radius; wider ones are halved, narrower ones solve more radii."""

_DECADE = int(_WIDTHS[0])

_UNIT = np.log(10) / _DECADE
"""Unit of the widths in ln beta."""

_NODES = {1: 16}
"""Nodes by width, `NODES` of the others: 16 leave as little on narrow panels, 1e-14 to 1e-12 of flat and edge responses."""


_ENDS = np.array([0.1, 4.0, RESOLVED])
"""Effective beta at the end of a half decade above which panels have the next of the widths."""


def panels(
    kernel: Kernel,
    sample: Callable[[Array], Array],
    judge: Callable[[Array], float] = tail,
    floor: Callable[[Array], float] = lambda series: 0.0,
) -> PiecewiseChebyshev:
    """A function of x = log(beta) for one medium, whose shortest length decides where panels may be wide.

    `sample` maps the radii at the nodes of one panel, shape (n,), to values, shape (n, outputs); `judge` maps Chebyshev
    coefficients, shape (nodes, outputs), to the relative size of their tail, which decides on halving, and `floor` to the tail
    that is rounding, which no halving removes.
    """
    bounds = _bounds(kernel)

    def edges(x: Array) -> Array:
        first, last = (np.floor(end / (_DECADE * _UNIT)) for end in (x.min(), x.max()))
        unit = np.arange(_DECADE * first, _DECADE * (last + 1))
        width = _WIDTHS[np.searchsorted(bounds, unit // 2, side="right")]
        return np.asarray(np.append(np.unique(unit // width * width), unit[-1] + 1) * _UNIT)

    def beyond(low: float) -> bool:
        """Whether the contacts of a panel that begins here are too wide to resolve the shortest length."""
        return bool(low > (2 * bounds[-1] - 0.5) * _UNIT)

    def nodes(low: float, high: float) -> int:
        # nodes beyond the resolved lengths, where functions are nearly powers of beta and 1e-8 is enough
        return 10 if beyond(low) else _NODES.get(round((high - low) / _UNIT), NODES)

    def rough(piece: Piece) -> bool:
        # more on graded media, whose responses are interpolated to 2e-12 and differentiated for edges, and beyond the resolved
        # lengths, where truncation leaves as much of radii; forces at given depth have its square
        tolerance = 1e-9 if kernel.graded else 1e-5 if beyond(piece.low) else TOLERANCE
        return piece.error > max(tolerance, floor(piece.series)) and piece.high - piece.low > _UNIT / 2

    # responses of steep gradings have noise far below this, poles of outlines have tails far above it
    noise = 1e-5 if kernel.graded else 0.0
    return PiecewiseChebyshev(lambda x: sample(np.exp(x)), edges, nodes, judge=judge, rough=rough, noise=noise)


def _bounds(kernel: Kernel) -> Array:
    """Half decades of log(beta) above which panels have the next of the widths."""
    if kernel.graded:
        # radii of any size cost the same
        return np.full(_ENDS.size, np.inf)
    with np.errstate(divide="ignore"):
        return np.asarray(np.ceil(np.log(_ENDS / np.float64(effective_beta(kernel, 1.0))) / (2 * _UNIT) - 1))


def polynomials_on(parts: list[tuple[Piece, Indices]], logs: Array) -> Array:
    """Chebyshev polynomials at many log(beta), each of its own panel, shape (nodes, n): once for all panels, which is faster."""
    x = np.empty_like(logs)
    for panel, inside in parts:
        x[inside] = panel.unit(logs[inside])
    return polynomials(x, max((panel.nodes for panel, _ in parts), default=1) - 1)
