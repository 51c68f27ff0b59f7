"""One asperity alone: force, radius and moments of its pressures over the depth, tabulated once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from flatpunch._support.checks import Array
from flatpunch.contact.indentation import indent
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.punch import flat_punch

_DECADES, _POINTS = 6, 181
"""Depths of the curve of one asperity, downwards from the largest, and their number: cubics between them are exact to 1e-7."""

_RADII = 24
"""Radii at which flat punches are solved for their moments, which vary slowly."""


@dataclass(frozen=True, slots=True)
class Law:
    """One asperity alone: logarithms of force and radius over that of depth, and shape factors.

    These are mean r^2 and r^4 of punch and contact over a^2 and a^4, and the radius of curvature over a^2.

    Below the smallest depth they are powers; above the largest nothing is known.
    """

    force: CubicSpline
    radius: CubicSpline
    moments: PchipInterpolator
    first: float
    last: float

    @classmethod
    def of(cls, medium: Body, tip: Indenter, name: str, largest: float, beyond: float) -> Law:
        """The law of a tip up to `beyond` times a depth [m] or that of a force [N]."""
        if largest == 0:
            name, largest = "depth", 1e-9
        deepest = largest if name == "depth" else float(indent(medium, tip, force=largest)["depth"][0])
        depth = beyond * deepest * np.geomspace(10.0**-_DECADES, 1.0, _POINTS)
        curve = indent(medium, tip, depth=depth)
        x, a, force = np.log(depth), curve["radius"].values, curve["force"].values
        phi = 2 * np.pi * np.arange(36) / 36
        slope = np.mean(np.broadcast_to(tip.slope(a[:, None], phi), (a.size, phi.size)), axis=1)
        if not ((slope > 0).all() and (np.diff(a) > 0).all()):
            raise ValueError(
                f"tips contains {type(tip).__name__}, which has a flat end: asperities take tips that are curved or pointed at "
                "their apex. rough_contact takes flat tops."
            )
        radii = np.geomspace(a[0], a[-1], _RADII)
        punches = [flat_punch(medium, float(radius)) for radius in radii]
        own = [[punch.moment(k) / ((k + 1) * punch.normalized_stiffness) for punch in punches] for k in (2, 4)]
        punch = PchipInterpolator(np.log(radii), np.transpose(own))(np.log(a))
        # F m = int K s dd, K dd = dF; powers below the first depth
        powers = np.gradient(np.log(force), x)[0] / np.gradient(np.log(a), x)[0]
        contact = []
        for k, shape in zip((2, 4), punch.T, strict=True):
            grown = shape * a**k
            steps = (grown[1:] + grown[:-1]) / 2 * np.diff(force)
            total = np.cumsum(np.append(grown[0] * force[0] * powers / (powers + k), steps))
            contact.append(total / (force * a**k))
        moments = PchipInterpolator(x, np.column_stack([punch, *contact, 1 / (slope * a)]))
        return cls(CubicSpline(x, np.log(force)), CubicSpline(x, np.log(a)), moments, float(x[0]), float(x[-1]))

    def __call__(self, depth: Array) -> tuple[Array, ...]:
        """Force [N], stiffness [N/m], radius [m], d ln a/dd [1/m] and moments, shape (n, 5), at depths > 0 [m]."""
        x = np.log(depth)
        inside = np.clip(x, self.first, self.last)
        slope, growth = self.force(inside, 1), self.radius(inside, 1)
        force = np.exp(self.force(inside) + slope * (x - inside))
        radius = np.exp(self.radius(inside) + growth * (x - inside))
        return force, force * slope / depth, radius, growth / depth, np.asarray(self.moments(inside))
