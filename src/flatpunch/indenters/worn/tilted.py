"""A tip that is pressed in at an angle: a plane is added, and the shape is centred about its new point of first touch.

A tilted paraboloid is the same paraboloid about another point, a tilted pyramid a pyramid with other faces; such cases come out
as exactly those shapes. All others are evaluated about the new apex.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import scipy

from flatpunch._support.checks import Array, refused_overflow
from flatpunch._support.declared import an_angle
from flatpunch._support.readable import readable
from flatpunch.indenters._common import SAME, spread
from flatpunch.indenters.profile import Indenter, as_of, check_indenter, check_rising
from flatpunch.indenters.shapes.pointed import FacetedPyramid, Pyramid, face_gradients, pyramid_of
from flatpunch.indenters.shapes.power_law import PowerLaw
from flatpunch.indenters.shapes.smooth import EllipticParaboloid, Paraboloid
from flatpunch.indenters.worn.rounded import Rounded

Tilt = Annotated[
    float,
    an_angle("tilt", above=-math.pi / 2, below=math.pi / 2, outside="must be an angle below pi/2 in size, in radians."),
]


@as_of("shape", "exponent reach corners seams rounded_edges angular_tolerance crossings scales rings round")
@readable
@dataclass(frozen=True, slots=True)
class Tilted(Indenter):
    """Indenter tilted by small angles: f + x tan(tilt_x) + y tan(tilt_y), from its new lowest point.

    A plane is added, as small slopes allow; a true rotation differs by the square of the tilt. A sphere, which does not change
    when it is rotated, comes out as one of radius R/(1 + tan(tilt)^2): at 0.05 rad its force is 0.12 % too low.

    Parameters
    ----------
    tip : Indenter
        The tip as it is without tilt.
    tilt_x, tilt_y : float
        Angles by which it rises along x and y [rad].

    Raises
    ------
    ValueError
        If the tilt is more than a flank of the tip: it would touch elsewhere than at its apex.

    Attributes
    ----------
    apex : tuple of float
        The point of first touch (x, y) in the coordinates of the tip [m].
    shape : Indenter
        The tip about that point.

    See Also
    --------
    AfmPyramid : Angles of a tip on a cantilever.
    HeightMap : A measured tip, tilted or not.

    Examples
    --------
    >>> tip = fp.Tilted(fp.Pyramid(4, 0.6), tilt_x=np.radians(2))
    >>> tip.exponent
    1.0
    """

    tip: Indenter
    tilt_x: Tilt
    tilt_y: Tilt = 0.0
    apex: tuple[float, float] = field(init=False, compare=False)
    shape: Indenter = field(init=False, repr=False, compare=False)

    @refused_overflow()
    def _together_(self) -> None:
        check_indenter(self.tip, "Tilted.tip")
        check_rising(self.tip)
        shape, apex = _tilted(self.tip, math.tan(self.tilt_x), math.tan(self.tilt_y))
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "apex", apex)

    def angular(self, phi: Array) -> Array:
        """psi(phi) of power-law shapes, in the shape of phi [rad]."""
        if self.exponent is None:
            raise AttributeError(f"{self!r} is no power law about its new apex, so it has no angular factor.")
        return np.asarray(self.shape.height(np.ones(np.shape(phi)), phi))

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return self.shape.height(r, phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        return self.shape.slope(r, phi)


@dataclass(frozen=True, slots=True)
class _LeaningAngular:
    """psi(phi) of a pointed tip plus the tilt."""

    tip: Indenter
    gradient: tuple[float, float]

    def __call__(self, phi: Array) -> Array:
        own = np.asarray(self.tip.height(np.ones(np.shape(phi)), phi))
        return np.asarray(own + self.gradient[0] * np.cos(phi) + self.gradient[1] * np.sin(phi))


@dataclass(frozen=True, slots=True)
class _Recentred(Indenter):
    """f + gradient . x about the point `apex` of a smooth tip."""

    tip: Indenter
    gradient: tuple[float, float]
    apex: tuple[float, float]

    @property
    def reach(self) -> float:
        return self.tip.reach - math.hypot(*self.apex)

    @property
    def rings(self) -> tuple[float, ...]:
        """Smallest and largest distance of the tip's rings from the new apex, where they are circles."""
        shift, circles = math.hypot(*self.apex), self.tip.rings if self.tip.round else ()
        limits = {abs(ring + sign * shift) for ring in circles for sign in (-1, 1)}
        return tuple(sorted(limit for limit in limits if SAME * shift < limit < self.reach))

    @property
    def angular_tolerance(self) -> float:
        """Differences of heights at the old apex and the new cost some digits."""
        return float(max(10 * SAME, self.tip.angular_tolerance))

    @property
    def scales(self) -> tuple[float, ...]:
        return () if np.isfinite(self.reach) else tuple(s * math.hypot(*self.apex) for s in (0.1, 0.5, 1, 3, 10))

    def height(self, r: Array, phi: Array) -> Array:
        rho, angle, x, y = self._polar(r, phi)
        lowest = np.asarray(
            self.tip.height(np.array(math.hypot(*self.apex)), np.array(math.atan2(self.apex[1], self.apex[0])))
        )
        plane = self.gradient[0] * x + self.gradient[1] * y
        gap = np.asarray(self.tip.height(rho, angle)) - lowest + plane
        # beside the apex the difference would be rounding; there the shape is its own curvature
        close = np.asarray(r) <= self._beside
        if np.any(close):
            curved = 0.5 * np.square(r) / self._beside * self._slope(np.array(self._beside), phi)
            gap = np.where(close, curved, gap)
        return spread(gap, phi)

    def slope(self, r: Array, phi: Array) -> Array:
        close = np.asarray(r) <= self._beside
        slope = self._slope(r, phi)
        if np.any(close):
            slope = np.where(close, np.asarray(r) / self._beside * self._slope(np.array(self._beside), phi), slope)
        return spread(slope, phi)

    @property
    def _beside(self) -> float:
        """Radius below which f is taken from the curvature at the new apex: rounding and third derivatives count 1e-5 there."""
        return max(1e-5 * math.hypot(*self.apex), np.finfo(float).tiny)

    def _slope(self, r: Array, phi: Array) -> Array:
        rho, angle, _, _ = self._polar(r, phi)
        radial, around = _gradient(self.tip, rho, angle)
        turn = np.asarray(phi) - angle
        own = radial * np.cos(turn) + around * np.sin(turn)
        return np.asarray(own + self.gradient[0] * np.cos(phi) + self.gradient[1] * np.sin(phi))

    def _polar(self, r: Array, phi: Array) -> tuple[Array, Array, Array, Array]:
        """Polar coordinates about the tip's own apex, and the step from the new one."""
        x, y = np.asarray(r) * np.cos(phi), np.asarray(r) * np.sin(phi)
        return np.hypot(self.apex[0] + x, self.apex[1] + y), np.arctan2(self.apex[1] + y, self.apex[0] + x), x, y


def _tilted(tip: Indenter, x: float, y: float) -> tuple[Indenter, tuple[float, float]]:
    """Shape about the new apex, and where that is; (x, y) is the gradient of the added plane."""
    if isinstance(tip, Paraboloid):
        return tip, (-tip.radius * x, -tip.radius * y)
    if isinstance(tip, EllipticParaboloid):
        return tip, (-x / (2 * tip.A), -y / (2 * tip.B))
    if isinstance(tip, Rounded) and not tip.true_sphere and isinstance(tip.tip, (Pyramid, FacetedPyramid)):
        return Rounded(_leaning(tip.tip, x, y), tip.radius, true_sphere=False), (-tip.radius * x, -tip.radius * y)
    if isinstance(tip, (Pyramid, FacetedPyramid)):
        return _leaning(tip, x, y), (0.0, 0.0)
    if tip.exponent == 1:
        try:
            return PowerLaw(1.0, _LeaningAngular(tip, (x, y)), tip.corners), (0.0, 0.0)
        except ValueError:
            raise _too_far(x, y) from None
    if tip.corners:
        raise ValueError(
            f"Tilted cannot centre {type(tip).__name__} anew: its edges would not meet at the new apex. Pyramids "
            "can be tilted; tilt "
            "before cutting off or combining."
        )
    apex = _lowest(tip, x, y)
    return _Recentred(tip, (x, y), apex), apex


def _leaning(tip: Pyramid | FacetedPyramid, x: float, y: float) -> FacetedPyramid:
    try:
        return pyramid_of(face_gradients(tip) + np.array([x, y]))
    except ValueError:
        raise _too_far(x, y) from None


def _too_far(x: float, y: float) -> ValueError:
    return ValueError(
        f"Tilted by a slope of {math.hypot(x, y):.4g} is more than a flank of the tip: it lies on that flank "
        "and has no apex of its "
        "own. Tilt less."
    )


def _gradient(tip: Indenter, rho: Array, angle: Array) -> tuple[Array, Array]:
    """Derivatives of the tip's height along its radius and along its circumference."""
    radial = np.asarray(tip.slope(rho, angle))
    if tip.round:
        return radial, np.zeros_like(radial)
    # step of the five-point difference [rad]: rounding 1e-11 of f, truncation far below
    step = 1e-4
    h = [np.asarray(tip.height(rho, angle + j * step)) for j in (-2, -1, 1, 2)]
    change = (4 * (h[2] - h[1]) / 2 - (h[3] - h[0]) / 4) / (3 * step)
    return radial, np.divide(change, rho, out=np.zeros_like(change), where=np.asarray(rho) > 0)


def _lowest(tip: Indenter, x: float, y: float) -> tuple[float, float]:
    """Lowest point of f + x X + y Y."""
    steepness = math.hypot(x, y)
    if steepness == 0:
        return 0.0, 0.0
    direction = math.atan2(-y, -x)

    def excess(radius: float) -> float:
        return float(np.asarray(tip.slope(np.array(radius), np.array(direction)))) - steepness

    end = _first_steeper(excess, tip.reach)
    if end is None:
        raise _too_far(x, y)
    low = 1e-9 * end
    if excess(low) >= 0:
        return 0.0, 0.0
    unit = float(scipy.optimize.brentq(excess, low, end, xtol=1e-15 * end, rtol=1e-15))
    start = np.array([math.cos(direction), math.sin(direction)])
    if tip.round:
        return unit * float(start[0]), unit * float(start[1])

    def gradient(point: Array) -> Array:
        # a step beyond the tip is judged at its end: there may be no height farther out
        rho, angle = min(np.hypot(*point) * unit, tip.reach), np.arctan2(point[1], point[0])
        radial, around = _gradient(tip, np.array(rho), np.array(angle))
        c, s = math.cos(angle), math.sin(angle)
        return np.array([radial * c - around * s + x, radial * s + around * c + y]) / steepness

    found = scipy.optimize.root(gradient, start, tol=100 * np.finfo(float).eps)
    if np.abs(gradient(found.x)).max() > 1e-8 or np.hypot(*found.x) * unit >= tip.reach:
        raise _too_far(x, y)
    return float(found.x[0]) * unit, float(found.x[1]) * unit


def _first_steeper(excess: Callable[[float], float], reach: float) -> float | None:
    """A radius at which the slope exceeds the tilt, up to the reach."""
    radius = min(1.0, reach)
    for _ in range(200):
        if excess(radius / 2) < 0:
            break
        radius /= 2
    for _ in range(200):
        if excess(radius) >= 0:
            return radius
        if radius >= reach:
            return None
        radius = min(2 * radius, reach)
    return None
