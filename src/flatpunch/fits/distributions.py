"""Pictures of distributions: one parameter of many curves with its intervals, as a map, as a histogram; draws of a posterior."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.ndimage import gaussian_filter
from scipy.special import ndtr

from flatpunch._support.checks import Array, Flags, instance
from flatpunch.fits.report.table import axis_label, unit_of
from flatpunch.plots.style import BLUE, GREY, ORANGE, PALE, SHADE, THIN, StyleName, axes_or_new, scale_of, sheet, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flatpunch.fits.batch import Batch
    from flatpunch.fits.report.posterior import Posterior

_CELLS = 28
"""Cells along a side of the picture of two parameters of a posterior, and along its histograms."""

_HELD = 2 * ndtr([2, 1]) - 1
"""Share of the draws inside the contours of two parameters: that of two standard deviations and of one, 95 and 68 %."""


def bars(batch: Batch, name: str, axes: Axes) -> None:
    """Values with their intervals, one a curve, in the order of the curves."""
    values = batch.trusted(name)
    factor, unit = scale_of(values, unit_of(batch.number(name)))
    low, high = (np.asarray(batch.column(f"{name} {end}"), dtype=float) for end in ("low", "high"))
    spread: Any = np.abs(np.stack([values - low, high - values])) * factor
    number = np.arange(1, values.size + 1)
    known = np.isfinite(values)
    options: Any = {"fmt": "o", "ms": 4, "color": BLUE, "ecolor": GREY, "elinewidth": 1, "capsize": 2}
    axes.errorbar(number[known], values[known] * factor, np.nan_to_num(spread[:, known], posinf=0.0), **options)
    for i in number[~known]:
        axes.axvline(i, color=PALE, lw=THIN, ls=":")
    axes.set_xlabel("curve")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel(axis_label(batch.number(name), unit))
    lost = int((~known).sum())
    axes.set_title(f"{values.size - lost} curves" + (f", {lost} left out (dotted)" if lost else ""))


def map_figure(batch: Batch, name: str, *, style: StyleName | str = "screen") -> Figure:
    """Values of one parameter over a force map, or with their intervals in the order of the curves, beside their histogram."""
    x, y = (np.asarray(batch.column(f"position {axis}"), dtype=float) for axis in ("x", "y"))
    placed = np.isfinite(x) & np.isfinite(y)
    with styled(style) as chosen:
        one = chosen.width is not None and chosen.width == chosen.panel[0]
        figure = Figure(figsize=sheet(chosen, 3 / 2 if one else 0.5, 2), layout="constrained")
        mapped = placed.sum() > 1
        left, right = figure.subplots(2, 1) if one else figure.subplots(1, 2, width_ratios=(1 if mapped else 3 / 2, 1))
        if mapped:
            _map(batch, name, left, x, y, placed)
        else:
            bars(batch, name, left)
        _histogram(batch, name, right)
    return figure


def _histogram(batch: Batch, name: str, axes: Axes) -> None:
    """Histogram with the standard error of its counts, and the median with its 95 % interval.

    A share p of n curves falls into a bin by chance: its count has the variance n p (1 - p).
    """
    values = batch.trusted(name)
    factor, unit = scale_of(values, unit_of(batch.number(name)))
    known = values[np.isfinite(values)] * factor
    if known.size:
        counts, edges, _ = axes.hist(known, bins="auto", color=PALE, edgecolor="white", linewidth=THIN)
        counts = np.asarray(counts, dtype=float)
        error = np.sqrt(counts * (1 - counts / known.size))
        low_error: Any = np.array([np.minimum(error, counts), error])
        axes.errorbar((edges[1:] + edges[:-1]) / 2, counts, low_error, fmt="none", ecolor=GREY, elinewidth=1, capsize=2)
        median = batch.median(name)
        axes.axvline(median.value * factor, color=BLUE)
        within = ""
        if np.isfinite(median.low):
            axes.axvspan(median.low * factor, median.high * factor, color=BLUE, alpha=SHADE, lw=0)
            within = f" (95 % in {median.low * factor:.4g} to {median.high * factor:.4g})"
        low, high = np.quantile(known, ndtr([-1, 1]))
        for end in (low, high):
            axes.axvline(end, color=BLUE, lw=1, ls="--")
        lost = values.size - known.size
        left_out = f", {lost} left out" if lost else ""
        axes.set_title(
            f"{known.size} curves{left_out}\nmedian {median.value * factor:.4g}{within}\n"
            f"middle two thirds {low:.3g} to {high:.3g} {unit}".rstrip()
        )
    axes.set(xlabel=axis_label(batch.number(name), unit), ylabel="curves")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _map(batch: Batch, name: str, axes: Axes, x: Array, y: Array, placed: Flags) -> None:
    """Values over the positions of a force map; curves that are left out are masked and crossed out."""
    values = batch.trusted(name)
    factor, unit = scale_of(values, unit_of(batch.number(name)))
    span = float(max(np.ptp(x[placed]), np.ptp(y[placed])))
    scale, length = scale_of([span], "m")
    x, y = ((along - along[placed].min()) * scale for along in (x, y))
    columns, rows = (np.unique(np.round(along[placed] / (span * scale), 4)) * span * scale for along in (x, y))
    # most cells of a grid for each curve; positions that would need more are scattered, and drawn as squares
    if min(columns.size, rows.size) > 1 and columns.size * rows.size <= 2 * placed.sum():
        cells = np.full((rows.size, columns.size), np.nan)
        at = tuple(
            np.abs(along[placed] - places[:, None]).argmin(axis=0) for along, places in ((y, rows), (x, columns))
        )
        cells[at] = values[placed] * factor
        axes.set_facecolor("0.88")
        drawn: Any = axes.pcolormesh(columns, rows, cells, shading="nearest", cmap="viridis", rasterized=True)
    else:
        across = max(columns.size, rows.size, 4)
        drawn = axes.scatter(x, y, c=values * factor, s=(250 / across) ** 2, marker="s", cmap="viridis")
    bad = placed & ~np.isfinite(values)
    axes.plot(x[bad], y[bad], "x", color=GREY)
    figure = axes.get_figure()
    assert figure is not None
    figure.colorbar(drawn, ax=axes, label=axis_label(batch.number(name), unit))
    axes.set(aspect="equal", xlabel=f"$x$ ({length})", ylabel=f"$y$ ({length})")
    lost = int(bad.sum())
    axes.set_title(f"{values.size - lost} curves" + (f", {lost} left out (crosses)" if lost else ""))


def plot_posterior(posterior: Posterior, name: str, second: str | None = None, axes: Axes | None = None) -> Axes:
    """Draw the posterior of one parameter as a histogram, or of two as a map with contours that hold 68 and 95 %.

    Parameters
    ----------
    posterior : Posterior
        What `FitResult.posterior` returned.
    name, second : str
        Parameters, along the axes.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    plot_fit : The fit itself.

    Examples
    --------
    >>> gel, tip = fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6)
    >>> depth = np.linspace(-2e-7, 4e-7, 300)
    >>> force = np.zeros(300)
    >>> force[depth > 0] = fp.indent(gel, tip, depth=depth[depth > 0]).force
    >>> force += 1e-11 * np.random.default_rng(0).normal(size=300)
    >>> fitted = fp.fit(fp.Curve(depth=depth, force=force), gel, tip, ["base.young"])
    >>> axes = fp.plot_posterior(fitted.posterior(draws=2000), "base.young", "contact")
    >>> axes.get_xlabel()
    "Young's modulus of base (kPa)"
    """
    # posteriors are loaded with their sampler
    from flatpunch.fits.report.posterior import Posterior

    instance("posterior", posterior, (Posterior,), "a Posterior, as `FitResult.posterior` returns it")
    drawn = axes_or_new(axes)
    _draws(posterior, name, second, drawn)
    return drawn


def posterior_figure(
    posterior: Posterior, names: Sequence[str] | None = None, *, style: StyleName | str = "screen"
) -> Figure:
    """Corner picture: each parameter along the diagonal, each pair below it."""
    wanted = tuple(posterior.names if names is None else names)
    count = len(wanted)
    with styled(style) as chosen:
        side = chosen.width if chosen.width is not None else 1 + 2 * count
        figure = Figure(figsize=(side, side), layout="constrained")
        panels = figure.subplots(count, count, squeeze=False, sharex="col")
        for i, row in enumerate(wanted):
            for j, column in enumerate(wanted):
                axes = panels[i, j]
                if j > i:
                    axes.set_axis_off()
                    continue
                _draws(posterior, column, None if i == j else row, axes)
                axes.label_outer()
        figure.align_labels()
    return figure


def _draws(posterior: Posterior, name: str, second: str | None, axes: Axes) -> None:
    """Draws of one parameter as a histogram with median and interval, of two as points with contours."""
    scales = [
        (each, *scale_of(posterior[each], unit_of(posterior.numbers[each])))
        for each in (name, second)
        if each is not None
    ]
    values = [posterior[each] * factor for each, factor, _ in scales]
    labels = [axis_label(posterior.numbers[each], unit) for each, _, unit in scales]
    if second is None:
        axes.hist(values[0], bins=_CELLS, density=True, color=PALE, edgecolor="white", linewidth=0.5)
        for end in posterior.interval(name):
            axes.axvline(end * scales[0][1], color=BLUE, lw=1, ls="--")
        axes.axvline(float(np.median(values[0])), color=BLUE)
        axes.set_yticks([])
    else:
        counts, *edges = np.histogram2d(values[0], values[1], bins=_CELLS)
        smooth = gaussian_filter(counts, 1.0, mode="constant")
        ordered = np.sort(smooth.ravel())[::-1]
        places = np.searchsorted(np.cumsum(ordered) / ordered.sum(), _HELD)
        levels = [*ordered[np.minimum(places, ordered.size - 1)], smooth.max()]
        axes.plot(*values, ",", color=GREY, alpha=0.5, rasterized=True)
        if levels[0] < levels[1] < levels[2]:
            axes.contourf(*((e[1:] + e[:-1]) / 2 for e in edges), smooth.T, levels, colors=[PALE, BLUE], alpha=0.5)
        axes.plot(*map(np.median, values), "+", color=ORANGE, ms=10, mew=2 * THIN)
        axes.yaxis.set_major_locator(MaxNLocator(3))
    axes.set(xlabel=labels[0], ylabel=labels[1] if second is not None else "density")
    axes.xaxis.set_major_locator(MaxNLocator(3))
