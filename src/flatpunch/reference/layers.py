"""Closed kernels L(kappa), kappa = k h, of one layer; limits of thick and thin layers on a rigid base.

L is the surface compliance over that of a half-space of the layer's own material. The formulas are rearranged
so that no difference of nearly equal numbers remains at small kappa and nothing overflows at large kappa.

See Also
--------
flatpunch.compliance : Any stack of layers.

Examples
--------
>>> from flatpunch.reference.layers import frictionless_on_rigid
>>> print(frictionless_on_rigid(np.array([0.1, 1.0, 10.0])).round(4))
[0.05   0.4909 1.    ]
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def _sinh_minus(y: Array) -> Array:
    """sinh(y) - y, for 0 <= y <= 2 by its series (error below 1e-17), scaled by exp(-y)."""
    y = np.asarray(y, float)
    small = np.minimum(y, 2.0)
    term = small**3 / 6
    total = term.copy()
    for n in range(5, 27, 2):
        term = term * small**2 / (n * (n - 1))
        total += term
    direct = -np.expm1(-2 * y) / 2 - y * np.exp(-y)
    return np.where(y <= 2, total * np.exp(-y), direct)


def frictionless_on_rigid(kappa: Array) -> Array:
    """Layer sliding on a rigid base: L = 2 sinh^2 kappa/(sinh 2 kappa + 2 kappa), for every Poisson ratio."""
    x = np.asarray(kappa, float)
    # everything times exp(-2x)
    sinh2 = np.expm1(-2 * x) ** 2 / 4
    return np.asarray(2 * sinh2 / (-np.expm1(-4 * x) / 2 + 2 * x * np.exp(-2 * x)))


def bonded_on_rigid(kappa: Array, poisson: float) -> Array:
    """Layer bonded to a rigid base.

    L = [(3 - 4 nu) sinh kappa cosh kappa - kappa]/[(3 - 4 nu) cosh^2 kappa + kappa^2 + (1 - 2 nu)^2]
    """
    x, nu = np.asarray(kappa, float), poisson
    c = 3 - 4 * nu
    decay = np.exp(-2 * x)
    # c sinh(2x)/2 - x = c (sinh(2x) - 2x)/2 + 2 (1 - 2 nu) x, times exp(-2x)
    above = c * _sinh_minus(2 * x) / 2 + 2 * (1 - 2 * nu) * x * decay
    below = c * (1 + decay) ** 2 / 4 + (x**2 + (1 - 2 * nu) ** 2) * decay
    return np.asarray(above / below)


def bonded_on_half_space(kappa: Array, young: float, poisson: float, base_young: float, base_poisson: float) -> Array:
    """Layer bonded to an elastic half-space (Burmister 1945).

    L = (1 + 4 kappa K e - l K e^2)/(1 - (l + K + 4 K kappa^2) e + l K e^2),      e = exp(-2 kappa)
    g = mu1/mu2,      c_i = 3 - 4 nu_i,      l = (g c2 - c1)/(1 + g c2),      K = (g - 1)/(g + c1)

    Parameters
    ----------
    kappa : ndarray
        k h [-], > 0.
    young, poisson : float
        Of the layer.
    base_young, base_poisson : float
        Of the half-space.
    """
    x = np.asarray(kappa, float)
    g = young / (1 + poisson) / (base_young / (1 + base_poisson))
    c1, c2 = 3 - 4 * poisson, 3 - 4 * base_poisson
    ell, big = (g * c2 - c1) / (1 + g * c2), (g - 1) / (g + c1)
    e = np.exp(-2 * x)
    # notation: small differences in closed form, 1 - l, 1 - K, 1 - l K, 1 + l
    not_l, not_k = (1 + c1) / (1 + g * c2), (1 + c1) / (g + c1)
    not_lk = g * (1 + c1) * (1 + c2) / ((1 + g * c2) * (g + c1))
    plus_l = (2 * g * c2 + 1 - c1) / (1 + g * c2)
    above = not_lk + 2 * big * (ell * _sinh_minus(2 * x) + 2 * x * plus_l * e)
    u = -np.expm1(-2 * x)
    # e (sinh^2 x - x^2) = e (sinh x - x)(sinh x + x)
    plate = _sinh_minus(x) * (_sinh_minus(x) + 2 * x * np.exp(-x))
    below = not_l * not_k + (ell * not_k + big * not_l) * u + 4 * big * (ell * plate - not_l * x**2 * e)
    return np.asarray(above / below)


def sliding_on_half_space(kappa: Array, modulus: float, base_modulus: float) -> Array:
    """Layer sliding on an elastic half-space: only the ratio q = E1*/E2* of the moduli matters.

    L = (2 sinh^2 kappa + q (sinh 2 kappa + 2 kappa))/(sinh 2 kappa + 2 kappa + 2 q (sinh^2 kappa -
    kappa^2)),

    from the flexibilities of a free layer pressed on one face, (sinh 2k + 2k)/(2 D) there and (sinh k + k
    cosh k)/D on the other face, D = sinh^2 k - k^2.
    """
    x = np.asarray(kappa, float)
    q = modulus / base_modulus
    e = np.exp(-2 * x)
    both = -np.expm1(-4 * x) / 2 + 2 * x * e
    plate = _sinh_minus(x) * (_sinh_minus(x) + 2 * x * np.exp(-x))
    return np.asarray((np.expm1(-2 * x) ** 2 / 2 + q * both) / (both + 2 * q * plate))


def thick_layer_stiffness(beta: Array, moment0: float, moment2: float) -> Array:
    """Kbar of the flat punch on a thick layer on a rigid base, up to O(beta^4).

    Parameters
    ----------
    beta : ndarray
        a/h [-].
    moment0, moment2 : float
        N_2j = int_0^inf kappa^(2j) (1 - L) d kappa.
    """
    b = np.asarray(beta, float)
    al = 2 * moment0 / np.pi
    return np.asarray(1 + al * b + (al * b) ** 2 + (al**3 - 2 * moment2 / (3 * np.pi)) * b**3)


def thin_flat_punch(radius: float, thickness: float, young: float, poisson: float, *, bonded: bool) -> float:
    """Stiffness F/d [N/m] of a flat punch on a layer that is thin against it, leading order.

    pi a^2/h times the constrained modulus if bonded and compressible, times E* if sliding; 3 pi G a^4/(8 h^3)
    if bonded and incompressible.
    """
    a, h = radius, thickness
    if not bonded:
        return float(np.pi * a**2 * young / (1 - poisson**2) / h)
    if poisson == 0.5:
        return float(np.pi * young * a**4 / (8 * h**3))
    return float(np.pi * a**2 * young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson)) / h)


def thin_incompressible_paraboloid(depth: float, curvature_radius: float, thickness: float, young: float) -> float:
    """Force [N] of a paraboloid on a thin bonded incompressible layer, 2 pi G R^2 d^3/h^3; a^2 = 4 R d."""
    return float(2 * np.pi * young / 3 * curvature_radius**2 * depth**3 / thickness**3)


def small_contact_resistance(radius: float, thickness: float, conductivity: float, base_conductivity: float) -> float:
    """Resistance [K/W or ohm] of a disc, small against a conducting layer on a half-space (Dryden 1983), to order (a/h)^2."""
    beyond = np.log(2 / (1 + conductivity / base_conductivity)) / (2 * np.pi * thickness)
    return float((1 / (4 * radius) - beyond) / conductivity)
