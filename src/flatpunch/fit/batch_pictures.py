"""Pictures of batches: one parameter of many curves with its intervals, as a map, and as a histogram."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flatpunch._support.checks import Array, Flags
from flatpunch.fit.report.quantities import axis_label, unit_of
from flatpunch.plots.style import BLUE, GREY, PALE, StyleName, scale_of, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flatpunch.fit.batch import Batch


def first_parameter(batch: Batch) -> str:
    """First column with an interval."""
    return next(name.removesuffix(" low") for name in batch.columns if name.endswith(" low"))


def _trusted(batch: Batch, name: str) -> Array:
    """Values of a parameter; NaN where they cannot be trusted."""
    values = np.asarray(batch.column(name), dtype=float)
    return np.where([bool(row["ok"]) for row in batch.rows], values, np.nan)


def bars(batch: Batch, name: str, axes: Axes) -> None:
    """Values with their intervals, one a curve, in the order of the curves."""
    values = _trusted(batch, name)
    factor, unit = scale_of(values, unit_of(name))
    low, high = (np.asarray(batch.column(f"{name} {end}"), dtype=float) for end in ("low", "high"))
    spread: Any = np.abs(np.stack([values - low, high - values])) * factor
    number = np.arange(1, values.size + 1)
    known = np.isfinite(values)
    options: Any = {"fmt": "o", "ms": 4, "color": BLUE, "ecolor": GREY, "elinewidth": 1, "capsize": 2}
    axes.errorbar(number[known], values[known] * factor, np.nan_to_num(spread[:, known], posinf=0.0), **options)
    for i in number[~known]:
        axes.axvline(i, color=PALE, lw=0.8, ls=":")
    axes.set_xlabel("curve")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel(axis_label(name, unit))
    lost = int((~known).sum())
    axes.set_title(f"{values.size - lost} curves" + (f", {lost} left out (dotted)" if lost else ""))


def map_figure(batch: Batch, name: str, *, style: StyleName | str = "screen") -> Figure:
    """Values of one parameter over a force map, or with their intervals in the order of the curves, beside their histogram.

    Parameters
    ----------
    batch : Batch
        The fits.
    name : str
        Column of the table.
    style : "screen", "one-column" or "two-columns"
        Sizes and fonts.
    """
    x, y = (np.asarray(batch.column(f"position {axis}"), dtype=float) for axis in ("x", "y"))
    placed = np.isfinite(x) & np.isfinite(y)
    with styled(style) as chosen:
        one = chosen.width is not None and chosen.width == chosen.panel[0]
        size = (3.5, 5.2) if one else (chosen.width or 8.8, 0.45 * (chosen.width or 8.8))
        figure = Figure(figsize=size, layout="constrained")
        left, right = figure.subplots(2, 1) if one else figure.subplots(1, 2, width_ratios=(1.7, 1))
        if placed.sum() > 1:
            _map(batch, name, left, x, y, placed)
        else:
            bars(batch, name, left)
        _histogram(batch, name, right)
    return figure


def _histogram(batch: Batch, name: str, axes: Axes) -> None:
    """Histogram of the values, with their median and middle two thirds."""
    values = _trusted(batch, name)
    factor, unit = scale_of(values, unit_of(name))
    known = values[np.isfinite(values)] * factor
    if known.size:
        axes.hist(known, bins="auto", color=PALE, edgecolor="white", linewidth=0.8)
        low, middle, high = np.percentile(known, [16, 50, 84])
        axes.axvline(middle, color=BLUE)
        for end in (low, high):
            axes.axvline(end, color=BLUE, lw=1, ls="--")
        axes.set_title(f"median {middle:.3g}, middle two thirds\n{low:.3g} to {high:.3g} {unit}".rstrip())
    axes.set_xlabel(axis_label(name, unit))
    axes.set_ylabel("curves")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _map(batch: Batch, name: str, axes: Axes, x: Array, y: Array, placed: Flags) -> None:
    """Values over the positions of a force map, as squares of about the map's spacing."""
    values = _trusted(batch, name)
    factor, unit = scale_of(values, unit_of(name))
    span = float(max(np.ptp(x[placed]), np.ptp(y[placed])))
    scale, length = scale_of([span], "m")
    across = max(*(np.unique(np.round(along[placed] / span, 4)).size for along in (x, y)), 4)
    x, y = ((along - along[placed].min()) * scale for along in (x, y))
    points: Any = axes.scatter(x, y, c=values * factor, s=(250 / across) ** 2, marker="s", cmap="viridis")
    bad = placed & ~np.isfinite(values)
    axes.plot(x[bad], y[bad], "x", color=GREY)
    drawn = axes.get_figure()
    assert drawn is not None
    drawn.colorbar(points, ax=axes, label=axis_label(name, unit))
    axes.set_aspect("equal")
    axes.set_xlabel(f"$x$ ({length})")
    axes.set_ylabel(f"$y$ ({length})")
    lost = int(bad.sum())
    axes.set_title(f"{values.size - lost} curves" + (f", {lost} left out (crosses)" if lost else ""))
