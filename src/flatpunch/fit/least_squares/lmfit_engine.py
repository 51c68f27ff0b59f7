"""lmfit at the end of a single fit: the same problem as `lmfit.Parameters`, for everything that lmfit can do with it.

Parameters appear under their internal form, as in log_layers_0_young (natural logarithm of the value in SI), poisson ratios
as they are, contact, baseline and tilt in units of the curve's ranges.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.least_squares.minimum import Minimum
from flatpunch.fit.parameters.scaling import plain_limits
from flatpunch.fit.parameters.unknowns import NUISANCE


def lmfit_name(name: str) -> str:
    """Name of a parameter as lmfit wants it: letters, digits and underscores."""
    plain = re.sub(r"\W+", "_", name).strip("_")
    logarithm = name not in NUISANCE and plain_limits(name) is None
    return f"log_{plain}" if logarithm else plain


def polish(objective: Any, found: Minimum, lower: Array, upper: Array, loss: str) -> tuple[Any, Minimum]:
    """Run lmfit from the minimum found; returns its result and the minimum it ended at.

    Raises
    ------
    ValueError
        If lmfit is not installed.
    """
    try:
        import lmfit
    except ImportError:
        raise ValueError(
            "fit needs lmfit: pip install 'flatpunch[fit]', or choose engine='normal-equations', which does without."
        ) from None
    names = [lmfit_name(name) for name in objective.names]
    parameters = lmfit.Parameters()
    for j, name in enumerate(names):
        # lmfit's transformation of a limit has no slope at the limit: what sits there stays there
        parameters.add(
            name, value=float(found.x[j]), min=float(lower[j]), max=float(upper[j]), vary=not bool(found.at_bound[j])
        )
    varied = np.flatnonzero(~found.at_bound)
    if not varied.size:
        return None, found

    def vector(p: Any) -> Array:
        return np.array([p[name].value for name in names])

    last: dict[bytes, tuple[Array, Array]] = {}

    def both(p: Any) -> tuple[Array, Array]:
        x = vector(p)
        key = x.tobytes()
        if key not in last:
            last.clear()
            last[key] = objective.evaluate(x)
        return last[key]

    if loss == "linear":
        problem = lmfit.Minimizer(lambda p: both(p)[0], parameters, Dfun=lambda p: both(p)[1][varied], col_deriv=1)
        result = problem.leastsq(max_nfev=200)
    else:
        from flatpunch.fit.least_squares.robust import robust_scale

        scale = robust_scale(found.residual)
        problem = lmfit.Minimizer(lambda p: both(p)[0] / scale, parameters, scale_covar=False)
        result = problem.least_squares(loss=loss, jac=lambda p: both(p)[1][varied].T / scale)
    x = vector(result.params)
    residual, jacobian = objective.evaluate(x)
    return result, Minimum(
        x, residual, jacobian @ jacobian.T, True, found.at_bound, found.evaluations + int(result.nfev)
    )
