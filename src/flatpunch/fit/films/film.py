"""Hard films: the film's modulus from the contact stiffness, which stays elastic where loading does not.

Contact depth after Oliver and Pharr, h_c = h - epsilon P/S; contact radius from the tip's area function, pi a^2 = A(h_c); then

    1/S = C_f + 1/(2 beta_tip a) (1/(E* Kbar(a/t)) + 1/E*_tip)

with the exact normalised stiffness Kbar of film and substrate, the tip's own compliance and that of the load frame C_f in
series. The film's modulus, and whatever else is free, is fitted over all depths; S counts with constant relative error.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TypeGuard

import numpy as np
from scipy.special import ndtri

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table, readable
from flatpunch.fit.films.formulas import by_formulas, differentiated
from flatpunch.fit.films.oliver_pharr import OliverPharr, Tip, oliver_pharr
from flatpunch.fit.half_space.contact_area import punch_modulus
from flatpunch.fit.least_squares.minimum import Minimum, covariance, minimise
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.signal import memory_of
from flatpunch.fit.parameters.scaling import external, internal, replaced, slope, value_of
from flatpunch.fit.parameters.settings import Settings
from flatpunch.fit.report.quantities import quantity, unit_of
from flatpunch.fit.report.table import Estimate, Row, Rows, rows_of
from flatpunch.media import AnyLayer, Body, GradedLayer, HalfSpace, Layer, Medium

_FRAME = "frame"


@readable
@dataclass(frozen=True, eq=False)
class FilmResult:
    """A fitted film.

    Attributes
    ----------
    estimates : dict
        Free parameters by name, and "frame" [m/N] if fitted.
    case : Medium or HalfSpace
        The sample with the fitted values.
    points : OliverPharr
        The points that were fitted.
    model : ndarray
        Fitted apparent plane-strain modulus E* Kbar at these points [Pa].
    others : dict
        What published formulas give for the film's Young's modulus [Pa] from the same points (nan where these do not determine
        it), with their rms misfit of S [-].
    misfit : float
        Rms relative misfit of S.
    rule : TenthRule or None
        What the one-tenth rule is worth for this film.
    notes : tuple of str

    See Also
    --------
    flatpunch.fit.fit_film : Makes it.

    Examples
    --------
    >>> from flatpunch.fit import Tip
    >>> film = fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=130e9, poisson=0.28))
    >>> tip = Tip.from_coefficients([24.5], beta=1.0, material=fp.HalfSpace(young=1e15, poisson=0.0))  # nearly rigid
    >>> cone = fp.Cone(inclination=np.arctan(np.sqrt(np.pi / 24.5)))
    >>> contact = fp.indent(film, cone, depth=np.linspace(50e-9, 500e-9, 20))
    >>> test = fp.Curve(depth=contact.depth, force=contact.force, stiffness=contact.stiffness)
    >>> from flatpunch.fit import fit_film
    >>> result = fit_film(test, film, tip, compare=False)
    >>> print(sorted(result.estimates), f"misfit {100 * result.misfit:.1f} %")
    ['layers[0].young'] misfit 6.1 %
    """

    estimates: dict[str, Estimate]
    case: Body
    points: OliverPharr
    model: Array
    others: dict[str, tuple[float, float]]
    misfit: float
    rule: TenthRule | None
    notes: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> float:
        """Best value, SI."""
        return self.estimates[name].value

    def _line_(self) -> str:
        """The fitted values."""
        found = ", ".join(f"{name}={quantity(e.value, unit_of(name))}" for name, e in self.estimates.items())
        return f"FilmResult({found}, {self.points.depth.size} points, misfit {self.misfit:.2%})"

    def table(self) -> Rows:
        """The table: a row for each fitted value, and for what published formulas give from the same points."""
        nan = float("nan")
        others = [Row(name, Estimate(v, nan), "Pa", f"misfit {m:.2%}") for name, (v, m) in self.others.items()]
        notes = (*self.notes, *([str(self.rule)] if self.rule is not None else []))
        title = f"{self.points.depth.size} points, misfit of the stiffness {self.misfit:.2%}"
        return Rows(title, (*rows_of(self.estimates), *others), notes=notes)

    def _table_(self) -> Table:
        """A row for each value."""
        return self.table().cells()

    def summary(self) -> str:
        """The result in words."""
        return self.table().text()


@dataclass(frozen=True, slots=True)
class TenthRule:
    """The rule "press to a tenth of the thickness and the substrate does not matter", by numbers.

    Attributes
    ----------
    error : float
        Apparent over film modulus minus one at a contact depth of a tenth of the film.
    depth : float
        Contact depth over thickness at which the apparent modulus is off by `tolerance`; nan if it never is within the film.
    tolerance : float
    """

    error: float
    depth: float
    tolerance: float = 0.05

    def __str__(self) -> str:
        where = f"at {self.depth:.3f}" if np.isfinite(self.depth) else "nowhere within the film"
        return (
            f"One-tenth rule: at h_c = t/10 the apparent modulus is off by {self.error:+.1%}; "
            f"{self.tolerance:.0%} is reached {where}{' of the thickness' if np.isfinite(self.depth) else ''}."
        )


def normalised_stiffness(medium: Body, radius: Array) -> Array:
    """Exact Kbar of flat punches of `radius` [m], shape (n,)."""
    return np.asarray(punch_modulus(medium, radius) / medium.surface_modulus)


def tenth_rule(medium: Medium, tip: Tip, tolerance: float = 0.05) -> TenthRule:
    """Judge the one-tenth rule for a film.

    Parameters
    ----------
    medium : Medium
        Film and substrate.
    tip : Tip
        Area function.
    tolerance : float
        Error of the modulus that is looked for.

    See Also
    --------
    flatpunch.fit.fit_film : Fits the film instead.

    Examples
    --------
    >>> from flatpunch.fit import Tip
    >>> film = fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=130e9, poisson=0.28))
    >>> tip = Tip.from_coefficients([24.5])
    >>> from flatpunch.fit import tenth_rule
    >>> rule = tenth_rule(film, tip)
    >>> print(f"{100 * rule.error:+.0f} % at a tenth of the thickness")
    +23 % at a tenth of the thickness
    """
    share = np.geomspace(1e-5, 1, 600)
    area = tip.area(share * medium.length)
    # polynomials of calibrated tips may be negative at the depth of some atoms
    share, area = share[area > 0], area[area > 0]
    error = normalised_stiffness(medium, np.sqrt(area / np.pi)) - 1
    beyond = np.flatnonzero(np.abs(error) > tolerance)
    depth = (
        float(np.interp(tolerance, np.abs(error[: beyond[0] + 1]), share[: beyond[0] + 1]))
        if beyond.size
        else float("nan")
    )
    return TenthRule(float(np.interp(0.1, share, error)), depth, tolerance)


@dataclass(frozen=True, eq=False)
class _Stiffness:
    """Residuals ln(model/measured) of the stiffness over the free parameters."""

    curve: Curve
    tip: Tip
    medium: Body
    names: tuple[str, ...]
    span: tuple[float, float]
    frame: float

    def case(self, x: Array) -> tuple[Body, float]:
        values = {name: external(name, v) for name, v in zip(self.names, x, strict=True) if name != _FRAME}
        frame = self.frame + (x[self.names.index(_FRAME)] * _UNIT if _FRAME in self.names else 0.0)
        return replaced(self.medium, None, values)[0], float(frame)

    def points(self, frame: float) -> OliverPharr:
        """Points within the range of depths, whatever the frame."""
        found = oliver_pharr(self.curve, self.tip, max(frame, 0.0))
        inside = (found.depth >= self.span[0]) & (found.depth <= self.span[1])
        return replace(found, **{name: getattr(found, name)[inside] for name in found.__dataclass_fields__})

    def residual(self, x: Array) -> Array:
        medium, frame = self.case(x)
        points = self.points(frame)
        modulus = medium.surface_modulus * normalised_stiffness(medium, points.radius)
        reduced = 1 / (1 / modulus + 1 / self.tip.material.surface_modulus)
        return np.asarray(np.log(2 * self.tip.beta * points.radius * reduced / points.stiffness))


_UNIT = 1e-9
"""Frame compliance is fitted in nm/N."""


def fit_film(
    curve: Curve,
    sample: Body,
    tip: Tip,
    free: Iterable[str] | None = None,
    *,
    depths: tuple[float, float] = (0.0, float("inf")),
    frame: float = 0.0,
    compare: bool = True,
) -> FilmResult:
    """Fit the modulus of a film (or of a homogeneous sample) to its contact stiffness over depth.

    Parameters
    ----------
    curve : Curve
        Depth from the surface, force and stiffness.
    sample : Medium or HalfSpace
        Known values, and starting values of the free ones.
    tip : Tip
        Area function, constants, material.
    free : sequence of str, optional
        Parameters as in `fit`, and "frame" for the load frame's compliance; the surface's Young's modulus if left out.
    depths : tuple of float
        Range of depths h that is fitted [m].
    frame : float
        Compliance of the load frame [m/N], or where its search starts.
    compare : bool
        Whether to fit published formulas to the same points (one film on a half-space).

    Returns
    -------
    FilmResult

    Raises
    ------
    CurveError
        If there are too few points with a stiffness in the range.

    See Also
    --------
    flatpunch.fit.oliver_pharr : The points.
    flatpunch.fit.tenth_rule : Error of the one-tenth rule.

    Examples
    --------
    >>> from flatpunch.fit import Tip
    >>> film = fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=130e9, poisson=0.28))
    >>> tip = Tip.from_coefficients([24.5], beta=1.0, material=fp.HalfSpace(young=1e15, poisson=0.0))  # nearly rigid
    >>> cone = fp.Cone(inclination=np.arctan(np.sqrt(np.pi / 24.5)))
    >>> contact = fp.indent(film, cone, depth=np.linspace(50e-9, 500e-9, 20))
    >>> test = fp.Curve(depth=contact.depth, force=contact.force, stiffness=contact.stiffness)
    >>> from flatpunch.fit import fit_film
    >>> result = fit_film(test, film, tip, compare=False)
    >>> print(f"{result['layers[0].young'] / 1e9:.1f} GPa")
    22.8 GPa
    """
    top = "base.young" if not isinstance(sample, Medium) or not sample.layers else "layers[0].young"
    names = tuple(free) if free is not None else (top,)
    problem = _Stiffness(curve, tip, sample, names, depths, frame)
    count = problem.points(frame).depth.size
    if count < len(names) + 3:
        raise CurveError(
            f"{curve.name}: {count} points with a stiffness between {text(float(depths[0]), 'm')} and "
            f"{text(float(depths[1]), 'm')}."
        )
    found, spread = _minimum(problem)
    medium, used_frame = problem.case(found.x)
    points = problem.points(used_frame)
    misfit = float(np.sqrt(np.mean(found.residual**2)))
    notes = list(curve.meta.get("notes", ()))
    if isinstance(sample, Medium) and points.contact_depth.max() > medium.length:
        notes.append(
            f"{int((points.contact_depth > medium.length).sum())} points are deeper than the film is thick; the tip has gone "
            "through. Limit the depths."
        )
    memory = memory_of(found.residual)
    if memory > 0.5:
        notes.append(
            f"The misfit drifts over depth (correlation of neighbours {memory:.2f}): frame compliance, area function or pile-up. "
            "The intervals are those of the scatter only."
        )
    others = by_formulas(points, tip, medium) if _isotropic(medium) and compare else {}
    rule = tenth_rule(medium, tip) if _isotropic(medium) else None
    model = medium.surface_modulus * normalised_stiffness(medium, points.radius)
    return FilmResult(_named(problem, found.x, spread), medium, points, model, others, misfit, rule, tuple(notes))


def _isotropic(sample: Body) -> TypeGuard[Medium]:
    """Whether it is one isotropic film on a half-space, as the published formulas suppose."""
    return (
        isinstance(sample, Medium)
        and len(sample.layers) == 1
        and _isotropic_layer(sample.layers[0])
        and isinstance(sample.base, HalfSpace)
    )


def _isotropic_layer(layer: AnyLayer) -> bool:
    return not layer.anisotropic if isinstance(layer, GradedLayer) else isinstance(layer, Layer)


def _minimum(problem: _Stiffness) -> tuple[Minimum, Array]:
    start = np.array([0.0 if n == _FRAME else internal(n, value_of(problem.medium, None, n)) for n in problem.names])
    wide = np.array([1e6 if n == _FRAME else 14.0 for n in problem.names])
    upper = np.array([0.5 if n.endswith("poisson") else v for n, v in zip(problem.names, start + wide, strict=True)])
    found = minimise(
        differentiated(problem.residual),
        start,
        start - wide,
        upper,
        longest=2.0 if _FRAME not in problem.names else 1e4,
    )
    variance = found.cost / max(found.residual.size - start.size, 1)
    return found, covariance(found.normal, ~found.at_bound, variance)[0]


def _named(problem: _Stiffness, x: Array, spread: Array) -> dict[str, Estimate]:
    estimates, reach = {}, float(ndtri((1 + Settings().level) / 2))
    for j, name in enumerate(problem.names):
        error = float(np.sqrt(spread[j, j]))
        if name == _FRAME:
            value, unit = problem.frame + _UNIT * float(x[j]), _UNIT
            estimates[name] = Estimate(value, unit * error, value - reach * unit * error, value + reach * unit * error)
            continue
        value = external(name, float(x[j]))
        low, high = (external(name, float(x[j]) + s * reach * error) for s in (-1, 1))
        estimates[name] = Estimate(value, error * abs(slope(name, value)), low, high)
    return estimates
