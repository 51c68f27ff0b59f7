"""Pictures of fits: the curve with its fit, the ridge between two parameters, several curves of one sample, hard films."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from scipy.special import erfc

from flatpunch._support.checks import Array, Indices
from flatpunch._support.kinds import instance
from flatpunch.fit.batch_pictures import bars, first_parameter
from flatpunch.fit.half_space.formulas import layer_on_top
from flatpunch.fit.parameters.scaling import plain_limits
from flatpunch.fit.report.quantities import axis_label, quantity, unit_of
from flatpunch.fit.report.quantities import label as label_of
from flatpunch.fit.viscoelastic.model import HistoryModel
from flatpunch.plots.style import (
    BLUE,
    GREY,
    ORANGE,
    PALE,
    THIN,
    StyleName,
    axes_or_new,
    legend_below,
    logarithmic,
    next_colour,
    printed,
    scale_of,
    scale_on,
    sheet,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

    from flatpunch.fit.batch import Batch
    from flatpunch.fit.films.film import FilmResult
    from flatpunch.fit.report.joint import JointResult
    from flatpunch.fit.report.result import FitResult

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
        What `fit`, `flatpunch.fit.fit_film` or `fit_batch` returned.
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
    from flatpunch.fit.batch import Batch
    from flatpunch.fit.films.film import FilmResult
    from flatpunch.fit.report.result import FitResult

    instance("result", result, (FitResult, FilmResult, Batch), "what `fit`, `fit_film` or `fit_batch` returns")
    drawn = axes_or_new(axes)
    if isinstance(result, FitResult):
        (_residuals if residuals else _measured_and_fitted)(result, drawn, label)
    elif isinstance(result, FilmResult):
        _film(result, drawn)
    else:
        bars(result, name or first_parameter(result), drawn)
    return drawn


def fit_figure(result: FitResult, *, ridge: bool | None = None, style: StyleName | str = "screen") -> Figure:
    """Curve with fit, residuals, and the ridge of the two most correlated free parameters, by default where they are a note."""
    pair = most_tangled(result)
    wanted = pair is not None and (ridge if ridge is not None else _complains(result))
    with styled(style) as chosen:
        beside = wanted and chosen.width != chosen.panel[0]
        figure = Figure(
            figsize=sheet(chosen, 0.5 if beside else 3 / 2 if wanted else 3 / 4, 1 + beside), layout="constrained"
        )
        shape = (2, 2 if beside else 1) if beside or not wanted else (3, 1)
        grid = figure.add_gridspec(*shape, height_ratios=[3, 1, 3][: shape[0]])
        top = figure.add_subplot(grid[0, 0])
        _measured_and_fitted(result, top)
        bottom = figure.add_subplot(grid[1, 0], sharex=top)
        _residuals(result, bottom)
        top.set_xlabel("")
        top.tick_params(labelbottom=False)
        if wanted and pair is not None:
            _ridge(result, *pair, figure.add_subplot(grid[:, 1] if beside else grid[2, 0]))
    return figure


def most_tangled(result: FitResult) -> tuple[str, str] | None:
    """The two free parameters with the largest correlation; None if there are fewer than two."""
    free = result.objective.model.free
    names = list(result.names)
    pairs = list(combinations(free, 2))
    if not pairs:
        return None

    def strength(pair: tuple[str, str]) -> float:
        found = abs(result.correlation[names.index(pair[0]), names.index(pair[1])])
        # undetermined pairs have no correlation; they are as tangled as can be
        return float(found) if np.isfinite(found) else 2.0

    return max(pairs, key=strength)


def _complains(result: FitResult) -> bool:
    return any("apart" in note or "combination" in note for note in result.notes)


def _along(result: FitResult, axis: Axis) -> tuple[Array, str]:
    """Depth, or time where that is what was fitted, in the unit of an axis, and its label."""
    over_time = isinstance(result.objective.model, HistoryModel)
    if over_time and result.curve.time is not None:
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
    axes.set_xlabel(along)
    axes.set_ylabel(f"normal force $F$ ({unit})")
    axes.legend(loc="best", markerscale=2)
    axes.set_title(_title(result.curve.name, result, result.objective.model.free) if first else "")


def _ways(result: FitResult, x: Array) -> list[Indices]:
    """Points of each line of the fit, ascending: drag makes the force on the way back another one."""
    order = np.argsort(x, kind="stable")
    speed = result.curve.meta.get("speed") if result.settings.drag != 0 else None
    if speed is None or isinstance(result.objective.model, HistoryModel):
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
    axes.set_xlabel(along)
    axes.set_ylabel(f"residual ({unit})")


def together_figure(result: JointResult, *, style: StyleName | str = "screen") -> Figure:
    """Curves of a joint fit, force over depth, and below their residuals over their noise."""
    import matplotlib

    with styled(style) as chosen:
        figure = Figure(figsize=sheet(chosen, 1 if chosen.across == 1 else 3 / 4), layout="constrained")
        grid = figure.add_gridspec(2, 1, height_ratios=[3, 1])
        top = figure.add_subplot(grid[0])
        bottom = figure.add_subplot(grid[1], sharex=top)
        x_factor, x_unit = scale_of([float(r.depth.max()) for r in result.results], "m")
        levels = [r.estimates["baseline"].value if "baseline" in r.estimates else 0.0 for r in result.results]
        tops = [float(r.force.max()) - level for r, level in zip(result.results, levels, strict=True)]
        y_factor, y_unit = scale_of(tops, "N")
        colours = matplotlib.colormaps["viridis"](np.arange(len(result.results)) / (1 + len(result.results)))
        for one, level, colour in zip(result.results, levels, colours, strict=True):
            order = np.argsort(one.depth, kind="stable")
            x = one.depth * x_factor
            measured = (one.curve.force - level) * y_factor
            top.plot(x, measured, ".", ms=3, color=colour, label=one.curve.name, rasterized=True)
            top.plot(x[order], ((one.force - level) * y_factor)[order], color="black", lw=THIN)
            left = one.residual[one.used] / one.noise
            if one.minimum.residual.size == left.size:
                # as they were weighted: behind a cantilever the noise moves the tip as well, the more the stiffer the contact;
                # histories are fitted as means, with no weights but their counts
                left = -one.minimum.residual * one.objective.frame[2] / one.noise
            bottom.plot(x[one.used], left, ".", ms=2, alpha=0.5, color=colour, rasterized=True)
        top.legend(title="measured; fitted in black", markerscale=3)
        top.set_ylabel(f"force over baseline ({y_unit})")
        top.tick_params(labelbottom=False)
        top.set_title(_title(f"{len(result.results)} curves", result, result.shared))
        bottom.axhline(0, color=GREY, lw=THIN)
        bottom.set_xlabel(f"indentation depth $d$ ({x_unit})")
        bottom.set_ylabel("residual / noise")
    return figure


def _title(name: str, result: FitResult | JointResult, parameters: Sequence[str]) -> str:
    """Name of a curve and fitted values, in lines that fit above one panel."""
    name = name if len(name) <= _LETTERS - 1 else name[: _LETTERS - 2] + "…"
    words = [f"{label_of(each)} = {quantity(result[each], unit_of(each))}" for each in parameters]
    # a value keeps to its line: spaces within it do not break
    values = ", ".join(printed(word).replace("-", "−").replace(" ", "\u00a0") for word in words)
    return textwrap.fill(f"{name}: {values}" if values else name, _LETTERS, break_on_hyphens=False)


def _ridge(result: FitResult, first: str, second: str, axes: Axes) -> None:
    found = result.ridge(first, second)
    scales = [scale_of(found[name].values, unit_of(label)) for name, label in (("first", first), ("second", second))]
    x, y = (found[name].values * scale[0] for name, scale in zip(("first", "second"), scales, strict=True))
    # growth of the sum of squares, over the noise variance, that bounds 68, 95 and 99.7 % jointly for two parameters
    levels = [0.0, *(-2 * np.log(erfc(np.array([1, 2, 3]) / np.sqrt(2))))]
    axes.contourf(
        np.broadcast_to(x[:, None], y.shape),
        y,
        found["growth"].values,
        levels=levels,
        colors=["#0b4f86", "#6f95b8", "#c4d5e4"],
    )
    axes.plot(x, found["line"].values * scales[1][0], color=ORANGE, label="best for each value")
    axes.plot(
        result[first] * scales[0][0], result[second] * scales[1][0], "o", ms=4, color="white", mec="black", mew=THIN
    )
    for values, name, which in ((x, first, "x"), (y, second, "y")):
        if plain_limits(name) is None and values.max() > 4 * values.min():
            logarithmic(axes, which)
    axes.set_xlabel(axis_label(first, scales[0][1]))
    axes.set_ylabel(axis_label(second, scales[1][1]))
    axes.set_title("68, 95, 99.7 % regions")
    axes.legend(loc="best")


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
        y_factor, y_unit = scale_of(found, unit_of(name))
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
        axes.set_xlabel(f"largest fitted depth ({x_unit})")
        axes.set_ylabel(axis_label(name, y_unit))
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
        poisson = layer_on_top(result.case)[1].poisson
        axes.axhline(young / (1 - poisson**2) * y_factor, color=ORANGE, lw=THIN, ls=style, label=f"film, {name}")
    axes.set_xlabel(f"contact depth $h_c$ ({x_unit})")
    axes.set_ylabel(f"plane-strain modulus $E^*$ ({y_unit})")
    axes.set_xlim(left=0)
    legend_below(axes, ncols=3)
