"""Pictures of fits: curves, the modulus over depth, hard films, corrected moduli, formulas against the exact contact."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from flatpunch._support.checks import Array, Indices, instance, switch
from flatpunch._support.prefixes import text
from flatpunch.fits.distributions import bars
from flatpunch.fits.half_space.correction import Correction
from flatpunch.fits.half_space.formulas import WITHIN, layer_on_top
from flatpunch.fits.report.table import axis_label, unit_of
from flatpunch.fits.report.table import label as label_of
from flatpunch.media.material import young_and_poisson
from flatpunch.plots.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PALE,
    THIN,
    StyleName,
    axes_or_new,
    check_label,
    legend_below,
    next_colour,
    panels,
    printed,
    scale_of,
    scale_on,
    sheet,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

    from flatpunch.fits.batch import Batch
    from flatpunch.fits.films.film import FilmResult
    from flatpunch.fits.report.result import FitResult


_SHOWN = 50
"""Largest error of a formula that a picture shows [%]."""
_LETTERS = 46
"""Letters in a line of a title; more do not fit above a panel of one column."""


def plot_fit(
    result: FitResult | FilmResult | Batch,
    axes: Axes | None = None,
    *,
    residuals: bool = False,
    name: str | None = None,
    label: str | None = None,
) -> Axes:
    """Draw what was measured and what was fitted to it.

    Of a curve its force over depth, or over time where that was fitted; of a film the apparent modulus over the contact depth;
    of a batch one parameter of all its curves.

    Parameters
    ----------
    result : FitResult, FilmResult or Batch
        What `fit`, `flatpunch.fits.fit_film` or `fit_batch` returned.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure. Axes that hold a fit keep their units, and the new one has its own colour.
    residuals : bool
        Of a curve: the measured minus the fitted force instead.
    name : str, optional
        Of a batch: the parameter; its first by default.
    label : str, optional
        Of a curve: its name in the legend.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    plot_curve : A computed curve.

    Examples
    --------
    >>> gel, tip = fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6)
    >>> depth = np.linspace(-2e-7, 4e-7, 300)
    >>> force = np.zeros(300)
    >>> force[depth > 0] = fp.indent(gel, tip, depth=depth[depth > 0]).force
    >>> force += 1e-11 * np.random.default_rng(0).normal(size=300)
    >>> fitted = fp.fit(fp.Curve(depth=depth, force=force), gel, tip, ["base.young"])
    >>> axes = fp.plot_fit(fitted)
    >>> axes.get_ylabel()
    'normal force $F$ (nN)'
    """
    # what is drawn depends on what it is; the batch is loaded with its readers
    from flatpunch.fits.batch import Batch
    from flatpunch.fits.films.film import FilmResult
    from flatpunch.fits.report.result import FitResult

    instance("result", result, (FitResult, FilmResult, Batch), "what `fit`, `fit_film` or `fit_batch` returns")
    check_label(label)
    switch("residuals", residuals)
    drawn = axes_or_new(axes)
    if isinstance(result, FitResult):
        (_residuals if residuals else _measured_and_fitted)(result, drawn, label)
    elif isinstance(result, FilmResult):
        _film(result, drawn)
    else:
        bars(result, name or result.fitted[0], drawn)
    return drawn


def fit_figure(result: FitResult, *, style: StyleName | str = "screen") -> Figure:
    """Force with fit, over residuals; of several curves the force over the baseline and the residuals over the noise."""
    several = len(result.results) > 1
    with styled(style) as chosen:
        figure = Figure(figsize=sheet(chosen, 1 if several and chosen.across == 1 else 3 / 4), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
        if several:
            _several(result, top, bottom)
        else:
            _measured_and_fitted(result, top)
            _residuals(result, bottom)
        top.set_xlabel("")
    return figure


def _along(result: FitResult, axis: Axis) -> tuple[Array, str]:
    """Depth, or time where that is what was fitted, in the unit of an axis, and its label."""
    if result.objective.model.over_time and result.curve.time is not None:
        factor, unit = scale_on(axis, result.curve.time, "s")
        return result.curve.time * factor, f"time $t$ ({unit})"
    factor, unit = scale_on(axis, result.depth, "m")
    return result.depth * factor, f"indentation depth $d$ ({unit})"


def _measured_and_fitted(result: FitResult, axes: Axes, label: str | None = None) -> None:
    """Points pale, the fitted line dark and on top, over depth or time."""
    first, colour = not axes.has_data(), next_colour(axes)
    x, along = _along(result, axes.xaxis)
    factor, unit = scale_on(axes.yaxis, result.curve.force, "N")
    left = ~result.used
    measured = result.curve.force * factor
    points = "measured" if first else None
    axes.plot(x[~left], measured[~left], "o", ms=4, mew=0, color=PALE, label=points, rasterized=True)
    if left.any():
        axes.plot(x[left], measured[left], "x", ms=4, mew=THIN, color=GREY, label="left out", rasterized=True)
    for at, name in zip(_ways(result, x), (label or "fitted", None), strict=False):
        axes.plot(x[at], result.force[at] * factor, color=colour, label=name)
    if along.startswith("indentation"):
        axes.axvline(0, color=GREY, lw=THIN, ls=":")
    axes.set(xlabel=along, ylabel=f"normal force $F$ ({unit})")
    axes.legend(loc="best", markerscale=2)
    axes.set_title(_title(result.curve.name, result, result.problem.free) if first else "")


def _ways(result: FitResult, x: Array) -> list[Indices]:
    """Points of each line of the fit, ascending: drag makes the force on the way back another one.

    Readings that are left out between others have positions, and thus a background, that are not those of the model.
    """
    order = np.argsort(x, kind="stable")
    order = order[(result.used | (x > x[result.used].max()))[order]]
    speed = result.curve.meta.get("speed") if result.settings.drag != 0 else None
    if speed is None or result.objective.model.over_time:
        return [order]
    return [way for way in (order[speed[order] >= 0], order[speed[order] < 0]) if way.size]


def _residuals(result: FitResult, axes: Axes, label: str | None = None) -> None:
    """Measured minus fitted; what was left out would only stretch the axis."""
    first, colour = not axes.has_data(), next_colour(axes)
    x, along = _along(result, axes.xaxis)
    factor, unit = scale_on(axes.yaxis, result.residual[result.used], "N")
    pale = {"color": PALE} if first else {"color": colour, "alpha": 0.5}
    axes.plot(
        x[result.used], result.residual[result.used] * factor, "o", ms=2, mew=0, rasterized=True, label=label, **pale
    )
    axes.axhline(0, color=colour, lw=1.0)
    if label is not None:
        axes.legend(loc="best", markerscale=2)
    axes.set(xlabel=along, ylabel=f"residual ({unit})")


def _several(result: FitResult, top: Axes, bottom: Axes) -> None:
    """Curves of a joint fit over their baselines, and their residuals over their noise."""
    import matplotlib

    results = result.results
    levels = [r.estimates["baseline"].value if "baseline" in r.estimates else 0.0 for r in results]
    x_factor, x_unit = scale_of([float(r.depth.max()) for r in results], "m")
    y_factor, y_unit = scale_of([float(r.force.max()) - level for r, level in zip(results, levels, strict=True)], "N")
    colours = matplotlib.colormaps["viridis"](np.arange(len(results)) / (1 + len(results)))
    for one, level, colour in zip(results, levels, colours, strict=True):
        x = one.depth * x_factor
        measured, fitted = ((force - level) * y_factor for force in (one.curve.force, one.force))
        top.plot(x, measured, ".", ms=3, color=colour, label=one.curve.name, rasterized=True)
        for at in _ways(one, x):
            top.plot(x[at], fitted[at], color="black", lw=THIN, zorder=3)
        left = one.residual[one.used] / one.noise
        if one.minimum.residual.size == left.size:
            # as they were weighted: behind a cantilever the noise moves the tip as well, the more the stiffer the contact;
            # histories are fitted as means, with no weights but their counts
            left = -one.minimum.residual * one.objective.frame.span / one.noise
        bottom.plot(x[one.used], left, ".", ms=2, alpha=0.5, color=colour, rasterized=True)
    top.legend(title="measured; fitted in black", markerscale=3)
    top.set(ylabel=f"force over baseline ({y_unit})", title=_title(f"{len(results)} curves", result, result.shared))
    bottom.axhline(0, color=GREY, lw=THIN)
    bottom.set(xlabel=f"indentation depth $d$ ({x_unit})", ylabel="residual / noise")


def _title(name: str, result: FitResult, parameters: Sequence[str]) -> str:
    """Name of a curve and fitted values, in lines that fit above one panel."""
    name = name if len(name) <= _LETTERS - 1 else name[: _LETTERS - 2] + "…"
    numbers = result.problem.numbers
    words = [f"{label_of(numbers[each])} = {text(result[each], unit_of(numbers[each]))}" for each in parameters]
    # a value keeps to its line: spaces within it do not break
    values = ", ".join(printed(word).replace("-", "−").replace(" ", "\u00a0") for word in words)
    return textwrap.fill(f"{name}: {values}" if values else name, _LETTERS, break_on_hyphens=False)


def drift_figure(
    results: Sequence[FitResult],
    name: str,
    beside: Sequence[FitResult] = (),
    beside_name: str = "",
    *,
    style: StyleName | str = "screen",
) -> Figure:
    """One parameter over the largest fitted depth, with intervals; another model's, usually a half-space, beside it."""
    with styled(style) as chosen:
        figure = Figure(figsize=sheet(chosen), layout="constrained")
        axes = figure.add_subplot()
        x_factor, x_unit = scale_of([float(r.depth.max()) for r in (*results, *beside)], "m")
        found = [abs(r[n]) for rs, n in ((results, name), (beside, beside_name)) for r in rs]
        shown = results[0].problem.numbers[name]
        y_factor, y_unit = scale_of(found, unit_of(shown))
        for fits, label, how, words in (
            (results, name, {"fmt": "o-", "color": BLUE}, "layered model"),
            (beside, beside_name, {"fmt": "s--", "color": ORANGE, "markerfacecolor": "white"}, "half-space"),
        ):
            if not fits:
                continue
            x = [float(r.depth.max()) * x_factor for r in fits]
            values = np.array([r[label] for r in fits]) * y_factor
            ends = np.array([(r.estimates[label].low, r.estimates[label].high) for r in fits]) * y_factor
            spread: Any = np.abs(ends - values[:, None]).T
            options: Any = {**how, "ms": 4, "capsize": 3, "label": words}
            axes.errorbar(x, values, spread, **options)
        axes.set(xlabel=f"largest fitted depth ({x_unit})", ylabel=axis_label(shown, y_unit))
        axes.set_ylim(bottom=0)
        axes.legend(loc="best", ncols=2)
    return figure


def film_figure(result: FilmResult, *, style: StyleName | str = "screen") -> Figure:
    """Apparent modulus over contact depth: measured, fitted, film, substrate, and what published formulas give for the film."""
    with styled(style) as chosen:
        figure = Figure(figsize=sheet(chosen), layout="constrained")
        _film(result, figure.add_subplot())
    return figure


def _film(result: FilmResult, axes: Axes) -> None:
    points = result.points
    x_factor, x_unit = scale_of(points.contact_depth, "m")
    y_factor, y_unit = scale_of([float(np.median(points.apparent))], "Pa")
    x = points.contact_depth * x_factor
    order = np.argsort(x)
    axes.plot(x, points.apparent * y_factor, "o", ms=3, mew=0, color=PALE, label="measured", rasterized=True)
    axes.plot(x[order], (result.model * y_factor)[order], color=BLUE, label="fitted")
    axes.axhline(result.case.surface_modulus * y_factor, color=BLUE, lw=1, ls="--", label="film")
    base = getattr(result.case, "base", None)
    if base is not None and hasattr(base, "surface_modulus"):
        axes.axhline(base.surface_modulus * y_factor, color="black", lw=1, ls=":", label="substrate")
    styles = (":", "-.", (0, (1, 3)), (0, (5, 5)), (0, (3, 1)))
    known = {name: young for name, (young, _) in result.others.items() if np.isfinite(young)}
    for (name, young), style in zip(known.items(), styles, strict=False):
        poisson = young_and_poisson(layer_on_top(result.case)[1])[1]
        axes.axhline(young / (1 - poisson**2) * y_factor, color=ORANGE, lw=THIN, ls=style, label=f"film, {name}")
    axes.set(xlabel=f"contact depth $h_c$ ({x_unit})", ylabel=f"plane-strain modulus $E^*$ ({y_unit})")
    axes.set_xlim(left=0)
    legend_below(axes, ncols=3)


_LINES = ("--", ":", "-.", (0, (3, 1)))


def correction_figure(found: Correction, *, title: str = "", style: StyleName | str = "screen") -> Figure:
    """Moduli of the layer by the exact contact and by formulas; the half-space modulus over depth."""
    with styled(style) as chosen:
        drawn, (bars, curve) = panels(chosen, 2, title=title)
        young = {row.name: v for row in found.table().rows if np.isfinite(v := row.estimate.value)}
        factor, unit = scale_of([*young.values(), found.reported], "Pa")
        bars.barh(list(young), [each * factor for each in young.values()], color=[BLUE, *[GREY] * (len(young) - 1)])
        bars.invert_yaxis()
        bars.axvline(found.young * factor, color=BLUE, linewidth=THIN)
        # one formula far off must not hide the others
        bars.set_xlim(0, min(bars.get_xlim()[1], 3 * factor * max(found.young, found.reported)))
        bars.set_xlabel(f"Young's modulus of the layer ({unit})")
        length, length_unit = scale_of(found.depth, "m")
        curve.plot(
            found.depth * length, found.apparent * factor, color=ORANGE, label="half-space formula at each depth"
        )
        curve.axhline(found.young * factor, color=BLUE, label="layer")
        curve.plot([found.depth[-1] * length], [found.reported * factor], "o", color=ORANGE, label="reported")
        curve.set_ylim(bottom=0)
        curve.set_xlim(left=0)
        curve.set(xlabel=f"indentation depth ({length_unit})", ylabel=f"Young's modulus ({unit})")
        curve.legend()
    return drawn


def comparison_figure(found: xr.Dataset, *, title: str = "", style: StyleName | str = "screen") -> Figure:
    """Force over that of the half-space formula, and the errors of the formulas, over depth."""
    with styled(style) as chosen:
        drawn, (factors, errors) = panels(chosen, 2, title=title)
        length, unit = scale_of(found["depth"].values, "m")
        depth, bare = found["depth"].values * length, found["formula_force"].values[0]
        factors.plot(depth, found["factor"].values, color=BLUE, linewidth=3 * THIN, alpha=0.5, label="exact")
        for i, name in enumerate(found["formula"].values):
            look: Any = {
                "color": (ORANGE, GREEN, GREY)[i % 3],
                "linestyle": _LINES[i // 3 % len(_LINES)],
                "label": str(name),
            }
            factors.plot(depth, found["formula_force"].values[i] / bare, **look)
            errors.plot(depth, 100 * found["deviation"].values[i], **look)
        top = float(np.nanmax(found["factor"].values))
        factors.set_ylim(0, 3 / 2 * top)
        for limit in WITHIN:
            errors.axhspan(-100 * limit, 100 * limit, color="black", alpha=0.1, linewidth=0)
        errors.set_ylim(-_SHOWN, _SHOWN)
        for axes in (factors, errors):
            axes.set_xlabel(f"indentation depth ({unit})")
        factors.set_ylabel("force over that of the half-space formula")
        errors.set_ylabel("error of the formula (%)")
        factors.legend()
    return drawn
