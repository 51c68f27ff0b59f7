"""Coefficients of plane strain of transversely isotropic material, their derivatives, and rates at which waves decay in it."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from flatpunch._support.checks import ROUNDING, Array

N = TypeVar("N", float, Array)
"""One material, or one at each of many depths."""


class Plane(NamedTuple, Generic[N]):
    """Coefficients of plane strain along a wave in a transversely isotropic body, and the shear stiffness across it.

    s_ll = stiffness e_ll + coupling s_zz,  e_zz = oedometric s_zz - coupling e_ll,  2 e_lz = shear s_lz,  s_ln = 2 across e_ln.
    """

    coupling: N
    shear: N
    oedometric: N
    stiffness: N
    across: N


def plane_of_arrays(constants: Sequence[Array]) -> Plane[Array]:
    """Plane-strain coefficients of the five constants at many depths [Pa]; NaN where the body would not be stable."""
    young, axial, nu, nu_axial, shear = constants
    slack = 1 - nu - 2 * nu_axial * nu_axial * young / axial
    # zero where the body is incompressible along z, up to the rounding of the laws
    slack = np.where(np.abs(slack) <= ROUNDING * (1 - nu), 0.0, np.where(slack > 0, slack, nan))
    stable = (np.minimum(np.minimum(young, axial), shear) > 0) & (np.abs(nu) < 1)
    return plane_of(young, axial, nu, nu_axial, shear, np.where(stable, slack, nan))


def plane_of(young: N, axial: N, nu: N, nu_axial: N, shear: N, slack: N) -> Plane[N]:
    """Coefficients of the five constants [Pa] and of `slack_of` them."""
    return Plane(
        coupling=young / axial * nu_axial / (1 - nu),
        shear=1 / shear,
        oedometric=slack / ((1 - nu) * axial),
        stiffness=young / (1 - nu * nu),
        across=young / (2 * (1 + nu)),
    )


def over(scale: float, plane: Plane[N]) -> Plane[N]:
    """Coefficients with stresses in units of a scale."""
    q, shear, soft, stiff, across = plane
    return Plane(q, shear * scale, soft * scale, stiff / scale, across / scale)


def isotropic_plane(young: N, nu: N) -> Plane[N]:
    """Plane-strain coefficients of isotropic material [Pa]."""
    mu = young / (2 * (1 + nu))
    return Plane(nu / (1 - nu), 1 / mu, (1 - 2 * nu) / (2 * mu * (1 - nu)), 2 * mu / (1 - nu), mu)


def in_plane(plane: Plane[N]) -> tuple[N, N]:
    """Young's modulus [Pa] and Poisson ratio in the plane of a body with given coefficients."""
    nu = 1 - 2 * plane.across / plane.stiffness
    return 2 * plane.across * (1 + nu), nu


def from_plane(plane: Plane[N]) -> tuple[N, N, N, N, N]:
    """The five constants of a body with given coefficients."""
    young, nu = in_plane(plane)
    axial = 1 / (plane.oedometric + 2 * plane.coupling**2 * (1 - nu) / young)
    return young, axial, nu, plane.coupling * (1 - nu) * axial / young, 1 / plane.shear


def plane_slopes(constants: Sequence[N]) -> dict[str, Plane[N]]:
    """Derivatives of the coefficients by each of the five constants, all others fixed."""
    e, z, nu, nu_z, g = constants
    q, slack = e / z * nu_z / (1 - nu), 1 - nu - 2 * nu_z**2 * e / z
    soft = -2 * nu_z**2 / (z * z * (1 - nu))
    zero = 0 * e
    return {
        "young_in_plane": Plane(q / e, zero, soft, 1 / (1 - nu * nu), 1 / (2 * (1 + nu))),
        "young_axial": Plane(-q / z, zero, -slack / ((1 - nu) * z * z) - soft * e / z, zero, zero),
        "poisson_in_plane": Plane(
            q / (1 - nu),
            zero,
            soft * e / (1 - nu),
            2 * nu * e / (1 - nu * nu) ** 2,
            -e / (2 * (1 + nu) ** 2),
        ),
        "poisson_axial": Plane(e / (z * (1 - nu)), zero, -4 * nu_z * e / (z * z * (1 - nu)), zero, zero),
        "shear": Plane(zero, -1 / g**2, zero, zero, zero),
    }


def isotropic_slopes(young: N, poisson: N) -> dict[str, Plane[N]]:
    """Derivatives of the coefficients of isotropic material by Young's modulus and the Poisson ratio."""
    shear = young / (2 * (1 + poisson))
    in_plane, axial, nu, nu_axial, by_shear = plane_slopes((young, young, poisson, poisson, shear)).values()
    along = shear / young, -shear / (1 + poisson)
    return {
        "young": Plane(*(a + b + along[0] * c for a, b, c in zip(in_plane, axial, by_shear, strict=True))),
        "poisson": Plane(*(a + b + along[1] * c for a, b, c in zip(nu, nu_axial, by_shear, strict=True))),
    }


def slack_of(young: float, axial: float, nu: float, nu_axial: float) -> float:
    """1 - nu - 2 nu_z^2 E/E_z: zero where the body is incompressible along z, up to rounding."""
    slack = 1 - nu - 2 * nu_axial * nu_axial * young / axial
    return 0.0 if abs(slack) <= 4 * np.finfo(float).eps * (1 - nu) else slack


def exponents(plane: Plane[N]) -> tuple[N, N, N, N]:
    """Sum s and product d of the two rates at which fields decay with depth, per wavenumber, d - q, and e^2 = s^2/4 - d.

    The rates are the roots of p^2 - s p + d: real, equal or a complex pair; s and d are positive.
    """
    q, shear, soft, stiff, _ = plane
    d = (q * q + stiff * soft) ** 0.5
    # notation: d - q and d + q, of which one cancels, from the other
    large, upper = d + abs(q), 1.0 * (q > 0)
    small = stiff * soft / large
    less, more = small * upper + large * (1 - upper), large * upper + small * (1 - upper)
    return (stiff * shear + 2 * less) ** 0.5, d, less, (stiff * shear - 2 * more) / 4


def rates_of(plane: Plane[Array]) -> tuple[Array, Array]:
    """Rate at which waves decay with k z at least, along the wave and across it, and the magnitude of the largest rate."""
    s, d, _, square = exponents(plane)
    # of a complex pair the real part, and the magnitude
    fast = np.where(square > 0, s / 2 + np.sqrt(np.maximum(square, 0.0)), np.sqrt(d))
    across = np.sqrt(plane.across * plane.shear)
    return np.minimum(np.where(square > 0, d / fast, s / 2), across), np.maximum(fast, across)


def contact_modulus(plane: Plane[N]) -> N:
    """Contact modulus E* of a half-space [Pa]."""
    s, d, _, _ = exponents(plane)
    return 2 * plane.stiffness / (s * d)


def exponent_slopes(plane: Plane[N], change: Plane[N]) -> tuple[N, N]:
    """Changes of the sum s and the product d of both rates, d^2 = q^2 + M/C33 and s^2 = M/C44 + 2 (d - q)."""
    s, d, _, _ = exponents(plane)
    soft = change.stiffness * plane.oedometric + plane.stiffness * change.oedometric
    shear = change.stiffness * plane.shear + plane.stiffness * change.shear
    of_d = (2 * plane.coupling * change.coupling + soft) / (2 * d)
    return (shear + 2 * (of_d - change.coupling)) / (2 * s), of_d
