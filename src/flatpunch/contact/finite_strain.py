"""Forces at large strain over those of linear theory, from a table of finite elements, for `finite_strain=` of `indent`.

The ratio depends on the depth and the thickness over the radius of a sphere, or on the angle of a cone and the depth over the
thickness, and on the Poisson ratio, not on the modulus. It is tabulated for a neo-Hookean solid that is bonded to a rigid base,
or a half-space, without friction; `scripts/finite_strain` makes the table and says how. There are three families of series in
Chebyshev polynomials: spheres on layers thinner and thicker than the radius, and sharp cones.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.resources import files

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array, BadValue
from flatpunch._support.kinds import one_of
from flatpunch._support.prefixes import text
from flatpunch.contact.curve import Control, Curve
from flatpunch.indenters import Cone, FacetedPyramid, Pyramid, Sphere, angular_rule
from flatpunch.indenters.shapes.facets import face_gradients
from flatpunch.media import FreeLayer, HalfSpace, Layer, Medium, RigidBase

NEO_HOOKEAN = "neo-hookean"
"""W = mu/2 (I - 3) + kappa/2 (J - 1)^2 with I = J^(-2/3) tr F^T F."""

SETTLED, ITERATIONS = 1e-5, 30
"""Relative step of Newton's method after which a depth is known to about its square; and the most steps to it."""

FILE = files("flatpunch.contact") / "data" / "finite_strain.json"

POISSON = 0.45
"""Least Poisson ratio."""
THIN = 0.1
"""Least thickness over the radius."""
DEEP = 0.5
"""Largest depth, over the thickness and over the radius."""


CONES, ANGLES = "sharp", (10.0, 60.0)
"""Name of the table of cones, and its angles between flank and surface [degrees]."""

SPHERES: dict[str, Callable[[float, float], tuple[float, float, float]]] = {
    "thin": lambda x, y: (DEEP * x**2, THIN ** (y - 1), 1.0),
    "thick": lambda x, y: (DEEP * x**2, 1.0, 1 / y),
}
"""Depth, radius and thickness at coordinates (x, y) in [0, 1] of each table of spheres."""


def angle_at(y: float) -> float:
    """Angle of a cone [degrees] at a coordinate in [0, 1]."""
    return ANGLES[0] + (ANGLES[1] - ANGLES[0]) * y


def poisson_at(z: float) -> float:
    """Poisson ratio at a coordinate in [0, 1]: thin layers are soft by their compressibility, so that it is a root."""
    return 0.5 - (0.5 - POISSON) * z**2


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
    """

    series: Array
    safety: float
    mesh: float
    grows: bool

    def at(self, z: float, y: float, x: Array) -> tuple[Array, Array, Array]:
        """Ratio of forces, its derivative by x, and its error, shape (n,) each."""
        plane = np.asarray(chebyshev.chebval(2 * z - 1, self.series))
        line = np.asarray(chebyshev.chebval(2 * y - 1, plane))
        value, slope = chebyshev.chebval(2 * x - 1, line), 2 * chebyshev.chebval(2 * x - 1, chebyshev.chebder(line))
        last = abs(line[-1])
        for rest in (plane[-1], chebyshev.chebval(2 * y - 1, self.series[-1])):
            last = last + np.abs(chebyshev.chebval(2 * x - 1, rest))
        weight, rise = (x, value) if self.grows else (np.ones_like(x), np.zeros_like(x))
        return 1 + weight * value, rise + weight * slope, weight * (self.mesh + self.safety * last)


@byte_cached
def tables() -> dict[str, Table]:
    """The tables that come with the package."""
    found = json.loads(FILE.read_text())["tables"]
    return {
        name: Table(np.array(each["series"]), each["safety"], each["mesh"], each["grows"])
        for name, each in found.items()
    }


@dataclass(frozen=True, slots=True)
class Strained:
    """Where in the table a tip on a medium is.

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
        parts = "the thickness" if self.family == CONES else "the thickness and of the radius"
        return f"the table of finite_strain ends at {text(self.deepest, 'm')}, half of {parts}."

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
        """Force over that of linear theory, its derivative by the depth [1/m], and its error, at depths of shape (n,).

        Constant beyond the table. To the error of a pyramid the distance to the farther one of its bounds is added, there or on
        a half-space: on layers factors of different angles cross.
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


def strained(medium: object, indenter: object) -> Strained:
    """Place of a case in the table.

    Raises
    ------
    BadValue
        If the table does not hold it.
    """
    if not isinstance(indenter, Sphere | Cone | Pyramid | FacetedPyramid):
        raise BadValue(
            "finite_strain",
            repr(NEO_HOOKEAN),
            f"is tabulated for Sphere and sharp Cone, and estimated for sharp pyramids; the tip is {type(indenter).__name__}. "
            "Leave finite_strain out.",
        )
    poisson, thickness = _layer(medium)
    if poisson < POISSON:
        raise _beyond(f"Poisson ratios from {POISSON:g} to 0.5", f"{poisson:.10g}")
    z = math.sqrt((0.5 - poisson) / (0.5 - POISSON))
    if not isinstance(indenter, Sphere):
        *bounds, y = map(_of_angle, _cones(indenter))
        return Strained(CONES, z, y, DEEP * thickness, tuple(bounds))
    over = thickness / indenter.radius
    if over < THIN * (1 - ROUNDING):
        raise _beyond(f"layers of {THIN:g} or more radii of the sphere", f"{over:.7g} radii")
    if over < 1:
        return Strained("thin", z, min(1 - math.log(over) / math.log(THIN), 1.0), DEEP * thickness)
    return Strained("thick", z, 1 / over, DEEP * indenter.radius)


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
    return float(weights @ indenter.angular(phi) ** -2.0) ** -0.5


def _of_angle(angle: float) -> float:
    """Inverse of `angle_at`, for angles of the table."""
    y = (angle - ANGLES[0]) / (ANGLES[1] - ANGLES[0])
    if not -ROUNDING < y < 1 + ROUNDING:
        held = f"cones, and edges and faces of pyramids, that are inclined by {ANGLES[0]:g} to {ANGLES[1]:g} degrees"
        raise _beyond(held, f"{angle:.7g} degrees")
    return min(max(y, 0.0), 1.0)


def _layer(medium: object) -> tuple[float, float]:
    """Poisson ratio and thickness of a half-space, or of one layer bonded to a rigid base."""
    if isinstance(medium, HalfSpace):
        return medium.poisson, math.inf
    if isinstance(medium, Medium) and len(medium.layers) == 1 and isinstance(medium.base, RigidBase):
        layer = medium.layers[0]
        if isinstance(layer, Layer) and layer.bonded is True:
            return layer.poisson, layer.thickness
    raise BadValue(
        "finite_strain",
        repr(NEO_HOOKEAN),
        "is tabulated for a HalfSpace, and a Medium of one homogeneous Layer bonded to a RigidBase. Leave finite_strain out.",
    )


def _beyond(held: str, given: str) -> BadValue:
    return BadValue(
        "finite_strain",
        repr(NEO_HOOKEAN),
        f"is tabulated for {held}; here it is {given}. Leave finite_strain out.",
    )


def checked(name: str | None, medium: object, indenter: object, control: str) -> Strained | None:
    """Place of a case in the table, or None where no law is asked for; refuses what cannot be corrected."""
    if name is None:
        return None
    one_of("finite_strain", name, (NEO_HOOKEAN,), "None is linear theory.")
    if isinstance(medium, FreeLayer):
        raise BadValue("finite_strain", repr(name), "does not go with a FreeLayer, which lifts off.")
    if control == "radius":
        raise BadValue(
            "finite_strain",
            repr(name),
            "goes with depth or force: the contact radius at large strain is not tabulated.",
        )
    return strained(medium, indenter)


def solve(place: Strained, linear: Callable[[Control], Curve], control: Control) -> Curve:
    """Curve of linear theory, its forces and stiffnesses corrected.

    Parameters
    ----------
    place : Strained
        Where in the table.
    linear : callable
        Linear theory.
    control : Control
        Depths or forces.

    Raises
    ------
    BadValue
        For steps beyond the table.
    """
    if control.name == "depth":
        _in_table(place, control, control.values)
    curve = linear(control)
    ratio, rate, error = place.ratio(curve.depth)
    for _ in range(ITERATIONS if control.name == "force" else 0):
        # Newton's method on the logarithms; without contact nothing moves
        found, slope = curve.force * ratio, curve.stiffness * ratio + curve.force * rate
        live = found > 0
        step = np.log(np.divide(control.values, found, out=np.ones_like(found), where=live))
        step *= np.divide(found, curve.depth * slope, out=np.zeros_like(found), where=live)
        curve = linear(Control("depth", curve.depth * np.exp(step)))
        ratio, rate, error = place.ratio(curve.depth)
        if np.abs(step).max(initial=0.0) <= SETTLED:
            break
    _in_table(place, control, curve.depth)
    before = curve.extra["force_error"][1].astype(float) if "force_error" in curve.extra else 0.0
    extra = {
        **curve.extra,
        "force_error": (("step",), before + error / ratio, "1", "estimated relative error of the force"),
        "strain_factor": (("step",), ratio, "1", "force at large strain over that of linear theory"),
    }
    return replace(
        curve,
        force=control.values if control.name == "force" else curve.force * ratio,
        stiffness=curve.stiffness * ratio + curve.force * rate,
        extra=extra,
        notes=curve.notes + place.notes,
    )


def _in_table(place: Strained, control: Control, depth: Array) -> None:
    """Refuse steps whose depth is beyond the table."""
    far = np.flatnonzero(depth > place.deepest * (1 + SETTLED**2))
    if far.size:
        i = int(far[0])
        unit = {"depth": "m", "force": "N"}[control.name]
        raise BadValue(
            f"{control.name}[{i}]",
            text(float(control.values[i]), unit),
            f"is a depth of {text(float(depth[i]), 'm')}; {place.end} Ask for less, or leave finite_strain out.",
        )


def overestimate(medium: object, indenter: object, depth: Array) -> str | None:
    """What linear theory is off by at the largest depth, as the end of a note; None outside the table."""
    try:
        place = strained(medium, indenter)
    except BadValue:
        return None
    largest = np.array([np.nanmax(depth, initial=0.0)])
    if not 0 < largest[0] <= place.deepest:
        return None
    off = 100 * (float(place.ratio(largest)[0][0]) - 1)
    side = "less" if off < 0 else "more"
    found = f"at {text(float(largest[0]), 'm')} a neo-Hookean solid takes {abs(off):.2g} % {side} force than linear theory; "
    return found + f"finite_strain = '{NEO_HOOKEAN}' corrects it."
