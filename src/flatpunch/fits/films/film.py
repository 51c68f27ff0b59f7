"""Hard films: the film's modulus from the contact stiffness, which stays elastic where loading does not.

Contact depth after Oliver and Pharr, h_c = h - epsilon P/S; contact radius from the tip's area function, pi a^2 = A(h_c); then

    1/S = C_f + 1/(2 beta_tip a) (1/(E* Kbar(a/t)) + 1/E*_tip)

with the exact normalised stiffness Kbar of film and substrate, the tip's own compliance and that of the load frame C_f in
series. The film's modulus, and whatever else is free, is fitted over all depths; S counts with constant relative error.
A plastic imprint thins the film under the tip: with `imprint` = c it counts as t - c h_c thick.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import ndtri

from flatpunch._support.checks import Array, BadValue
from flatpunch._support.declared import Place
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch.fits.films.oliver_pharr import OliverPharr, Tip, analysed, oliver_pharr
from flatpunch.fits.films.unloading import least_squares_fit
from flatpunch.fits.half_space import published
from flatpunch.fits.half_space.correction import punch_modulus
from flatpunch.fits.half_space.formulas import equivalents, layer_on_top
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.signal import memory_of
from flatpunch.fits.parameters.sample import BESIDE, FRAME, IMPRINT, Scale, check_names, ends, numbers_in
from flatpunch.fits.report.table import LEVEL, Estimate, Row, Rows, Tabled, rows_of, unit_of
from flatpunch.media import Body, Stack
from flatpunch.media.material import young_and_poisson
from flatpunch.media.paths import with_values

_UNIT = 1e-9
"""Unit in which the compliance of the load frame is fitted [m/N]."""
_WIDE = float(np.log(1e6))
"""Largest change of the logarithm of a parameter, a factor of a million; also of the frame in millions of its unit."""
_THINNEST = 1e-3
"""Least thickness of a film that the tip has gone through, over that of the film: thin, not absent."""
_HALF = 0.5
"""Where the search of `imprint` starts."""
_AROUND = 10.0
"""Largest factor of the grid on which the search of a published formula begins."""
_DRIFTS = 0.5
"""Correlation of neighbouring residuals above which they are no scatter."""


@readable
@dataclass(frozen=True, eq=False)
class FilmResult(Tabled):
    """A fitted film.

    Attributes
    ----------
    estimates : dict
        Free parameters by name, and "frame" [m/N] and "imprint" if fitted.
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
    name : str
        Of the test.

    See Also
    --------
    flatpunch.fits.fit_film : Makes it.

    Examples
    --------
    >>> from flatpunch.fits import Tip
    >>> film = fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=130e9, poisson=0.28))
    >>> tip = Tip.from_coefficients([24.5], beta=1.0, material=fp.HalfSpace(young=1e15, poisson=0.0))  # nearly rigid
    >>> cone = fp.Cone(inclination=np.arctan(np.sqrt(np.pi / 24.5)))
    >>> contact = fp.indent(film, cone, depth=np.linspace(50e-9, 500e-9, 20))
    >>> test = fp.Curve(depth=contact.depth, force=contact.force, stiffness=contact.stiffness)
    >>> from flatpunch.fits import fit_film
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
    name: str = "film"

    def __getitem__(self, name: str) -> float:
        """Best value, SI."""
        return self.estimates[name].value

    @property
    def numbers(self) -> Mapping[str, Place]:
        """Declarations of the parameters, by name."""
        return {**numbers_in(self.case, None), **BESIDE}

    def _line_(self) -> str:
        found = ", ".join(f"{name}={text(e.value, unit_of(self.numbers[name]))}" for name, e in self.estimates.items())
        return f"FilmResult({found}, {self.points.depth.size} points, misfit {self.misfit:.2%})"

    def table(self) -> Rows:
        """The fitted values with their intervals, and what published formulas give from the same points; rule and notes below."""
        others = [Row(n, Estimate(young, np.nan), "Pa", f"misfit {m:.2%}") for n, (young, m) in self.others.items()]
        title = f"{self.name}: {self.points.depth.size} points, misfit of the stiffness {self.misfit:.2%}"
        notes = (*([str(self.rule)] if self.rule else []), *self.notes)
        return Rows(title, (*rows_of(self.estimates, self.numbers), *others), notes=notes)


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
    tolerance: float

    def __str__(self) -> str:
        where = f"at {self.depth:.3f} of the thickness" if np.isfinite(self.depth) else "nowhere within the film"
        return (
            f"One-tenth rule: at h_c = t/10 the apparent modulus is off by {self.error:+.1%}; {self.tolerance:.0%} is reached "
            f"{where}."
        )


def normalised_stiffness(medium: Body, radius: Array) -> Array:
    """Exact Kbar of flat punches of `radius` [m], shape (n,)."""
    return np.asarray(punch_modulus(medium, radius) / medium.surface_modulus)


def tenth_rule(medium: Stack, tip: Tip, tolerance: float = 0.05) -> TenthRule:
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
    flatpunch.fits.fit_film : Fits the film instead.

    Examples
    --------
    >>> from flatpunch.fits import Tip
    >>> film = fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=130e9, poisson=0.28))
    >>> tip = Tip.from_coefficients([24.5])
    >>> from flatpunch.fits import tenth_rule
    >>> rule = tenth_rule(film, tip)
    >>> print(f"{100 * rule.error:+.0f} % at a tenth of the thickness")
    +23 % at a tenth of the thickness
    """
    share = np.geomspace(1e-5, 1, 1000)
    area = tip.area(share * medium.length)
    # polynomials of calibrated tips may be negative at the depth of some atoms
    share, area = share[area > 0], area[area > 0]
    error = normalised_stiffness(medium, np.sqrt(area / np.pi)) - 1
    beyond = np.flatnonzero(np.abs(error) > tolerance)
    end = beyond[0] + 1 if beyond.size else 0
    depth = float(np.interp(tolerance, np.abs(error[:end]), share[:end])) if end else float("nan")
    return TenthRule(float(np.interp(0.1, share, error)), depth, tolerance)


def fit_film(
    curve: Curve,
    sample: Body,
    tip: Tip,
    free: Iterable[str] | None = None,
    *,
    depths: tuple[float, float] = (0.0, float("inf")),
    frame: float = 0.0,
    imprint: float = 0.0,
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
        Parameters as in `fit`, "frame" for the load frame's compliance, and "imprint"; the surface's Young's modulus if left out.
    depths : tuple of float
        Range of depths h that is fitted [m].
    frame : float
        Compliance of the load frame [m/N], or where its search starts.
    imprint : float
        Share of the contact depth by which the plastic imprint thins the film under the tip, 0 to 1; about a half in hard films.
        For one homogeneous layer.
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
    flatpunch.fits.oliver_pharr : The points.
    flatpunch.fits.tenth_rule : Error of the one-tenth rule.

    Examples
    --------
    >>> from flatpunch.fits import Tip
    >>> film = fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=130e9, poisson=0.28))
    >>> tip = Tip.from_coefficients([24.5], beta=1.0, material=fp.HalfSpace(young=1e15, poisson=0.0))  # nearly rigid
    >>> cone = fp.Cone(inclination=np.arctan(np.sqrt(np.pi / 24.5)))
    >>> contact = fp.indent(film, cone, depth=np.linspace(50e-9, 500e-9, 20))
    >>> test = fp.Curve(depth=contact.depth, force=contact.force, stiffness=contact.stiffness)
    >>> from flatpunch.fits import fit_film
    >>> result = fit_film(test, film, tip, compare=False)
    >>> print(f"{result['layers[0].young'] / 1e9:.1f} GPa")
    22.8 GPa
    """
    top = "layers[0].young" if sample.single and sample.single.layers else "base.young"
    names = tuple(free) if free is not None else (top,)
    oliver_pharr(curve, tip, frame)
    inside = (curve.depth >= depths[0]) & (curve.depth <= depths[1])

    def points(frame: float) -> OliverPharr:
        return analysed(curve, tip, max(frame, 0.0)).taken(inside)

    known = numbers_in(sample, None)
    known.update({FRAME: BESIDE[FRAME], IMPRINT: BESIDE[IMPRINT]._replace(value=imprint or _HALF)})
    check_names(names, known)
    _check_imprint(sample, IMPRINT in names, imprint)
    scales = [Scale("plain", frame, _UNIT) if n == FRAME else Scale.of(known[n]) for n in names]

    def described(x: Array) -> tuple[Body, OliverPharr, float]:
        found = {name: float(scale.external(v)) for name, scale, v in zip(names, scales, x, strict=True)}
        here, share = points(found.pop(FRAME, frame)), found.pop(IMPRINT, imprint)
        return with_values(sample, None, found)[0], here, share

    def residual(x: Array) -> Array:
        medium, here, share = described(x)
        return misfit_of(here, tip, _thinned(medium, here, share))

    if (count := int(np.isfinite(points(frame).radius).sum())) < len(names) + 3:
        raise CurveError(
            f"{curve.name}: {count} points with a stiffness between {text(float(depths[0]), 'm')} and "
            f"{text(float(depths[1]), 'm')}; {len(names) + 3} are needed. Widen the range of depths, or fit fewer values."
        )
    start = np.array([0.0 if n == FRAME else s.internal(known[n].value) for n, s in zip(names, scales, strict=True)])
    wide = np.array([_WIDE * (1e6 if n == FRAME else 1.0) for n in names])
    lower, upper = np.array([(-np.inf, np.inf) if n == FRAME else ends(known[n]) for n in names]).T
    limits = np.maximum(start - wide, lower), np.minimum(start + wide, upper)
    found, spread = least_squares_fit(residual, start, limits, count)
    medium, here, share = described(found.x)
    here = here.taken(np.isfinite(here.radius))
    reach, estimates = float(ndtri((1 + LEVEL) / 2)), {}
    for name, scale, x, error in zip(names, scales, found.x, np.sqrt(np.diag(spread)), strict=True):
        value, low, high = map(float, scale.external(x + reach * error * np.array([0, -1, 1])))
        estimates[name] = Estimate(value, abs(float(scale.slope(x))) * error, low, high)
    others: dict[str, tuple[float, float]] = {}
    rule = None
    # the rule and the published formulas are about one isotropic film on a half-space
    stack = medium.single
    if stack and len(stack.layers) == 1 and stack.base.isotropic:
        (film,) = stack.layers
        if not film.anisotropic:
            rule = tenth_rule(stack, tip)
        if film.isotropic and compare:
            others = by_formulas(here, tip, stack)
    model = _thinned(medium, here, share)
    notes = (*curve.meta.get("notes", ()), *_notes(sample, here, found.residual, share))
    return FilmResult(
        estimates, medium, here, model, others, float(np.sqrt(found.cost / count)), rule, notes, curve.name
    )


def _check_imprint(sample: Body, fitted: bool, imprint: float) -> None:
    BESIDE[IMPRINT].number.checked("imprint", imprint)
    if (fitted or imprint) and not (sample.single and len(sample.single.layers) == 1):
        raise BadValue("imprint", repr(imprint), "goes with one layer, which it thins. Leave it out.")


def _thinned(medium: Body, points: OliverPharr, share: float) -> Array:
    """Plane-strain moduli of flat punches on a film that the imprint has thinned: those of wider ones on the whole film [Pa]."""
    # a frame may leave no contact at some points, whose residuals are zero
    radius = np.nan_to_num(points.radius, nan=float(np.nanmax(points.radius)))
    if share:
        radius = radius / np.maximum(1 - share * np.nan_to_num(points.contact_depth) / medium.length, _THINNEST)
    return punch_modulus(medium, radius)


def _notes(sample: Body, points: OliverPharr, residual: Array, share: float) -> Iterable[str]:
    if share:
        yield f"The film counts as thinner under the tip by {share:.2f} of the contact depth, by its plastic imprint."
    if sample.single and (deep := int((points.contact_depth > sample.length).sum())):
        yield f"{deep} points are deeper than the film is thick; the tip has gone through. Limit the depths."
    if (memory := memory_of(residual)) > _DRIFTS:
        yield (
            f"The misfit drifts over depth (correlation of neighbours {memory:.2f}): "
            + ("frame" if share else "the imprint, which thins the film (imprint = 0.5), frame")
            + " compliance, area function or pile-up. The intervals are those of the scatter only."
        )


def misfit_of(points: OliverPharr, tip: Tip, modulus: Array) -> Array:
    """Residuals ln(model/measured) of the stiffness for plane-strain moduli at the points; zero where there is no contact."""
    return np.nan_to_num(np.log(tip.stiffness(points.radius, modulus) / points.stiffness))


def by_formulas(points: OliverPharr, tip: Tip, fitted: Stack) -> dict[str, tuple[float, float]]:
    """Film modulus [Pa] and rms relative misfit of the stiffness by each formula; King's with its exponent fitted as well.

    The search begins at the best of a grid about the modulus of `fitted` and the exponent 1: King's law has several minima. The
    modulus is nan where the points do not determine it: film and substrate that hardly differ fit with any modulus if the
    exponent makes the film vanish.
    """
    base, t = fitted.base, fitted.length
    below = np.maximum(t - points.contact_depth, _THINNEST * t)
    kings = {"King": points.radius / t, "Saha-Nix": points.radius / below}
    laws = {name: partial(law, points.radius / t) for name, law in equivalents(fitted).items()}
    laws |= {name: partial(published.king, x, substrate=base.surface_modulus) for name, x in kings.items()}
    results = {}
    factors = np.log(np.geomspace(1 / _AROUND, _AROUND, 9))
    for name, law in laws.items():

        def residual(x: Array, law: Callable[..., Array] = law) -> Array:
            return misfit_of(points, tip, np.maximum(law(*np.exp(x)), 1.0))

        first = np.log([fitted.surface_modulus, *([1.0] if name in kings else [])])
        grid = first + np.stack(np.meshgrid(*[factors] * first.size), axis=-1).reshape(-1, first.size)
        start = min(grid, key=lambda x: float(np.sum(residual(x) ** 2)))
        found, _ = least_squares_fit(residual, start, (start - _WIDE, start + _WIDE), points.radius.size)
        star = float("nan") if found.at_bound.any() else float(np.exp(found.x[0]))
        results[name] = (
            star * (1 - young_and_poisson(layer_on_top(fitted)[1])[1] ** 2),
            float(np.sqrt(found.cost / points.radius.size)),
        )
    return results
