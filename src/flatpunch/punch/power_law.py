"""Power-law half-spaces E(z) = E_l (z/l)^k: every punch quantity in closed form.

With alpha = (k - 1)/2 the pressures of angular harmonic m on the unit disc

    p_n(r) = r^m P_n^(m,alpha)(1 - 2 r^2) (1 - r^2)^alpha / binom(n + alpha, n),     edge coefficient (-1)^n,

have the Hankel transforms N x^(-1-alpha) J_(m+2n+1+alpha)(x), N = 2^alpha Gamma(1 + alpha), and their matrix is diagonal,
D_n = N^2/(m + 2n + 1 + alpha). A displacement f cos(m phi) needs the pressure (E*/(c a)) (a/l)^k sum c_n p_n(r/a), D c = b[f],
with c of `flatpunch.compliances.power_law`. k = 0 is the basis of `basis`; k -> 1 with nu = 1/2 the Gibson soil, whose
punch pressure is uniform. Sources: Booker, Balaam and Davis 1985; Giannakopoulos and Suresh 1997; Jin and Guo 2013 for the
flat punch and the paraboloid.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import gamma, lgamma

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.compliances.power_law import stiffness_factor
from flatpunch.media.material import PowerLaw
from flatpunch.punch.basis import beta


def power_law_punch(body: PowerLaw | Kernel) -> PowerLawPunch:
    """Closed forms for a power-law half-space, or for its kernel."""
    if isinstance(body, Kernel):
        k, constant = body.exponent, float(body.response(np.ones(1))[0])
        factor = float(np.pi / (2**k * gamma((1 + k) / 2) ** 2 * constant))
        return PowerLawPunch(body.modulus, body.length, k, factor)
    factor = stiffness_factor(body.exponent, body.poisson)
    return PowerLawPunch(body.surface_modulus, body.depth, body.exponent, factor)


@dataclass(frozen=True, slots=True)
class PowerLawPunch:
    """Flat punches and round contacts of any radius on a power-law half-space; made by `power_law_punch`.

    Attributes
    ----------
    modulus : float
        E* = E_l/(1 - nu^2) [Pa].
    length : float
        Reference depth l [m].
    exponent : float
        k of the grading [-].
    factor : float
        h_N of the stiffness [-].
    """

    modulus: float
    length: float
    exponent: float
    factor: float

    @property
    def alpha(self) -> float:
        """Exponent of (1 - rho^2) in the punch pressure, (k - 1)/2."""
        return (self.exponent - 1) / 2

    def normalized_stiffness(self, radius: Array) -> Array:
        """Kbar = F/(2 E* a d) = h_N (a/l)^k/(1 + k) [-] at radii a [m], same shape."""
        k = self.exponent
        return np.asarray(self.factor / (1 + k) * (np.asarray(radius) / self.length) ** k)

    def stiffness(self, radius: Array) -> Array:
        """K = dF/dd [N/m]; K' = (1 + k) K/a."""
        return 2 * self.modulus * np.asarray(radius) * self.normalized_stiffness(radius)

    def pressure(self, radius: float, r: Array) -> Array:
        """Flat-punch pressure per unit depth [Pa/m] at distances r [m] from the axis; zero outside."""
        rho = np.minimum(np.asarray(r, dtype=float) / radius, 1.0)
        mean = self.stiffness(np.asarray(radius)) / (np.pi * radius**2)
        with np.errstate(divide="ignore"):
            inside = (1 + self.alpha) * mean * ((1 - rho) * (1 + rho)) ** self.alpha
        return np.where(np.asarray(r) <= radius, inside, 0.0)

    def moment(self, exponent: float, radius: Array) -> Array:
        """kappa_n = (n + 1) int_0^1 pbar rho^(n+1) drho [-], pbar the pressure over E* d/(pi a)."""
        weight = (exponent + 1) * (1 + self.alpha) * beta(exponent / 2 + 1, 1 + self.alpha)
        return np.asarray(weight * self.normalized_stiffness(radius))

    def power_depth(self, exponent: float) -> float:
        """d/f(a) of the round contact of f = A r^n: Gamma(n/2 + 1) Gamma(1 + alpha)/Gamma(n/2 + 1 + alpha)."""
        return float(np.exp(self._log_edge(exponent, 0) - self._log_edge(0.0, 0)))

    def power_force(self, exponent: float) -> float:
        """F/(K d) of the round contact of f = A r^n: n/(n + 1 + k)."""
        return exponent / (exponent + 1 + self.exponent)

    def round_contact(
        self, height: Callable[[Array], Array], slope: Callable[[Array], Array], radius: Array, nodes: int = 64
    ) -> tuple[Array, Array]:
        """Exact round contact of any profile smooth in r.

        Parameters
        ----------
        height, slope : callable
            r [m] -> f [m] and df/dr [-].
        radius : ndarray, shape (n,)
            Contact radii a [m], > 0.
        nodes : int
            Gauss nodes.

        Returns
        -------
        depth, force : ndarray, shape (n,)
            d [m] and F [N], from d = int (2 (1 + alpha) f + r f') w dr and F = K (d - 2 (1 + alpha) int f w dr),
            w = (1 - rho^2)^alpha rho: the edge singularity vanishes.
        """
        rho, weight = self.rule(nodes)
        r = np.asarray(radius)[:, None] * rho
        f = height(r)
        mean = 2 * (1 + self.alpha) * (f @ weight)
        depth = mean + (r * slope(r)) @ weight
        return depth, self.stiffness(radius) * (depth - mean)

    def power_edge(self, exponent: float, m: int) -> float:
        """S of the pressure for the displacement r^n cos(m phi) on the unit disc; 1/(2 N^2) for n = m = 0."""
        return float(np.exp(self._log_edge(exponent, m)))

    def outline_response(self, exponent: float, m: int) -> float:
        """R_m of an indenter f = r^n psi(phi): the harmonic m of ln a is -R_m times that of ln psi."""
        return float(np.exp(self._log_edge(exponent, m) - self._log_edge(exponent, 0))) / exponent

    def stiffening(self, m: int) -> float:
        """k_m: relative gain of edge strength under the harmonic m of an outline, (m - 1)(1 - k)/2."""
        return (m - 1) * (1 - self.exponent) / 2

    def diagonal(self, m: int, terms: int) -> Array:
        """D_n, shape (terms,)."""
        return np.asarray(self._norm() ** 2 / (m + 2 * np.arange(terms) + 1 + self.alpha))

    def regular_part(self, m: int, terms: int, r: Array) -> Array:
        """p_n(r) (1 - r^2)^(-alpha) at 0 <= r <= 1; shape (terms, *r.shape)."""
        n = np.arange(terms)
        binomial = np.cumprod(np.concatenate([[1.0], (n[1:] + self.alpha) / n[1:]])) if terms > 1 else np.ones(1)
        shape = (-1, *([1] * np.ndim(r)))
        values = scipy.special.eval_jacobi(n.reshape(shape), m, self.alpha, 1 - 2 * np.asarray(r) ** 2)
        return np.asarray(r**m * values / binomial[:terms].reshape(shape))

    def power_moments(self, exponent: float, m: int, terms: int) -> Array:
        """b_l[r^n] = int_0^1 r^n p_l r dr; shape (terms,)."""
        shift = (exponent - m) / 2
        b = np.empty(terms)
        b[0] = 0.5 * beta((exponent + m) / 2 + 1, 1 + self.alpha)
        n = np.arange(terms - 1)
        b[1:] = b[0] * np.cumprod((n - shift) / (n + shift + m + 2 + self.alpha))
        return b

    def _norm(self) -> float:
        return float(2**self.alpha * np.exp(lgamma(1 + self.alpha)))

    def _log_edge(self, exponent: float, m: int) -> float:
        """ln S, S = Gamma(mu + 1)/(2 4^alpha Gamma(1 + alpha) Gamma(mu + 1 + alpha)), mu = (n + m)/2."""
        mu, alpha = (exponent + m) / 2, self.alpha
        return float(lgamma(mu + 1) - lgamma(mu + 1 + alpha) - lgamma(1 + alpha) - alpha * np.log(4) - np.log(2))

    def rule(self, nodes: int) -> tuple[Array, Array]:
        """Radii on the unit disc and weights of int_0^1 (.) (1 - r^2)^alpha r dr.

        With r = cos(theta) the weight is sin^k(theta) cos(theta): Gauss-Jacobi for theta^k, the rest is smooth, also for
        profiles with a tip at r = 0.
        """
        k = self.exponent
        t, v = scipy.special.roots_jacobi(nodes, 0.0, k)
        theta = np.pi / 4 * (t + 1)
        sine = np.sinc(theta / np.pi)  # sin(theta)/theta
        return np.cos(theta), (np.pi / 4) ** (1 + k) * v * sine**k * np.cos(theta)
