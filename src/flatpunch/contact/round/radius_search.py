"""From a prescribed depth or force to the contact radius.

Depth and force are explicit functions of the radius; here they are inverted: a coarse logarithmic grid finds, for each
target, the first interval in which the curve reaches it (where a curve turns back, that is what monotone loading would
find), then Newton's method with the analytic derivative ends at rounding, kept inside that interval.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, BadValue, Indices
from flatpunch._support.prefixes import text
from flatpunch.contact.curve import UNITS
from flatpunch.punch.family import UnresolvedLayer

Quantity = Literal["depth", "force"]


class Loading(Protocol):
    """Contacts along a path over the radius a: depth, force, dF/dd and a d'(a), shape (n,) each."""

    @property
    def depth(self) -> Array: ...  # noqa: D102

    @property
    def force(self) -> Array: ...  # noqa: D102

    @property
    def stiffness(self) -> Array: ...  # noqa: D102

    @property
    def depth_slope(self) -> Array: ...  # noqa: D102


PER_DECADE = 12
"""Radii per decade: half as many may miss a turn of the path and change forces by 2e-10, twice as many by 1e-12."""

_MOST_DECADES = 40
"""Decades around the expected radius within which it is searched for."""


def radius_for(
    evaluate: Callable[[Array], Loading],
    quantity: Quantity,
    target: Array,
    guess: float,
    reach: float,
    resolved: float = float("inf"),
    near: bool = False,
) -> Array:
    """Contact radii [m] at which a round contact has the wanted depths or forces >= 0, shape (n,); 0 gives 0.

    `guess` is of the order of magnitude of the largest, and close to it where `near`; `reach` is the largest radius of the
    indenter and `resolved` the largest one that `evaluate` accepts [m]. A ValueError says which of them a target exceeds.
    """
    radius = np.zeros_like(target)
    live = target > 0
    if not live.any():
        return radius
    nodes = _bracket(evaluate, quantity, target[live], min(guess, reach, resolved), reach, resolved, near)
    # a target that exceeds the last one within reach by rounding is that one
    wanted = np.minimum(target[live], nodes.value.max())
    radius[live] = _newton(evaluate, quantity, wanted, nodes)
    return radius


@dataclass(frozen=True, slots=True)
class _Nodes:
    """The curve on a grid: ln a, the quantity q, and dln q/dln a; shape (n,)."""

    x: Array
    value: Array
    growth: Array

    def joined(self, other: _Nodes) -> _Nodes:
        """These nodes followed by the others."""
        pairs = ((self.x, other.x), (self.value, other.value), (self.growth, other.growth))
        return _Nodes(*(np.concatenate(pair) for pair in pairs))


def _sample(evaluate: Callable[[Array], Loading], quantity: Quantity, radius: Array) -> _Nodes:
    contact = evaluate(radius)
    if quantity == "depth":
        value, slope = contact.depth, contact.depth_slope
    else:
        value, slope = contact.force, contact.stiffness * contact.depth_slope
    with np.errstate(divide="ignore", invalid="ignore"):
        return _Nodes(np.log(radius), value, slope / value)


def _bracket(
    evaluate: Callable[[Array], Loading],
    quantity: Quantity,
    wanted: Array,
    guess: float,
    reach: float,
    resolved: float,
    near: bool,
) -> _Nodes:
    """The curve on log-spaced radii, from below all targets to above."""
    step = 10 ** (1 / PER_DECADE)
    decade = np.asarray(step ** np.arange(PER_DECADE), dtype=float)
    # large radii cost most: there, about the guess alone
    nodes = _sample(evaluate, quantity, guess * (step ** np.array([-2.0, -1.0, 0.0]) if near else 1 / decade[::-1]))
    for _ in range(_MOST_DECADES):
        if nodes.value[0] <= wanted.min():
            break
        below = np.exp(nodes.x[0]) / (step * decade[::-1])
        nodes = _sample(evaluate, quantity, below).joined(nodes)
    else:
        raise _out_of_range(quantity, float(wanted.min()), "small")
    for _ in range(4 * _MOST_DECADES):
        if nodes.value.max() >= wanted.max() * (1 - ROUNDING):
            return nodes
        last = float(np.exp(nodes.x[-1]))
        if last >= reach * (1 - ROUNDING):
            raise _beyond(quantity, float(wanted.max()), reach, float(nodes.value.max()))
        if last >= resolved * (1 - ROUNDING):
            bad = _unresolved(quantity, float(wanted.max()), resolved, float(nodes.value.max()))
            raise UnresolvedLayer(str(bad)) from bad
        # no further than needed, the cost of a radius grows with it
        most = min(reach, resolved)
        # extrapolated by the growth of the curve
        left = np.log(wanted.max() / nodes.value[-1]) / nodes.growth[-1] if nodes.growth[-1] > 0 else np.inf
        # how far the grid goes, in ln a, beyond the radius at which the growth of the curve puts the largest target
        enough = last * np.exp(min(left + 0.03, 1.0))
        above = np.unique(np.minimum(last * step ** np.arange(1, 4), min(enough, most)))
        nodes = nodes.joined(_sample(evaluate, quantity, above))
    raise _out_of_range(quantity, float(wanted.max()), "large")


def _out_of_range(quantity: Quantity, wanted: float, size: str) -> BadValue:
    return BadValue(
        quantity,
        text(wanted, UNITS[quantity]),
        f"is too {size}: no contact radius within {_MOST_DECADES} decades of the "
        "expected one belongs to it. Check the units, or prescribe the radius instead.",
    )


def _unresolved(quantity: Quantity, wanted: float, resolved: float, most: float) -> BadValue:
    unit = UNITS[quantity]
    return BadValue(
        quantity,
        text(wanted, unit),
        f"needs a contact radius above {text(resolved, 'm')}, the largest that is solved on "
        f"this medium; there the {quantity} is {text(most, unit)}. Check the units of {quantity}, thickness and modulus, or ask "
        "for less.",
    )


def _beyond(quantity: Quantity, wanted: float, reach: float, most: float) -> BadValue:
    unit = UNITS[quantity]
    return BadValue(
        quantity,
        text(wanted, unit),
        f"is beyond this indenter: its shape ends at the radius {text(reach, 'm')}, where the "
        f"{quantity} is {text(most, unit)}. Ask for less, or give the shape further out.",
    )


def _newton(evaluate: Callable[[Array], Loading], quantity: Quantity, wanted: Array, nodes: _Nodes) -> Array:
    """Newton's method for ln q over ln a, bisecting when a step leaves the bracket or the steps do not settle."""
    upper = np.clip(np.searchsorted(np.maximum.accumulate(nodes.value), wanted), 1, nodes.x.size - 1)
    lo, hi = nodes.x[upper - 1], nodes.x[upper]
    x = _start(nodes, upper, np.log(wanted))
    left = np.arange(wanted.size)
    # smooth indenters need two or three Newton steps; 60 bisections after twelve take a tenth of a decade to rounding
    for count in range(72):
        here, goal, at = _sample(evaluate, quantity, np.exp(x[left])), wanted[left], x[left]
        miss = here.value - goal
        lo[left], hi[left] = np.where(miss < 0, at, lo[left]), np.where(miss >= 0, at, hi[left])
        with np.errstate(divide="ignore", invalid="ignore"):
            trial = at - np.log(here.value / goal) / here.growth
        safe = (here.growth > 0) & (trial >= lo[left]) & (trial <= hi[left]) & (count < 10)
        close = np.abs(miss) <= 1000 * np.finfo(float).eps * goal
        middle = (lo[left] + hi[left]) / 2
        x[left] = np.where(safe, trial, np.where(close, at, middle))
        # Newton converges quadratically: after such a step the next one is below rounding, as is the width of such a bracket
        settled = (safe & (np.abs(trial - at) < 1e-8)) | close | (hi[left] - lo[left] < 100 * np.finfo(float).eps)
        left = left[~settled]
        if not left.size:
            break
    return np.asarray(np.exp(x))


def _start(nodes: _Nodes, upper: Indices, wanted: Array) -> Array:
    """Inverse cubic Hermite interpolation of ln a over ln q between the grid points around each target."""
    with np.errstate(divide="ignore", invalid="ignore"):
        q, slope = np.log(nodes.value), 1 / nodes.growth
        x0, x1, q0, width = nodes.x[upper - 1], nodes.x[upper], q[upper - 1], np.diff(q)[upper - 1]
        t = (wanted - q0) / width
        ends = x0 * (1 + 2 * t) * (1 - t) ** 2 + x1 * t**2 * (3 - 2 * t)
        cubic = ends + width * t * (1 - t) * (slope[upper - 1] * (1 - t) - slope[upper] * t)
    return np.asarray(np.where((cubic >= x0) & (cubic <= x1), cubic, (x0 + x1) / 2))
