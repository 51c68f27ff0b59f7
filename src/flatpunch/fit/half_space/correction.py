"""From a half-space modulus that somebody's software reported to the true modulus of the layer.

The software fitted F = c E* d^n to a curve that a layer on a base produced. Which layer gives that E*? Either at the one depth
d, or by least squares over the curve up to d, contact point known (both are offered; most software does the second). Beside it
stand the moduli that published corrections would give for the same reported value. Moduli after Oliver and Pharr follow from the
stiffness of the contact (`contact_area`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.optimize import brentq

from flatpunch._support.checks import ROUNDING, Array, poisson_ratio, positive
from flatpunch._support.kinds import one_of
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.half_space.contact_area import apparent_modulus, area_laws, remark, section_radius
from flatpunch.fit.half_space.formulas import (
    OLIVER_PHARR,
    Formula,
    formulas,
    half_space_model,
    has_half_space_model,
    layer_on_top,
)
from flatpunch.fit.parameters.scaling import replaced
from flatpunch.fit.parameters.settings import FitMethod
from flatpunch.fit.report.quantities import quantity
from flatpunch.fit.report.table import csv_of
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, Medium

if TYPE_CHECKING:
    import xarray as xr

Over = Literal["curve", "depth"]

_POINTS = 200
"""Evenly spaced depths of the curve that the software fitted; twice as many move the modulus by 0.1 %."""

_NO_FILM = "no film modulus gives the reported value"

_WIDEST = math.log(1e6)
"""Largest ratio of the layer's modulus to the reported one, either way, as its logarithm."""


@readable
@dataclass(frozen=True)
class Correction:
    """Corrected modulus.

    Attributes
    ----------
    young : float
        True Young's modulus of the layer [Pa].
    reported : float
        What was put in [Pa].
    factor : float
        Reported over true.
    others : dict
        Young's modulus [Pa] by published corrections; nan where a formula does not apply, with the reason in `why`.
    why : dict
        Remarks on them.
    sensitivity : float
        d ln(true)/d ln(reported): 1 without a base; large where the base carries the load and the answer hangs on the report.
    over : str
    notes : tuple of str
        Limits of the contact theory at this depth.
    depth, apparent : ndarray
        Depths up to that of the fit [m], and Young's modulus that the half-space formula gives at each of them for the true layer
        [Pa].

    See Also
    --------
    flatpunch.correct : Makes it.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> found = fp.correct(8e3, gel, fp.Sphere(radius=5e-6), depth=500e-9)
    >>> print(f"{found.young / 1e3:.2f} kPa, {found.factor:.2f} times too high as reported")
    2.63 kPa, 3.04 times too high as reported
    """

    young: float
    reported: float
    factor: float
    others: dict[str, float]
    why: dict[str, str]
    sensitivity: float
    over: str
    notes: tuple[str, ...] = ()
    depth: Array = field(default_factory=lambda: np.zeros(0), repr=False, compare=False)
    apparent: Array = field(default_factory=lambda: np.zeros(0), repr=False, compare=False)

    def rows(self) -> list[tuple[str, float, str]]:
        """Name, Young's modulus [Pa] and remark: the exact contact first, then the published corrections."""
        return [("exact", self.young, ""), *((n, value, self.why.get(n, "")) for n, value in self.others.items())]

    def to_csv(self) -> str:
        """Return the moduli as CSV, a line for the exact contact and for each published correction."""
        names = ("formula", "young", "deviation", "remark")
        rows = [(name, young, young / self.young - 1, remark) for name, young, remark in self.rows()]
        return csv_of([dict(zip(names, row, strict=True)) for row in rows], {"deviation": "-"})

    def dataset(self) -> xr.Dataset:
        """Return the result as a dataset: moduli by `formula`, the exact contact first, and the apparent modulus by `depth`."""
        import xarray as xr

        names, moduli, remarks = zip(*self.rows(), strict=True)
        pascal = {"units": "Pa"}
        return xr.Dataset(
            {
                "young": ("formula", np.array(moduli), pascal | {"long_name": "Young's modulus of the layer"}),
                "remark": ("formula", np.array(remarks, dtype=object)),
                "apparent": ("depth", self.apparent, pascal | {"long_name": "modulus of the half-space formula"}),
            },
            {"formula": np.array(names, dtype=object), "depth": ("depth", self.depth, {"units": "m"})},
            {
                "reported": self.reported,
                "over": self.over,
                "sensitivity": self.sensitivity,
                "notes": "\n".join(self.notes),
                "flatpunch_version": __version__,
            },
        )

    def summary(self) -> str:
        """The result in words."""
        lines = [
            f"Reported {quantity(self.reported, 'Pa')} -> layer {quantity(self.young, 'Pa')}  (reported is {self.factor:.3f} of "
            f"it; 1 % in the report is {self.sensitivity:.1f} % in the layer)"
        ]
        for name, value in self.others.items():
            shown = (
                f"{quantity(value, 'Pa'):>12}  {100 * (value / self.young - 1):+6.1f} %"
                if np.isfinite(value)
                else f"{'-':>12}"
            )
            lines.append(f"  {name:<18} {shown}  {self.why.get(name, '')}".rstrip())
        return "\n".join([*lines, *(f"  Note: {note}" for note in self.notes)])


@one_blas_thread()
def correct(
    reported: float,
    medium: Body,
    indenter: Indenter,
    depth: float,
    *,
    model: str | None = None,
    reported_poisson: float | None = None,
    over: Over = "curve",
    method: FitMethod = "auto",
) -> Correction:
    """Return the layer modulus behind a reported half-space modulus.

    Parameters
    ----------
    reported : float
        Young's modulus that was reported [Pa].
    medium : Medium
        Layers and base; the young of the top layer is what is looked for, its value there only a start.
    indenter : object
        The tip.
    depth : float
        Depth of the fit [m]; for "oliver-pharr" the contact depth.
    model : str, optional
        Half-space formula of the software, see `half_space_model`, or "oliver-pharr": the modulus followed from the stiffness at
        the beginning of unloading and the area of the tip at the contact depth. That is taken for tips without a formula, such as
        Berkovich's and area functions; `over` is "depth" then.
    reported_poisson : float, optional
        Poisson ratio that the software used; that of the layer if left out.
    over : "curve" or "depth"
        Whether the software fitted the curve from 0 to the depth by least squares, or used the force at the depth.
    method : str or method
        Contact method, or "auto".

    Returns
    -------
    Correction

    Raises
    ------
    ValueError
        On bad input, or if no modulus of the layer gives the reported value (the base alone is softer or stiffer).

    See Also
    --------
    fit : From the curve itself.
    fit.Correction : What it returns.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase())
    >>> found = fp.correct(8e3, gel, fp.Sphere(radius=5e-6), 300e-9)
    >>> print(f"{found.young / 1e3:.2f} kPa")
    1.38 kPa
    """
    reported, depth = positive("reported", reported, unit="Pa"), positive("depth", depth, unit="m")
    check_indenter(indenter)
    medium, top = layer_on_top(medium)
    one_of("over", over, ("curve", "depth"))
    nu = poisson_ratio("reported_poisson", reported_poisson) if reported_poisson is not None else top.poisson
    if (isinstance(model, str) and model == OLIVER_PHARR) or (model is None and not has_half_space_model(indenter)):
        return _by_area(reported, medium, indenter, depth, nu)
    formula = half_space_model(indenter, model)
    grid = depth * (np.arange(1, _POINTS + 1) / _POINTS if over == "curve" else np.ones(1))
    target = reported / (1 - nu**2)
    weight = formula.force(grid)
    weight = weight / float(weight @ weight)
    start, _ = replaced(medium, None, {"layers[0].young": reported})
    exact = ForwardModel(start, indenter, ("layers[0].young",), method)

    def seen(young: float) -> float:
        """Plane-strain modulus that the software reports for a layer of this modulus."""
        return float(weight @ exact.force(grid, {"layers[0].young": young}))

    young = _solved(seen, target, reported)
    others, why = _others(medium, indenter, grid, weight, target)
    notes = tuple(exact.exact(grid[-1:], {"layers[0].young": young})[1].splitlines())
    along = depth * np.arange(1, _POINTS + 1) / _POINTS
    apparent = exact.force(along, {"layers[0].young": young}) / formula.force(along) * (1 - nu**2)
    sensitivity = _sensitivity(seen, young)
    return Correction(young, reported, reported / young, others, why, sensitivity, over, notes, along, apparent)


def _by_area(reported: float, medium: Medium, indenter: Indenter, depth: float, nu: float) -> Correction:
    """The layer behind a modulus after Oliver and Pharr at a contact depth."""
    along = depth * np.arange(1, _POINTS + 1) / _POINTS
    radius = section_radius(indenter, along)
    at, target = radius[-1:], reported / (1 - nu**2)

    def seen(young: float) -> float:
        return float(apparent_modulus(medium, young, at)[0])

    young = _solved(seen, target, reported)
    others, why = {}, {}
    for name, law in area_laws(medium, float(at[0])).items():
        try:
            others[name] = _solved(law, target, reported)
        except ValueError:
            others[name], why[name] = math.nan, _NO_FILM
    apparent = apparent_modulus(medium, young, radius) * (1 - nu**2)
    notes = (remark(float(at[0])),)
    return Correction(
        young, reported, reported / young, others, why, _sensitivity(seen, young), "depth", notes, along, apparent
    )


def _sensitivity(seen: Callable[[float], float], young: float) -> float:
    """d ln(true)/d ln(reported)."""
    step = 1e-4
    growth = (math.log(seen(young * (1 + step))) - math.log(seen(young * (1 - step)))) / (2 * step)
    return 1 / growth if growth > 0 else math.inf


def _solved(seen: Callable[[float], float], target: float, guess: float) -> float:
    """Root of seen(E) = target over E, in logarithms, bracketed step by step."""
    low = high = math.log(guess)

    def miss(x: float) -> float:
        return math.log(seen(math.exp(x)) / target)

    while miss(high) < 0 and high < math.log(guess) + _WIDEST:
        high += math.log(2)
    while miss(low) > 0 and low > math.log(guess) - _WIDEST:
        low -= math.log(2)
    if miss(low) * miss(high) > 0:
        bounds = [seen(math.exp(x)) for x in (low, high)]
        raise ValueError(
            f"no modulus of the layer gives the reported value: between {math.exp(low):.3g} and {math.exp(high):.3g} Pa the "
            f"software would report plane-strain moduli of {min(bounds):.3g} to {max(bounds):.3g} Pa, not {target:.3g}. Base, "
            "thickness and depth do not go together with it."
        )
    return math.exp(brentq(miss, low, high, xtol=ROUNDING)) if low < high else math.exp(low)


def _others(
    medium: Medium, indenter: Indenter, grid: Array, weight: Array, target: float
) -> tuple[dict[str, float], dict[str, str]]:
    """Published corrections, each inverted for the same reported modulus."""
    results: dict[str, float] = {}
    why: dict[str, str] = {}
    for formula in formulas(medium, indenter):

        def seen(young: float, formula: Formula = formula) -> float:
            return float(weight @ formula.force(grid, young))

        try:
            results[formula.name] = target / seen(1.0) if formula.linear else _solved(seen, target, target)
        except ValueError:
            results[formula.name] = math.nan
        if formula.remark:
            why[formula.name] = formula.remark
        if not math.isfinite(results[formula.name]):
            why[formula.name] = "the depth is outside its range" if formula.linear else _NO_FILM
    return results, why
