"""Published formulas: which apply to a sample and a tip, the force by each of them, and how far it is from the exact contact."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from flatpunch._support.checks import Array, BadValue, Values, one_of
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table
from flatpunch._version import __version__
from flatpunch.contact import Method, MethodName, indent
from flatpunch.contact.curve import FEW_ANGLES
from flatpunch.files import Case
from flatpunch.fits.half_space import published
from flatpunch.fits.report.table import csv_of
from flatpunch.indenters import Cone, Paraboloid, Pyramid, Sphere
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import AnyLayer, Body, Layer, Medium, Stack, underlying
from flatpunch.media.material import young_and_poisson

if TYPE_CHECKING:
    import xarray as xr

WITHIN = (0.01, 0.05, 0.10)
"""Errors for which the range of a formula is given."""
Force = Callable[[Array], Array]
"""Force [N] at depths [m] on a half-space with E* = 1 Pa."""
Equivalent = Callable[[Array, float], Array]

OLIVER_PHARR = "oliver-pharr"
"""Name of the evaluation by stiffness and contact area, which goes with every tip."""


class Shape(NamedTuple):
    """What half-space formulas know of a tip.

    `kind` is "paraboloid", "flat", "cone" or "pyramid", `width` the radius of the contact on a half-space, or for cones and
    pyramids the half-width of the tip, over the depth [m], `models` the formulas in use, the usual one first, and `radius` that
    of a paraboloid [m].
    """

    kind: str
    width: Force
    models: dict[str, Force]
    radius: float = 0.0


def shape_of(indenter: Indenter) -> Shape | None:
    """What half-space formulas know of a tip; None for most tips, for which none is in use."""
    models: dict[str, Force]
    if isinstance(indenter, (Sphere, Paraboloid)):
        radius = indenter.radius
        models = {"hertz": lambda d: 4 / 3 * math.sqrt(radius) * d ** (3 / 2)}
        return Shape("paraboloid", lambda d: np.sqrt(radius * d), models, radius)
    if indenter.flat:
        return Shape("flat", lambda d: np.full_like(d, indenter.reach), {"flat": lambda d: 2 * indenter.reach * d})
    if not isinstance(indenter, (Cone, Pyramid)):
        return None
    # tan(alpha), alpha the half opening angle
    slope = 1 / math.tan(indenter.inclination)
    if isinstance(indenter, Cone):
        return Shape("cone", lambda d: d * slope, {"sneddon": lambda d: 2 / math.pi * slope * d**2})
    if indenter.sides != 4:
        return None
    models = {
        "bilodeau": lambda d: 0.7453 * slope * d**2,
        "rico": lambda d: slope / math.sqrt(2) * d**2,
    }
    return Shape("pyramid", lambda d: d * slope, models)


def half_space_model(indenter: Indenter, name: str | None = None) -> Force:
    """One of the half-space formulas for a tip, the first that fits it if no name is given.

    Names are "hertz", "sneddon", "flat", and for pyramids "bilodeau" (0.7453 E* tan(alpha) d^2, alpha the face's half opening
    angle) or "rico" (1/sqrt(2) instead of 0.7453).
    """
    check_indenter(indenter)
    if (shape := shape_of(indenter)) is None:
        raise ValueError(
            f"indenter = {type(indenter).__name__}: no half-space formula is in use for it; there are those for Sphere, "
            "Paraboloid, Cone, Cylinder and Pyramid(sides=4)."
        )
    name = next(iter(shape.models)) if name is None else name
    return shape.models[one_of("model", name, shape.models, wrong=f"does not belong to a {type(indenter).__name__}")]


@dataclass(frozen=True, slots=True)
class Formula:
    """A published formula for one sample and tip.

    Parameters
    ----------
    name : str
        By its authors.
    force : callable
        (depths [m], Young's modulus of the layer [Pa]) -> forces [N].
    remark : str
        What the formula was made for, where the sample differs.
    """

    name: str
    force: Callable[[Array, float], Array]
    remark: str = ""


def layer_on_top(medium: Body) -> tuple[Stack, AnyLayer]:
    """Return the sample and the homogeneous layer at its surface, whose modulus formulas give; ValueError without one."""
    stack = underlying(medium).single
    if not stack or not stack.layers or not stack.layers[0].isotropic:
        raise BadValue("layers[0]", "", "must be a homogeneous layer on top of a Medium: its modulus is looked for.")
    return stack, stack.layers[0]


def formulas(medium: Stack, indenter: Indenter) -> list[Formula]:
    """Return the published formulas for one layer on a base and a tip with a half-space model; none for more layers.

    Formulas for thin layers are factors on the half-space force; those for films on substrates are equivalent moduli at the
    contact radius of the half-space, as they are used.
    """
    top, base, tip, shape = layer_on_top(medium)[1], medium.base, half_space_model(indenter), shape_of(indenter)
    if len(medium.layers) != 1 or top.bonded not in (True, False) or shape is None:
        return []
    nu, h, bonded = young_and_poisson(top)[1], top.thickness, bool(top.bonded)
    star, radius, pyramid = 1 / (1 - nu**2), shape.radius, shape.kind == "pyramid"
    kind = "cone" if pyramid else shape.kind
    found: list[Formula] = []

    def x(d: Array) -> Array:
        return shape.width(d) / h

    def add(name: str, of: Callable[[Array], Array], *made_for: str) -> None:
        """A factor on the half-space force."""
        rigid = "" if base.rigid else "for a rigid base"
        remark = "; ".join(filter(None, (*made_for, rigid)))
        found.append(Formula(name, lambda d, young: young * star * tip(d) * of(d), remark))

    half = "" if nu == 0.5 else "for nu = 0.5"
    if radius:
        add("Dimitriadis", lambda d: published.dimitriadis(x(d), nu, bonded))
    if bonded:
        add("Garcia", lambda d: published.garcia(x(d), kind), "for cones" if pyramid else "", half)
    if bonded and radius:
        if published.LONG[0] <= radius / h < published.LONG[1]:
            add("Long", lambda d: published.long(x(d), radius / h), "for large strains", half)
        thin = "for bonded incompressible layers much thinner than the contact"
        found.append(Formula("Chadwick", lambda d, young: published.chadwick(radius, d, young, h), thin))
    if pyramid:
        ours = published.PYRAMID_FORCE[4] * float(shape.width(np.ones(1))[0] / tip(np.ones(1))[0])
        add("flatpunch", lambda d: ours * published.pyramid(x(d), 4, bonded), "of this project", half)
    if base.isotropic:
        narrow = 2 / math.pi if kind == "cone" else 1.0
        laws = equivalents(medium)
        if radius:
            substrate, ratio = base.surface_modulus, young_and_poisson(base)[1]
            laws["Clifford"] = lambda a, film: published.clifford(a, film, nu, substrate, ratio)
        for name, law in laws.items():

            def force(d: Array, young: float, law: Equivalent = law) -> Array:
                return tip(d) * law(narrow * x(d), young * star)

            found.append(Formula(name, force, MADE_FOR.get(name, "")))
    return found


MADE_FOR = {"Gao": "for bodies of similar stiffness", "Perriot-Barthel": "for moduli that differ by up to 100 times"}
"""Films and substrates for which formulas were made."""


def equivalents(film: Stack) -> dict[str, Equivalent]:
    """Equivalent plane-strain moduli of one film on a half-space by published formulas.

    Each is a function of contact radius over thickness and of the film's plane-strain modulus [Pa].
    """
    nu, substrate = young_and_poisson(layer_on_top(film)[1])[1], film.base.surface_modulus
    return {
        "Gao": lambda x, e: published.gao(x, e, substrate, nu),
        "Perriot-Barthel": lambda x, e: published.perriot_barthel(x, e, substrate),
        "Bec": lambda x, e: published.bec(x, e, substrate),
    }


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

    check_indenter(indenter)
    medium, top = layer_on_top(medium)
    young, poisson = young_and_poisson(top)
    star = 1 / (1 - poisson**2)

    def alone(model: Force) -> Callable[[Array, float], Array]:
        return lambda d, young: young * star * model(d)

    shape = shape_of(indenter)
    models = {} if shape is None else shape.models
    laws = [Formula(name.capitalize(), alone(model), "no correction") for name, model in models.items()]
    laws += _of_one_layer(medium, indenter)
    given = {"depth": depth, "force": force, "radius": radius}
    control: Plain = {name: values for name, values in given.items() if values is not None}
    result = indent(medium, indenter, method=method, angles=FEW_ANGLES, finite_strain=finite_strain, **control)
    depths, exact = result["depth"].values, result["force"].values
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        forces = np.array([law.force(depths, young) for law in laws])
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


def _of_one_layer(medium: Stack, indenter: Indenter) -> list[Formula]:
    """The formulas for the layer at the surface on the base, with a remark on what they do not see."""
    top = layer_on_top(medium)[1]
    rest = len(medium.layers) - 1
    unseen = [f"without the {rest} layers below" if rest > 1 else "without the layer below"] if rest else []
    if top.bonded not in (True, False):
        top = Layer(*young_and_poisson(top), top.thickness)
        unseen.append("without springs")
    laws = formulas(Medium([top], medium.base), indenter)
    return [replace(law, remark="; ".join(filter(None, (*unseen, law.remark)))) for law in laws]


def compare_case(case: Case) -> xr.Dataset:
    """Compare the formulas at the steps of a case; ValueError for histories and adhesion, and as for `compare_formulas`."""
    if case.time is not None:
        raise ValueError("formulas are for elastic samples; give a [control] instead of a [history].")
    if case.physics.work_of_adhesion is not None:
        raise ValueError("work_of_adhesion: formulas are compared without adhesion; leave it out.")
    given: Plain = {name: case.arguments.get(name) for name in (case.control, "method", "finite_strain")}
    return compare_formulas(case.medium, case.indenter, **given)


def _valid_to(depth: Array, deviation: Array, limit: float) -> float:
    """Largest depth at which the deviation is still within the limit; 0 if it never is."""
    order = np.argsort(depth, kind="stable")
    order = order[depth[order] > 0]
    within = np.logical_and.accumulate(np.abs(deviation[order]) <= limit)
    return float(depth[order][within].max(initial=0.0))


def comparison_table(found: xr.Dataset) -> Table:
    """Name, deviation at the largest depth, largest depths at which it is within the limits, and remark of each formula."""
    deepest, last = float(found["depth"].values.max()), int(np.argmax(found["depth"].values))

    def reach(end: float) -> str:
        return "all depths" if end == deepest else text(end, "m") if end > 0 else "none"

    def percent(value: float) -> str:
        return f"{100 * value:+{'.2f' if abs(value) < 0.1 else '.3g'}} %" if math.isfinite(value) else "-"

    columns = (found[name].values for name in ("formula", "deviation", "valid_to", "remark"))
    rows = tuple(
        (str(name), percent(float(off[last])), *map(reach, map(float, ends)), str(remark))
        for name, off, ends, remark in zip(*columns, strict=True)
    )
    within = (f"within {100 * limit:g} % up to" for limit in WITHIN)
    header = ("formula", f"error at {text(deepest, 'm')}", *within, "remark")
    return Table(f"exact force: {found.attrs['method']}", header, rows, tuple(found.attrs["notes"].splitlines()))


def comparison_csv(found: xr.Dataset) -> str:
    """Comparison as CSV: a line for each step, the exact force, and force and deviation by each formula."""
    columns, units = {"depth": found["depth"].values, "force": found["force"].values}, {"depth": "m", "force": "N"}
    for name, force, off in zip(*(found[n].values for n in ("formula", "formula_force", "deviation")), strict=True):
        columns |= {str(name): force, f"{name} deviation": off}
        units |= {str(name): "N", f"{name} deviation": "-"}
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return csv_of([dict(zip(columns, row, strict=True)) for row in rows], units)
