"""Relaxation functions as sums of exponentials, so that convolutions cost one recursion per term.

psi(t) = constant + sum_j weight_j exp(-rate_j t). Prony series are that already. For a power law the integral
t^-alpha = (1/Gamma(alpha)) int exp(alpha u - t e^u) du is taken by the trapezoidal rule, whose relative error
2 |Gamma(alpha + 2 pi i/h)|/Gamma(alpha) is the same at all times. Terms much slower than the whole history are joined into a
constant and one term, terms faster than a step into one fast term with the same first two moments.
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
