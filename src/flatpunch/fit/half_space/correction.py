"""From a half-space modulus that somebody's software reported to the true modulus of the layer.

The software fitted F = c E* d^n to a curve that a layer on a base produced. Which layer gives that E*? Either at the one depth
d, or by least squares over the curve up to d, contact point known (both are offered; most software does the second). Beside it
stand the moduli that published corrections would give for the same reported value.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.optimize import brentq

from flatpunch._support.checks import Array, poisson_ratio, positive
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.half_space import published
from flatpunch.fit.parameters.scaling import replaced
from flatpunch.fit.parameters.settings import FitMethod
from flatpunch.fit.report.quantities import quantity
from flatpunch.indenters import Cone, Cylinder, Paraboloid, Pyramid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase

Over = Literal["curve", "depth"]

_POINTS = 200
_WIDEST = math.log(1e6)


@dataclass(frozen=True, slots=True)
class Reported:
    """Half-space model of the software: F = factor E* d^exponent.

    Parameters
    ----------
    name : str
        What it is called.
    factor : float
        [m^(2 - exponent)].
    exponent : float
    """

    name: str
    factor: float
    exponent: float

    def force(self, depth: Array) -> Array:
        """Force for E* = 1 Pa."""
        return np.asarray(self.factor * depth**self.exponent)


def half_space_model(indenter: Any, name: str | None = None) -> Reported:
    """The usual half-space formula for a tip.

    Parameters
    ----------
    indenter : Sphere, Paraboloid, Cone, Cylinder or Pyramid of four sides
        The tip.
    name : str, optional
        "hertz", "sneddon", "flat", and for pyramids "bilodeau" (0.7453 E* tan(alpha) d^2, alpha the face's half opening angle) or
        "rico" (1/sqrt(2) instead of 0.7453). The first that fits the tip if left out.
    """
    if isinstance(indenter, (Sphere, Paraboloid)):
        found = {"hertz": Reported("hertz", 4 / 3 * math.sqrt(indenter.radius), 1.5)}
    elif isinstance(indenter, Cone):
        found = {"sneddon": Reported("sneddon", 2 / (math.pi * math.tan(indenter.inclination)), 2.0)}
    elif isinstance(indenter, Cylinder):
        found = {"flat": Reported("flat", 2 * indenter.radius, 1.0)}
    elif isinstance(indenter, Pyramid) and indenter.sides == 4:
        slope = 1 / math.tan(indenter.inclination)
        found = {
            "bilodeau": Reported("bilodeau", 0.7453 * slope, 2.0),
            "rico": Reported("rico", slope / math.sqrt(2), 2.0),
        }
    else:
        raise ValueError(
            f"indenter = {type(indenter).__name__}: no half-space formula is in use for it; there are those for Sphere, "
            "Paraboloid, Cone, Cylinder and Pyramid(sides=4)."
        )
    if name is None:
        return next(iter(found.values()))
    if name not in found:
        raise ValueError(
            f"model = {name!r} does not belong to a {type(indenter).__name__}; choose {', '.join(map(repr, found))}."
        )
    return found[name]


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
    medium: Medium,
    indenter: Any,
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
        Depth of the fit [m].
    model : str, optional
        Half-space formula of the software, see `half_space_model`.
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
    if not isinstance(medium, Medium) or not medium.layers or not isinstance(medium.layers[0], Layer):
        raise TypeError("medium must be a Medium with a homogeneous layer on top: its modulus is looked for.")
    if over not in ("curve", "depth"):
        raise ValueError(f"over = {over!r} must be 'curve' or 'depth'.")
    top = medium.layers[0]
    nu = poisson_ratio("reported_poisson", reported_poisson) if reported_poisson is not None else top.poisson
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
    step = 1e-4
    growth = (math.log(seen(young * (1 + step))) - math.log(seen(young * (1 - step)))) / (2 * step)
    others, why = _others(medium, indenter, grid, weight, target, top)
    notes = tuple(exact.exact(grid[-1:], {"layers[0].young": young})[1].splitlines())
    return Correction(
        young, reported, reported / young, others, why, 1 / growth if growth > 0 else math.inf, over, notes
    )


def _solved(seen: Callable[[float], float], target: float, guess: float) -> float:
    """Root of seen(E) = target over E, in logarithms, bracketed step by step."""
    low = high = math.log(guess)

    def miss(x: float) -> float:
        return math.log(seen(math.exp(x)) / target)

    while miss(high) < 0 and high < math.log(guess) + _WIDEST:
        high += 0.7
    while miss(low) > 0 and low > math.log(guess) - _WIDEST:
        low -= 0.7
    if miss(low) * miss(high) > 0:
        bounds = [seen(math.exp(x)) for x in (low, high)]
        raise ValueError(
            f"no modulus of the layer gives the reported value: between {math.exp(low):.3g} and {math.exp(high):.3g} Pa the "
            f"software would report plane-strain moduli of {min(bounds):.3g} to {max(bounds):.3g} Pa, not {target:.3g}. Base, "
            "thickness and depth do not go together with it."
        )
    return math.exp(brentq(miss, low, high, xtol=1e-12)) if low < high else math.exp(low)


def _others(
    medium: Medium, indenter: Any, grid: Array, weight: Array, target: float, top: Layer
) -> tuple[dict[str, float], dict[str, str]]:
    """Published corrections, each inverted for the same reported modulus."""
    nu, h = top.poisson, top.thickness
    stiff = isinstance(medium.base, RigidBase)
    star = 1 / (1 - nu**2)
    hertz = half_space_model(indenter).force(grid)
    round_tip = isinstance(indenter, (Sphere, Paraboloid))
    results: dict[str, float] = {}
    why: dict[str, str] = {}

    def by_factor(name: str, factor: Array, remark: str = "") -> None:
        """Formulas F = E* factor hertz: linear in the modulus."""
        results[name] = target / float(weight @ (hertz * factor)) / star
        if not stiff:
            remark = f"{remark}; for a rigid base" if remark else "for a rigid base"
        if remark:
            why[name] = remark

    single = len(medium.layers) == 1
    if single and round_tip:
        x = np.sqrt(indenter.radius * grid) / h
        by_factor("Dimitriadis", published.dimitriadis(x, nu, top.bonded))
        if top.bonded:
            by_factor("Garcia", published.garcia(x, "paraboloid"), "" if nu == 0.5 else "for nu = 0.5")
            force = published.chadwick(indenter.radius, grid, 1.0, h)
            results["Chadwick"] = target / float(weight @ force)
            why["Chadwick"] = "for bonded incompressible layers much thinner than the contact"
    elif single and isinstance(indenter, Cone) and top.bonded:
        by_factor(
            "Garcia",
            published.garcia(grid / math.tan(indenter.inclination) / h, "cone"),
            "" if nu == 0.5 else "for nu = 0.5",
        )
    elif single and isinstance(indenter, Cylinder) and top.bonded:
        x = np.full_like(grid, indenter.radius / h)
        by_factor("Garcia", published.garcia(x, "flat"), "" if nu == 0.5 else "for nu = 0.5")
    if single and isinstance(medium.base, HalfSpace):
        _substrate_formulas(results, why, medium, indenter, grid, weight * hertz, target)
    return results, why


def _substrate_formulas(
    results: dict[str, float],
    why: dict[str, str],
    medium: Medium,
    indenter: Any,
    grid: Array,
    share: Array,
    target: float,
) -> None:
    """Equivalent moduli E(a/t): the contact radius is the half-space's, as these formulas are used."""
    top, base = medium.layers[0], medium.base
    assert isinstance(top, Layer)
    assert isinstance(base, HalfSpace)
    nu, t, substrate = top.poisson, top.thickness, base.surface_modulus
    if isinstance(indenter, (Sphere, Paraboloid)):
        a = np.sqrt(indenter.radius * grid)
    elif isinstance(indenter, Cylinder):
        a = np.full_like(grid, indenter.radius)
    else:
        a = 2 / math.pi * grid / math.tan(indenter.inclination)
    laws: dict[str, Callable[[float], Array]] = {
        "Gao": lambda film: published.gao(a / t, film, substrate, nu),
        "Perriot-Barthel": lambda film: published.perriot_barthel(a / t, film, substrate),
        "Bec": lambda film: published.bec(a, film, substrate, t),
    }
    if isinstance(indenter, (Sphere, Paraboloid)):
        laws["Clifford"] = lambda film: published.clifford(indenter.radius, grid, film, nu, substrate, base.poisson, t)
    for name, law in laws.items():

        def seen(young: float, law: Callable[[float], Array] = law) -> float:
            return float(share @ law(young / (1 - nu**2)))

        try:
            results[name] = _solved(seen, target, target)
        except ValueError:
            results[name] = math.nan
            why[name] = "no film modulus gives the reported value"
