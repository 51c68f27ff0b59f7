"""Pictures of fits: the curve with its fit, the ridge between two parameters, a map of values."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from flatpunch.files.units import readable
from flatpunch.fit.parameters.scaling import plain_limits
from flatpunch.fit.report.quantities import label, quantity, unit_of
from flatpunch.fit.viscoelastic.model import HistoryModel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flatpunch.fit.batch import Batch
    from flatpunch.fit.films.film import FilmResult
    from flatpunch.fit.report.joint import JointResult
    from flatpunch.fit.report.result import FitResult

_DATA, _FIT, _GREY = "#8fa9bf", "#b8541a", "#8c8c8c"
_SOLVED = "#1f4e79"
_LONGEST = 32
"""Letters of a curve's name in a title."""
_JOINT = (2.30, 5.99, 11.83)
"""Growth of the sum of squares, over the noise variance, that bounds 68, 95 and 99.7 % jointly for two parameters."""


def fit_figure(result: FitResult, *, ridge: bool | None = None) -> Figure:
    """Curve with fit, residuals, and, where two parameters are hard to tell apart, their ridge.

    Parameters
    ----------
    result : FitResult
        The fit.
    ridge : bool, optional
        Whether to draw the ridge of the two most correlated free parameters; where the notes complain if left out.
    """
    pair = most_tangled(result)
    wanted = pair is not None and (ridge if ridge is not None else _complains(result))
    figure = Figure(figsize=(9.6 if wanted else 5.6, 4.6), layout="constrained")
    grid = figure.add_gridspec(2, 2 if wanted else 1, height_ratios=[3, 1])
    top = figure.add_subplot(grid[0, 0])
    _curve(result, top, figure.add_subplot(grid[1, 0], sharex=top))
    if wanted and pair is not None:
        _ridge(result, *pair, figure.add_subplot(grid[:, 1]))
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


def _curve(result: FitResult, top: Axes, bottom: Axes) -> None:
    """Curve, fit and residuals over depth, or over time where that is what was fitted."""
    over_time = isinstance(result.objective.model, HistoryModel)
    along = result.curve.time if over_time and result.curve.time is not None else result.depth
    x_factor, x_unit = readable(float(np.abs(along).max()), "s" if over_time else "m")
    y_factor, y_unit = readable(float(np.abs(result.curve.force).max()), "N")
    x, order = along * x_factor, np.argsort(along, kind="stable")
    fitted, residual = result.force, result.residual
    left = ~result.used
    top.plot(x, result.curve.force * y_factor, ".", ms=2, color=_DATA, label="measured", rasterized=True)
    if left.any():
        top.plot(
            x[left], result.curve.force[left] * y_factor, "x", ms=4, color=_GREY, label="left out", rasterized=True
        )
    top.plot(x[order], fitted[order] * y_factor, color=_FIT, lw=1.4, label="fitted")
    if not over_time:
        top.axvline(0, color=_GREY, lw=0.6, ls=":")
    top.set_ylabel(f"force / {y_unit}")
    top.legend(frameon=False, fontsize=8, loc="best")
    free = result.objective.model.free
    words = [f"{label(name)} = {quantity(result[name], unit_of(name))}" for name in free]
    top.set_title(_lines(result.curve.name, words), fontsize=9)
    # what was left out would only stretch the axis
    bottom.plot(x[~left], residual[~left] * y_factor, ".", ms=2, color=_DATA, rasterized=True)
    bottom.axhline(0, color=_FIT, lw=0.8)
    bottom.set_xlabel(f"time / {x_unit}" if over_time else f"depth / {x_unit}")
    bottom.set_ylabel(f"residual / {y_unit}")
    for axes in (top, bottom):
        axes.grid(alpha=0.25, lw=0.6)


def together_figure(result: JointResult) -> Figure:
    """Curves of a joint fit, force over depth, and below their residuals over their noise.

    Parameters
    ----------
    result : JointResult
        The fit.
    """
    import matplotlib

    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    grid = figure.add_gridspec(2, 1, height_ratios=[3, 1])
    top = figure.add_subplot(grid[0])
    bottom = figure.add_subplot(grid[1], sharex=top)
    x_factor, x_unit = readable(max(float(r.depth.max()) for r in result.results), "m")
    levels = [r.estimates["baseline"].value if "baseline" in r.estimates else 0.0 for r in result.results]
    tops = [float(r.force.max()) - level for r, level in zip(result.results, levels, strict=True)]
    y_factor, y_unit = readable(max(tops), "N")
    colours = matplotlib.colormaps["viridis"](np.linspace(0, 0.85, len(result.results)))
    for one, level, colour in zip(result.results, levels, colours, strict=True):
        order = np.argsort(one.depth, kind="stable")
        x = one.depth * x_factor
        measured = (one.curve.force - level) * y_factor
        top.plot(x, measured, ".", ms=3, color=colour, label=one.curve.name, rasterized=True)
        top.plot(x[order], ((one.force - level) * y_factor)[order], color="black", lw=0.8)
        bottom.plot(
            x[one.used], one.residual[one.used] / one.noise, ".", ms=2, alpha=0.4, color=colour, rasterized=True
        )
    top.legend(frameon=False, fontsize=8, title="measured; fitted in black", title_fontsize=8, markerscale=3)
    top.set_ylabel(f"force over baseline / {y_unit}")
    words = [f"{label(name)} = {quantity(result[name], unit_of(name))}" for name in result.shared]
    top.set_title(_lines(f"{len(result.results)} curves", words), fontsize=9)
    bottom.axhline(0, color=_GREY, lw=0.8)
    bottom.set_xlabel(f"depth / {x_unit}")
    bottom.set_ylabel("residual / noise")
    for axes in (top, bottom):
        axes.grid(alpha=0.25, lw=0.6)
    return figure


def _lines(name: str, words: Sequence[str]) -> str:
    """Title of at most two values a line."""
    name = name if len(name) <= _LONGEST else name[: _LONGEST - 1] + "…"
    rows = [", ".join(words[i : i + 2]) for i in range(0, len(words), 2)]
    return "\n".join([f"{name}: {rows[0]}", *rows[1:]]) if rows else name


def _ridge(result: FitResult, first: str, second: str, axes: Axes) -> None:
    found = result.ridge(first, second)
    scales = [
        readable(float(np.abs(found[name]).max()), unit_of(label))
        for name, label in (("first", first), ("second", second))
    ]
    x, y = (found[name].values * scale[0] for name, scale in zip(("first", "second"), scales, strict=True))
    axes.contourf(
        np.broadcast_to(x[:, None], y.shape),
        y,
        found["growth"].values,
        levels=[0, *_JOINT],
        colors=["#1f4e79", "#6f95b8", "#c4d5e4"],
    )
    axes.plot(x, found["line"].values * scales[1][0], color="#b8541a", lw=1.2, label="best for each value")
    axes.plot(
        result[first] * scales[0][0], result[second] * scales[1][0], "o", ms=4, color="white", mec="black", mew=0.8
    )
    for values, name, scale in ((x, first, axes.set_xscale), (y, second, axes.set_yscale)):
        if plain_limits(name) is None and values.max() > 5 * values.min():
            scale("log")
    axes.set_xlabel(f"{label(first)} / {scales[0][1] or '1'}")
    axes.set_ylabel(f"{label(second)} / {scales[1][1] or '1'}")
    axes.set_title("68, 95, 99.7 % regions", fontsize=9)
    axes.legend(frameon=False, fontsize=8)


def drift_figure(
    results: Sequence[FitResult], name: str, beside: Sequence[FitResult] = (), beside_name: str = ""
) -> Figure:
    """One parameter over the depth up to which was fitted, with intervals; another model's beside it.

    Parameters
    ----------
    results, beside : sequence of FitResult
        Fits of the same curve up to several depths, of the layered model and of another one (a half-space, usually).
    name, beside_name : str
        The parameter in either.
    """
    figure = Figure(figsize=(5.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    x_factor, x_unit = readable(max(float(r.depth.max()) for r in (*results, *beside)), "m")
    y_factor, y_unit = readable(
        max(abs(r[n]) for rs, n in ((results, name), (beside, beside_name)) for r in rs), unit_of(name)
    )
    for fits, parameter, colour, words in (
        (results, name, _SOLVED, "layered model"),
        (beside, beside_name, _FIT, "half-space"),
    ):
        if not fits:
            continue
        x = [float(r.depth.max()) * x_factor for r in fits]
        values = np.array([r[parameter] for r in fits]) * y_factor
        ends = np.array([(r.estimates[parameter].low, r.estimates[parameter].high) for r in fits]) * y_factor
        spread = np.abs(ends - values[:, None]).T
        axes.errorbar(x, values, spread, fmt="o-", ms=4, lw=1.2, capsize=3, color=colour, label=words)
    axes.set_xlabel(f"fitted up to a depth of / {x_unit}")
    axes.set_ylabel(f"{label(name)} / {y_unit or '1'}")
    axes.set_ylim(bottom=0)
    axes.grid(alpha=0.25, lw=0.6)
    axes.legend(frameon=False, fontsize=8)
    return figure


def film_figure(result: FilmResult) -> Figure:
    """Apparent modulus over contact depth: measured, fitted, film, substrate, and what published formulas give for the film.

    Parameters
    ----------
    result : FilmResult
        The fit.
    """
    points = result.points
    x_factor, x_unit = readable(float(points.contact_depth.max()), "m")
    y_factor, y_unit = readable(float(np.median(points.apparent)), "Pa")
    figure = Figure(figsize=(6.4, 4.6), layout="constrained")
    axes = figure.add_subplot()
    x = points.contact_depth * x_factor
    order = np.argsort(x)
    axes.plot(x, points.apparent * y_factor, ".", ms=3, color=_DATA, label="measured", rasterized=True)
    axes.plot(x[order], (result.model * y_factor)[order], color=_FIT, lw=1.4, label="film and substrate, fitted")
    axes.axhline(result.case.surface_modulus * y_factor, color=_SOLVED, lw=1, ls="--", label="film")
    base = getattr(result.case, "base", None)
    if base is not None and hasattr(base, "surface_modulus"):
        axes.axhline(base.surface_modulus * y_factor, color=_GREY, lw=1, ls="--", label="substrate")
    for (name, (young, _)), style in zip(
        result.others.items(), (":", "-.", (0, (1, 3)), (0, (5, 5)), (0, (3, 1))), strict=False
    ):
        poisson = float(result.case.layers[0].poisson)
        axes.axhline(young / (1 - poisson**2) * y_factor, color=_GREY, lw=0.8, ls=style, label=f"film, {name}")
    axes.set_xlabel(f"contact depth / {x_unit}")
    axes.set_ylabel(f"plane-strain modulus / {y_unit}")
    axes.set_xlim(left=0)
    axes.grid(alpha=0.25, lw=0.6)
    axes.legend(frameon=False, fontsize=7)
    return figure


def map_figure(batch: Batch, name: str) -> Figure:
    """Values of one parameter over the positions of a force map; over the order of the curves if there are no positions.

    Parameters
    ----------
    batch : Batch
        The fits.
    name : str
        Column of the table.
    """
    values = np.asarray(batch.column(name), dtype=float)
    # values that cannot be trusted are crossed out, not shown
    values = np.where([bool(row["ok"]) for row in batch.rows], values, np.nan)
    finite = np.abs(values[np.isfinite(values)])
    factor, unit = readable(float(finite.max()) if finite.size else 0.0, unit_of(name))
    figure = Figure(figsize=(5.6, 4.6), layout="constrained")
    axes = figure.add_subplot()
    x, y = (np.asarray(batch.column(f"position {axis}"), dtype=float) for axis in ("x", "y"))
    placed = np.isfinite(x) & np.isfinite(y)
    if placed.sum() > 1:
        span = max(np.ptp(x[placed]), np.ptp(y[placed]))
        scale, length = readable(float(span), "m")
        drawn: Any = axes.scatter(
            (x - x[placed].min()) * scale,
            (y - y[placed].min()) * scale,
            c=values * factor,
            # squares of about a map's spacing
            s=(
                250
                / max(np.unique(np.round(x[placed] / span, 4)).size, np.unique(np.round(y[placed] / span, 4)).size, 4)
            )
            ** 2,
            marker="s",
            cmap="viridis",
        )
        bad = placed & ~np.isfinite(values)
        axes.plot((x[bad] - x[placed].min()) * scale, (y[bad] - y[placed].min()) * scale, "x", color=_GREY)
        figure.colorbar(drawn, label=f"{label(name)} / {unit or '1'}")
        axes.set_aspect("equal")
        axes.set_xlabel(f"x / {length}")
        axes.set_ylabel(f"y / {length}")
    else:
        low, high = (np.asarray(batch.column(f"{name} {end}"), dtype=float) for end in ("low", "high"))
        order = np.arange(values.size)
        axes.vlines(order, low * factor, high * factor, color=_DATA, lw=1)
        axes.plot(order, values * factor, ".", ms=4, color=_FIT)
        axes.set_xlabel("curve")
        axes.set_ylabel(f"{label(name)} / {unit or '1'}")
        axes.grid(alpha=0.25, lw=0.6)
    failed = len(batch.failed)
    axes.set_title(f"{values.size - failed} curves" + (f", {failed} left out" if failed else ""), fontsize=9)
    return figure
