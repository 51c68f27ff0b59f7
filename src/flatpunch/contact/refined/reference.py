"""What boundary elements are compared with over a loading path: the round contact of the mean profile, or nothing.

Ratios to the round contact hardly move on soft layers and where contacts are small or wide. Under stiff films its depth may turn
back, so that one depth has several, while force and outline themselves remain smooth in the depth: there the logarithms of the
solutions are interpolated as they are. Second order in its place would save one solution in twenty and costs more than that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.curve import Control
from flatpunch.contact.perturbation.perturbed_contact import PathPoint, PerturbedContact
from flatpunch.contact.perturbation.series_method import controlled
from flatpunch.contact.refined.round_series import RoundSeries
from flatpunch.indenters.profile import Indenter

BASE, NOTHING = 0, 1
"""Columns of `Theory.force`."""

_SAMPLES = 200


@dataclass(frozen=True, slots=True)
class Theory:
    """References at n depths.

    Attributes
    ----------
    force, growth : ndarray, shape (n, 2)
        ln F [N] and dln F/dln d of the round contact and of nothing.
    radius : ndarray, shape (n,)
        Radius of the round contact [m].
    """

    force: Array
    growth: Array
    radius: Array


class TheoryAt:
    """References at depths, kept.

    Parameters
    ----------
    kernel, indenter, series
        Medium, indenter, and its round contacts.
    """

    def __init__(self, kernel: Kernel, indenter: Indenter, series: RoundSeries) -> None:
        self.kernel, self.indenter, self.series = kernel, indenter, series
        self._kept: dict[float, tuple[Array, Array, float]] = {}

    def at(self, x: Array) -> Theory:
        """References at x = ln d, shape (n,)."""
        new = np.array([at for at in x if at not in self._kept])
        if new.size:
            contact = controlled(self.kernel, self.indenter, self.series, Control("depth", np.exp(new)))
            rows = (*forces(contact), contact.radius)
            self._kept.update(zip(new.tolist(), zip(*rows, strict=True), strict=True))
        kept = [self._kept[at] for at in x]
        return Theory(*(np.array(part) for part in zip(*kept, strict=True)))

    def turning(self, radius: Array) -> float:
        """Least radius [m], up to the largest given, at which the depth of the round contact turns back; else infinity."""
        path = np.geomspace(radius.min(), radius.max(), _SAMPLES)
        return float(path[self.series.descent(path).depth_slope <= 0].min(initial=np.inf))


def forces(contact: PathPoint | PerturbedContact) -> tuple[Array, Array]:
    """`Theory.force` and `Theory.growth` of round contacts, not finite where there is no such force."""
    force = np.column_stack([contact.force, np.ones_like(contact.force)])
    stiffness = np.column_stack([contact.stiffness, np.zeros_like(contact.force)])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log(force), stiffness * contact.depth[:, None] / force
