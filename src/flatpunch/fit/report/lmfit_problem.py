"""A fit as a problem of lmfit, for everything that lmfit can do with it.

Parameters appear under their internal form, as in log_layers_0_young (natural logarithm of the value in SI), Poisson ratios
as they are, contact, baseline and tilt in units of the curve's ranges.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.least_squares.minimum import Minimum
from flatpunch.fit.parameters.scaling import plain_limits
from flatpunch.fit.parameters.unknowns import NUISANCE, Unknowns


def lmfit_name(name: str) -> str:
    """Name of a parameter as lmfit wants it: letters, digits and underscores."""
    plain = re.sub(r"\W+", "_", name).strip("_")
    logarithm = name not in NUISANCE and plain_limits(name) is None
    return f"log_{plain}" if logarithm else plain


def lmfit_problem(objective: Unknowns, found: Minimum, lower: Array, upper: Array) -> Any:
    """`lmfit.Minimizer` of residuals in units of the curve's force range, from the minimum found; ValueError without lmfit."""
    try:
        import lmfit
    except ImportError:
        raise ValueError("to_lmfit needs lmfit: pip install 'flatpunch[fit]'.") from None
    names = [lmfit_name(name) for name in objective.names]
    parameters = lmfit.Parameters()
    for name, *numbers, held in zip(names, found.x, lower, upper, found.at_bound, strict=True):
        # lmfit's transformation of a limit has no slope at the limit: what is there stays there
        value, least, most = map(float, numbers)
        parameters.add(name, value=value, min=least, max=most, vary=not held)

    def residual(p: Any) -> Array:
        return np.asarray(objective.evaluate(np.array([p[name].value for name in names]))[0])

    return lmfit.Minimizer(residual, parameters)
