"""Tables of the ratio of forces at large strain, series in Chebyshev polynomials, and where in them a tip on a medium is.

The ratio depends on the depth and the thickness over the radius of a sphere, or on the angle of a cone and the depth over the
thickness, and on the Poisson ratio, not on the modulus. It is tabulated for a neo-Hookean solid that is bonded to a rigid base,
or a half-space, without friction; `scripts/finite_strain` makes the tables and says how. There are three: spheres on layers
thinner and thicker than the radius, and sharp cones.

Pyramids are taken by the cone with the same areas.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Protocol

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array, BadValue
from flatpunch._support.prefixes import text
from flatpunch.contact.physics import NEO_HOOKEAN
from flatpunch.indenters import Cone, FacetedPyramid, Pyramid, angular_rule
from flatpunch.indenters.shapes.pointed import face_gradients
from flatpunch.media import Body

FILE = files("flatpunch.contact") / "data" / "finite_strain.json"

THIN = 0.1
"""Least thickness over the radius."""
DEEP = 0.5
"""Largest depth over the thickness of layers under cones, and under spheres of larger radius."""

CONES, ANGLES = "sharp", (10.0, 60.0)
"""Name of the table of cones, and its angles between flank and surface [degrees]."""

POISSON = 0.4
"""Least Poisson ratio."""

SPHERES: dict[str, Callable[[float, float], tuple[float, float, float]]] = {
    "thin": lambda x, y: (DEEP * x**2, THIN ** (y - 1), 1.0),
    "thick": lambda x, y: (float(thick_end(np.array(y))) * x**2, 1.0, 1 / y if y > 0 else math.inf),
}
"""Depth, radius and thickness at coordinates (x, y) in [0, 1] of each table of spheres."""


def thick_end(y: Array) -> Array:
    """Largest depth over the radius of spheres whose radii are y <= 1 of the thickness: at most half of the thickness."""
    return 1 / (1 + y * y)


def angle_at(y: float) -> float:
    """Angle of a cone [degrees] at a coordinate in [0, 1]."""
    return ANGLES[0] + (ANGLES[1] - ANGLES[0]) * y


def poisson_at(z: float) -> float:
    """Poisson ratio at a coordinate in [0, 1]: thin layers are soft by their compressibility, so that it is a root."""
    return 0.5 - (0.5 - POISSON) * z**2


def of_poisson(poisson: float) -> float:
    """Inverse of `poisson_at`, for Poisson ratios of the table."""
    return math.sqrt((0.5 - poisson) / (0.5 - POISSON))


@dataclass(frozen=True, slots=True)
class Table:
    """Series of one family, over coordinates (z, y, x) in [0, 1] of Poisson ratio, thickness or angle, and depth.

    Attributes
    ----------
    series : ndarray, shape (z, y, x)
        Chebyshev coefficients of (ratio - 1)/x, or of ratio - 1.
    safety : float
        Error between the nodes over the last terms of the series, the largest at points that did not make it.
    mesh : float
        Error of the finite elements, over x if strains grow with it.
    grows : bool
        Whether strains vanish at x = 0, as under spheres. Those under a cone on a half-space do not depend on the depth.
    doubts : ndarray, shape (n, z, y, x)
        Changes of the series had each of n nodes the other of two solutions on which meshes settle.
    """

    series: Array
    safety: float
    mesh: float
    grows: bool
    doubts: Array

    def at(self, z: float, y: float | Array, x: Array) -> tuple[Array, Array, Array]:
        """Ratio of forces, its derivative by x, and its error, shape (n,) each; y may have that shape too."""
        u, v = np.broadcast_arrays(2 * np.asarray(y) - 1, 2 * x - 1)
        plane = np.asarray(chebyshev.chebval(2 * z - 1, self.series))
        value = chebyshev.chebval2d(u, v, plane)
        slope = 2 * chebyshev.chebval2d(u, v, chebyshev.chebder(plane, axis=1))
        ends = (chebyshev.chebval(u, plane[:, -1]), chebyshev.chebval(v, plane[-1]))
        last = sum(map(np.abs, (*ends, chebyshev.chebval2d(u, v, self.series[-1]))))
        other = sum(
            np.abs(chebyshev.chebval2d(u, v, np.asarray(chebyshev.chebval(2 * z - 1, each)))) for each in self.doubts
        )
        weight, rise = (x, value) if self.grows else (np.ones_like(x), np.zeros_like(x))
        return 1 + weight * value, rise + weight * slope, weight * (self.mesh + self.safety * last + other)


@byte_cached
def tables() -> dict[str, Table]:
    """The tables that come with the package."""
    found = _file()["tables"]
    return {
        name: Table(np.array(each["series"]), each["safety"], each["mesh"], each["grows"], np.array(each["doubts"]))
        for name, each in found.items()
    }


@byte_cached
def next_order() -> tuple[float, float]:
    """Share of the term of next order in the ratio of rounded cones (`Capped`), and error at the least Poisson ratio besides."""
    share, spread = _file()["caps"]
    return share, spread


def _file() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(FILE.read_text())
    return found


SETTLED = 1e-5
"""Relative step of Newton's method after which a depth is known to about its square."""


class Place(Protocol):
    """What a case has from the tables."""

    @property
    def deepest(self) -> float:
        """Largest depth [m]; inf for cones on half-spaces."""

    @property
    def end(self) -> str:
        """The largest depth, in words."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What a result says about an estimate."""

    def ratio(self, depth: Array) -> tuple[Array, Array, Array]:
        """Force over that of linear theory, its derivative by the depth [1/m], and its error, at depths of shape (n,).

        Constant beyond the table.
        """


@dataclass(frozen=True, slots=True)
class Strained:
    """Where in one of the tables a tip on a medium is.

    Attributes
    ----------
    family : str
        Name of the table.
    z, y : float
        Coordinates of the Poisson ratio, and of the thickness or the angle.
    deepest : float
        Largest depth of the table [m]; inf for cones on half-spaces.
    bounds : tuple of float
        Coordinates of the cones through a pyramid's shallowest edge and steepest face; none for a tip of revolution.
    """

    family: str
    z: float
    y: float
    deepest: float
    bounds: tuple[float, ...] = ()

    @property
    def end(self) -> str:
        """The largest depth, in words."""
        part = "" if self.family == "thick" else ", half of the thickness"
        return f"the table of finite_strain ends at {text(self.deepest, 'm')}{part}."

    @property
    def notes(self) -> tuple[str, ...]:
        """What a result says about pyramids."""
        if not self.bounds:
            return ()
        edges, faces, own = (f"{angle_at(y):.3g}" for y in (*self.bounds, self.y))
        return (
            f"Large strains under a pyramid are estimated by the cone with the same areas, inclined by {own} degrees; the error "
            f"is the difference to the cones through the edges and the faces, inclined by {edges} and {faces} degrees.",
        )

    def ratio(self, depth: Array) -> tuple[Array, Array, Array]:
        """As of `Place`.

        To the error of a pyramid the distance to the farther one of its bounds is added, there or on a half-space: on layers
        factors of different angles cross.
        """
        power, table = (1.0 if self.family == CONES else 0.5), tables()[self.family]
        x = np.clip(depth / self.deepest, 0.0, 1.0) ** power
        ratio, slope, error = table.at(self.z, self.y, x)
        apart = np.zeros_like(x)
        for at in (x, np.zeros_like(x)) if self.bounds else ():
            own, *others = (table.at(self.z, y, at)[0] for y in (self.y, *self.bounds))
            apart = np.maximum(apart, np.abs(np.subtract(others, own)).max(axis=0))
        # without contact there is no force to correct
        inside = (depth > 0) & (depth <= self.deepest * (1 + SETTLED**2))
        return ratio, np.divide(power * slope * x, depth, out=np.zeros_like(x), where=inside), error + apart


def sphere_place(radius: float, poisson: float, thickness: float) -> Strained:
    """Place of a sphere on a layer, or on a half-space of infinite thickness."""
    over = thickness / radius
    if over < THIN * (1 - ROUNDING):
        raise beyond(f"layers of {THIN:g} or more radii of the sphere", f"{over:.7g} radii")
    family = "thin" if over < 1 else "thick"
    y, deepest = of_radius(np.array(radius), thickness)
    return Strained(family, _of_poisson(poisson), float(y), float(deepest))


def of_radius(radius: Array, thickness: float) -> tuple[Array, Array]:
    """Coordinate of spheres of radii [m], shape (n,), in the table of thin or that of thick layers, and its largest depth [m]."""
    slender = np.minimum(radius / thickness, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        y = np.minimum(1 - np.log(thickness / radius) / math.log(THIN), 1.0)
        thin = np.asarray(thickness < radius)
        return np.where(thin, y, slender), np.where(thin, DEEP * thickness, thick_end(slender) * radius)


def cone_place(indenter: Cone | Pyramid | FacetedPyramid, poisson: float, thickness: float) -> Strained:
    """Place of a sharp cone, or of the cone with the same areas as a pyramid."""
    *bounds, y = map(of_angle, _cones(indenter))
    return Strained(CONES, _of_poisson(poisson), y, DEEP * thickness, tuple(bounds))


def _of_poisson(poisson: float) -> float:
    if poisson < POISSON:
        raise beyond(f"Poisson ratios from {POISSON:g} to 0.5", f"{poisson:.10g}")
    return of_poisson(poisson)


def _cones(indenter: Cone | Pyramid | FacetedPyramid) -> tuple[float, ...]:
    """Angles of the cones through a pyramid's shallowest edge and steepest face, and of that with the same areas [degrees]."""
    slopes = [equal_area_slope(indenter)]
    if not isinstance(indenter, Cone):
        edge = float(indenter.angular(np.array(indenter.corners)).min())
        slopes = [edge, float(np.hypot(*face_gradients(indenter).T).max()), *slopes]
    return tuple(math.degrees(math.atan(slope)) for slope in slopes)


def equal_area_slope(indenter: Cone | Pyramid | FacetedPyramid) -> float:
    """Slope of the cone that has the same section at every height."""
    phi, weights = angular_rule(indenter)
    return 1 / math.sqrt(float(weights @ indenter.angular(phi) ** -2.0))


def of_angle(angle: float) -> float:
    """Inverse of `angle_at`, for angles of the table."""
    y = (angle - ANGLES[0]) / (ANGLES[1] - ANGLES[0])
    if not -ROUNDING < y < 1 + ROUNDING:
        held = f"cones, and edges and faces of pyramids, that are inclined by {ANGLES[0]:g} to {ANGLES[1]:g} degrees"
        raise beyond(held, f"{angle:.7g} degrees")
    return min(max(y, 0.0), 1.0)


def layer_of(medium: Body) -> tuple[float, float]:
    """Poisson ratio and thickness of a half-space, or of one layer bonded to a rigid base."""
    stack = medium.single
    if stack and stack.isotropic:
        return stack.isotropic[1], math.inf
    if stack and len(stack.layers) == 1 and stack.base.rigid and not stack.membrane:
        layer = stack.layers[0]
        if layer.isotropic and layer.bonded is True:
            return layer.isotropic[1], layer.thickness
    raise BadValue(
        "finite_strain",
        repr(NEO_HOOKEAN),
        "is tabulated for a HalfSpace, and a Medium of one homogeneous Layer bonded to a RigidBase. Leave finite_strain out.",
    )


def beyond(held: str, given: str) -> BadValue:
    """Error for a case that is not in the tables."""
    return BadValue(
        "finite_strain",
        repr(NEO_HOOKEAN),
        f"is tabulated for {held}; here it is {given}. Leave finite_strain out.",
    )
