"""Contacts of power-law indenters from the perturbation series, as functions of the base radius.

The base radius a is that of the round contact of C r^n at the same depth. The force is F_base exp(X); its exact derivative
by the depth is the stiffness, and the radius abar of the cylindrical punch that is as stiff, the outline's harmonics taken
into account, sets the size of the outline abar exp(w).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.contact.perturbation.perturbed_contact import PathPoint, PerturbedContact, sized
from flatpunch.contact.perturbation.power_law_terms import PowerPerturbation, Terms, limited_exponential
from flatpunch.contact.round.mean_profile import resolved_radius
from flatpunch.contact.round.profile import TINY, PowerProfile
from flatpunch.contact.round.radius_search import Loading
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.punch.family import punch_family

Order = Literal["second", "fourth"]

LARGEST_TERM = 2.0
"""|ln(F/F_base)| at which a series is cut; tips of three sides reach 0.2."""


class PowerExpansion:
    """Perturbation series of one power-law indenter on one medium.

    Parameters
    ----------
    kernel, indenter
        Medium and power-law indenter.
    order : "second" or "fourth"
        Second order expands in ln psi; fourth order in sqrt(psi), summed in its Pade form. Outlines come from sqrt(psi)
        for tips with edges under fourth order and from ln psi for all others, which measured best (validation page).
    terms : bool
        Whether second order computes the third and fourth terms too, for its error estimate; else they are zero.
    """

    def __init__(self, kernel: Kernel, indenter: Indenter, order: Order, *, terms: bool = True) -> None:
        assert indenter.exponent is not None
        self.kernel, self.order = kernel, order
        lam, fourth = (0.0, terms) if order == "second" else (0.5, True)
        self.series = PowerPerturbation(kernel, indenter, lam, fourth=fourth)
        self.base = PowerProfile(indenter.exponent, self.series.angles.mean)
        self._shape, self._shape_base = self.series, self.base
        if order == "fourth" and not indenter.corners:
            self._shape = PowerPerturbation(kernel, indenter, 0.0, fourth=False)
            self._shape_base = PowerProfile(indenter.exponent, self._shape.angles.mean)

    def descent(self, radius: Array) -> Loading:
        """Depth and its derivative at base radii of shape (n,), >= 0 [m], with the force of the base."""
        return round_contact(self.kernel, self.base, radius)

    def loading(self, radius: Array) -> PathPoint:
        """Depth, force and their derivatives alone, at base radii of shape (n,), >= 0 [m]."""
        return self._loading(radius, *self.series.at(radius))

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at base radii, shape (n,), >= 0 [m]."""
        values, slopes = self.series.at(radius)
        path = self._loading(radius, values, slopes)
        shape_radius, shape = self._shape_at(radius, path.depth, values)
        size = radius_of_stiffness(self.kernel, path.stiffness, shape.stiffening, radius)
        measures = shape.log_mean, shape.log_square, shape.swing
        return sized(path, shape_radius, size, measures, (values.x2, values.x3, values.x4))

    def _shape_at(self, radius: Array, depth: Array, values: Terms) -> tuple[Array, Terms]:
        """Base radii and terms of the series that gives the outline, at the same depths."""
        if self._shape is self.series:
            return radius, values
        other = same_depth(self.kernel, self.base, self._shape_base, radius, depth)
        return other, self._shape.at(other)[0]

    def _loading(self, radius: Array, values: Terms, slopes: Terms) -> PathPoint:
        base = round_contact(self.kernel, self.base, radius)
        logarithm, growth = self._force(values, slopes)
        # dF/dd = exp(X) (K + F_base (dX/dln a)/(a d'))
        slope = np.where(radius > 0, base.depth_slope, 1.0)
        slope = np.where(np.abs(slope) > TINY, slope, TINY)
        stiffness = np.exp(logarithm) * (base.stiffness + base.force * growth / slope)
        return PathPoint(radius, base.depth, base.force * np.exp(logarithm), stiffness, base.depth_slope)

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Contact outline a(phi), shape (n, p) [m]."""
        outline = limited_exponential(self._shape.outline(contact.shape_radius, phi))
        outline *= contact.size[:, None]
        return outline

    def doubt(self, radius: Array) -> Array:
        """Doubt about the fourth order, 1 where it ceases to hold; shape (n,)."""
        values, slopes = self.series.at(radius)
        x2, x4, growth = values.x2, values.x4, slopes.x4
        safe = np.where(x2 == 0, 1.0, x2)
        # largest |x4|/|x2|, |x4| and |dx4/dln a|/|x2| for which the fourth-order series was within 0.2 % of boundary elements
        # (validation page); near the poles under stiff films x4 passes through zero, but steeply
        shares = np.abs([x4 / (0.1 * safe), x4 / 0.02, growth / (0.1 * safe)])
        return np.where(x2 == 0, 0.0, shares.max(axis=0))

    def _force(self, values: Terms, slopes: Terms) -> tuple[Array, Array]:
        x2, x3, x4 = values.x2, values.x3, values.x4
        if self.order == "second":
            return np.clip(x2, -LARGEST_TERM, LARGEST_TERM), _where_kept(x2, slopes.x2)
        flat = x2 == 0
        safe = np.where(flat, 1.0, x2)
        # Padé form x2^2/(x2 - x3 + x3^2/x2 - x4) and its derivative
        denominator = safe - x3 + x3**2 / safe - x4
        # Padé denominator over x2 below which its pole is avoided; the sound range stays above 0.5
        denominator = np.where(np.abs(denominator) > 1e-3 * np.abs(safe), denominator, safe)
        bottom = slopes.x2 - slopes.x3 - slopes.x4
        bottom += 2 * x3 * slopes.x3 / safe - x3**2 * slopes.x2 / safe**2
        pade = x2**2 / denominator
        growth = 2 * x2 * slopes.x2 / denominator - pade * bottom / denominator
        kept = np.where(flat, 0.0, _where_kept(pade, growth))
        return np.where(flat, 0.0, np.clip(pade, -LARGEST_TERM, LARGEST_TERM)), kept


def same_depth(kernel: Kernel, base: PowerProfile, other_base: PowerProfile, radius: Array, depth: Array) -> Array:
    """Radii of round contacts of another profile with the depths that those of `base` have at `radius`, shape (n,)."""
    other, live = radius * (base.factor / other_base.factor) ** (1 / base.exponent), radius > 0
    # Newton steps in ln a between two bases of equal depth, per cent apart: each doubles the digits, and half leave 1e-8
    for _ in range(4):
        contact = round_contact(kernel, other_base, other[live])
        slope = np.where(np.abs(contact.depth_slope) > TINY, contact.depth_slope, TINY)
        # where the depth turns back only one of the series counts; longer steps may leave its branch
        other[live] *= np.exp(np.clip((depth[live] - contact.depth) / slope, -0.1, 0.1))
    return np.asarray(other)


def _where_kept(logarithm: Array, growth: Array) -> Array:
    return np.where(np.abs(logarithm) < LARGEST_TERM, growth, 0.0)


@byte_cached
def power_expansion(kernel: Kernel, indenter: Indenter, order: Order, *, terms: bool = True) -> PowerExpansion:
    """The series of a medium and an indenter; what is already computed is shared."""
    return PowerExpansion(kernel, indenter, order, terms=terms)


def radius_of_stiffness(kernel: Kernel, stiffness: Array, gain: Array, guess: Array) -> Array:
    """Radius abar with K(abar) exp(gain) = stiffness, by Newton in ln a; shape (n,).

    Where there is none (stiffness not positive, beyond a turning point) it is the guess. Beside the poles of a series, where it
    is arbitrary, it ends at a factor of exp(2) from the guess.
    """
    live = (stiffness > 0) & (guess > 0)
    radius = guess.copy()
    low = np.log(guess[live]) - 2.0
    high = np.minimum(low + 4.0, np.log(resolved_radius(kernel)))
    x, wanted = np.log(guess[live]), np.log(stiffness[live]) - np.clip(gain[live], -LARGEST_TERM, LARGEST_TERM)
    for _ in range(20):
        responses = punch_family(kernel).at(np.exp(x) / kernel.length)
        flat, edge = responses.flat[:, 0], 1 / np.pi + responses.edge[:, 0]
        # dln K/dln a = pi e^2/c_0, positive for every medium (Krein)
        step = (wanted - x - np.log(2 * np.pi * kernel.modulus * flat)) * flat / (np.pi * edge**2)
        x = np.clip(x + np.clip(step, -1, 1), low, high)
        if not step.size or np.abs(step).max() < 1e-9:
            break
    radius[live] = np.exp(x)
    return radius
