"""Relaxation functions as sums of exponentials, so that convolutions cost one recursion per term.

psi(t) = constant + sum_j weight_j exp(-rate_j t). Prony series are that already. For a power law the integral
t^-alpha = (1/Gamma(alpha)) int exp(alpha u - t e^u) du is taken by the trapezoidal rule, whose relative error
2 |Gamma(alpha + 2 pi i/h)|/Gamma(alpha) is the same at all times. Terms much slower than the whole history are joined into a
constant and one term, terms faster than a step into one fast term with the same first two moments.

Free recovery is the motion of a spring that carries no force. A spring of unit stiffness with the deflection w carries Q = int
psi(t - t') w'(t') dt'. With a sum of exponentials, psi = constant + sum_j w_j exp(-s_j t), its state is the memory m_j = int
exp(-s_j (t - t')) w'(t') dt'. While Q = 0 the speed w' is a sum of exponentials exp(-r_k t) whose rates are the zeros of

    H(-r) = constant - r sum_j w_j/(s_j - r),

one below each s_j and above the one before, and

    m_j = sum_k A_k exp(-r_k t)/(s_j - r_k),      w' = sum_k A_k exp(-r_k t),      A_k = sum_j s_j w_j m_j/(s_j - r_k) / N_k,

N_k = sum_j s_j w_j/(s_j - r_k)^2 (partial fractions of the Laplace transform of w').
"""

from __future__ import annotations

from dataclasses import dataclass
from math import gamma

import numpy as np

from flatpunch._support.checks import Array, shown
from flatpunch.media.relaxation import PowerLawRelaxation, Prony, Relaxation, StandardLinearSolid


@dataclass(frozen=True, slots=True)
class ExponentialSeries:
    """psi(t) = constant + sum_j weights_j exp(-rates_j t).

    Attributes
    ----------
    constant : float
        [-].
    weights, rates : ndarray, shape (terms,)
        [-], [1/s]; rates ascending.
    """

    constant: float
    weights: Array
    rates: Array

    @property
    def initial(self) -> float:
        """psi(0)."""
        return self.constant + float(self.weights.sum())

    def __call__(self, t: Array) -> Array:
        """psi(t) at times of any shape."""
        return np.asarray(self.constant + np.exp(-np.asarray(t)[..., None] * self.rates) @ self.weights)


def exponential_series(relaxation: Relaxation, shortest: float, longest: float) -> ExponentialSeries:
    """Series of a relaxation function for histories with steps from `shortest` on that last `longest` [s]."""
    if isinstance(relaxation, StandardLinearSolid):
        relaxation = relaxation.prony
    if isinstance(relaxation, Prony):
        # terms of equal times are one
        rates, term = np.unique(1 / np.array(relaxation.times), return_inverse=True)
        return ExponentialSeries(
            relaxation.equilibrium, np.asarray(np.bincount(term, relaxation.weights), dtype=float), rates
        )
    if isinstance(relaxation, PowerLawRelaxation):
        return _power_series(relaxation, shortest, longest)
    raise TypeError(f"relaxation = {shown(relaxation)} must be a Prony, a StandardLinearSolid or a PowerLawRelaxation.")


def _power_series(law: PowerLawRelaxation, shortest: float, longest: float) -> ExponentialSeries:
    # h: the trapezoidal rule then errs by 2 |Gamma(alpha + 16.5 i)|/Gamma(alpha) < 1e-11
    alpha, h = law.exponent, 0.38
    # rates kept, over the inverse of the shortest step and of the whole history
    first, last = np.floor(np.log(1e-8 / longest) / h), np.ceil(np.log(1e4 / shortest) / h)
    u = h * np.arange(first, last + 1)
    scale = law.time**alpha * h / gamma(alpha)
    rates, weights = np.exp(u), scale * np.exp(alpha * u)
    # slower terms: geometric sums of w; faster ones: of w/s and w/s^2
    constant = scale * np.exp(alpha * (u[0] - h)) / -np.expm1(-alpha * h)
    area = scale * np.exp((alpha - 1) * (u[-1] + h)) / -np.expm1((alpha - 1) * h)
    moment = scale * np.exp((alpha - 2) * (u[-1] + h)) / -np.expm1((alpha - 2) * h)
    fast = area / moment
    # slow terms are parabolas to 1e-9 over the history: a constant and one term with the same three derivatives stand for them
    slow = rates * longest < 1e-3
    first, second = weights[slow] @ rates[slow], weights[slow] @ rates[slow] ** 2
    one = first**2 / second
    return ExponentialSeries(
        constant + float(weights[slow].sum()) - one,
        np.concatenate([[one], weights[~slow], [area * fast]]),
        np.concatenate([[second / first], rates[~slow], [fast]]),
    )


def mean_decay(z: Array) -> Array:
    """int_0^1 exp(-z (1 - x)) dx: the first of `moments`, at a tenth of their cost."""
    safe = np.where(z == 0, 1.0, z)
    return np.asarray(np.where(z == 0, 1.0, -np.expm1(-safe) / safe))


def moments(z: Array) -> Array:
    """int_0^1 x^p exp(-z (1 - x)) dx for p = 0, 1, 2; shape (3, *z.shape)."""
    result = np.empty((3, *z.shape))
    small = z < 0.5
    x = z[small]
    for p in range(3):
        # sum_k p! (-x)^k/(p + k + 1)!: fourteen terms leave 0.5^14/15! of the first
        term = np.full(x.shape, 1 / (p + 1))
        total = term.copy()
        for k in range(1, 14):
            term = -term * x / (p + k + 1)
            total += term
        result[p, small] = total
    x = z[~small]
    zero = -np.expm1(-x) / x
    one = (1 - zero) / x
    result[:, ~small] = zero, one, (1 - 2 * one) / x
    return result


def convolve(decay: Array, increments: Array, start: Array) -> Array:
    """Recursion y_n = decay_n y_(n-1) + increments_n from y_0 = start; shapes (steps, terms) -> (steps + 1, terms)."""
    result = np.empty((decay.shape[0] + 1, start.size))
    result[0] = current = start
    for n in range(decay.shape[0]):
        current = decay[n] * current + increments[n]
        result[n + 1] = current
    return result


@dataclass(frozen=True, slots=True)
class Recovery:
    """Modes of free recovery.

    Attributes
    ----------
    rates : ndarray, shape (terms,)
        r_k [1/s], ascending.
    shapes : ndarray, shape (modes, terms)
        1/(s_j - r_k): memory per amplitude.
    amplitudes : ndarray, shape (terms, modes)
        A_k per memory m_j.
    """

    rates: Array
    shapes: Array
    amplitudes: Array


def recovery(series: ExponentialSeries) -> Recovery:
    """Modes of a relaxation function."""
    s, w = series.rates, series.weights
    below = np.concatenate([[0.0], s[:-1]])
    gap = s - below
    middle = below + gap / 2
    # distances s_j - r_k are taken from the nearer pole, so that none is a difference of rounded numbers
    upper = _excess(series, s[:, None] - middle, middle) > 0
    anchor, sign = np.where(upper, s, below), np.where(upper, -1.0, 1.0)
    poles = s[:, None] - anchor
    # smallest distance of a root from its pole over the distance of two poles; closer ones carry weights of that size
    low, high = np.full(s.size, np.log(1e-30)), np.zeros(s.size)
    # halvings of the logarithm of a root's distance from its pole: they leave rounding
    for _ in range(60):
        x = (low + high) / 2
        move = sign * np.exp(x) * gap / 2
        # H falls with r: it is positive below the root
        outward = (_excess(series, poles - move, anchor + move) > 0) != upper
        low, high = np.where(outward, x, low), np.where(outward, high, x)
    move = sign * np.exp(high) * gap / 2
    if series.constant == 0:
        # a fluid does not recover all: its slowest mode stands still
        poles[:, 0], move[0], anchor[0] = s, 0.0, 0.0
    shapes = 1 / (poles - move)
    weighted = (s * w)[:, None] * shapes
    return Recovery(anchor + move, np.ascontiguousarray(shapes.T), weighted / np.sum(weighted * shapes, axis=0))


def _excess(series: ExponentialSeries, distance: Array, rate: Array) -> Array:
    """H(-r) at r = rate, shape (modes,), from the distances s_j - r, shape (terms, modes)."""
    return np.asarray(series.constant - rate * (series.weights @ (1 / distance)))
