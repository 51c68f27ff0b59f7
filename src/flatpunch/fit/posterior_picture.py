"""Pictures of posteriors: one parameter along the diagonal, two parameters below it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flatpunch._support.checks import Array
from flatpunch._support.kinds import instance
from flatpunch.fit.report.quantities import axis_label, unit_of
from flatpunch.plots.style import BLUE, GREY, ORANGE, PALE, SAMPLES, THIN, StyleName, axes_or_new, scale_of, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flatpunch.fit.report.posterior import Posterior

_HELD = (0.95, 0.68)
"""Share of the draws inside the contours."""
_CELLS = 28
"""Cells along a side of a map of two parameters."""


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
    'E of base (kPa)'
    """
    # posteriors are loaded with their sampler
    from flatpunch.fit.report.posterior import Posterior

    instance("posterior", posterior, (Posterior,), "a Posterior, as `FitResult.posterior` returns it")
    drawn = axes_or_new(axes)
    if second is None:
        _histogram(posterior, name, drawn)
    else:
        _map(posterior, name, second, drawn)
    return drawn


def posterior_figure(
    posterior: Posterior, names: Sequence[str] | None = None, *, style: StyleName | str = "screen"
) -> Figure:
    """Corner picture: each parameter along the diagonal, each pair below it."""
    wanted = tuple(posterior.names if names is None else names)
    count = len(wanted)
    with styled(style) as chosen:
        side = chosen.width if chosen.width is not None else 1.0 + 2.1 * count
        figure = Figure(figsize=(side, side), layout="constrained")
        panels = figure.subplots(count, count, squeeze=False, sharex="col")
        for i, row in enumerate(wanted):
            for j, column in enumerate(wanted):
                axes = panels[i, j]
                if j > i:
                    axes.set_axis_off()
                    continue
                if i == j:
                    _histogram(posterior, row, axes)
                else:
                    _map(posterior, column, row, axes)
                if j > 0:
                    axes.set_ylabel("")
                    axes.tick_params(labelleft=False)
                if i < count - 1:
                    axes.set_xlabel("")
                    axes.tick_params(labelbottom=False)
        figure.align_labels()
    return figure


def _values(posterior: Posterior, name: str) -> tuple[Array, str]:
    """Draws in a readable unit, and the label of their axis."""
    draws = posterior[name]
    factor, unit = scale_of(draws, unit_of(name))
    return draws * factor, axis_label(name, unit)


def _histogram(posterior: Posterior, name: str, axes: Axes) -> None:
    values, text = _values(posterior, name)
    factor = float(values[0] / posterior[name][0]) if posterior[name][0] else 1.0
    axes.hist(values, bins=_CELLS, density=True, color=PALE, edgecolor="white", linewidth=0.5)
    low, middle, high = np.quantile(values, [(1 - posterior.level) / 2, 0.5, (1 + posterior.level) / 2])
    axes.axvline(middle, color=BLUE)
    for end in (low, high):
        axes.axvline(end, color=BLUE, lw=1, ls="--")
    prior = posterior.priors.get(name)
    if prior is not None:
        ends = axes.get_xlim()
        at = np.linspace(*ends, SAMPLES)
        density = np.exp(prior.logarithm(at / factor))
        total = _mass(prior, factor)
        axes.plot(at, density / total, color=ORANGE, label="prior")
        axes.set_xlim(*ends)
        axes.legend(loc="best")
    axes.set_yticks([])
    axes.set_xlabel(text)
    axes.set_ylabel("density")
    axes.xaxis.set_major_locator(MaxNLocator(3))


def _mass(prior: Any, factor: float) -> float:
    """Integral of a prior's unscaled density over the values that are shown."""
    low, high = (
        v if np.isfinite(v) else prior.centre + s * 8 * prior.spread
        for v, s in zip(prior.support, (-1, 1), strict=True)
    )
    at = np.linspace(low, high, 4001)[1:-1]
    return float(np.exp(prior.logarithm(at)).sum() * (at[1] - at[0]) * factor)


def _map(posterior: Posterior, first: str, second: str, axes: Axes) -> None:
    x, x_text = _values(posterior, first)
    y, y_text = _values(posterior, second)
    counts, x_edges, y_edges = np.histogram2d(x, y, bins=_CELLS)
    smooth = _smoothed(counts)
    x_mid, y_mid = ((edges[1:] + edges[:-1]) / 2 for edges in (x_edges, y_edges))
    ordered = np.sort(smooth.ravel())[::-1]
    share = np.cumsum(ordered) / ordered.sum()
    levels = [float(ordered[min(int(np.searchsorted(share, held)), ordered.size - 1)]) for held in _HELD]
    axes.plot(x, y, ",", color=GREY, alpha=0.5, rasterized=True)
    if levels[0] < levels[1] < smooth.max():
        axes.contourf(x_mid, y_mid, smooth.T, [*levels, smooth.max()], colors=[PALE, BLUE], alpha=0.5)
    axes.plot(np.median(x), np.median(y), "+", color=ORANGE, ms=10, mew=2 * THIN)
    axes.set_xlabel(x_text)
    axes.set_ylabel(y_text)
    axes.xaxis.set_major_locator(MaxNLocator(3))
    axes.yaxis.set_major_locator(MaxNLocator(3))


def _smoothed(counts: Array) -> Array:
    """Counts with the noise of the draws taken out: weights 1 2 1 both ways, twice."""
    result = np.pad(counts, 2)
    for _ in range(2):
        for axis in (0, 1):
            moved = [np.roll(result, shift, axis) for shift in (-1, 1)]
            result = result / 2 + (moved[0] + moved[1]) / 4
    return np.asarray(result[2:-2, 2:-2])
