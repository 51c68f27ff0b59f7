"""Pyramids and cones with a rounded tip: every face and edge is tangent to a cap of one radius.

A convex tip is the highest of its tangent planes. Take the cap and keep only the tangent planes whose gradient k the
pyramid has, the polygon K that its faces span (for a cone, a disc):

    f(x) = max over k in K of  k . x - q(k),     q = R |k|^2/2 (paraboloid) or R (sqrt(1 + |k|^2) - 1) (sphere).

At the apex this is the cap itself, far away the pyramid, lowered by q of its faces, and along the edges a rounding of the same
radius R. The faces touch the cap; height and slope are continuous everywhere, only curvatures jump. For equal faces it is the
body that a sphere of radius R can touch everywhere from inside. The common "blunted pyramid" of AFM software puts a cap
inside the circle in which the sections of the faces' middles end; off those middles its slope jumps on that circle, which no real
tip does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch._support.declared import a_length
from flatpunch._support.readable import readable
from flatpunch.indenters._common import FULL_TURN, spread
from flatpunch.indenters.profile import Indenter
from flatpunch.indenters.shapes.pointed import Cone, FacetedPyramid, Pyramid, edge_directions, face_gradients


@readable
@dataclass(frozen=True, slots=True)
class Rounded(Indenter):
    """Pyramid or cone whose tip is rounded with a given radius, its faces tangent to the cap.

    Parameters
    ----------
    tip : Pyramid, FacetedPyramid or Cone
        The tip before rounding; far away the shape is this one, lowered by the height that rounding takes off.
    radius : float
        Radius of curvature R at the apex [m], > 0.
    true_sphere : bool
        Whether the cap is a sphere, f = R - sqrt(R^2 - r^2), or its small-slope form r^2/(2 R). It matters for steep
        tips: a square pyramid of 55 degrees loses 0.74 R of its height to a sphere and 1.02 R to a paraboloid, and forces
        differ by 5 to 11 %. The small-slope form scales with the slopes, which the contact theory itself does.

    See Also
    --------
    Truncated : Tips that are worn flat.

    Examples
    --------
    >>> fp.Rounded(fp.Berkovich(), radius=50e-9)
    Rounded(tip=Pyramid(sides=3, inclination=0.43162), radius=5e-08, true_sphere=True)
    """

    tip: Pyramid | FacetedPyramid | Cone
    radius: Annotated[float, a_length("radius of the apex")]
    true_sphere: bool = True
    _gradients: Array | None = field(init=False, repr=False, compare=False)
    # the curvature jumps where edges and cap meet the faces, on lines across the rays
    angular_tolerance = 1e-8

    def _together_(self) -> None:
        if not isinstance(self.tip, (Pyramid, FacetedPyramid, Cone)):
            raise TypeError(
                f"Rounded.tip = {shown(self.tip)} must be a Pyramid, FacetedPyramid or Cone: other shapes are round at the "
                "apex already."
            )
        object.__setattr__(self, "_gradients", None if isinstance(self.tip, Cone) else face_gradients(self.tip))

    @property
    def rounded_edges(self) -> tuple[float, ...]:
        """Directions of the rounded edges, which far away look sharp [rad]."""
        return () if self._gradients is None else edge_directions(self._gradients)

    @property
    def seams(self) -> tuple[float, ...]:
        """Directions of the joints, which are those of the rounded edges [rad]."""
        return self.rounded_edges

    @property
    def scales(self) -> tuple[float, ...]:
        """Radii at which the cap meets the middles of edges and of faces, and some beyond [m]."""
        end = self.transition[1]
        return (end,) if self._gradients is None else (*self.rings, 1.5 * end, 4 * end, 20 * end)

    @property
    def rings(self) -> tuple[float, ...]:
        """Radii at which the curvature jumps: where the cap meets the middles of edges and of faces [m]."""
        if self._gradients is None:
            return (self.transition[0],)
        k, following = self._gradients, np.roll(self._gradients, -1, axis=0)
        side = (following - k) / np.hypot(*(following - k).T)[:, None]
        has_foot = (np.sum(side * k, axis=1) < 0) & (np.sum(side * following, axis=1) > 0)
        feet = np.abs(k[:, 0] * side[:, 1] - k[:, 1] * side[:, 0])[has_foot]
        met = sorted({round(float(v), 12) for v in (*feet, *np.hypot(*k.T))})
        return tuple(self._where(v) for v in met)

    @property
    def round(self) -> bool:
        """Whether the tip is a cone."""
        return self._gradients is None

    @property
    def transition(self) -> tuple[float, float]:
        """Radii at which the cap first ends (towards an edge) and last ends (towards the steepest face) [m]."""
        if self._gradients is None:
            steepest = lowest = self._cone_slope
        else:
            k, following = self._gradients, np.roll(self._gradients, -1, axis=0)
            steepest = float(np.hypot(*k.T).max())
            distance = (k[:, 0] * following[:, 1] - k[:, 1] * following[:, 0]) / np.hypot(*(following - k).T)
            lowest = float(distance.min())
        return self._where(lowest), self._where(steepest)

    @property
    def height_lost(self) -> float:
        """Height by which rounding lowers the steepest face against the sharp tip [m]."""
        steepness = math.tan(
            self.tip.inclination if isinstance(self.tip, (Pyramid, Cone)) else max(self.tip.inclinations)
        )
        return float(self._support(np.square(steepness)))

    def crossings(self, r: Array) -> Array:
        """Polar angles [rad] at which circles of radii r, shape (n,), cross lines along which the curvature jumps.

        There the cap meets edges and faces, and these meet each other. Shape (n, k), NaN where a line is not crossed.
        """
        found = [np.empty((r.size, 0))]
        if self._gradients is not None:
            with np.errstate(divide="ignore", invalid="ignore"):
                for start, end in zip(self._gradients, np.roll(self._gradients, -1, axis=0), strict=True):
                    along = (end - start) / np.hypot(*(end - start))
                    gamma, direction = float(along[1] * start[0] - along[0] * start[1]), math.atan2(along[1], along[0])
                    lines = [(direction - math.pi / 2, gamma / self._cap_slope(r))]
                    lines += [(direction, self._aside(float(along @ corner), gamma) / r) for corner in (start, end)]
                    for middle, cosine in lines:
                        found.append(middle + np.arccos(cosine)[:, None] * np.array([-1, 1]))
        return np.hstack(found)

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return self.height_and_slope(r, phi)[0]

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting."""
        return self.height_and_slope(r, phi)[1]

    def height_and_slope(self, r: Array, phi: Array) -> tuple[Array, Array]:
        """Both at once, which costs no more than one of them."""
        if self._gradients is None:
            height, slope = self._cone(np.asarray(r, dtype=float))
            return spread(height, phi), spread(slope, phi)
        return self._evaluate(r, phi)

    @property
    def _cone_slope(self) -> float:
        assert isinstance(self.tip, Cone)  # without gradients of faces
        return math.tan(self.tip.inclination)

    def _cone(self, r: Array) -> tuple[Array, Array]:
        k = np.minimum(self._cap_slope(r), self._cone_slope)
        inside = k < self._cone_slope
        return np.where(inside, self._cap(r), k * r - self._support(k * k)), k

    def _evaluate(self, r: Array, phi: Array) -> tuple[Array, Array]:
        """Height and slope: on the cap where its gradient lies in the polygon, else at the best gradient on the border."""
        assert self._gradients is not None
        r, phi = np.asarray(r, dtype=float), np.asarray(phi, dtype=float)
        sides = list(zip(self._gradients, np.roll(self._gradients, -1, axis=0), strict=True))
        if isinstance(self.tip, Pyramid):
            # seen from one sector between the middles of two faces, the side of that sector is the best
            phi, sides = np.mod(phi, FULL_TURN / self.tip.sides), sides[:1]
        cap_slope, cosine, sine = self._cap_slope(r), np.cos(phi), np.sin(phi)
        shape = np.broadcast_shapes(r.shape, phi.shape)
        on_cap = np.ones(shape, dtype=bool)
        height, slope = np.full(shape, -np.inf), np.zeros(shape)
        for start, end in sides:
            along = (end - start) / np.hypot(*(end - start))
            # notation: on this side of the polygon k = gamma normal + tau along, the normal being `along` turned clockwise
            gamma = float(along[1] * start[0] - along[0] * start[1])
            across, aside = along[1] * cosine - along[0] * sine, along[0] * cosine + along[1] * sine
            on_cap &= cap_slope * across <= gamma
            tau = np.clip(self._best(r * aside, gamma), along @ start, along @ end)
            inclined = gamma * across + tau * aside
            value = r * inclined - self._support(gamma**2 + tau * tau)
            if len(sides) == 1:
                height, slope = value, inclined
            else:
                higher = value > height
                height, slope = np.where(higher, value, height), np.where(higher, inclined, slope)
        return np.where(on_cap, self._cap(r), height), np.where(on_cap, cap_slope, slope)

    def _support(self, square: Array) -> Array:
        """q(k) from |k|^2."""
        if self.true_sphere:
            return np.asarray(self.radius * square / (1 + np.sqrt(1 + square)))
        return np.asarray(self.radius * square / 2)

    def _best(self, aside: Array, gamma: float) -> Array:
        """Gradient tau along an edge of gradient gamma, at the distance `aside` from it."""
        if not self.true_sphere:
            return aside / self.radius
        room = np.maximum((self.radius - aside) * (self.radius + aside), 0.0)
        with np.errstate(divide="ignore"):
            return np.asarray(aside * math.hypot(1, gamma) / np.sqrt(room))

    def _aside(self, tau: float, gamma: float) -> float:
        """Distance from an edge of gradient gamma at which the gradient along it is tau."""
        return tau * self.radius / (math.hypot(1, gamma, tau) if self.true_sphere else 1)

    def _cap(self, r: Array) -> Array:
        if self.true_sphere:
            return np.asarray(r * r / (self.radius + np.sqrt(np.maximum((self.radius - r) * (self.radius + r), 0.0))))
        return np.asarray(r * r / (2 * self.radius))

    def _cap_slope(self, r: Array) -> Array:
        if not self.true_sphere:
            return np.asarray(r / self.radius)
        room = np.sqrt(np.maximum((self.radius - r) * (self.radius + r), 0.0))
        # beyond the sphere's equator steeper than any face, but finite
        return np.asarray(r / np.maximum(room, 1e-150 * self.radius))

    def _where(self, slope: float) -> float:
        """Radius at which the cap has a slope."""
        return self.radius * slope / (math.hypot(1, slope) if self.true_sphere else 1)
