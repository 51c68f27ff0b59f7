"""Where in the tables of large strains a tip on a medium is: spheres, cones, and pyramids by the cone with the same areas."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, BadValue
from flatpunch._support.prefixes import text
from flatpunch.contact.finite_strain.tables import (
    ANGLES,
    CONES,
    DEEP,
    POISSON,
    THIN,
    angle_at,
    of_poisson,
    tables,
    thick_end,
)
from flatpunch.contact.physics import NEO_HOOKEAN
from flatpunch.indenters import Cone, FacetedPyramid, Pyramid, angular_rule
from flatpunch.indenters.shapes.pointed import face_gradients
from flatpunch.media import Body

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
    """Coordinate of a Poisson ratio of the tables."""
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
    if stack and len(stack.layers) == 1 and stack.base.rigid:
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
