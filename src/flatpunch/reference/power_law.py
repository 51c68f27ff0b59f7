"""Power-law graded half-space E(z) = E0 z^k, constant Poisson ratio: constants and round contacts.

Booker, Balaam and Davis (1985), Giannakopoulos and Suresh (1997), Jin and Guo (2013), Hess and Popov (2016).
Everything follows from one constant N = h_N E0/(1 - nu^2): a flat punch has the stiffness 2 N a^(1+k)/(1 +
k), and

    g(x) = x^(1-k) int_0^x f'(r) dr/(x^2 - r^2)^((1-k)/2),      d = g(a),      F = 2 N int_0^a x^k (d - g(x))
    dx

See Also
--------
flatpunch.PowerLawHalfSpace : The body.
flatpunch.reference.half_space : The homogeneous one.

Examples
--------
>>> from flatpunch.reference.power_law import booker_constant
>>> print(f"{booker_constant(0.5, 0.3):.4f}")
1.1414
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import beta as beta_function
from scipy.special import gamma

from flatpunch.reference.half_space import RoundContact

Array = NDArray[np.float64]


def booker_constant(exponent: float, poisson: float) -> float:
    """h_N(k, nu) [-]; 1 for k = 0."""
    k, nu = exponent, poisson
    if k == 1 and nu == 0.5:
        # Gibson soil, the limit along nu = 1/2: cos(k pi/2)/(1 - k) -> pi/2
        return np.pi / 2
    # beta^2 < 0 for k near 1 and nu near 1/2: beta sin(beta pi/2) and the product of gammas stay real
    b = np.sqrt(complex((1 + k) * (1 - k * nu / (1 - nu))))
    c = 2 ** (1 + k) * gamma((3 + k + b) / 2) * gamma((3 + k - b) / 2) / (np.pi * gamma(2 + k))
    # beta sin(beta pi/2) -> beta^2 pi/2 at beta = 0
    sine = b * np.sin(b * np.pi / 2)
    above = 2 * (1 + k) * np.cos(k * np.pi / 2) * gamma(1 + k / 2)
    return float((above / (np.sqrt(np.pi) * c * sine * gamma((1 + k) / 2))).real)


def stiffness_constant(modulus: float, depth: float, exponent: float, poisson: float) -> float:
    """N [Pa/m^k] of E(z) = modulus (z/depth)^exponent."""
    return float(booker_constant(exponent, poisson) * modulus / depth**exponent / (1 - poisson**2))


def compliance(k: float | Array, constant: float, exponent: float) -> Array:
    """Surface compliance C(k) [m/Pa] at wavenumbers k [1/m].

    C = pi k^(q-1)/(N 2^(q-1) Gamma((q+1)/2)^2), q the exponent.
    """
    q = exponent
    return np.asarray(np.pi * np.asarray(k) ** (q - 1) / (constant * 2 ** (q - 1) * gamma((q + 1) / 2) ** 2))


def flat_punch(radius: float | Array, depth: float | Array, constant: float, exponent: float) -> RoundContact:
    """Cylindrical flat punch.

    Parameters
    ----------
    radius, depth : float or array
        a, d [m].
    constant, exponent : float
        N [Pa/m^k] from `stiffness_constant`, and k.
    """
    a, d = np.broadcast_arrays(np.asarray(radius, float), np.asarray(depth, float))
    stiffness = 2 * constant * a ** (1 + exponent) / (1 + exponent)
    return RoundContact(a, d, stiffness * d, stiffness)


def flat_punch_pressure(r: Array, radius: float, depth: float, constant: float, exponent: float) -> Array:
    """Pressure p = N d/pi (a^2 - r^2)^((k-1)/2) [Pa] at r < a; its integral is the force."""
    return np.asarray(constant * depth / np.pi * (radius**2 - np.square(r)) ** ((exponent - 1) / 2))


def power_law(
    radius: float | Array, power: float, coefficient: float, constant: float, exponent: float
) -> RoundContact:
    """Profile f = c r^n.

    d = (n/2) B(n/2, (1+k)/2) c a^n,      F = 2 N n d a^(1+k)/((1 + k)(n + 1 + k))

    Parameters
    ----------
    radius : float or array
        Contact radius a [m].
    power, coefficient : float
        n [-] and c [m^(1-n)].
    constant, exponent : float
        N [Pa/m^k] and k of the medium.
    """
    a, k = np.asarray(radius, float), exponent
    depth = coefficient * power / 2 * beta_function(power / 2, (1 + k) / 2) * a**power
    stiffness = 2 * constant * a ** (1 + k) / (1 + k)
    return RoundContact(a, np.asarray(depth), np.asarray(stiffness * power / (power + 1 + k) * depth), stiffness)
