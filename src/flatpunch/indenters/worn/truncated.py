"""Tips with their end cut or worn off flat."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated

import numpy as np
import scipy

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, BadValue, refused_overflow, shown
from flatpunch._support.declared import a_length, checked
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch.indenters._common import FULL_TURN, RAYS, SAME
from flatpunch.indenters.profile import Indenter, as_of, check_indenter, check_rising


@as_of("tip", "reach corners seams round angular_tolerance")
@readable
@dataclass(frozen=True, slots=True)
class Truncated(Indenter):
    """Tip cut off flat: f = max(0, f_tip - height).

    The slope jumps along the border of the flat, the level line f_tip = height. Where that is no circle, `rings` names the
    distances from the axis at which it turns: between the smallest and the largest the flat ends in some directions only.

    Parameters
    ----------
    tip : Indenter
        The tip before cutting, such as Pyramid, Cone, Sphere, EllipticParaboloid.
    height_removed : float
        Height cut off above the apex [m], > 0. `Truncated.across` takes the radius of the flat instead.

    See Also
    --------
    Rounded : A round apex in place of the flat.
    Cylinder : The flat alone.

    Examples
    --------
    >>> fp.Truncated(fp.Cone(0.3), height_removed=20e-9)
    Truncated(tip=Cone(inclination=0.3), height_removed=2e-08)
    """

    tip: Indenter
    height_removed: Annotated[float, a_length("height removed", remedy="It is the height cut off above the apex.")]
    _rings: tuple[float, ...] = field(init=False, repr=False, compare=False)

    @refused_overflow()
    def _together_(self) -> None:
        check_indenter(self.tip, "Truncated.tip")
        check_rising(self.tip)
        if self.tip.flat or isinstance(self.tip, Truncated):
            raise TypeError(f"Truncated.tip = {shown(self.tip)} is flat already.")
        object.__setattr__(self, "_rings", _border(self.tip, self.height_removed))

    @classmethod
    @checked
    def across(
        cls,
        tip: Indenter,
        radius: Annotated[float, a_length("radius", remedy="It is the smallest radius of the flat.")],
    ) -> Truncated:
        """Tip cut off where its flat has the given smallest radius [m]: half the side of a square pyramid's flat."""
        check_indenter(tip, "tip")
        if radius >= tip.reach:
            raise ValueError(
                f"Truncated radius = {radius!r} must be below the reach of the tip, {text(tip.reach, 'm')}."
            )
        angles = _angles(tip)
        at = np.array(radius)
        values = np.asarray(tip.height(at, angles))
        best = angles[int(np.argmax(values))]
        found = scipy.optimize.minimize_scalar(
            lambda phi: -float(tip.height(at, np.array(phi))) / values.max(),
            bounds=(best - 0.01, best + 0.01),
            method="bounded",
            options={"xatol": SAME},
        )
        return cls(tip, max(float(values.max()), -float(found.fun) * float(values.max())))

    @property
    def rings(self) -> tuple[float, ...]:
        """Border of the flat, radii at which it turns, and the rings of the tip beyond it [m]."""
        return tuple(sorted({*self._rings, *(ring for ring in self.tip.rings if ring > self._rings[0])}))

    @property
    def scales(self) -> tuple[float, ...]:
        """Radii about the border of the flat [m]."""
        low, high = self._rings[0], self._rings[-1]
        return tuple(s for s in (0.5 * (low + high), 1.2 * high, 3 * high, 20 * high) if s < self.reach) or (high,)

    def crossings(self, r: Array) -> Array:
        """Polar angles [rad] at which circles of radii r, shape (n,), cross the border of the flat, and kinks of the tip.

        Shape (n, k), NaN where a circle has fewer.
        """
        angles, radii = _border_line(self.tip, self.height_removed)
        inside = r[:, None] < radii
        rows, columns = np.nonzero(inside[:, 1:] != inside[:, :-1])
        low, high = angles[columns], angles[columns + 1]

        def above(phi: Array, radius: Array) -> Array:
            return np.asarray(self.tip.height(radius, phi)) - self.height_removed

        from scipy.optimize import elementwise

        root = elementwise.find_root(above, (low, high), args=(r[rows],))
        place = np.arange(rows.size) - np.searchsorted(rows, rows)
        found = np.full((r.size, int(place.max(initial=-1)) + 1), np.nan)
        # where both ends are at the border to rounding, so is the middle
        found[rows, place] = np.where(root.success, root.x, (low + high) / 2)
        return found if self.tip.crossings is None else np.hstack([found, self.tip.crossings(r)])

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return np.asarray(np.maximum(self.tip.height(r, phi) - self.height_removed, 0.0))

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting; at the border of the flat the value beyond it."""
        beyond = np.asarray(self.tip.height(r, phi)) >= self.height_removed
        return np.where(beyond, self.tip.slope(r, phi), 0.0)


def _border(tip: Indenter, level: float) -> tuple[float, ...]:
    """Smallest and largest radius of the level line f = level, and others at which it turns; one where it is a circle."""
    radii = _border_line(tip, level)[1]
    if not np.isfinite(radii).all():
        raise BadValue(
            "Truncated.height_removed",
            repr(level),
            f"is more than the height of the tip where it ends (reach {text(tip.reach, 'm')}).",
        )
    if np.ptp(radii) <= SAME * radii.max():
        return (float(radii.max()),)
    closed = np.append(radii, radii[1])
    turns = radii[1:][(closed[1:-1] - closed[:-2]) * (closed[2:] - closed[1:-1]) <= 0]
    # below rounding one turn of a border gives several rings
    alike = 1e-9
    between = np.sort(turns[(turns > (1 + alike) * radii.min()) & (turns < (1 - alike) * radii.max())])
    between = between[np.diff(between, prepend=0.0) > alike * radii.max()]
    # most radii at which a border turns that are rings; more, as of rough height maps, would only cost panels
    few = between if between.size <= 6 else between[:0]
    return (float(radii.min()), *few.tolist(), float(radii.max()))


@byte_cached
def _border_line(tip: Indenter, level: float) -> tuple[Array, Array]:
    """Angles over a full turn, ends included, and the radii there of the level line f = level, none of its extremes left out."""
    angles = _angles(tip)
    radii = _level_radii(tip, level, angles)
    if np.isfinite(radii).all() and np.ptp(radii) > SAME * radii.max():
        width, extremes = FULL_TURN / RAYS, []
        for sign in (1, -1):
            beside = np.minimum(sign * np.roll(radii, 1), sign * np.roll(radii, -1))
            turning = angles[sign * radii <= beside]
            extremes.append(_least(partial(_signed_radii, tip, level, sign), turning, width))
        angles = np.union1d(angles, np.mod(np.concatenate(extremes), FULL_TURN))
    closed = np.append(angles, angles[0] + FULL_TURN)
    return closed, _level_radii(tip, level, closed)


def _signed_radii(tip: Indenter, level: float, sign: int, phi: Array) -> Array:
    return sign * _level_radii(tip, level, phi)


def _least(function: Callable[[Array], Array], about: Array, width: float) -> Array:
    """Where a function of one variable is least about several places, to the root of rounding."""
    from scipy.optimize import elementwise

    found = elementwise.find_minimum(function, (about - width, about, about + width))
    return np.where(found.success, found.x, about)


def _angles(tip: Indenter) -> Array:
    even = FULL_TURN * np.arange(RAYS) / RAYS
    return np.array(sorted({*even, *tip.split_angles}))


def _level_radii(tip: Indenter, level: float, phi: Array) -> Array:
    """Radii at which f reaches the level, infinite where it does not."""
    if tip.exponent is not None:
        return np.asarray((level / np.asarray(tip.height(np.ones_like(phi), phi))) ** (1 / tip.exponent))
    from scipy.optimize import elementwise

    def above(r: Array, phi: Array) -> Array:
        return np.asarray(tip.height(r, phi)) - level

    start = min(1.0, tip.reach)
    bracket = elementwise.bracket_root(above, start / 2, start, xmin=0.0, xmax=tip.reach, args=(phi,))
    root = elementwise.find_root(above, bracket.bracket, args=(phi,))
    return np.where(root.success, root.x, np.inf)
