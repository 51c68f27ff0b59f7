"""Functions of ln a that are expensive to evaluate, as piecewise Chebyshev series cut at the radii at which they have kinks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.numerics.piecewise import PiecewiseChebyshev, Plain, Root, Variable


def log_table(
    sample: Callable[[Array], Array], reach: float = np.inf, kinks: tuple[float, ...] = ()
) -> PiecewiseChebyshev:
    """A vector function of x = ln a, from values (n, outputs) at radii a (n,) [m].

    No radius beyond `reach` [m] is sampled. At `kinks` [m] the function has kinks, beyond which it is a series in the root of
    the distance.
    """
    end, cuts = float(np.log(reach)), np.log(kinks) if kinks else np.empty(0)

    def edges(x: Array) -> Array:
        return _edges(float(x.min()), float(x.max()), end, cuts)

    def variable(low: float, high: float) -> Variable:
        before = cuts[cuts <= low]
        # root of the distance from a kink, in ln a, below which slopes rise no further; half of it doubles the slope at a kink
        return Root(float(before.max()), 0.1) if before.size else Plain()

    return PiecewiseChebyshev(
        lambda x: sample(np.minimum(np.exp(x), reach)), edges, lambda low, high: 11, variable, together=True
    )


def _edges(low: float, high: float, end: float, kinks: Array) -> Array:
    """Ends of the spans that hold ln a from `low` to `high`."""
    # spans per decade; half as many leave 1e-7 of smooth functions in the place of 1e-10
    step, narrowest = np.log(10) / 4, 1e-6
    # one of the even ends may be next to the reach, and make way for it below
    first = min(np.floor(low / step), np.ceil((end - 2 * narrowest) / step) - 1)
    even = np.arange(first, np.floor(high / step) + 2) * step
    kinks = kinks[(kinks > even[0]) & (kinks < min(even[-1], end))]
    # what is next to a kink or to the reach makes way for it
    fixed = np.append(kinks, end) if end <= even[-1] else kinks
    even = even[even < end]
    if fixed.size:
        even = even[np.abs(even[:, None] - fixed).min(axis=1) > narrowest]
    return np.unique(np.concatenate([even, fixed]))
