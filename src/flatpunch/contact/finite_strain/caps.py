"""Rounded cones: between the sphere of the cap and the sharp cone of the flank.

A cone of height c above the depth at which its cap ends is, at a depth d, the sharp cone at the depth D = d + c whose apex is cut
off. Were the cap all that touches, it would be the sphere, of a radius R D/D_b and at a depth d_b D/D_b, with d_b the depth at
which the contact under the sphere reaches the flank and D_b = d_b + c. In between

    rho = rho_cone(D) + t^3 (rho_sphere - rho_cone(D)),    t = D_b/D,

since a missing apex takes a share of the order t^3 off the force. Both ends are exact: rho is that of the sphere up to d_b, and
that of the sharp cone far beyond. In elasticity of second order forces are quadratic in the profile, and what a cap takes off
them has one weight for all angles. What is of higher order is taken in proportion to t^2 (1 - t) and to the part of rho_cone that
is not linear in the slope; its factor and its error are measured by finite elements (`next_order`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, BadValue
from flatpunch._support.prefixes import text
from flatpunch.compliances import compliance
from flatpunch.contact.curve import Control
from flatpunch.contact.finite_strain.tables import (
    ANGLES,
    CONES,
    DEEP,
    THIN,
    Place,
    Strained,
    angle_at,
    cone_place,
    layer_of,
    next_order,
    of_poisson,
    of_radius,
    sphere_place,
    tables,
)
from flatpunch.contact.physics import NEO_HOOKEAN
from flatpunch.contact.round.mean_profile import mean_contact
from flatpunch.indenters import Cone, FacetedPyramid, Pyramid, Sphere
from flatpunch.media import Body, HalfSpace, Layer, Medium, RigidBase

STEP = 1e-4
"""Relative step of the difference that gives the derivative by the depth."""


@dataclass(frozen=True, slots=True)
class Capped:
    """Where in the tables a rounded cone is.

    Attributes
    ----------
    sphere, cone : Strained
        Places of the cap and of the sharp cone.
    radius, thickness, poisson : float
        Radius of the cap [m], thickness of the layer [m], and its Poisson ratio.
    end_of_cap, lost : float
        Depth at which the cap ends in linear theory, and height that it takes off the sharp cone [m].
    """

    sphere: Strained
    cone: Strained
    radius: float
    thickness: float
    poisson: float
    end_of_cap: float
    lost: float

    @property
    def whole(self) -> float:
        """Depth of the sharp cone when the cap ends [m]."""
        return self.end_of_cap + self.lost

    @property
    def deepest(self) -> float:
        """Largest depth at which sphere and sharp cone are in their tables [m]."""
        if self.sphere.deepest < self.end_of_cap:
            return self.sphere.deepest
        share, far = (
            self.end_of_cap / self.radius,
            min(DEEP * self.thickness / self.whole, self.thickness / (THIN * self.radius)),
        )
        if share > DEEP:
            far = min(far, math.sqrt(1 / share - 1) * self.thickness / self.radius)
        return max(self.end_of_cap, far * self.whole - self.lost)

    @property
    def end(self) -> str:
        """As of `Place`."""
        return f"the tables of finite_strain end at {text(self.deepest, 'm')}."

    @property
    def notes(self) -> tuple[str, ...]:
        """As of `Place`."""
        return ()

    def ratio(self, depth: Array) -> tuple[Array, Array, Array]:
        """As of `Place`."""
        ratio, slope, error = self.sphere.ratio(np.minimum(depth, self.end_of_cap))
        flank = (depth > self.end_of_cap) & (self.deepest > self.end_of_cap)
        if flank.any():
            at = np.minimum(depth[flank], self.deepest)
            below, above = (1 - STEP) * at, np.minimum((1 + STEP) * at, self.deepest)
            inside = depth[flank] <= self.deepest * (1 + 1e-10)
            ratio[flank], error[flank] = self._flank(at)
            slope[flank] = np.where(inside, (self._flank(above)[0] - self._flank(below)[0]) / (above - below), 0.0)
        return ratio, slope, error

    def _flank(self, depth: Array) -> tuple[Array, Array]:
        """Ratio and error at depths beyond the end of the cap, shape (n,)."""
        ratio, error, between = self.parts(depth)
        share, spread = next_order()
        return (
            ratio - share * self.beyond_second_order * between,
            error + spread * of_poisson(self.poisson) ** 2 * between,
        )

    def parts(self, depth: Array) -> tuple[Array, Array, Array]:
        """Ratio of second order beyond the cap, what the tables add to its error, and the distance to both, (n,) each."""
        sharp = depth + self.lost
        t = np.minimum(self.whole / sharp, 1.0)
        cap, cap_error = self._sphere(self.radius / t, self.end_of_cap / t)
        cone, _, cone_error = self.cone.ratio(sharp)
        between = 27 / 4 * t**2 * (1 - t)
        return cone + t**3 * (cap - cone), t**3 * cap_error + (1 - t**3) * cone_error, between

    @property
    def beyond_second_order(self) -> float:
        """Part of the ratio under the sharp cone on an incompressible half-space that is not in proportion to its slope.

        Near a Poisson ratio of 0.48 this part vanishes; what caps add of that order does not.
        """
        angles = np.array([angle_at(self.cone.y), ANGLES[0]])
        y, slope = (angles - ANGLES[0]) / (ANGLES[1] - ANGLES[0]), np.tan(np.radians(angles))
        own, least = tables()[CONES].at(0.0, y, np.zeros(2))[0] - 1
        return float(abs(own - least * slope[0] / slope[1]))

    def _sphere(self, radius: Array, depth: Array) -> tuple[Array, Array]:
        """Ratio under spheres and its error, shape (n,)."""
        ratio, error = np.empty_like(depth), np.empty_like(depth)
        y, deepest = of_radius(radius, self.thickness)
        x = np.sqrt(np.minimum(depth / deepest, 1.0))
        for family, here in (("thin", radius > self.thickness), ("thick", radius <= self.thickness)):
            z = of_poisson(self.poisson)
            ratio[here], _, error[here] = tables()[family].at(z, y[here], x[here])
        return ratio, error


def place_of(medium: Body, indenter: object) -> Place:
    """Place of a case in the tables; BadValue if they do not hold it."""
    if isinstance(indenter, Sphere):
        return sphere_place(indenter.radius, *layer_of(medium))
    if isinstance(indenter, Cone | Pyramid | FacetedPyramid):
        return cone_place(indenter, *layer_of(medium))
    # here, since every other result asks for a place and needs no worn tips
    from flatpunch.indenters import Rounded

    if isinstance(indenter, Rounded) and isinstance(indenter.tip, Cone) and indenter.true_sphere:
        return capped_place(indenter.tip, indenter.radius, *layer_of(medium))
    raise BadValue(
        "finite_strain",
        repr(NEO_HOOKEAN),
        "is tabulated for Sphere, Cone and SpheroCone, and estimated for sharp pyramids; the tip is "
        f"{type(indenter).__name__}. Leave finite_strain out.",
    )


def capped_place(flank: Cone, radius: float, poisson: float, thickness: float) -> Capped:
    """Place of a cone whose cap has a radius [m]."""
    return Capped(
        sphere_place(radius, poisson, thickness),
        cone_place(flank, poisson, thickness),
        radius,
        thickness,
        poisson,
        radius * _end_of_cap(flank.inclination, poisson, thickness / radius),
        radius * (1 / math.cos(flank.inclination) - 1),
    )


@byte_cached
def _end_of_cap(inclination: float, poisson: float, thickness: float) -> float:
    """Depth over the radius of a sphere at which its slope at the rim is that of a flank, at a thickness over the radius."""
    half = HalfSpace(young=1.0, poisson=poisson)
    medium = Medium([Layer(1.0, poisson, thickness)], base=RigidBase()) if math.isfinite(thickness) else half
    end = Control("radius", np.array([math.sin(inclination)]))
    return float(mean_contact(compliance(medium), Sphere(1.0), end)[1].depth[0])
