"""The elastic curve F_el(d) that a viscoelastic contact is built from: any method's, tabulated against the log of the depth.

`Lumps` are the same curve as a row of springs, by which histories are followed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, Curve
from flatpunch.contact.round.radius_search import PER_DECADE
from flatpunch.contact.round.superposition import spline
from flatpunch.indenters.profile import Indenter


class Column(IntEnum):
    """Columns of the table."""

    FORCE, RADIUS, AREA, STIFFNESS = range(4)


class ElasticForce(Protocol):
    """What a viscoelastic contact needs of the elastic one."""

    def force(self, depth: Array) -> Array:
        """F_el at depths, shape (n,) [N]; zero without contact."""

    def stiffness(self, depth: Array) -> Array:
        """dF_el/dd at depths, shape (n,) [N/m]."""


@dataclass(frozen=True)
class ElasticCurve:
    """Force, radius, area and stiffness at depth d, up to the depth it was made for.

    Attributes
    ----------
    logs : scipy.interpolate.BSpline
        ln d -> ln of force, radius, area, stiffness, shape (n, 4).
    low : float
        Smallest ln d of the table.
    shape : scipy.interpolate.BSpline or None
        ln d -> outline over mean radius, shape (n, p); None for round indenters.
    sound : float
        Largest depth at which the elastic theory holds [m].
    notes : tuple of str
        Its limits.
    estimated : tuple of ndarray, shape (n,)
        ln d, and the method's own estimates of the relative error of force and outline.
    """

    logs: scipy.interpolate.BSpline
    low: float
    shape: scipy.interpolate.BSpline | None
    sound: float
    notes: tuple[str, ...]
    estimated: tuple[Array, Array, Array]

    def at(self, depth: Array, *columns: Column) -> Array:
        """Columns at depths >= 0 of shape (n,); shape (columns, n)."""
        live = depth > 0
        x = np.log(np.where(live, depth, 1.0))
        inside = np.maximum(x, self.low)
        # a power law below the table
        beyond = np.where(live, x - inside, 0.0)
        logs = self.logs(np.where(live, inside, self.low))
        if beyond.any():
            logs = logs + beyond[:, None] * self.logs.derivative()(self.low)
        return np.where(live[:, None], np.exp(logs), 0.0).T[list(columns)]

    def errors(self, depth: Array) -> tuple[Array, Array]:
        """Estimated relative errors of force and outline at depths, shape (n,) each; zero for exact methods."""
        x, force, outline = self.estimated
        at = np.log(np.where(depth > 0, depth, np.exp(self.low)))
        return np.interp(at, x, force), np.interp(at, x, outline)

    def force(self, depth: Array) -> Array:
        """F_el at depths, shape (n,) [N]."""
        return np.asarray(self.at(depth, Column.FORCE)[0])

    def stiffness(self, depth: Array) -> Array:
        """dF_el/dd at depths, shape (n,) [N/m]."""
        return np.asarray(self.at(depth, Column.STIFFNESS)[0])

    def depth_of(self, force: Array, deepest: float) -> Array:
        """Depths at which F_el takes given values >= 0, shape (n,) [m]: Newton in logarithms."""
        live = force > 0
        wanted = np.log(np.where(live, force, 1.0))
        grid = np.linspace(self.low, np.log(deepest), 1000)
        table = self.logs(grid)[:, Column.FORCE]
        x = np.interp(wanted, table, grid)
        slope = self.logs.derivative()
        first = slope(self.low)[Column.FORCE]
        below = wanted < table[0]
        for _ in range(20):
            step = (wanted - self.logs(x)[:, Column.FORCE]) / slope(x)[:, Column.FORCE]
            x = np.clip(x + np.where(below, 0, step), self.low, np.log(deepest))
            # quadratic convergence
            if np.abs(np.where(live & ~below, step, 0)).max() < 1e-9:
                break
        x = np.where(below, self.low + (wanted - table[0]) / first, x)
        return np.where(live, np.exp(x), 0.0)

    def contour(self, depth: Array, radius: Array, angles: int) -> Array:
        """Outline at depths, shape (n, angles) [m]."""
        if self.shape is None:
            return np.repeat(radius[:, None], angles, axis=1)
        x = np.maximum(np.log(np.where(depth > 0, depth, 1.0)), self.low)
        return np.asarray(self.shape(np.where(depth > 0, x, self.low)) * radius[:, None])


Solve = Callable[[Kernel, Indenter, Control, Array], Curve]


_PER_DECADE = 2 * PER_DECADE
"""Nodes per decade of depth: 1e-10 of smooth functions; half as many leave 1e-8, twice as many cost time. Below ten decades all
functions are power laws."""


def elastic_curve(solve: Solve, kernel: Kernel, indenter: Indenter, deepest: float, phi: Array) -> ElasticCurve:
    """Tabulate a method's curve up to the depth `deepest`."""
    x = np.log(deepest) + np.log(10) / _PER_DECADE * np.arange(-10 * _PER_DECADE, 1)
    flat = indenter.flat
    angles = phi[:1] if indenter.round else phi
    depth = np.exp(x)
    depth[-1] = deepest
    curve = solve(kernel, indenter, Control("depth", depth), angles)
    found = np.stack([curve.force, curve.radius, curve.area, curve.stiffness], axis=1)
    good = np.all(np.isfinite(found) & (found > 0), axis=1) & np.all(np.isfinite(curve.contour), axis=1)
    if not good.all():
        raise ValueError(
            f"The elastic curve has no contact or no outline at depth {text(float(depth[~good].max()), 'm')}, so nothing can be "
            "built on it. " + " ".join(curve.notes)
        )
    logs = scipy.interpolate.make_interp_spline(x, np.log(found), k=1) if flat else spline(x, np.log(found))
    shape = None
    if not indenter.round:
        shape = spline(x, curve.contour / curve.radius[:, None])
    unsound = depth[~curve.valid]
    none = np.zeros_like(x)
    force_error, outline_error = (
        curve.extra[name][1].astype(float) if name in curve.extra else none for name in ("force_error", "contour_error")
    )
    return ElasticCurve(
        logs,
        float(x[0]),
        shape,
        float(unsound.min()) if unsound.size else np.inf,
        curve.notes,
        (x, force_error, outline_error),
    )


class Lumps:
    """Springs at depths `touch` that make the elastic force exact for pulls Q linear between them."""

    def __init__(self, touch: Array, force: Array, stiffness: Array) -> None:
        self.touch, self.stiffness = touch, stiffness
        self.slope = np.diff(force) / np.diff(touch)
        self.lump = np.diff(self.slope, prepend=0.0, append=stiffness[-1])

    def force(self, pull: Array, extent: float) -> float:
        """Force [N] of springs pulled by Q [m], shape (n,), which reaches zero at the contact depth `extent`."""
        n = pull.size
        if not n:
            return 0.0
        total = float(self.lump[:n] @ pull)
        if n == self.touch.size:
            return total
        share = (extent - self.touch[n - 1]) / (self.touch[n] - self.touch[n - 1])
        # the lumps take Q as zero at the next spring and beyond
        return total + float(pull[n - 1] * (self.slope[n - 1] - self.stiffness[n - 1]) * (share - 1))

    def grown_to(self, contact: int, depth: float, height: Array) -> float:
        """Contact depth: where the heights of the springs ahead meet the tip, linear in between."""
        if not contact:
            return 0.0
        low = float(self.touch[contact - 1])
        if contact == self.touch.size:
            return low
        high = float(self.touch[contact])
        # beyond the last spring but one nothing was ever touched: heights rise as the depths of touch do
        last = height.size < 2 or height[1] <= height[0]
        slope = 1.0 if last else (height[1] - height[0]) / (self.touch[contact + 1] - high)
        return float(np.clip(high + (depth - height[0]) / slope, low, high))

    def shrunk_to(self, pull: Array) -> float:
        """Contact depth: where Q falls to zero, linear beyond the last springs in contact."""
        n = pull.size
        if not n:
            return 0.0
        low = float(self.touch[n - 1])
        if n == self.touch.size:
            return low
        high = float(self.touch[n])
        if n < 2 or pull[-2] <= pull[-1]:
            return high
        return float(np.clip(low + pull[-1] * (low - self.touch[n - 2]) / (pull[-2] - pull[-1]), low, high))
