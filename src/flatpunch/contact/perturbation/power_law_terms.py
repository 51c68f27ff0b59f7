"""Exact perturbation theory for power-law indenters f = r^n psi(phi), second and fourth order (T8.4)-(T8.11).

With a reference mean C and a free exponent lam, u = ((psi/C)^lam - 1)/lam has zero mean (lam = 0: u = ln(psi/C)), and
psi/C - 1 = u + c2 u^2 + c3 u^3 + c4 u^4. The round contact of C r^n is the base; the medium responds to each harmonic of u with
one function of beta,

    outline   a(phi) = abar exp(w),  w = -R[u] + ...,       force   ln F = ln F_base + x2 + x3 + x4 + ...

Everything here depends on beta = a/l alone once a^n is scaled out; it is sampled on panels of log(beta), where derivatives by
ln a are exact. Angular fields live on one period of the outline; R and k act on their Fourier coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flatpunch._support.byte_cache import PROCESS, byte_cached
from flatpunch._support.checks import Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.indenters.geometry.angles import angular_rule
from flatpunch.indenters.geometry.features import rotational_symmetry
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.chebyshev import log_derivative, tail
from flatpunch.numerics.piecewise import PiecewiseChebyshev
from flatpunch.punch.basis import power_edge, power_moments
from flatpunch.punch.family import SMALLEST, check_resolution, panels, punch_family
from flatpunch.punch.harmonics import edges_of, known_edges
from flatpunch.punch.matrix import edge_strength
from flatpunch.punch.power_law import power_law_punch


@dataclass(frozen=True, slots=True)
class Angles:
    """One period of a profile psi(phi) in the variable of the expansion.

    Attributes
    ----------
    u : ndarray, shape (points,)
        ((psi/C)^lam - 1)/lam at equal steps from `start` over one period.
    orders : ndarray of int, shape (points/2,)
        Harmonics m that its Fourier coefficients belong to.
    start : float
        First angle [rad].
    mean : float
        Reference C [m^(1-n)], for which <u> = 0.
    c2, c3, c4 : float
        Coefficients of psi/C - 1 = u + c2 u^2 + c3 u^3 + c4 u^4 + ...
    """

    u: Array
    orders: Indices
    start: float
    mean: float
    c2: float
    c3: float
    c4: float

    def waves(self, phi: Array) -> Array:
        """Harmonics of -u at angles phi, shape (orders, p): weighted by R they add up to w."""
        spectrum = np.fft.rfft(self.u) / self.u.size
        # the highest frequency of the grid has no partner
        spectrum[1:-1] *= 2
        return np.asarray(-np.real(spectrum[1:, None] * np.exp(1j * np.outer(self.orders, phi - self.start))))


def act(weights: Array, field: Array) -> Array:
    """Multiply the harmonics m > 0 of angular fields by weights, shape (nb, orders); the mean goes to zero."""
    spectrum = np.fft.rfft(field)
    weighted = np.zeros((weights.shape[0], spectrum.shape[-1]), dtype=complex)
    weighted[:, 1:] = weights * spectrum[..., 1:]
    return np.asarray(np.fft.irfft(weighted, n=field.shape[-1], axis=-1))


def expand(indenter: Indenter, lam: float) -> Angles:
    """Profile psi(phi) of a power-law indenter as one period of the variable u."""
    phi, weights = angular_rule(indenter)
    psi = _angular(indenter, phi)
    mean = float(np.exp(weights @ np.log(psi)) if lam == 0 else (weights @ psi**lam) ** (1 / lam))
    fold = rotational_symmetry(indenter)
    start = indenter.corners[0] if indenter.corners else 0.0
    # points on one period of a kinked outline: its harmonics fall like 1/m^2, which leaves 1e-7 of the force
    points = 2048
    while True:
        grid = start + 2 * np.pi / fold * np.arange(points) / points
        ratio = _angular(indenter, grid) / mean
        u = np.log(ratio) if lam == 0 else (ratio**lam - 1) / lam
        spectrum = np.abs(np.fft.rfft(u))
        # products of four fields must fit on the grid
        if points <= 128 or spectrum[points // 16 :].max() > 1e-15 * max(spectrum.max(), 1e-15):
            break
        points //= 2
    c2 = (1 - lam) / 2
    c3 = c2 * (1 - 2 * lam) / 3
    return Angles(u - u.mean(), fold * np.arange(1, points // 2 + 1), start, mean, c2, c3, c3 * (1 - 3 * lam) / 4)


def _angular(indenter: Indenter, phi: Array) -> Array:
    return np.asarray(indenter.height(np.ones_like(phi), phi))


class Terms(NamedTuple):
    """Terms of ln F and measures of the outline abar exp(w), or their derivatives by ln a; shape (n,) each.

    Attributes
    ----------
    x2, x3, x4 : ndarray
        Terms of ln(F/F_base).
    stiffening : ndarray
        sum_m eta_m h_m^2, by which the outline makes the punch stiffer.
    log_mean, log_square : ndarray
        ln<e^w> and ln<e^2w>.
    swing : ndarray
        Largest |w|.
    """

    x2: Array
    x3: Array
    x4: Array
    stiffening: Array
    log_mean: Array
    log_square: Array
    swing: Array


@dataclass(frozen=True, slots=True)
class Base:
    """Round contact of r^n over a^n on the unit disc, modulus 1; shape (nb, 1) each.

    Attributes
    ----------
    depth, slope : ndarray
        d and D1 = a d'.
    force, excess : ndarray
        F and G = K d - F.
    edge, flat : ndarray
        Edge strength e of the flat punch and its c_0: K = 2 pi c_0, a K' = 2 pi^2 e^2.
    """

    depth: Array
    slope: Array
    force: Array
    excess: Array
    edge: Array
    flat: Array


class PowerPerturbation:
    """Second- and fourth-order terms of one power-law indenter on one medium.

    Parameters
    ----------
    kernel : Kernel
        The medium.
    indenter : Indenter
        A power-law shape.
    lam : float
        Exponent of the expansion variable; 0 is the logarithm, 1/2 serves the fourth order.
    fourth : bool
        Whether x3 and x4 are wanted; otherwise their columns are zero.
    """

    def __init__(self, kernel: Kernel, indenter: Indenter, lam: float, *, fourth: bool) -> None:
        assert indenter.exponent is not None
        self.kernel, self.exponent, self.fourth = kernel, indenter.exponent, fourth
        self.angles = expand(indenter, lam)
        self._panels = panels(kernel, self._columns, _judge)
        # edge functionals are smooth where the outline has poles, and expensive: all series of an indenter share them
        self._edges = _edge_panels(kernel, indenter.exponent, self.angles.orders.tobytes())
        self._outlines: dict[bytes, PiecewiseChebyshev] = {}
        self._known: dict[bytes, tuple[Array, Array, Base]] = {}

    def at(self, radius: Array) -> tuple[Terms, Terms]:
        """Terms and their derivatives by ln a at base radii, shape (n,) each."""
        beta = radius / self.kernel.length
        live = (beta > SMALLEST) & (not self.kernel.homogeneous)
        values = np.empty((radius.size, len(Terms._fields)))
        slopes = np.zeros_like(values)
        if not live.all():
            values[~live] = self._columns(np.zeros(1))
        if live.any():
            check_resolution(self.kernel, float(beta.max()))
            logs = np.log(beta[live])
            values[live], slopes[live] = self._panels.with_slope(logs)
        return Terms(*values.T), Terms(*slopes.T)

    def outline(self, radius: Array, phi: Array) -> Array:
        """w(phi) at base radii, a(phi) = abar exp(w); shape (n, p)."""
        key = phi.tobytes()
        if key not in self._outlines:
            waves = self.angles.waves(phi)
            self._outlines[key] = panels(self.kernel, lambda beta: self._response(beta)[0] @ waves)
            PROCESS.grown(waves.nbytes)
        beta = radius / self.kernel.length
        live = (beta > SMALLEST) & (not self.kernel.homogeneous)
        if live.all():
            return self._outlines[key].at(np.log(beta))
        w = np.repeat(self._response(np.zeros(1))[0] @ self.angles.waves(phi), radius.size, axis=0)
        if live.any():
            w[live] = self._outlines[key].at(np.log(beta[live]))
        return w

    def _response(self, beta: Array) -> tuple[Array, Array, Base]:
        """R_m and k_m at radii beta for the orders of the outline, shape (nb, orders), and the round base."""
        key = beta.tobytes()
        if key not in self._known:
            base = round_base(self.kernel, self.exponent, beta)
            if beta.all():
                power, stiffening = np.hsplit(self._edges.at(np.log(beta)), 2)
            else:
                power, stiffening = np.hsplit(_edge_columns(self.kernel, beta, self.exponent, self.angles.orders), 2)
            self._known[key] = (power / (base.edge * base.slope), stiffening, base)
            PROCESS.grown(3 * power.nbytes)
        return self._known[key]

    def _columns(self, beta: Array) -> Array:
        """All of `Terms` side by side, shape (nb, 7)."""
        response, stiffening, base = self._response(beta)
        derivative = log_derivative(beta) if beta.all() else np.zeros((1, 1))
        w = -act(response, self.angles.u)
        # sum of eta_m h_m^2, eta_m = (1/2)(dlnK/dlna)(1 + k_m) with dlnK/dlna = pi e^2/c_0
        gain = np.pi * (base.edge**2 / base.flat)[:, 0] * np.mean(w * (w + act(stiffening, w)), axis=1)
        higher: tuple[Array, ...] = (np.zeros_like(base.edge), np.zeros_like(base.edge))
        if self.fourth:
            higher = higher_force(self.angles, base, response, stiffening, derivative, self.exponent)
        outline = limited_exponential(w)
        means = [np.log(_mean(outline)), np.log(_mean(outline * outline)), np.abs(w).max(axis=1, keepdims=True)]
        return np.hstack([second_order_force(self.angles, base, w), *higher, gain[:, None], *means])


@byte_cached
def _edge_panels(kernel: Kernel, exponent: float, orders: bytes) -> PiecewiseChebyshev:
    numbers = np.frombuffer(orders, dtype=int)
    return panels(kernel, lambda beta: _edge_columns(kernel, beta, exponent, numbers))


def _edge_columns(kernel: Kernel, beta: Array, exponent: float, orders: Indices) -> Array:
    """S[A_m^-1 b[r^n]] and k_m of the orders of an outline side by side, shape (nb, 2 orders)."""
    edges = known_edges(kernel, beta, orders, exponent) or edges_of(kernel, beta, orders)
    return np.hstack([edges.power_edge(exponent, orders), edges.stiffening(orders)])


def second_order_force(angles: Angles, base: Base, w1: Array) -> Array:
    """Term x2 of ln(F/F_base), shape (nb, 1): X2 = -G c2 <u^2> + H <w1^2>/2 with H = a K' D1."""
    h = 2 * np.pi**2 * base.edge**2 * base.slope
    return np.asarray((-base.excess * angles.c2 * np.mean(angles.u**2) + h * _mean(w1 * w1) / 2) / base.force)


def higher_force(
    angles: Angles, base: Base, response: Array, stiffening: Array, derivative: Array, exponent: float
) -> tuple[Array, Array]:
    """Terms x3 and x4 of ln(F/F_base), shape (nb, 1) each, of a profile with `exponent` n.

    `response` and `stiffening` are R_m and k_m, shape (nb, orders), `derivative` the matrix of d/dln(beta) between the nb
    radii.
    """
    u, c2, c3, c4 = angles.u, angles.c2, angles.c3, angles.c4
    e2, d1 = base.edge**2, base.slope
    h = 2 * np.pi**2 * e2 * d1
    # notation: k0 = (1/2) dln(K'/a)/dln a, ratio = D2/D1
    k0 = derivative @ np.log(base.edge) - 0.5
    ratio = exponent + derivative @ np.log(np.abs(d1))
    w1, w2 = -act(response, u), -c2 * act(response, u * u)
    w3 = -c3 * act(response, u**3) if c3 else np.zeros_like(w1)
    wf = -c2 * np.mean(u * u) * base.depth / d1
    eta = (k0 + ratio) * w1 - act(derivative @ response, u)

    def carried(y: Array) -> Array:
        """T(y) = (1/D1) d/dln a (a K' D1^2 y/2), all of it growing like a^(2n + 1)."""
        g = e2 * d1 * d1 * y
        return np.asarray(np.pi**2 / d1 * ((2 * exponent + 1) * g + derivative @ g))

    square = w1 * w1
    cube, mean_square = square * w1, _mean(square)
    excess = stiffening - k0
    q = _mean(square * square) * (1 - ratio / 2 - k0) / 6 + _mean(cube * eta) / 3 + wf * mean_square
    q += _mean(square * act(excess, square)) / 4 - _mean(cube * act(excess, w1)) / 3
    x3 = -base.excess * c3 * np.mean(u**3) + h * _mean(w1 * w2) + carried(_mean(cube) / 3)
    x4 = -base.excess * c4 * np.mean(u**4) + h * (_mean(w2 * w2 + 2 * w1 * w3) + wf**2) / 2
    x4 += carried(_mean(square * w2) + q)
    return x3 / base.force, x4 / base.force - second_order_force(angles, base, w1) ** 2 / 2


def round_base(kernel: Kernel, exponent: float, beta: Array) -> Base:
    """Round contact of r^n on discs beta, shape (nb,)."""
    responses = punch_family(kernel).at(beta, nodes=True)
    flat, edge = responses.flat[:, 0], edge_strength(responses)
    if kernel.exponent:
        punch = power_law_punch(kernel)
        depth = np.full_like(beta, punch.power_depth(exponent))
        slope, force = exponent * depth, 2 * np.pi * depth * flat * punch.power_force(exponent)
        excess = 2 * np.pi * depth * flat - force
    else:
        b = power_moments(exponent, 0, responses.flat.shape[1])
        closed = power_edge(exponent, 0)
        depth = (closed + responses.edge @ b) / edge
        slope = (depth * responses.slope[:, 0] + exponent * closed - responses.slope @ b) / edge
        excess = 2 * np.pi * responses.flat @ b
        force = 2 * np.pi * depth * flat - excess
    return Base(*(value[:, None] for value in (depth, slope, force, excess, edge, flat)))


def limited_exponential(w: Array) -> Array:
    """exp(w), cut far beyond the range of the series."""
    # |w| at which outlines are cut: R has a pole where the depth turns back under a stiff film, and exp(w) would overflow
    return np.asarray(np.exp(np.clip(w, -10.0, 10.0)))


def _mean(field: Array) -> Array:
    return np.asarray(np.mean(field, axis=-1, keepdims=True))


def _judge(series: Array) -> float:
    """Tail of the force's second-order term and of the outline's mean; the higher terms are small and noisier."""
    terms = Terms(*series.T)
    return max(tail(terms.x2[:, None]), tail(terms.log_square[:, None]))
