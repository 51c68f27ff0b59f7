"""Curves through boundary element solutions over x = ln d.

The force is interpolated by its values and slopes (every solution has dF/dd): cubic Hermite pieces of ln F less that of the
round contact, or of ln F itself where the depth of round contacts turns back. Radius, area and outline have no slopes: local
cubics (Akima's, modified) of their logarithms less that of the round radius. Below the first solution ratios to the round
contact are constant.

Over the depth the ratio to the force of the round contact changes by some per cent where the force itself changes by orders of
magnitude, so that few solutions determine it. Round contacts are taken on a lattice of depths and joined by cubic Hermite
pieces: what matters is that the same smooth function divides and multiplies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import Akima1DInterpolator, CubicHermiteSpline, make_interp_spline
from scipy.optimize import elementwise

from flatpunch._support.checks import Array, Indices
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, ControlName
from flatpunch.contact.refined.sample import STIFFNESS_ERROR, Sample
from flatpunch.contact.round.mean_profile import mean_contact, resolved_radius
from flatpunch.contact.round.radius_search import PER_DECADE
from flatpunch.indenters.profile import Indenter

STEP = np.log(10) / PER_DECADE
"""Spacing of the lattice in ln d; twice as wide, forces of round contacts are off by 1e-5 between its points."""


class RoundReference:
    """Round contacts of the mean profile.

    Parameters
    ----------
    kernel, indenter
        Medium and indenter.
    """

    def __init__(self, kernel: Kernel, indenter: Indenter) -> None:
        self.kernel, self.indenter = kernel, indenter
        self._rows: dict[int | float, tuple[float, ...]] = {}
        self._end = np.inf

    def position(self, quantity: ControlName, logarithm: Array) -> Array:
        """ln d of the round contacts whose ln F/E* ("force"), ln a ("radius") or ln d has these values, shape (n,)."""
        scale = self.kernel.modulus if quantity == "force" else 1.0
        control = Control(quantity, scale * np.exp(logarithm))
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(mean_contact(self.kernel, self.indenter, control)[1].depth))

    def at(self, x: Array) -> tuple[Array, Array, Array]:
        """ln F/E*, dln F/dx and ln a at x = ln d, shape (n,) each."""
        table = self._table(float(x.min()), float(x.max()))
        force, radius = (CubicHermiteSpline(table[0], table[row], table[row + 1]) for row in (1, 3))
        return force(x), force(x, 1), radius(x)

    def smooth(self, low: float, high: float) -> bool:
        """Whether ln F has no jump between two positions: under stiff films the depth of round contacts may turn back."""
        nodes, force, growth, *_ = self._table(low, high)
        secant = np.diff(force) / np.diff(nodes)
        # difference between slope and secant of ln F above which the depth of round contacts has turned back
        return bool(np.isfinite(force).all() and np.abs(secant - (growth[1:] + growth[:-1]) / 2).max() < 0.3)

    def _table(self, low: float, high: float) -> Array:
        """Positions on the lattice around [low, high], ln F/E*, its slope, ln a and its slope, shape (5, points)."""
        numbers: list[int | float] = list(range(int(np.floor(low / STEP)) - 1, int(np.ceil(high / STEP)) + 2))
        if numbers[-1] * STEP > self._end or not self._known(numbers):
            # raises what is wrong with the depth, which would be taken for the end of the tip otherwise
            self.position("depth", np.array([high]))
            self._find_end(high)
            numbers = [number for number in numbers if number * STEP < self._end]
            if self._end <= high + STEP:
                numbers.append(self._end / STEP)
            if len(numbers) < 2 or not self._known(numbers):
                raise ValueError(
                    f"depth = {text(float(np.exp(high)), 'm')}: the contact radius changes too fast with the depth for method="
                    "'refined', which interpolates between depths. Check the shape of the tip, or choose method='second-order'."
                )
        rows = np.array([self._rows[number] for number in numbers])
        return np.column_stack([np.array(numbers) * STEP, rows]).T

    def _known(self, numbers: list[int | float]) -> bool:
        """Whether the contacts of these numbers are known, or could be found."""
        new = [number for number in numbers if number not in self._rows]
        if not new:
            return True
        depth = np.exp(np.array(new) * STEP)
        try:
            contact = mean_contact(self.kernel, self.indenter, Control("depth", depth))[1]
        except ValueError:
            return False
        with np.errstate(divide="ignore", invalid="ignore"):
            growth = contact.stiffness * depth / contact.force
            rows = (
                np.log(contact.force / self.kernel.modulus),
                growth,
                np.log(contact.radius),
                depth / contact.depth_slope,
            )
        self._rows.update(zip(new, zip(*(row.tolist() for row in rows), strict=True), strict=True))
        return True

    def _find_end(self, high: float) -> None:
        """ln d at which the tip, or what the medium resolves, ends."""
        if np.isfinite(self._end):
            return
        last = min(self.indenter.reach, resolved_radius(self.kernel))
        if np.isfinite(last):
            self._end = float(self.position("radius", np.log([last * (1 - 1e-9)]))[0])
        else:
            self._end = high


@dataclass(frozen=True, slots=True)
class Contacts:
    """Contacts of a curve, shape (n,) each.

    Attributes
    ----------
    force : ndarray
        ln F/E* [m^2].
    growth : ndarray
        dln F/dln d.
    shape : ndarray, shape (n, 2 + angles)
        As in `Sample`.
    force_error, shape_error : ndarray
        Estimated errors of force and outline.
    """

    force: Array
    growth: Array
    shape: Array
    force_error: Array
    shape_error: Array


@dataclass(frozen=True)
class Interpolation:
    """Interpolation of contacts over x = ln d.

    Parameters
    ----------
    reference : RoundReference
        Round contacts.
    nodes : ndarray, shape (m,)
        Positions of the samples, ascending.
    samples : tuple of Sample, length m
        The solutions there.
    missed : ndarray, shape (m - 1, 2)
        Interpolation errors of force and outline at the middle of each gap.
    """

    reference: RoundReference
    nodes: Array
    samples: tuple[Sample, ...]
    missed: Array

    def at(self, x: Array) -> Contacts:
        """Contacts at x, shape (n,); ratios to the round contact are constant outside the samples."""
        at = self._inside(x)
        force, growth = self.force_at(x)
        shape = self._shape_at(at) + (self.reference.at(x)[2] - self.reference.at(at)[2])[:, None]
        left, right = self._beside(at)
        force_error, shape_error = np.array([(s.force_error, s.shape_error) for s in self.samples]).T
        width = np.where(left == right, 1.0, self.nodes[right] - self.nodes[left])
        place = (at - self.nodes[left]) / width
        # no error at the solutions, that of the middle a quarter of the gap away from them
        share = np.minimum(4 * np.minimum(place, 1 - place), 1.0)
        missed = np.vstack([self.missed, np.zeros(2)])[left] * share[:, None]
        return Contacts(
            force,
            growth,
            shape,
            np.maximum(force_error[left], force_error[right]) + missed[:, 0],
            np.maximum(shape_error[left], shape_error[right]) + missed[:, 1],
        )

    def force_at(self, x: Array) -> tuple[Array, Array]:
        """ln F/E* and dln F/dln d at x, shape (n,)."""
        at = self._inside(x)
        (round_force, round_growth, _), there = self.reference.at(x), self.reference.at(at)
        force, growth = self._ratio(at), self._ratio(at, 1)
        if self._divided:
            force, growth = force + there[0], growth + there[1]
        frozen = at != x
        return np.where(frozen, force + round_force - there[0], force), np.where(frozen, round_growth, growth)

    def positions(self, quantity: ControlName, wanted: Array) -> Array:
        """x at which ln F/E* ("force") or ln a0 ("radius") first reaches the wanted values, shape (n,)."""
        values = np.array([s.force if quantity == "force" else s.shape[0] for s in self.samples])
        x, below = np.empty_like(wanted), (wanted <= values[0]) | (self.nodes.size == 1)
        if below.any():
            first = self.reference.at(self.nodes[:1])[0 if quantity == "force" else 2]
            found = self.reference.position(quantity, first + wanted[below] - values[0])
            # on a flat end the depth is zero: six decades below the first solution
            x[below] = np.maximum(found, self.nodes[0] - np.log(1e6) if self.reference.indenter.rings else -np.inf)
        if not below.all():
            x[~below] = self._between(quantity, wanted[~below], values)
        return x

    def _between(self, quantity: ControlName, wanted: Array, values: Array) -> Array:
        """Positions between the first and the last sample."""
        after = np.clip(np.searchsorted(np.maximum.accumulate(values), wanted), 1, self.nodes.size - 1)

        def excess(x: Array, target: Array) -> Array:
            return (self.force_at(x)[0] if quantity == "force" else self._sizes_at(x)[:, 0]) - target

        root = elementwise.find_root(excess, (self.nodes[after - 1], self.nodes[after]), args=(wanted,))
        return np.where(root.success, root.x, self.nodes[after])

    def _inside(self, x: Array) -> Array:
        return np.asarray(np.clip(x, self.nodes[0], self.nodes[-1]))

    def _beside(self, x: Array) -> tuple[Indices, Indices]:
        """Numbers of the samples to the left and right; of one sample twice where x is its position."""
        left = np.maximum(np.searchsorted(self.nodes, x, side="right") - 1, 0)
        return left, np.where(x == self.nodes[left], left, np.minimum(left + 1, self.nodes.size - 1))

    def _shape_at(self, x: Array) -> Array:
        """ln of radius, sqrt(area/pi) and outline at x, shape (n, 2 + angles); no outline beside a sample without one."""
        outlined = np.array([sample.outlined for sample in self.samples])
        left, right = self._beside(x)
        whole = outlined[left] & outlined[right]
        outline = np.full((x.size, self.samples[0].shape.size - 2), np.nan)
        if whole.any():
            outline[whole] = self._outlines(x[whole])
        if self._divided:
            outline += self.reference.at(x)[2][:, None]
        return np.hstack([self._sizes_at(x), outline])

    def _sizes_at(self, x: Array) -> Array:
        """ln of radius and sqrt(area/pi) at x, shape (n, 2)."""
        return np.asarray(self._sizes(x) + self.reference.at(x)[2][:, None] * self._divided)

    @cached_property
    def _divided(self) -> bool:
        """Whether the round contact divides."""
        return self.reference.smooth(float(self.nodes[0]), float(self.nodes[-1]))

    @cached_property
    def _ratio(self) -> Callable[..., Array]:
        """ln F/E* over that of the round contact, by x and the number of derivatives."""
        force, growth = np.array([(sample.force, sample.growth) for sample in self.samples]).T
        if self._divided:
            there = self.reference.at(self.nodes)
            force, growth = force - there[0], growth - there[1]
        if self.nodes.size == 1:
            return lambda x, nu=0: np.full_like(x, growth[0] if nu else force[0])
        force = settled(self.nodes, force, growth, np.array([sample.force_error for sample in self.samples]))
        curve: Callable[..., Array] = CubicHermiteSpline(self.nodes, force, growth)
        return curve

    @cached_property
    def _sizes(self) -> Callable[[Array], Array]:
        return local_cubic(self.nodes, self._shapes[:, :2])

    @cached_property
    def _outlines(self) -> Callable[[Array], Array]:
        outlined = np.array([sample.outlined for sample in self.samples])
        return local_cubic(self.nodes[outlined], self._shapes[outlined, 2:])

    @cached_property
    def _shapes(self) -> Array:
        shapes = np.array([sample.shape for sample in self.samples])
        return shapes - self.reference.at(self.nodes)[2][:, None] if self._divided else shapes


def settled(nodes: Array, values: Array, slopes: Array, errors: Array) -> Array:
    """Values changed by a third of their errors at most so that close neighbours agree with the slopes between them, shape (n,).

    Forces of solutions that are close scatter by the error of the cells, which would spoil the slope of a curve through them.
    Least squares weigh each value by its error, and each difference by that of the trapezoidal rule.
    """
    gaps = np.diff(nodes)
    # the trapezoidal rule is off by a tenth of the cube of the gap; with far less, forces in wide gaps would follow the rule
    weights = (gaps * (STIFFNESS_ERROR + 0.1 * gaps**2)) ** -2.0
    difference = np.diff(np.eye(nodes.size), axis=0)
    missing = gaps * (slopes[1:] + slopes[:-1]) / 2 - np.diff(values)
    # a solution that did not converge has an infinite error
    errors = np.minimum(errors, 1.0)
    normal = np.diag(errors**-2.0) + difference.T @ (weights[:, None] * difference)
    shift = np.linalg.solve(normal, difference.T @ (weights * missing))
    # largest change of a force over its stated error; with twice as much, forces beside kinks follow the rule across the kink
    return np.asarray(values + np.clip(shift, -errors / 3, errors / 3))


def local_cubic(nodes: Array, table: Array) -> Callable[[Array], Array]:
    """Local cubic pieces through the rows of a table, polynomials through three rows or fewer."""
    if nodes.size == 1:
        return lambda x: np.repeat(table, x.size, axis=0)
    curve: Callable[[Array], Array] = (
        make_interp_spline(nodes, table, k=nodes.size - 1)
        if nodes.size < 4
        else Akima1DInterpolator(nodes, table, method="makima", extrapolate=True)
    )
    return curve
