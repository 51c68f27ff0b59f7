"""Limits of small-slope contact theory, as notes of a result."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.contact.curve import first_failure
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter, reach_along

_STEEP = 35.0
"""Mean inclination at the rim above which shapes do not enter by their heights alone any more [degrees]."""


_AT_END = 0.98
"""Share of the reach above which a contact counts as ending there: outlines are off by a hundredth."""


_DIRECTIONS = 2 * np.pi * (np.arange(36) + 0.382) / 36


def steepness(indenter: Indenter, radius: Array, depth: Array) -> tuple[str, ...]:
    """Whether faces are too steep for a theory of small slopes, at contact radii of shape (n,)."""
    r = np.minimum(np.where(np.isfinite(radius), radius, 0.0), indenter.reach)
    live = r > 0
    # slopes of power laws grow with the radius
    if indenter.exponent is not None and np.mean(indenter.slope(r.max(), _DIRECTIONS)) <= np.tan(np.radians(_STEEP)):
        return ()
    slope = np.zeros_like(r)
    if live.any():
        slope[live] = np.mean(indenter.slope(r[live][:, None], _DIRECTIONS), axis=1)
    steep = slope > np.tan(np.radians(_STEEP))
    if not steep.any():
        return ()
    angle = np.degrees(np.arctan(slope[steep].max()))
    return first_failure(
        steep,
        depth,
        f"faces at the rim are inclined by up to {angle:.0f} degrees on average. The theory takes slopes as small (surface and "
        "pressure move along z); from about 35 degrees on that costs some per cent, at 60 ten and more.",
    )


def cut_off(indenter: Indenter, contour: Array, phi: Array, depth: Array) -> tuple[str, ...]:
    """Whether outlines a(phi), shape (n, p), end where the shape of the indenter does, and not by themselves."""
    if indenter.reach == np.inf or isinstance(indenter, Cylinder):
        return ()
    with np.errstate(invalid="ignore"):
        at_end = np.any(contour > _AT_END * reach_along(indenter, phi), axis=1)
    return first_failure(
        np.asarray(at_end),
        depth,
        f"the contact reaches the end of the indenter's shape ({indenter.reach:.4g} m from the first touch) and is cut off "
        "there as by the edge of a punch. Ask for less depth, or describe the tip farther out.",
    )
