"""Measured body of revolution: a table (r, f).

Between the points a monotone cubic (Hermite) is laid whose slopes are those of the quartic through the five
nearest points, limited to 0 .. 3 times the smaller neighbouring chord slope, which keeps the curve from
falling or overshooting (de Boor and Swartz 1977). The tip needs no special case: the one-sided slope at r = 0
is exact for a cone (its inclination) and for a parabola (zero), so the first points of the table decide which
of the two it is. The usual PCHIP slopes are not used: their harmonic mean puts a paraboloid's first cells off
by some per cent.

Heights are smoothed by local parabolas with Gaussian weights, from one kink to the next and at the apex from one side only.
Cones, spheres and edges keep their form. Where heights still fall afterwards they are averaged (isotonic regression); straight
lines between the middles of these averages leave no flat, which would act as a flat end. On a half-space a round tip with slope
f'(r) has, at contact radius a and for E* = 1, r = a sin t,

    depth = a int_0^(pi/2) f' dt,    force = 2 a^2 int_0^(pi/2) f' sin^2 t dt
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated

import numpy as np
import scipy
from numpy.typing import NDArray

from flatpunch._support.checks import Array, BadValue, numbers, values
from flatpunch._support.declared import a_length, checked
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch.indenters._common import spread
from flatpunch.indenters.profile import RoundShape

NOTABLE = 0.01
"""Relative change of the force by kinks that is worth a note; few curves are calibrated better."""

_ROUNDING = 100 * np.finfo(float).eps
"""Height over the largest one that is rounding."""


Smoothing = Annotated[
    float,
    a_length("smoothing", above=-np.inf, least=0.0, varies=False, remedy="0 takes the heights as they are."),
]


@readable
@dataclass(frozen=True, slots=True)
class RadialProfile(RoundShape):
    """Body of revolution through measured points.

    Parameters
    ----------
    r : sequence of float
        Radii [m], strictly increasing from 0.
    f : sequence of float
        Heights [m] over the apex, from 0, never falling, and not zero throughout.
    kinks : sequence of float
        Radii of the table at which the slope jumps, such as the edge of a truncated tip; elsewhere it is
        continuous.
    smoothing : float
        Standard deviation of the Gaussian by which noise of the heights is smoothed [m]; 0 takes them as they are. Heights may
        then fall, and be negative.

    Attributes
    ----------
    notes : tuple of str
        Change of the table by smoothing, and relative change of the force by given or apparent kinks.

    Raises
    ------
    ValueError
        If the table does not describe such a body; the message names the point.

    See Also
    --------
    AreaFunction : From the area over the depth.
    HeightMap : Tips that are not round.

    Examples
    --------
    >>> r = np.linspace(0, 1e-6, 50)
    >>> fp.RadialProfile(r, r**2 / 2e-6)
    RadialProfile(r=(0, 2.04082e-08, ..., 1e-06), f=(0, 2.08247e-10, ..., 5e-07), kinks=())
    """

    r: tuple[Annotated[float, a_length("radii r", varies=False, example='["0 um", "1 um", "2 um", "3 um"]')], ...]
    f: tuple[
        Annotated[float, a_length("heights f", ascending=True, example='["0 nm", "100 nm", "400 nm", "900 nm"]')], ...
    ]
    kinks: tuple[Annotated[float, a_length("kinks", varies=False)], ...] = ()
    _smoothed: str = field(init=False, repr=False, compare=False)
    _curve: scipy.interpolate.PPoly = field(init=False, repr=False, compare=False)
    _derivative: scipy.interpolate.PPoly = field(init=False, repr=False, compare=False)
    # the second derivative jumps at the points of the table
    tabulated = True

    @checked
    def __init__(
        self,
        r: Sequence[float] | Array,
        f: Sequence[float] | Array,
        kinks: Sequence[float] | Array = (),
        *,
        smoothing: Smoothing = 0.0,
    ) -> None:
        radii, heights, cuts, change = _table(r, f, kinks, smoothing)
        object.__setattr__(self, "r", tuple(map(float, radii)))
        object.__setattr__(self, "f", tuple(map(float, heights)))
        object.__setattr__(self, "_smoothed", change)
        object.__setattr__(self, "kinks", tuple(float(radii[i]) for i in cuts))
        curve = _curve(radii, heights, cuts)
        object.__setattr__(self, "_curve", curve)
        object.__setattr__(self, "_derivative", curve.derivative())

    @classmethod
    def from_area(cls, depth: Sequence[float] | Array, area: Sequence[float] | Array) -> RadialProfile:
        """Body of revolution with a measured tip area function: f = depth at r = sqrt(area/pi).

        It has the sections of the true tip as discs, but not its force; `AreaFunction` states the difference.

        Parameters
        ----------
        depth : sequence of float
            Distances h from the apex [m], from 0, never falling.
        area : sequence of float
            Areas of the sections there [m^2], from 0, strictly increasing.
        """
        areas = values("RadialProfile.from_area area", area, unit="m**2", smallest=0.0)
        return cls(np.sqrt(areas / np.pi), values("RadialProfile.from_area depth", depth, unit="m", smallest=0.0))

    @property
    def reach(self) -> float:
        """Last radius of the table [m]; beyond it the profile is continued straight, for no result to use."""
        return self.r[-1]

    @property
    def rings(self) -> tuple[float, ...]:
        """The points of the table at which a derivative jumps by more than rounding."""
        cubic, square, linear, _ = self._curve.c
        width = np.diff(self._curve.x)
        # coefficients of the piece that ends at a point against those of the next, as heights over the longer piece
        bend = (3 * cubic * width + square)[:-1] - square[1:]
        tilt = ((3 * cubic * width + 2 * square) * width + linear)[:-1] - linear[1:]
        longer = np.maximum(width[:-1], width[1:])
        height = np.abs(np.diff(cubic)) * longer**3 + np.abs(bend) * longer**2 + np.abs(tilt) * longer
        return tuple(self._curve.x[1:-1][height > _ROUNDING * self.f[-1]].tolist())

    @property
    def notes(self) -> tuple[str, ...]:
        """What smoothing and kinks change, in words."""
        found: tuple[str, ...] = (self._smoothed,) if self._smoothed else ()
        radii, heights = np.array(self.r), np.array(self.f)
        cuts = [] if self.kinks else possible_kinks(radii, heights)
        if not self.kinks and not cuts:
            return found
        without = self._derivative if not self.kinks else _curve(radii, heights, []).derivative()
        having = self._derivative if self.kinks else _curve(radii, heights, cuts).derivative()
        change, depth = change_of_force(without, having, self.reach)
        if abs(change) > NOTABLE:
            places = ", ".join(text(float(r), "m") for r in (self.kinks or radii[cuts][:4]))
            which = "Kinks of the tip" if self.kinks else "The slope of the tip seems to jump; kinks="
            found += (
                f"{which} at {places} change the force on a half-space by up to {100 * change:+.1f} %, at a depth of "
                f"{text(depth, 'm')}.",
            )
        return found

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        r = np.asarray(r, dtype=float)
        inside = np.minimum(r, self.reach)
        beyond = (r - inside) * float(self._derivative(self.reach))
        # rounding must not make a gap negative where the table is flat at zero
        return spread(np.maximum(self._curve(inside), 0.0) + beyond, phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting; at a kink the value beyond it."""
        return spread(np.maximum(self._derivative(np.minimum(r, self.reach)), 0.0), phi)


def _table(
    r: Sequence[float] | Array, f: Sequence[float] | Array, kinks: Sequence[float] | Array, width: float
) -> tuple[Array, Array, list[int], str]:
    """Radii, heights, points of kinks, and what smoothing changed."""
    if width == 0:
        radii, heights = _checked_table(r, f)
        return radii, heights, _kink_indices(radii, kinks), ""
    radii = values("RadialProfile.r", r, unit="m")
    measured = values("RadialProfile.f", f, minimum=-np.inf, unit="m", smallest=0.0)
    # heights are judged once they are smoothed
    _checked_table(radii, np.arange(float(measured.size)))
    if width > radii[-1]:
        raise BadValue("RadialProfile.smoothing", repr(width), "is wider than the profile. Take some of its spacings.")
    cuts = _kink_indices(radii, kinks)
    heights = smoothed_heights(radii, measured, width, cuts)
    return *_checked_table(radii, heights), cuts, what_smoothing_changed(width, heights - measured)


def _checked_table(r: Sequence[float] | Array, f: Sequence[float] | Array) -> tuple[Array, Array]:
    radii, heights = (
        values("RadialProfile.r", r, unit="m"),
        values("RadialProfile.f", f, minimum=-np.inf, unit="m", smallest=0.0),
    )
    if radii.size != heights.size or radii.size < 3:
        raise ValueError(
            f"RadialProfile has {radii.size} radii and {heights.size} heights; it needs 3 or more of each, "
            "equally many."
        )
    if radii[0] != 0 or heights[0] != 0:
        raise ValueError(
            f"RadialProfile starts at r = {radii[0]:.6g}, f = {heights[0]:.6g}; it must start at r = 0, f = 0. Subtract its "
            "first point; of a noisy profile smoothing = some spacings of the table [m] finds the apex."
        )
    _refuse(
        "RadialProfile.r",
        radii,
        np.diff(radii) <= 0,
        "must increase strictly; sort the table and drop repeated radii.",
    )
    _refuse(
        "RadialProfile.f",
        heights,
        heights[1:] < 0,
        "is negative: the apex is the lowest point of an indenter. Take it as the origin; smooth noise, smoothing = some "
        "spacings of the table [m].",
    )
    _refuse(
        "RadialProfile.f",
        heights,
        np.diff(heights) < 0,
        "falls: smooth the measured profile, smoothing = some spacings of the table [m].",
    )
    if heights[-1] == 0:
        raise BadValue("RadialProfile.f", "", "is zero throughout and does not rise; a flat end is Cylinder(radius).")
    return radii, heights


def _refuse(name: str, table: Array, bad: NDArray[np.bool_], reason: str) -> None:
    if bad.any():
        i = int(np.argmax(bad)) + 1
        raise BadValue(f"{name}[{i}]", f"{table[i]:.6g}", f"after {name}[{i - 1}] = {table[i - 1]:.6g} {reason}")


def _kink_indices(radii: Array, kinks: Sequence[float] | Array) -> list[int]:
    cuts = []
    given = np.atleast_1d(numbers("RadialProfile.kinks", kinks, "m"))
    if given.ndim > 1:
        raise BadValue("RadialProfile.kinks", "", f"has shape {given.shape}; it must be a sequence of radii.")
    for kink in given:
        i = int(np.argmin(np.abs(radii - kink)))
        if not (0 < i < radii.size - 1 and abs(radii[i] - kink) <= 1e-9 * radii[-1]):
            raise BadValue(
                "RadialProfile.kinks",
                "",
                f"contains {float(kink)!r}, which is no inner radius of the table. Add that point to the table.",
            )
        cuts.append(i)
    return sorted(set(cuts))


def _curve(radii: Array, heights: Array, cuts: list[int]) -> scipy.interpolate.PPoly:
    """Monotone piecewise cubic, cut at the kinks."""
    ends = [0, *cuts, radii.size - 1]
    parts = []
    for i, j in pairwise(ends):
        r, f = radii[i : j + 1], heights[i : j + 1]
        m = _limited_slopes(r, f)
        h, chord = np.diff(r), np.diff(f) / np.diff(r)
        parts.append([(m[:-1] + m[1:] - 2 * chord) / h**2, (3 * chord - 2 * m[:-1] - m[1:]) / h, m[:-1], f[:-1]])
    return scipy.interpolate.PPoly(np.hstack([np.array(part) for part in parts]), radii)


def _limited_slopes(r: Array, f: Array) -> Array:
    """Slopes at the points from the five nearest of them, limited so that the cubics rise."""
    chord = np.diff(f) / np.diff(r)
    width = min(5, r.size)
    slopes = np.empty(r.size)
    for i in range(r.size):
        start = min(max(i - width // 2, 0), r.size - width)
        slopes[i] = _lagrange_slope(r[start : start + width], f[start : start + width], i - start)
    smaller = np.minimum(np.concatenate([chord[:1], chord]), np.concatenate([chord, chord[-1:]]))
    return np.clip(slopes, 0.0, 3 * smaller)


def _lagrange_slope(x: Array, y: Array, at: int) -> float:
    """Derivative at x[at] of the polynomial through all points."""
    total = 0.0
    for j in range(x.size):
        if j != at:
            others = [k for k in range(x.size) if k not in (j, at)]
            weight = np.prod((x[at] - x[others]) / (x[j] - x[others])) / (x[j] - x[at])
            total += weight * (y[j] - y[at])
    return float(total)


_FAR = 5.0
"""Standard deviations of the Gaussian beyond which points count for nothing: 4e-6 of the weight of the nearest."""


def smoothed_heights(r: Array, f: Array, width: float, cuts: list[int]) -> Array:
    """Measured heights [m], smoothed by a Gaussian of `width` [m] and rising from zero at the apex; slopes jump at `cuts`."""
    total, count = np.zeros(r.size), np.zeros(r.size)
    for i, j in pairwise([0, *cuts, r.size - 1]):
        part = slice(i, j + 1)
        total[part] += _local_parabolas(r[part], f[part], width)
        count[part] += 1
    found = scipy.optimize.isotonic_regression(total / count)
    if found.blocks.size < 3:
        return np.asarray(found.x - found.x[0])
    middles = np.add.reduceat(r, found.blocks[:-1]) / found.weights
    level = scipy.interpolate.make_interp_spline(middles, found.x[found.blocks[:-1]], k=1)(r)
    return np.asarray(level - level[0])


def _local_parabolas(r: Array, f: Array, width: float) -> Array:
    result = np.empty(r.size)
    for i, centre in enumerate(r):
        near = slice(*np.searchsorted(r, [centre - _FAR * width, centre + _FAR * width]))
        x = (r[near] - centre) / width
        weight = np.exp(-(x**2) / 4)
        rows = np.column_stack([weight, weight * x, weight * x**2])
        result[i] = np.linalg.lstsq(rows, weight * f[near], rcond=None)[0][0]
    return result


def what_smoothing_changed(width: float, change: Array) -> str:
    """A sentence about the change of heights [m] by a Gaussian of this width [m], whatever it did to the apex."""
    off = change - np.median(change)
    rms, largest = float(np.sqrt(np.mean(off**2))), float(np.abs(off).max())
    return f"The tip was smoothed over {text(width, 'm')}: heights changed by {text(rms, 'm')} rms, {text(largest, 'm')} at most."


def change_of_force(
    slope: Callable[[Array], Array], other: Callable[[Array], Array], reach: float
) -> tuple[float, float]:
    """Largest relative change of the half-space force between two slopes at equal depth up to a radius [m], and its depth [m]."""
    (depth, force), (depths, forces) = (_half_space(each, reach) for each in (slope, other))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.exp(np.interp(np.log(depth), np.log(depths), np.log(forces))) / force
    known = np.isfinite(ratio) & (depth >= depths.min()) & (depth <= depths.max()) & (force > 0)
    if not known.any():
        return 0.0, 0.0
    at = int(np.argmax(np.where(known, np.abs(ratio - 1), 0.0)))
    return float(ratio[at] - 1), float(depth[at])


def _half_space(slope: Callable[[Array], Array], reach: float) -> tuple[Array, Array]:
    """Depth and force for E* = 1 at 60 contact radii."""
    a = reach * np.geomspace(0.02, 1, 60)[:, None]
    # midpoints: jumps of the slope cost 1/n of their part
    n = 1000
    t = (np.arange(n) + 0.5) * (np.pi / 2 / n)
    steep = slope(a * np.sin(t))
    weight = np.pi / 2 / n
    return (a * steep).sum(axis=1) * weight, 2 * (a**2 * steep * np.sin(t) ** 2).sum(axis=1) * weight


def possible_kinks(r: Array, f: Array) -> list[int]:
    """Points at which the slope of the chords jumps by far more than it changes elsewhere."""
    bend = np.abs(np.diff(np.diff(f) / np.diff(r))) / ((r[2:] - r[:-2]) / 2)
    # nine tenths of the table are no kinks; noise and smooth profiles bend there at most two or three times as little
    usual = float(np.quantile(bend, 0.9, method="lower"))
    return (np.flatnonzero(bend > 3 * usual) + 1).tolist()
