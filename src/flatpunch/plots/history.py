"""Picture of a viscoelastic contact: force and depth over time, force over depth, and the size of the contact."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flatpunch._support.checks import Array
from flatpunch.indenters.profile import Indenter
from flatpunch.plots.outline import plot_outline
from flatpunch.plots.style import BLUE, GREEN, GREY, HEADROOM, ORANGE, THIN, Style, panels, scaled

_FORCE, _DEPTH, _RADIUS, _INVALID = BLUE, ORANGE, GREEN, GREY


def over_time(result: xr.Dataset, axes: Axes) -> Axes:
    """Draw force and depth of a history over time; the depth gets a second axis on the right."""
    time, time_label = _quantity(result, "time", "time $t$", "s")
    force, force_label = _quantity(result, "force", "normal force $F$", "N")
    depth, depth_label = _quantity(result, "depth", "indentation depth $d$", "m")
    right = axes.twinx()
    right.grid(visible=False)
    _line(axes, time, force, _FORCE, "-", result)
    _line(right, time, depth, _DEPTH, "--", result)
    axes.set_xlabel(time_label)
    axes.set_ylabel(force_label, color=_FORCE)
    right.set_ylabel(depth_label, color=_DEPTH)
    # an infinite force begins a sudden step of a body without an instantaneous modulus
    for target, values in ((axes, force), (right, depth)):
        finite = values[np.isfinite(values)]
        target.set_ylim(min(0.0, HEADROOM * finite.min()), HEADROOM * finite.max())
    axes.set_title("Force (solid) and depth (dashed)")
    return axes


def force_over_depth(result: xr.Dataset, axes: Axes) -> Axes:
    """Draw force over depth, with an arrow for the sense of time; the area within is the work lost."""
    depth, depth_label = _quantity(result, "depth", "indentation depth $d$", "m")
    force, force_label = _quantity(result, "force", "normal force $F$", "N")
    _line(axes, depth, force, _FORCE, "-", result)
    for after in (False, True):
        _arrow(axes, depth, force, after=after)
    axes.axhline(0, color="black", linewidth=THIN)
    axes.set_xlabel(depth_label)
    axes.set_ylabel(force_label)
    axes.set_title("Force over depth, arrows in the sense of time")
    return axes


def radius_over_time(result: xr.Dataset, axes: Axes) -> Axes:
    """Draw the mean contact radius over time."""
    time, time_label = _quantity(result, "time", "time $t$", "s")
    radius, radius_label = _quantity(result, "radius", "mean contact radius $a_0$", "m")
    _line(axes, time, radius, _RADIUS, "-", result)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(time_label)
    axes.set_ylabel(radius_label)
    axes.set_title("Contact radius")
    return axes


def figure(result: xr.Dataset, indenter: Indenter, style: Style, *, title: str = "") -> Figure:
    """Return the three pictures side by side; of tips that are not round the largest outline instead of the radius."""
    drawn, (left, middle, right) = panels(style, 3, title=title)
    over_time(result, left)
    force_over_depth(result, middle)
    largest = np.where(result["valid"].values, result["radius"].values, 0.0)
    if indenter.round or not largest.max() > 0:
        radius_over_time(result, right)
    else:
        plot_outline(result, right, indenter=indenter, step=int(np.argmax(largest)))
    return drawn


def _quantity(result: xr.Dataset, name: str, words: str, unit: str) -> tuple[Array, str]:
    """Values in a readable unit, and the label of their axis."""
    values, prefixed = scaled(result[name].values, unit)
    return values, f"{words} ({prefixed})"


def _line(axes: Axes, x: Array, y: Array, colour: str, style: str, result: xr.Dataset) -> None:
    """Draw a line, grey where the theory does not hold."""
    valid = result["valid"].values.astype(bool)
    finite = np.isfinite(y)
    axes.plot(x, np.where(valid & finite, y, np.nan), style, color=colour)
    if not valid.all():
        axes.plot(x, np.where(valid | ~finite, np.nan, y), style, color=_INVALID)


def _arrow(axes: Axes, x: Array, y: Array, *, after: bool) -> None:
    """Draw an arrow head at half the largest force before it, or at a quarter after it."""
    finite = np.where(np.isfinite(y), y, 0.0)
    top = int(np.argmax(finite))
    way = range(top + 1, y.size - 1) if after else range(1, top)
    if not len(way) or not finite[top] > 0:
        return
    share = 1 / 4 if after else 1 / 2
    at = min(way, key=lambda i: abs(float(finite[i]) - share * float(finite[top])))
    axes.annotate(
        "",
        (x[at + 1], y[at + 1]),
        (x[at - 1], y[at - 1]),
        arrowprops={"arrowstyle": "-|>", "color": _FORCE, "lw": 2 * THIN},
    )
