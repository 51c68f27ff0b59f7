"""Published thin-layer and substrate formulas against the exact contact, for one sample and tip."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from flatpunch._support.checks import Array, Values
from flatpunch._support.paths import Plain
from flatpunch._version import __version__
from flatpunch.contact import Method, MethodName, indent
from flatpunch.contact.curve import FEW_ANGLES
from flatpunch.files import Case
from flatpunch.files.units import text
from flatpunch.fit.half_space.formulas import Formula, formulas, half_space_model, half_space_models, layer_on_top
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Interface, Medium

if TYPE_CHECKING:
    import xarray as xr

WITHIN = (0.01, 0.05, 0.10)
"""Errors for which the range of a formula is given."""


def compare_formulas(
    medium: Body,
    indenter: Indenter,
    *,
    depth: Values | None = None,
    force: Values | None = None,
    radius: Values | None = None,
    method: MethodName | Method | None = None,
    finite_strain: Literal["neo-hookean"] | None = None,
) -> xr.Dataset:
    """Compare published formulas with the exact contact.

    Parameters
    ----------
    medium : Medium
        The sample: a homogeneous layer on top of others or of the base. Formulas are for one layer on a base; of a stack they
        see the layer at the surface and the base, and `remark` says so.
    indenter : Sphere, Paraboloid, Cone, Cylinder or Pyramid of four sides
        The tip.
    depth, force, radius : array_like
        Exactly one of them, as for `indent`: where they are compared [m], [N], [m].
    method : str or method, optional
        Contact method of the exact force, as for `indent`.
    finite_strain : {"neo-hookean"}, optional
        The exact force is corrected for large strains, as in `indent`.

    Returns
    -------
    xarray.Dataset
        Over `step`: depth [m], the exact force [N], `factor` [-], that force over the half-space formula's, and force_error [-].
        Over `formula` and `step`: formula_force [N] and `deviation` [-], the formula's force over the exact one less 1. Over
        `formula` and `limit`: `valid_to` [m], the largest depth at which the deviation is still within the limit. `remark` says
        what a formula was made for. First are the half-space formulas without a correction.

    Raises
    ------
    ValueError, TypeError
        On bad input, and for tips without a half-space formula.

    See Also
    --------
    correct : From a reported modulus to the true one.
    indent : The exact contact.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase())
    >>> found = fp.compare_formulas(gel, fp.Paraboloid(radius=5e-6), depth=[50e-9, 300e-9])
    >>> print(f"{float(found.deviation.sel(formula='Garcia')[-1]):.3f}")
    0.265
    """
    import xarray as xr

    medium, top = layer_on_top(medium)
    half_space_model(indenter)
    star = 1 / (1 - top.poisson**2)
    bare = [
        Formula(model.name.capitalize(), lambda d, young, model=model: young * star * model.force(d), "no correction")  # type: ignore[misc]
        for model in half_space_models(indenter).values()
    ]
    laws = [*bare, *_of_one_layer(medium, indenter)]
    given = {"depth": depth, "force": force, "radius": radius}
    control: Plain = {name: values for name, values in given.items() if values is not None}
    result = indent(medium, indenter, method=method, angles=FEW_ANGLES, finite_strain=finite_strain, **control)
    depths, exact = result["depth"].values, result["force"].values
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        forces = np.array([law.force(depths, top.young) for law in laws])
        deviation = forces / exact - 1
        factor = exact / forces[0]
    reach = np.array([[_valid_to(depths, line, limit) for limit in WITHIN] for line in deviation])
    over = ("formula", "step")
    error = {"force_error": result["force_error"]} if "force_error" in result else {}
    return xr.Dataset(
        {
            "depth": result["depth"],
            "force": result["force"],
            **error,
            "factor": ("step", factor, {"long_name": "force over that of the half-space formula"}),
            "formula_force": (over, forces, {"units": "N", "long_name": "force by the formula"}),
            "deviation": (over, deviation, {"long_name": "force by the formula over the exact force, less 1"}),
            "valid_to": (("formula", "limit"), reach, {"units": "m", "long_name": "largest depth within the limit"}),
            "remark": ("formula", np.array([law.remark for law in laws], dtype=object)),
        },
        {"formula": np.array([law.name for law in laws], dtype=object), "limit": np.array(WITHIN)},
        {
            "method": result.attrs["method"],
            "notes": str(result.attrs.get("notes", "")),
            "flatpunch_version": __version__,
        },
    )


def _of_one_layer(medium: Medium, indenter: Indenter) -> list[Formula]:
    """The formulas for the layer at the surface on the base, with a remark on what they do not see."""
    top = layer_on_top(medium)[1]
    rest = len(medium.layers) - 1
    unseen = [f"without the {rest} layers below" if rest > 1 else "without the layer below"] if rest else []
    if isinstance(top.bonded, Interface):
        top = replace(top, bonded=True)
        unseen.append("without springs")
    laws = formulas(Medium([top], medium.base), indenter)
    return [replace(law, remark="; ".join(filter(None, (*unseen, law.remark)))) for law in laws]


def compare_case(case: Case) -> xr.Dataset:
    """Compare the formulas at the steps of a case; ValueError for histories and adhesion, and as for `compare_formulas`."""
    if case.time is not None:
        raise ValueError("formulas are for elastic samples; give a [control] instead of a [history].")
    if case.work_of_adhesion is not None:
        raise ValueError("work_of_adhesion: formulas are compared without adhesion; leave it out.")
    given: Plain = {name: case.arguments.get(name) for name in (case.control, "method", "finite_strain")}
    return compare_formulas(case.medium, case.indenter, **given)


def _valid_to(depth: Array, deviation: Array, limit: float) -> float:
    """Largest depth at which the deviation is still within the limit; 0 if it never is."""
    order = np.argsort(depth, kind="stable")
    order = order[depth[order] > 0]
    within = np.logical_and.accumulate(np.abs(deviation[order]) <= limit)
    return float(depth[order][within].max(initial=0.0))


def comparison_rows(found: xr.Dataset) -> list[list[str]]:
    """Table of a comparison: name, deviation at the largest depth, largest depths at which it is within the limits, remark."""
    deepest, last = float(found["depth"].values.max()), int(np.argmax(found["depth"].values))

    def reach(end: float) -> str:
        return "all depths" if end == deepest else text(end, "m") if end > 0 else "none"

    def percent(value: float) -> str:
        return f"{100 * value:+{'.2f' if abs(value) < 0.1 else '.3g'}} %" if math.isfinite(value) else "-"

    columns = (found[name].values for name in ("formula", "deviation", "valid_to", "remark"))
    return [
        [str(name), percent(float(off[last])), *map(reach, map(float, ends)), str(remark)]
        for name, off, ends, remark in zip(*columns, strict=True)
    ]


def comparison_columns(found: xr.Dataset) -> list[str]:
    """Headings of `comparison_rows`."""
    deepest = text(float(found["depth"].values.max()), "m")
    return ["formula", f"error at {deepest}", *(f"within {100 * limit:g} % up to" for limit in WITHIN), "remark"]


def comparison_csv(found: xr.Dataset) -> str:
    """Comparison as CSV: a line for each step, the exact force, and force and deviation by each formula."""
    import pandas as pd

    columns = {"depth [m]": found["depth"].values, "force [N]": found["force"].values}
    for one in (found.isel(formula=i) for i in range(found.sizes["formula"])):
        columns[f"{one['formula'].item()} [N]"] = one["formula_force"].values
        columns[f"{one['formula'].item()} deviation [-]"] = one["deviation"].values
    return str(pd.DataFrame(columns).to_csv(index=False, na_rep="nan", lineterminator="\n"))
