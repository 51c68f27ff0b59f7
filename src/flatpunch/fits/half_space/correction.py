"""From a half-space modulus that somebody's software reported to the true modulus of the layer.

The software fitted F = c E* d^n to a curve that a layer on a base produced. Which layer gives that E*? Either at the one depth
d, or by least squares over the curve up to d, contact point known (both are offered; most software does the second). Beside it
stand the moduli that published corrections would give for the same reported value.

After Oliver and Pharr the software computed E* = S/(2 beta a), pi a^2 = A(h_c), with the compliance of the tip taken out. A film
on a base has the stiffness S = 2 beta a E* Kbar(a/t) of a flat punch of radius a: the film sought is that whose E* Kbar is the
reported modulus.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.optimize import brentq

from flatpunch._support.checks import ROUNDING, Array, one_of, positive
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch._version import __version__
from flatpunch.compliances import compliance
from flatpunch.fits.elastic.model import ForwardModel
from flatpunch.fits.half_space.formulas import (
    OLIVER_PHARR,
    Equivalent,
    Formula,
    equivalents,
    formulas,
    half_space_model,
    layer_on_top,
    shape_of,
)
from flatpunch.fits.parameters.settings import FitMethod
from flatpunch.fits.report.table import Estimate, Row, Rows, Tabled
from flatpunch.indenters import AreaFunction
from flatpunch.indenters.geometry.angles import angular_rule
from flatpunch.indenters.geometry.features import radius_above
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, Stack
from flatpunch.media.material import POISSON, young_and_poisson
from flatpunch.media.paths import with_values
from flatpunch.punch.family import punch_family

if TYPE_CHECKING:
    import xarray as xr

Over = Literal["curve", "depth"]

_Laws = dict[str, tuple[Callable[[float], Array], str]]
"""By name: apparent modulus at each depth over Young's modulus of the layer, and a remark; the exact contact first."""
_Limits = Callable[[float], tuple[str, ...]]

_TOP, _EXACT = "layers[0].young", "exact"
_POINTS = 200
"""Evenly spaced depths of the curve that the software fitted; twice as many move the modulus by 0.1 %."""
_FARTHEST = 1e6
"""Factor between the reported modulus and the farthest that is tried for the layer, either way."""
_STEP = 1e-4
"""Relative step of the derivative of the reported modulus."""


@readable
@dataclass(frozen=True)
class Correction(Tabled):
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

    def table(self) -> Rows:
        """Young's modulus of the layer [Pa] by the exact contact first, then by the published corrections, with remarks."""
        title = (
            f"Reported {text(self.reported, 'Pa')} -> layer {text(self.young, 'Pa')} (reported is {self.factor:.3f} of it; 1 % "
            f"in the report is {self.sensitivity:.1f} % in the layer)"
        )
        moduli = {"exact": self.young, **self.others}
        rows = (
            Row(n, Estimate(v, np.nan), "Pa", self._remark(n, v) if n in self.others else "") for n, v in moduli.items()
        )
        return Rows(title, tuple(rows), notes=self.notes)

    def _remark(self, name: str, value: float) -> str:
        """Deviation from the exact contact, and what the formula was made for."""
        off = f"{100 * (value / self.young - 1):+.3g} %" if math.isfinite(value) else ""
        return "; ".join(filter(None, (off, self.why.get(name, ""))))

    def dataset(self) -> xr.Dataset:
        """Return the result as a dataset: moduli by `formula`, the exact contact first, and the apparent modulus by `depth`."""
        import xarray as xr

        names, moduli = zip(("exact", self.young), *self.others.items(), strict=True)
        remarks = np.array([self.why.get(name, "") for name in names], dtype=object)
        attributes = {name: getattr(self, name) for name in ("reported", "over", "sensitivity")}
        return xr.Dataset(
            {
                "young": ("formula", np.array(moduli), {"units": "Pa", "long_name": "Young's modulus of the layer"}),
                "remark": ("formula", remarks),
                "apparent": ("depth", self.apparent, {"units": "Pa", "long_name": "modulus of the half-space formula"}),
            },
            {"formula": np.array(names, dtype=object), "depth": ("depth", self.depth, {"units": "m"})},
            attributes | {"notes": "\n".join(self.notes), "flatpunch_version": __version__},
        )


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
    fits.Correction : What it returns.

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
    nu = (
        POISSON.checked("reported_poisson", reported_poisson)
        if reported_poisson is not None
        else young_and_poisson(top)[1]
    )
    along = depth * np.arange(1, _POINTS + 1) / _POINTS
    named = isinstance(model, str) and model == OLIVER_PHARR
    if named or (model is None and shape_of(indenter) is None):
        over, weight = "depth", np.ones(_POINTS)
        laws, limits = _by_area(medium, indenter, along)
    else:
        weight = half_space_model(indenter, model)(along) ** 2
        laws, limits = _by_force(with_values(medium, None, {_TOP: reported})[0], indenter, along, model, method)
    if over == "depth":
        weight = np.append(np.zeros(_POINTS - 1), 1.0)
    weight, target = weight / weight.sum(), reported / (1 - nu**2)
    found: dict[str, float] = {}
    why = {name: remark for name, (_, remark) in laws.items() if remark}
    for name, (law, _) in laws.items():
        try:
            found[name] = _solved(law, weight, target, reported)
        except ValueError as error:
            if name == _EXACT:
                raise
            found[name], why[name] = math.nan, str(error).partition(":")[0]
    young, exact = found.pop(_EXACT), laws[_EXACT][0]
    near = [math.log(float(weight @ exact(young * (1 + step)))) for step in (-_STEP, _STEP)]
    sensitivity = 2 * _STEP / (near[1] - near[0]) if near[1] > near[0] else math.inf
    apparent = exact(young) * (1 - nu**2)
    return Correction(young, reported, reported / young, found, why, sensitivity, over, limits(young), along, apparent)


def _by_force(
    medium: Stack, indenter: Indenter, along: Array, model: str | None, method: FitMethod
) -> tuple[_Laws, _Limits]:
    """Plane-strain moduli of the half-space with the same force at each depth, and limits of the exact contact."""
    unit = half_space_model(indenter, model)(along)
    exact = ForwardModel(medium, indenter, (_TOP,), method)
    laws: _Laws = {_EXACT: (lambda young: exact.force(along, {_TOP: young}) / unit, "")}

    def over(law: Formula) -> Callable[[float], Array]:
        return lambda young: np.asarray(law.force(along, young) / unit)

    laws |= {law.name: (over(law), law.remark) for law in formulas(medium, indenter)}
    return laws, lambda young: tuple(exact.exact(along[-1:], {_TOP: young}).notes.splitlines())


def _by_area(medium: Stack, indenter: Indenter, along: Array) -> tuple[_Laws, _Limits]:
    """Oliver and Pharr: plane-strain moduli of the half-space with the same stiffness at each contact depth; what is assumed."""
    radius, top = section_radius(indenter, along), layer_on_top(medium)[1]
    x, star = radius / top.thickness, 1 / (1 - young_and_poisson(top)[1] ** 2)
    laws: _Laws = {_EXACT: (lambda young: punch_modulus(with_values(medium, None, {_TOP: young})[0], radius), "")}
    if len(medium.layers) == 1 and medium.base.isotropic:

        def plane_strain(law: Equivalent) -> Callable[[float], Array]:
            return lambda young: law(x, young * star)

        laws |= {name: (plane_strain(law), "") for name, law in equivalents(medium).items()}
    note = (
        "Oliver and Pharr: the depth is that of the contact, where the tip has the area of a circle of "
        f"{text(float(radius[-1]), 'm')}. The reported modulus is that of the sample, the tip's own compliance taken out."
    )
    return laws, lambda young: (note,)


def section_radius(indenter: Indenter, depth: Array) -> Array:
    """Radius [m] of the circle with the area of a tip's section at distances from the apex [m]."""
    if isinstance(indenter, AreaFunction):
        return np.asarray(np.sqrt(indenter.area(depth) / np.pi))
    phi, weights = angular_rule(indenter)
    # no tip is wider than a metre
    return np.asarray(np.sqrt(radius_above(indenter, depth[:, None], phi, 1.0) ** 2 @ weights))


def punch_modulus(medium: Body, radius: Array) -> Array:
    """Plane-strain modulus of the half-space on which flat punches of `radius` [m] have the same stiffness [Pa], shape (n,)."""
    kernel = compliance(medium)
    return np.asarray(medium.surface_modulus * np.pi * punch_family(kernel).flat(radius / kernel.length)[:, 0])


def _solved(law: Callable[[float], Array], weight: Array, target: float, guess: float) -> float:
    """The Young's modulus for which the target is reported, in logarithms, from a bracket that grows by factors of two."""

    def reports(young: float) -> float:
        return float(weight @ law(young))

    def miss(x: float) -> float:
        seen = reports(math.exp(x)) / target
        return math.log(seen) if seen > 0 else math.nan

    at = math.log(guess)
    if not math.isfinite(first := miss(at)):
        raise ValueError("the depth is outside its range")
    step = -math.copysign(math.log(2), first)
    while abs(at - math.log(guess)) < math.log(_FARTHEST):
        if miss(at + step) * first <= 0:
            return math.exp(brentq(miss, at, at + step, xtol=ROUNDING))
        at += step
    ends = sorted((guess, math.exp(at)))
    seen = [reports(end) for end in ends]
    raise ValueError(
        f"no modulus of the layer gives the reported value: between {ends[0]:.3g} and {ends[1]:.3g} Pa the software would report "
        f"plane-strain moduli of {seen[0]:.3g} to {seen[1]:.3g} Pa, not {target:.3g}. Base, thickness and depth do not go "
        "together with it."
    )
