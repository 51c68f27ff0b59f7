"""Adhesive contact of round indenters on homogeneous and power-law graded half-spaces.

`maugis_paraboloid` has an adhesive stress of finite range. The others are its limit of range zero (Johnson et al. 1971): a punch
of radius a is pulled back by D from the contact without adhesion until the energy release rate, (1/2) D^2 K'(a)/(2 pi a), equals
the work of adhesion w.

See Also
--------
flatpunch.pull_off : On layers, for any tip.

Examples
--------
>>> from flatpunch.reference.adhesion import jkr_pull_off
>>> print(f"{jkr_pull_off(curvature_radius=5e-6, work=1e-3) * 1e9:.2f} nN")  # 3/2 pi w R
23.56 nN
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flatpunch.reference.half_space import RoundContact, paraboloid
from flatpunch.reference.power_law import power_law

Array = NDArray[np.float64]


def jkr_paraboloid(radius: float | Array, curvature_radius: float, modulus: float, work: float) -> tuple[Array, Array]:
    """Depth [m] and force [N] at contact radius a.

    d = a^2/R - sqrt(2 pi a w/E*),      F = 4 E* a^3/(3 R) - sqrt(8 pi w E* a^3)

    Parameters
    ----------
    radius : float or array
        a [m].
    curvature_radius : float
        R [m].
    modulus : float
        E* [Pa].
    work : float
        Work of adhesion w [J/m^2].
    """
    a = np.asarray(radius, float)
    plain = paraboloid(a, curvature_radius, modulus)
    return (
        np.asarray(plain.depth - np.sqrt(2 * np.pi * a * work / modulus)),
        np.asarray(plain.force - np.sqrt(8 * np.pi * work * modulus * a**3)),
    )


def maugis_paraboloid(
    radius: float | Array, outer: float | Array, curvature_radius: float, modulus: float, stress: float
) -> tuple[Array, Array, Array]:
    """Depth [m], force [N] and gap at the end of the adhesive stress [m] of a paraboloid on a half-space (Maugis 1992).

    With m^2 = c^2 - a^2, of the contact without adhesion

        d = d_n - 2 s0 m/E*,      F = F_n - 2 s0 (c^2 arccos(a/c) + a m),
        gap = (a m + (c^2 - 2 a^2) arccos(a/c))/(pi R) + 4 s0 (m arccos(a/c) - c + a)/(pi E*).

    The work of adhesion is the gap times the stress, and the gap is the range of action.

    Parameters
    ----------
    radius, outer : float or array
        Contact radius a, and radius c within which the stress acts [m].
    curvature_radius : float
        R [m].
    modulus : float
        E* [Pa].
    stress : float
        Adhesive stress s0 [Pa].
    """
    a, c = np.asarray(radius, float), np.asarray(outer, float)
    plain = paraboloid(a, curvature_radius, modulus)
    m, angle = np.sqrt((c - a) * (c + a)), np.arccos(a / c)
    opened = (a * m + (c**2 - 2 * a**2) * angle) / (np.pi * curvature_radius)
    return (
        np.asarray(plain.depth - 2 * stress * m / modulus),
        np.asarray(plain.force - 2 * stress * (c**2 * angle + a * m)),
        np.asarray(opened + 4 * stress * (m * angle - c + a) / (np.pi * modulus)),
    )


def jkr_pull_off(curvature_radius: float, work: float, exponent: float = 0.0) -> float:
    """Largest tension under force control, (3 + k)/2 pi w R [N]: independent of the modulus."""
    return (3 + exponent) / 2 * np.pi * work * curvature_radius


def jkr_pull_off_radius(curvature_radius: float, modulus: float, work: float) -> float:
    """Contact radius at the force minimum on a homogeneous half-space, a^3 = 9 pi w R^2/(8 E*) [m]."""
    return float((9 * np.pi * work * curvature_radius**2 / (8 * modulus)) ** (1 / 3))


def jkr_cone(radius: float | Array, inclination: float, modulus: float, work: float) -> tuple[Array, Array]:
    """Depth [m] and force [N] of a cone at contact radius a (Maugis and Barquins 1981)."""
    a, slope = np.asarray(radius, float), np.tan(inclination)
    back = np.sqrt(2 * np.pi * a * work / modulus)
    return np.asarray(np.pi / 2 * a * slope - back), np.asarray(
        np.pi / 2 * modulus * a**2 * slope - 2 * modulus * a * back
    )


def jkr_power_law(
    radius: float | Array, power: float, coefficient: float, constant: float, exponent: float, work: float
) -> tuple[Array, Array]:
    """Depth [m] and force [N] of f = c r^n on a graded half-space; arguments as `power_law.power_law`.

    K = 2 N a^(1+k)/(1 + k), so D = sqrt(2 pi w a^(1-k)/N).
    """
    a = np.asarray(radius, float)
    plain: RoundContact = power_law(a, power, coefficient, constant, exponent)
    back = np.sqrt(2 * np.pi * work * a ** (1 - exponent) / constant)
    return np.asarray(plain.depth - back), np.asarray(plain.force - plain.stiffness * back)
