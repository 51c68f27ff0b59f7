"""The equilibrium branch of a round adhesive contact (JKR), exact for every medium (T11.1), (T11.2).

A contact of radius a that is pulled back by D from the contact without adhesion (d_n, F_n) releases the energy
(1/2) D^2 K'(a)/(2 pi a) per area. It is in equilibrium where this equals the work of adhesion w:

    D = sqrt(4 pi a w/K'),      d = d_n - D,      F = F_n - K D

With s = dln K'/dln a the derivatives along the branch are

    dd/dln a = a d_n' - D (1 - s)/2,      dF/dln a = K dd/dln a - a K' D.

The contact is stable under a prescribed depth where the first is positive, under a prescribed force where the second is. K'
is Krein's identity, 2 pi^2 E* e^2 with e the edge strength of the flat punch; where the modulus varies at the surface itself
e converges slowly and K' is taken from K instead.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.contact.round.mean_profile import Evaluate
from flatpunch.contact.round.round_contact import RoundContact
from flatpunch.punch.family import punch_family
from flatpunch.punch.matrix import edge_strength

STEP = 0.03
"""Step in ln a of the ten-point central differences: their error, about 11! step^10/2772, is then 1e-11 of functions that vary
over one unit of ln a; the noise of the punch family, 1e-12, is raised to 1e-10."""

AROUND = np.array(range(-5, 6))
"""Steps at which functions are sampled for their derivatives."""


@dataclass(frozen=True, slots=True)
class AdhesiveContact:
    """Adhesive contacts in equilibrium, arrays of shape (n,).

    Attributes
    ----------
    radius, depth, force : ndarray
        a [m], d [m], F [N].
    retraction : ndarray
        D [m], by which the punch of radius a is pulled back from the contact without adhesion.
    depth_slope, force_slope : ndarray
        dd/dln a [m] and dF/dln a [N].
    plain : RoundContact
        The contact without adhesion of the same radius.
    """

    radius: Array
    depth: Array
    force: Array
    retraction: Array
    depth_slope: Array
    force_slope: Array
    plain: RoundContact

    @property
    def stiffness(self) -> Array:
        """dF/dd along the branch [N/m]; negative between the two instabilities, infinite at that of the depth."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.force_slope / self.depth_slope)


class Equilibria(Protocol):
    """All equilibria of one medium, one indenter and one work of adhesion, over a radius: of contact, or of adhesive stress."""

    @property
    def kernel(self) -> Kernel:
        """Compliance of the medium."""

    @property
    def work(self) -> float:
        """Work of adhesion [J/m^2]."""

    @property
    def range_of_action(self) -> float:
        """Gap across which adhesion acts [m]; zero in JKR theory."""

    @property
    def kinks(self) -> tuple[float, ...]:
        """Radii [m] beyond which the branch is a series in the root of the distance; none in JKR theory."""

    def evaluate(self, radius: Array) -> RoundContact:
        """Contact without adhesion, shape (n,)."""

    def at(self, radius: Array) -> AdhesiveContact:
        """Equilibria at radii > 0, shape (n,)."""

    def size(self, radius: Array) -> tuple[Array, Array]:
        """Mean radius a0 of the outline and contact area at radii > 0, shape (n,) each."""

    def base_radius(self, mean_radius: Array) -> Array:
        """Radii at which `size` gives the mean radii a0, shape (n,)."""

    def error(self, radius: Array) -> Array:
        """Estimated error of the force [N], shape (n,)."""


@dataclass(frozen=True)
class Branch:
    """All equilibria of one medium, one round profile and one work of adhesion [J/m^2].

    `pressed` maps radii, shape (n,), to contacts without adhesion.
    """

    kernel: Kernel
    pressed: Evaluate
    work: float
    range_of_action: ClassVar[float] = 0.0
    kinks: ClassVar[tuple[float, ...]] = ()

    def evaluate(self, radius: Array) -> RoundContact:
        """Contacts without adhesion."""
        return self.pressed(radius)

    def at(self, radius: Array) -> AdhesiveContact:
        """Equilibria at radii a > 0, shape (n,)."""
        plain = self.pressed(radius)
        growth, s = stiffness_growth(self.kernel, plain)
        # notation: growth = a K', s = dln K'/dln a
        back = radius * np.sqrt(4 * np.pi * self.work / growth)
        depth_slope = plain.depth_slope - back * (1 - s) / 2
        return AdhesiveContact(
            radius=radius,
            depth=plain.depth - back,
            force=plain.force - plain.stiffness * back,
            retraction=back,
            depth_slope=depth_slope,
            force_slope=plain.stiffness * depth_slope - growth * back,
            plain=plain,
        )

    def size(self, radius: Array) -> tuple[Array, Array]:
        """Mean radius and area of discs."""
        return radius, np.pi * radius**2

    def base_radius(self, mean_radius: Array) -> Array:
        """The mean radii: discs have one radius."""
        return mean_radius

    def error(self, radius: Array) -> Array:
        """Nothing: round contacts are exact."""
        return np.zeros_like(radius)


def stiffness_growth(kernel: Kernel, contact: RoundContact) -> tuple[Array, Array]:
    """Growth of the punch stiffness with the radius: a K'(a) [N/m] and dln K'/dln a [-], shape (n,) each."""
    a, stiffness = contact.radius, contact.stiffness
    if kernel.homogeneous or kernel.exponent:
        # K ~ a^(1 + k) on a power-law half-space
        return (1 + kernel.exponent) * stiffness, np.full_like(a, kernel.exponent)
    family = punch_family(kernel)
    beta = a / kernel.length * np.exp(STEP * AROUND)[:, None]
    responses = family.at(beta.ravel())
    if kernel.tail == 0.0:
        strength = edge_strength(responses).reshape(beta.shape)
        first, _ = central_derivatives(np.log(np.abs(strength)))
        return 2 * np.pi**2 * kernel.modulus * a * strength[AROUND == 0][0] ** 2, 2 * first
    first, second = central_derivatives(np.log(responses.flat[:, 0].reshape(beta.shape)))
    power = 1 + first
    return stiffness * power, first + second / power


def central_derivatives(samples: Array) -> tuple[Array, Array]:
    """First and second derivative in ln a of samples at the steps `AROUND`, shape (11, n)."""
    j = AROUND[AROUND > 0].astype(float)
    lower, middle, upper = samples[AROUND < 0][::-1], samples[AROUND == 0][0], samples[AROUND > 0]
    # Lagrange's polynomials in j^2 at zero
    squares = j[:, None] ** 2 - j**2 + np.diag(j**2)
    weights = np.prod(np.where(np.eye(j.size, dtype=bool), 1.0, -(j**2) / squares), axis=1)
    first = weights / (2 * j) @ (upper - lower) / STEP
    second = weights / j**2 @ (upper + lower - 2 * middle) / STEP**2
    return np.asarray(first), np.asarray(second)
