"""What several indenters share: the exponent of a power law, values spread over angles."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, BadValue, numbers, shown
from flatpunch._support.declared import a_ratio, an_angle

FULL_TURN = 2 * math.pi

RAYS = 720
"""Polar angles at which shapes are searched for extremes and faults; half as many miss those one degree apart."""

SCATTERED = FULL_TURN * (np.arange(RAYS) + 0.382) / RAYS
"""Polar angles twice a degree, off the multiples of common corners."""

SAME = ROUNDING
"""Relative difference below which heights and angles are the same; below rounding no tip would be round or symmetric."""

SLENDER = 1e6
"""Largest ratio of the half-axes of a tip."""


# powers of the radius outside this range are a step or a spike in floating point
Exponent = Annotated[
    float,
    a_ratio(
        "exponent",
        least=0.01,
        most=100.0,
        example="2",
        outside="must lie between 0.01 and 100; a flat end is Cylinder(radius).",
    ),
]


Inclination = Annotated[
    float,
    an_angle(
        "inclination",
        about="between the surface and a face",
        example="35 deg",
        outside="must lie in 0 < inclination < pi/2: the angle between surface and face in radians. Degrees go through "
        "math.radians; a half-opening angle t measured from the axis is pi/2 - t.",
    ),
]
HalfOpeningAngle = Annotated[
    float,
    an_angle(
        "half opening angle",
        about="between the axis and a face",
        outside="must lie between 0 and 90 degrees.",
        example="35 deg",
    ),
]


def check_slender(name: str, *lengths: float) -> None:
    """Refuse tips that are far longer than wide: their contacts are lines, and nothing resolves both."""
    if max(lengths) > SLENDER * min(lengths):
        raise BadValue(
            name,
            "",
            f"has half-axes or curvatures from {min(lengths):.3g} to {max(lengths):.3g}; they may differ by a "
            f"factor of {SLENDER:.0e}. Check the units.",
        )


def spread(radial: Array, phi: Array) -> Array:
    """Values over one coordinate, mostly the radius, broadcast against the other into an array of their own."""
    result = np.empty(np.broadcast_shapes(np.shape(radial), np.shape(phi)))
    result[...] = radial
    return result


def power(r: Array, exponent: float) -> Array:
    """r^exponent for r >= 0; infinite at r = 0 when the exponent is negative."""
    if exponent in (0, 1, 2):  # without logarithms
        return np.square(r) if exponent == 2 else np.asarray(r, dtype=float) if exponent else np.ones(np.shape(r))
    with np.errstate(divide="ignore"):
        return np.asarray(np.power(r, exponent))


def corner_angles(name: str, angles: object) -> tuple[float, ...]:
    """Return polar angles brought to [0, 2 pi), ascending, each once."""
    listed = numbers(name, angles, "rad")
    if listed.ndim == 0:
        raise TypeError(f"{name} = {shown(angles)} must be a sequence of polar angles [rad], also of one.")
    if listed.ndim > 1 or not np.isfinite(listed).all():
        raise BadValue(name, shown(angles), "must be a sequence of finite polar angles [rad].")
    return tuple(sorted({angle % FULL_TURN for angle in listed.tolist()}))
