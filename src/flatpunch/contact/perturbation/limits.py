"""Reasons for which a perturbation result is uncertain, as sentences: asymmetry, edges, stiff films, steep faces."""

from __future__ import annotations

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import first_failure
from flatpunch.contact.perturbation.perturbed_contact import PerturbedContact
from flatpunch.contact.perturbation.power_law_series import power_expansion
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace

LARGEST_SWING = 1.2
"""|ln a(phi)/abar| above which outlines are off by tens of per cent."""


def outline_causes(kernel: Kernel, indenter: Indenter, contact: PerturbedContact) -> tuple[str, ...]:
    """What makes the outline uncertain, with the depths beyond which it does."""
    wide = contact.swing > LARGEST_SWING
    if not wide.any():
        return ()
    # swing over that on a half-space above which the medium is the cause, not the tip
    amplified = wide & (contact.swing > 1.5 * _half_space_swing(kernel, indenter))
    remedy = (
        "(|ln a/abar| above 1.2), so outline and area are uncertain by ten per cent and more; the force is less affected. "
        "Refine outline and area with method='refined' or 'bem'."
    )
    edges = "its sharp edges draw" if indenter.corners else "it draws"
    return first_failure(
        amplified,
        contact.depth,
        f"the medium (a stiff film) amplifies the asymmetry of the tip in the outline {remedy}",
    ) + first_failure(
        wide & ~amplified,
        contact.depth,
        f"the tip is strongly asymmetric: {edges} the outline far from a circle {remedy}",
    )


def _half_space_swing(kernel: Kernel, indenter: Indenter) -> float:
    """Swing of a power-law tip on a half-space; infinite where that is the medium, or the tip is none."""
    if kernel.homogeneous or indenter.exponent is None:
        return float("inf") if kernel.homogeneous else 1.0
    return _power_swing(indenter)


@byte_cached
def _power_swing(indenter: Indenter) -> float:
    series = power_expansion(compliance(HalfSpace(1.0, 0.0)), indenter, "second")
    return float(series.evaluate(np.ones(1)).swing[0])
