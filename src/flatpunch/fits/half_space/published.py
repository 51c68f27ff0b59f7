"""Formulas that are in use today, to be shown beside the exact solution. None of them is exact; none is used by the fits.

Thin layers (factor on the half-space force; X = sqrt(R d)/h for paraboloids, d tan(alpha)/h for cones, a/h for flat ends, alpha
the half opening angle): Dimitriadis et al. 2002, Garcia et al. 2018, Chadwick 2002, Clifford and Seah 2009, Long et al. 2011
(large strains, Biophys. J. 101, 643). Films on substrates
(equivalent plane-strain modulus from those of film and substrate, over contact radius and thickness, x = a/t): Gao, Chiu and Lee
1992, Perriot and Barthel 2004, Bec et al. 2006, King 1987 in the form of Doerner and Nix, Saha and Nix 2002.
Coefficients as collected in the project's reference tables, from open implementations.
"""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array

_DIMITRIADIS_HALF = (1.0, 1.133, 1.283, 0.769, 0.0975)
"""Printed coefficients for paraboloids on bonded incompressible layers (Dimitriadis et al. 2002)."""
_DIMITRIADIS = {
    True: (-1.2876, 1.4678, -1.3442, 0.6387, -1.0277, 1.5164),
    False: (-1.041, 0.694, 0.0, 0.28, -0.112, 0.0),
}
"""(1 - nu) alpha_0 and (1 - nu) beta_0 over 1, nu, nu^2, of bonded layers and others: -0.347 (3 - 2 nu) and 0.056 (5 - 2 nu)."""


def dimitriadis(x: Array, poisson: float, bonded: bool) -> Array:
    """Factor for paraboloids, to fourth order in X = sqrt(R d)/h.

    For bonded incompressible layers programs use the numbers that are printed for that case; their last one, +0.0975, has the
    opposite sign of what the general formula gives there.
    """
    nu = poisson
    if bonded and nu == 0.5:
        return np.asarray(np.polynomial.polynomial.polyval(x, _DIMITRIADIS_HALF))
    a0, b0 = np.reshape(_DIMITRIADIS[bonded], (2, 3)) @ [1, nu, nu**2] / (1 - nu)
    pi = np.pi
    series = [
        1.0,
        -2 * a0 / pi,
        4 * a0**2 / pi**2,
        -8 / pi**3 * (a0**3 + 4 * pi**2 * b0 / 15),
        16 * a0 / pi**4 * (a0**3 + 3 * pi**2 * b0 / 5),
    ]
    return np.asarray(np.polynomial.polynomial.polyval(x, series))


_GARCIA = {
    "paraboloid": (1.0, 1.133, 1.497, 1.469, 0.755),
    "cone": (1.0, 0.721, 0.650, 0.491, 0.225),
    "flat": (1.0, 1.133, 1.283, 0.598, -0.291),
}


def garcia(x: Array, shape: str) -> Array:
    """Factor for incompressible bonded layers; shape is "paraboloid", "cone" or "flat"."""
    return np.asarray(np.polynomial.polynomial.polyval(x, _GARCIA[shape]))


LONG = (0.3, 2.0)
"""R/h of the formula of Long et al.; above, programs use other coefficients."""


_LONG = (10.05, -0.63, 3.1, 4.8, -4.23, 1.15, 2.3)
"""Printed coefficients of Long et al."""


def long(x: Array, ratio: float) -> Array:
    """Factor for spheres on incompressible bonded layers, fitted to finite elements at large strain; `ratio` is R/h."""
    w = np.asarray(x) ** 3
    a0, a1, a2, b0, b1, c, d = _LONG
    alpha, beta = a0 + a1 * np.sqrt(1 / ratio) * (a2 + ratio**-2), b0 + b1 * ratio**-2
    return np.asarray((1 + c * w ** (1 / 3) + alpha * w + beta * w**2) / (1 + d * w))


PYRAMID = {
    (4, True): (0.8313, 0.7317, 1.4221, -0.5489, 0.0986),
    (4, False): (0.5483, 0.3529, 0.3131, -0.2379, 0.0459),
    (3, True): (0.9944, 1.2876, 1.0070, -0.2928, 0.0613),
    (3, False): (0.6559, 0.5940, 0.0634, -0.1437, 0.0346),
}
"""Coefficients c1 to c5 by number of sides and bond, fitted to the exact contact up to x = 2 (page on AFM of the docs)."""


PYRAMID_FORCE = {4: 0.737619, 3: 0.88241}
"""F/(E* tan(alpha) d^2) of pyramids on thick samples by number of sides, which the factors of `pyramid` multiply."""


def pyramid(x: Array, sides: int = 4, bonded: bool = True) -> Array:
    """Factor for pyramids of three or four sides on incompressible layers, this project's own; nan for x > 2."""
    factor = np.polynomial.polynomial.polyval(x, (1.0, *PYRAMID[sides, bonded]))
    # largest x = d tan(alpha)/h of the formula for pyramids; beyond it there is none
    return np.where(np.asarray(x) <= 2.0 * (1 + 1e-9), factor, np.nan)


def chadwick(radius: float, depth: Array, young: float, thickness: float) -> Array:
    """Force on a layer much thinner than the contact: incompressible, bonded to its base, without friction under the tip."""
    return np.asarray(2 * np.pi / 3 * young * radius**2 * depth**3 / thickness**3)


def clifford(x: Array, film: float, poisson_film: float, substrate: float, poisson_substrate: float) -> Array:
    """Equivalent modulus under a paraboloid, over x = sqrt(R d)/t."""
    factor = (1 - 0.22 * poisson_substrate**2) / (1 - 1.92 * poisson_film**2)
    weight = 2.25 * (x * (film / substrate) ** (2 / 3) * factor) ** (3 / 2)
    return np.asarray(film + (substrate - film) * weight / (1 + weight))


def gao(x: Array, film: float, substrate: float, poisson: float) -> Array:
    """Equivalent modulus by first-order perturbation about equal bodies; x = a/t > 0."""
    y = 1 / x
    weight = 2 / np.pi * np.arctan(y) + ((1 - 2 * poisson) * y * np.log((1 + y**2) / y**2) - y / (1 + y**2)) / (
        2 * np.pi * (1 - poisson)
    )
    return np.asarray(substrate + (film - substrate) * weight)


def perriot_barthel(x: Array, film: float, substrate: float, exponent: float = 1.27) -> Array:
    """Equivalent modulus, a fit to numerical solutions."""
    ratio = np.log10(substrate / film)
    k0 = 10 ** (-0.093 + 0.792 * ratio + 0.05 * ratio**2)
    return np.asarray(film + (substrate - film) / (1 + (k0 / x) ** exponent))


def bec(x: Array, film: float, substrate: float) -> Array:
    """Equivalent modulus of two springs in series."""
    compliance = 1 / ((np.pi * x**2 + 2 * x) * film) + 1 / (2 * (x + 2 / np.pi) * substrate)
    return np.asarray(1 / (2 * x * compliance))


def king(x: Array, film: float, alpha: float, substrate: float) -> Array:
    """Equivalent modulus in the form of Doerner and Nix; King gave alpha as a plot, here it is a number to be fitted."""
    return np.asarray(1 / (1 / film + (1 / substrate - 1 / film) * np.exp(-alpha / x)))
