"""Why a perturbation result is uncertain, in sentences: asymmetry, edges, stiff films, steep faces."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from flatpunch._validation import Array
from flatpunch.compliance import Kernel, compliance
from flatpunch.contact.curve import first_failure
from flatpunch.contact.expansion import PerturbedContact, power_expansion
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter, reach_along
from flatpunch.media import HalfSpace

LARGEST_SWING = 1.2
"""|ln a(phi)/abar| above which outlines were off by tens of per cent."""
_AMPLIFIED = 1.5
"""Swing over that on a half-space from which on the medium is the cause, not the tip."""
_STEEP = 35.0
"""Mean inclination at the rim from which on shapes no longer enter by their heights alone [degrees]."""
_AT_END = 0.98
"""Share of the reach from which on a contact counts as ending there: outlines are off by a hundredth."""
_DIRECTIONS = 2 * np.pi * (np.arange(36) + 0.382) / 36


def outline_causes(kernel: Kernel, indenter: Indenter, contact: PerturbedContact) -> tuple[str, ...]:
    """What makes the outline uncertain, with the depths from which on it does."""
    wide = contact.swing > LARGEST_SWING
    if not wide.any():
        return ()
    amplified = wide & (contact.swing > _AMPLIFIED * _half_space_swing(kernel, indenter))
    remedy = (
        "(|ln a/abar| above 1.2), so outline and area are uncertain by ten per cent and more; the force is less affected. "
        "Refine outline and area with method='refined' or 'bem'."
    )
    edges = "its sharp edges draw" if indenter.corners else "it draws"
    return first_failure(
        amplified,
        contact.depth,
        f"the medium (a stiff film) answers the tip's asymmetry with a strong outline {remedy}",
    ) + first_failure(
        wide & ~amplified,
        contact.depth,
        f"the tip is strongly asymmetric: {edges} the outline far from a circle {remedy}",
    )


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


def _half_space_swing(kernel: Kernel, indenter: Indenter) -> float:
    """Swing of a power-law tip on a half-space; infinite where that is the medium, or the tip is none."""
    if kernel.homogeneous or indenter.exponent is None:
        return float("inf") if kernel.homogeneous else 1.0
    return _power_swing(indenter)


@lru_cache(maxsize=64)
def _power_swing(indenter: Indenter) -> float:
    series = power_expansion(compliance(HalfSpace(1.0, 0.0)), indenter, "second")
    return float(series.evaluate(np.ones(1)).swing[0])
