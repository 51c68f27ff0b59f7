"""Euler's beta function of two numbers, without SciPy, which takes longer to load than a first contact to solve."""

from __future__ import annotations

from math import exp, gamma, lgamma


def beta(a: float, b: float) -> float:
    """B(a, b) = Gamma(a) Gamma(b)/Gamma(a + b) for a, b > 0; to a few roundings where Gamma(a + b) does not overflow."""
    try:
        return gamma(a) / gamma(a + b) * gamma(b)
    except OverflowError:
        return exp(lgamma(a) - lgamma(a + b) + lgamma(b))
