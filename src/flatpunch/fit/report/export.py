"""What is made of a fit: a data set for a file, a problem of lmfit, its pull-off force, the error of its tables."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch._support.record import record
from flatpunch._version import __version__
from flatpunch.fit.elastic.model import method_for
from flatpunch.fit.parameters.scaling import OF, plain_limits
from flatpunch.fit.parameters.unknowns import NUISANCE
from flatpunch.fit.report.fitted import Fitted
from flatpunch.fit.report.quantities import unit_of
from flatpunch.fit.report.table import Estimate, half_width


def dataset_of(result: Fitted) -> xr.Dataset:
    """Curves, fitted forces and estimates; see `FitResult.dataset`."""
    results, points = result.results, [each.curve.depth.size for each in result.results]
    columns: dict[str, tuple[str, str, list[Any]]] = {
        "depth": ("m", "indentation depth", [r.depth for r in results]),
        "force": ("N", "measured force", [r.curve.force for r in results]),
        "fitted": ("N", "fitted force", [r.force for r in results]),
        "used": ("", "whether the point was fitted", [r.used for r in results]),
    }
    data: Plain = {
        name: ("point", np.concatenate(parts), {**({"units": unit} if unit else {}), "long_name": words})
        for name, (unit, words, parts) in columns.items()
    }
    if len(results) > 1:
        data["curve"] = (
            "point",
            np.repeat([r.curve.name for r in results], points),
            {"long_name": "name of the curve"},
        )
    for each in ("value", "stderr", "low", "high", "start"):
        data[each] = ("parameter", [getattr(e, each) for e in result.estimates.values()])
    data["correlation"] = (("parameter", "with"), result.correlation)
    names = list(result.estimates)
    each_sample = [_sample(r) for r in results]
    sample = {key: json.dumps([s[key] for s in each_sample]) for key in each_sample[0]}
    attributes = {
        "title": f"Fit of {', '.join(r.curve.name for r in results)}",
        "units": ", ".join(f"{name} [{unit_of(name)}]" for name in names),
        "noise": [r.noise for r in results] if len(results) > 1 else result.noise,
        "notes": "\n".join(dict.fromkeys(note for r in (result, *results) for note in r.notes)),
        "read": "\n".join(line for r in results for line in r.read),
        **(each_sample[0] if len(results) == 1 else sample),
        "flatpunch_version": __version__,
    }
    coordinates = {"point": np.arange(sum(points)), "parameter": names, "with": names}
    return xr.Dataset(data, coordinates, attributes)


def _sample(result: Fitted) -> dict[str, str | float]:
    """Sample and method of a curve as attributes of a file."""
    model = result.objective.model
    sample = model.sample_at(result.values)
    method = method_for(sample.indenter, model.method)
    found: dict[str, str | float] = {
        "method": method if isinstance(method, str) else method.name,
        "medium": json.dumps(record(sample.medium)),
        "indenter": json.dumps(record(sample.indenter)),
    }
    if sample.work_of_adhesion is not None:
        found["work_of_adhesion"] = sample.work_of_adhesion
    if sample.relaxation is not None:
        found["relaxation"] = json.dumps(record(sample.relaxation))
    return found


def lmfit_problem(result: Fitted) -> Any:
    """`lmfit.Minimizer` from the minimum that was found; see `FitResult.to_lmfit`."""
    try:
        import lmfit
    except ImportError:
        raise ValueError("to_lmfit needs lmfit: pip install 'flatpunch[fit]'.") from None
    parameters, names = lmfit.Parameters(), []
    for j, name in enumerate(result.names):
        bare = name.partition(OF)[0]
        logarithm = bare not in NUISANCE and plain_limits(name) is None
        names.append("log_" * logarithm + re.sub(r"\W+", "_", name).strip("_"))
        # lmfit's transformation of a limit has no slope at the limit: what is there stays there
        value, least, most = (float(v[j]) for v in (result.minimum.x, *result.problem.bounds))
        parameters.add(names[-1], value=value, min=least, max=most, vary=not result.minimum.at_bound[j])

    def residual(p: Any) -> Array:
        return np.asarray(result.problem.evaluate(np.array([p[name].value for name in names]))[0])

    return lmfit.Minimizer(residual, parameters)


def pull_off_force(result: Fitted) -> Estimate | None:
    """Largest tension of the contact [N]; see `FitResult.pull_off`.

    Where the force is smallest it does not change with the depth: its derivatives by the parameters are those at this depth.
    """
    model = result.objective.model
    if not model.adhesive:
        return None
    theta, count = result.minimum.x[: len(model.free)], len(model.free)
    ends, points = (model.pull_off(theta)[0], 0.0), 200
    # the grid once more between the neighbours of its smallest force
    for _ in range(2):
        depth = np.linspace(*ends, points)
        force, _, by_theta = model.evaluate(depth, theta)
        at = int(np.argmin(force))
        ends = float(depth[max(at - 1, 0)]), float(depth[min(at + 1, points - 1)])
    value, by = max(-float(force[at]), 0.0), by_theta[:, at]
    error = math.sqrt(max(float(by @ result.covariance[:count, :count] @ by), 0.0))
    reach = half_width(result.settings.level, result.freedom) * error
    return Estimate(value, error, max(value - reach, 0.0), value + reach)


def model_error(result: Fitted, points: int) -> float:
    """Largest difference between the tabulated model and the exact one, over the largest force."""
    deepest = float(result.depth.max())
    if deepest <= 0:
        return 0.0
    depth = deepest * np.geomspace(1e-2, 1, points)
    exact = result.objective.model.exact(depth, result.values)[0]
    return float(np.abs(result.objective.model.force(depth, result.values) - exact).max() / exact.max())
