"""Surface compliance of a half-space whose modulus is a power of depth, in closed form.

For E(z) = E_l (z/l)^k the response at wavenumber q is C(q) = (2 c/E*) (q l)^k/q with E* = E_l/(1 - nu^2). The constant
follows from the flat punch, F = 2 h_N E* a^(1+k) d/((1 + k) l^k) (Booker, Balaam and Davis 1985; Giannakopoulos and
Suresh 1997; Popov, Hess and Willert, Handbook of Contact Mechanics, chapter 9):

    h_N = 2 (1 + k) cos(k pi/2) Gamma(1 + k/2) / (sqrt(pi) D b sin(b pi/2) Gamma((1 + k)/2)),
    D = 2^(1+k) Gamma((3 + k + b)/2) Gamma((3 + k - b)/2) / (pi Gamma(2 + k)),    b^2 = (1 + k)(1 - k nu/(1 - nu))
    c = pi / (2^k Gamma((1 + k)/2)^2 h_N)
"""

from __future__ import annotations

from math import gamma

import numpy as np


def stiffness_factor(exponent: float, poisson: float) -> float:
    """h_N of the flat punch [-]: 1 at exponent 0, pi/2 for the Gibson soil (exponent 1, Poisson ratio 1/2)."""
    k, nu = exponent, poisson
    # notation: cos(k pi/2)/(b sin(b pi/2)) with both zeros of the Gibson soil divided out; at nu = 1/2 they cancel
    quotient = 1.0 if nu == 0.5 else (1 - nu) * (1 - k) / (1 - nu - k * nu)
    b = np.sqrt((1 + k) * (1 - k * nu / (1 - nu)))
    quotient *= np.sinc((1 - k) / 2) / np.sinc(b / 2)
    d = 2 ** (1 + k) * gamma((3 + k + b) / 2) * gamma((3 + k - b) / 2) / (np.pi * gamma(2 + k))
    return float(2 * gamma(1 + k / 2) * quotient / (np.sqrt(np.pi) * d * gamma((1 + k) / 2)))


def power_law_constant(exponent: float, poisson: float) -> float:
    """c of the response L(kappa) = c kappa^exponent [-]."""
    k = exponent
    return float(np.pi / (2**k * gamma((1 + k) / 2) ** 2 * stiffness_factor(k, poisson)))
