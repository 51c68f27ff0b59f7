"""Free recovery of a viscoelastic spring: the modes in which it moves while it carries no force.

A spring of unit stiffness with the deflection w carries Q = int psi(t - t') w'(t') dt'. With a sum of exponentials,
psi = constant + sum_j w_j exp(-s_j t), its state is the memory m_j = int exp(-s_j (t - t')) w'(t') dt'. While Q = 0 the speed w'
is a sum of exponentials exp(-r_k t) whose rates are the zeros of

    H(-r) = constant - r sum_j w_j/(s_j - r),

one below each s_j and above the one before, and

    m_j = sum_k A_k exp(-r_k t)/(s_j - r_k),      w' = sum_k A_k exp(-r_k t),      A_k = sum_j s_j w_j m_j/(s_j - r_k) / N_k,

N_k = sum_j s_j w_j/(s_j - r_k)^2 (partial fractions of the Laplace transform of w').
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.contact.viscoelastic.series import ExponentialSeries


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
