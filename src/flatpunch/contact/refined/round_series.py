"""The round contact of the mean profile with the interface of a series, its asymmetry left to who corrects it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.perturbation.asymmetry import expand
from flatpunch.contact.perturbation.perturbed_contact import PathPoint, PerturbedContact
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.profile import PowerProfile, RoundProfile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.log_table import LogTable


class RoundSeries:
    """Contacts of the angular mean of an indenter on one medium over their radius.

    Parameters
    ----------
    kernel, indenter
        Medium and indenter, of any shape f(r, phi).
    """

    def __init__(self, kernel: Kernel, indenter: Indenter) -> None:
        self.kernel, self.base = kernel, _round_base(indenter)
        self._table = LogTable(self._columns, indenter.reach, kinks=indenter.rings)

    def descent(self, radius: Array) -> PathPoint:
        """Depth and its derivative at radii of shape (n,), >= 0 [m]; here no cheaper than `loading`."""
        return self.loading(radius)

    def loading(self, radius: Array) -> PathPoint:
        """Depth, force and their derivatives at radii of shape (n,), >= 0 [m]."""
        live = radius > 0
        values = np.zeros((radius.size, 4))
        if live.any():
            values[live] = self._table.at(radius[live])[0]
        depth, force, stiffness, slope = values.T * radius
        modulus = self.kernel.modulus
        return PathPoint(radius, depth, modulus * radius * force, modulus * stiffness, slope)

    def _columns(self, radius: Array) -> Array:
        """d/a, F/(E* a^2), K/(E* a) and d'(a), shape (n, 4)."""
        contact = round_contact(self.kernel, self.base, radius)
        modulus = self.kernel.modulus
        measures = (contact.depth, contact.force / (modulus * radius), contact.stiffness / modulus, contact.depth_slope)
        return np.column_stack(measures) / radius[:, None]

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at radii, shape (n,), >= 0 [m]; their outlines are circles."""
        path, zero = self.loading(radius), np.zeros_like(radius)
        return PerturbedContact(
            radius=radius,
            depth=path.depth,
            force=path.force,
            stiffness=path.stiffness,
            depth_slope=path.depth_slope,
            shape_radius=radius,
            size=radius,
            mean_radius=radius,
            area=np.pi * radius**2,
            swing=zero,
            terms=np.zeros((radius.size, 3)),
            sound=np.ones(radius.size, dtype=bool),
        )

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Circles, shape (n, p) [m]."""
        return np.repeat(contact.size[:, None], phi.size, axis=1)


def _round_base(indenter: Indenter) -> RoundProfile:
    """Angular mean of an indenter, of power-law shapes that of second order, which a contact is closer to (lam = 0)."""
    if indenter.exponent is None:
        return mean_profile(indenter)
    return PowerProfile(indenter.exponent, expand(indenter, 0.0).mean)


@lru_cache(maxsize=64)
def round_series(kernel: Kernel, indenter: Indenter) -> RoundSeries:
    """The round contacts of a medium and an indenter; what is already computed is shared."""
    return RoundSeries(kernel, indenter)
