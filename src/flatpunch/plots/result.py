"""The picture of a result: force and stiffness over depth, the contact outline on the indenter, the pressure.

`figure` puts the three side by side, or as the style of a journal has it. The curve begins at zero, is smooth between the steps,
and grey where the theory does not hold. Figures are made without pyplot, so nothing depends on a display or on a global state.
Units get the prefix that keeps numbers readable.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import scipy
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flatpunch._support.checks import Array, Flags, switch
from flatpunch._support.whole_file import whole_file
from flatpunch.contact.curve import percent
from flatpunch.contact.default import EXACT
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.plots.bodies import plot_medium
from flatpunch.plots.loops import adhesion_figure, force_over_depth, history_figure, loop, slip_loop
from flatpunch.plots.outline import last_valid, plot_outline, plot_pressure
from flatpunch.plots.style import (
    BLUE,
    GREY,
    HEADROOM,
    ORANGE,
    SHADE,
    StyleName,
    axes_or_new,
    check_label,
    check_result,
    next_colour,
    panels,
    scale_on,
    styled,
)

_BETWEEN = 10
"""Points that are drawn between two steps."""

_STIFFNESS = "stiffness d$F$/d$d$"
"""Label of the axis on the right."""

_MARKED = 4
"""Steps below which each is marked."""


def plot_curve(
    result: xr.Dataset, axes: Axes | None = None, *, stiffness: bool = True, label: str | None = None
) -> Axes:
    """Draw the force over the depth, and the stiffness on a second axis.

    Between its steps the curve follows their forces and stiffnesses; below the first step it follows the power law that
    force and stiffness of that step imply. Steps at which the theory does not hold are grey. Loops of approach and withdrawal,
    cycles of partial slip and histories over time are drawn as such.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent`, `adhesion_loop` or `partial_slip` returned; of the last with steps of one normal contact.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure. Axes that hold a curve keep their units, and the new one has a colour of its own.
    stiffness : bool
        Whether the stiffness is drawn, on an axis on the right.
    label : str, optional
        Name of the curve in the legend.

    Returns
    -------
    matplotlib.axes.Axes
        The axes of the force.

    See Also
    --------
    plot_outline, plot_pressure : The contact of one step.
    plot_fit : A measured curve with its fit.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase())
    >>> curve = fp.indent(gel, fp.Sphere(radius=5e-6), depth=np.linspace(1e-8, 3e-7, 30))
    >>> axes = fp.plot_curve(curve)
    >>> axes.get_ylabel()
    'normal force $F$ (nN)'
    """
    check_result(result, "depth", "force")
    check_label(label)
    switch("stiffness", stiffness)
    axes = axes_or_new(axes)
    if "branch" in result:
        return loop(result, axes)
    if "stick_radius" in result:
        return slip_loop(result, axes)
    if "relaxation" in result.attrs:
        return force_over_depth(result, axes)
    check_result(result, "depth", "force", "stiffness", "valid")
    colour = next_colour(axes)
    _force(result, axes, colour, label)
    if stiffness and "work_of_adhesion" not in result.attrs:
        _stiffness(result, axes, ORANGE if colour == BLUE else colour)
    if label is not None:
        axes.legend(frameon=False, fontsize="small")
    return axes


def _force(result: xr.Dataset, axes: Axes, colour: str, label: str | None) -> None:
    first = not axes.has_data()
    (by_depth, depth_unit), (by_force, force_unit) = (
        scale_on(axis, result[name].values, unit)
        for axis, name, unit in ((axes.xaxis, "depth", "m"), (axes.yaxis, "force", "N"))
    )
    depth, force = result["depth"].values * by_depth, result["force"].values * by_force
    rate = result["stiffness"].values * by_force / by_depth
    valid = result["valid"].values.astype(bool)
    rising = _rising(depth, force) and bool(np.isfinite(rate).all())
    x, y, sound = depth, force, valid
    if rising:
        exponent = _exponent(float(depth[0]), float(force[0]), float(rate[0]))
        hermite = scipy.interpolate.CubicHermiteSpline
        x, y, sound = _smooth(depth, force, valid, lambda at: hermite(depth, force, rate)(at), exponent)
    axes.plot(x, np.where(sound, y, np.nan), color=colour, label=label or "force")
    if not valid.all():
        axes.plot(x, np.where(sound, np.nan, y), color=GREY, label="force, theory does not hold")
    if depth.size < _MARKED:
        for chosen, marked in ((valid, colour), (~valid, GREY)):
            axes.plot(depth[chosen], force[chosen], "o", color=marked, markersize=4)
    _error_band(result, axes, depth, force, colour)
    if (force >= 0).all() and (first or axes.get_ylim()[0] == 0):
        top = HEADROOM * float(np.nanmax(force[np.isfinite(force)], initial=0.0))
        # room for the curves that are there
        right, above = (0.0, 0.0) if first else (axes.get_xlim()[1], axes.get_ylim()[1])
        axes.set_xlim(0, None if first else max(right, HEADROOM * float(np.nanmax(depth))))
        axes.set_ylim(0, max(top, above) or None)
    axes.set(xlabel=f"indentation depth $d$ ({depth_unit})", ylabel=f"normal force $F$ ({force_unit})")
    if first:
        axes.set_title(_title(result, valid))


def _stiffness(result: xr.Dataset, axes: Axes, colour: str) -> None:
    depth = result["depth"].values * scale_on(axes.xaxis, result["depth"].values, "m")[0]
    drawn = axes.get_figure()
    assert drawn is not None
    beside = (each for each in drawn.axes if each.get_ylabel().startswith(_STIFFNESS))
    right = next((each for each in beside if axes.get_shared_x_axes().joined(axes, each)), None) or axes.twinx()
    factor, unit = scale_on(right.yaxis, result["stiffness"].values, "N/m")
    stiffness = result["stiffness"].values * factor
    valid = result["valid"].values.astype(bool)
    x, y, sound = depth, stiffness, valid
    if _rising(depth, result["force"].values) and np.isfinite(stiffness).all():
        exponent = _exponent(*(float(result[name].values[0]) for name in ("depth", "force", "stiffness")))
        below = None if exponent is None else exponent - 1
        pchip = scipy.interpolate.PchipInterpolator
        x, y, sound = _smooth(depth, stiffness, valid, lambda at: pchip(depth, stiffness)(at), below)
    right.plot(x, np.where(sound, y, np.nan), "--", color=colour, label="stiffness")
    if not valid.all():
        right.plot(x, np.where(sound, np.nan, y), "--", color=GREY)
    if depth.size < _MARKED:
        right.plot(depth, stiffness, "s", color=colour, markersize=4, markerfacecolor="white")
    shown = [np.asarray(line.get_ydata(), dtype=float) for line in right.get_lines()]
    largest = max(float(np.nanmax(np.where(np.isfinite(each), each, np.nan), initial=0.0)) for each in shown)
    right.set_ylim(0, HEADROOM * largest if largest > 0 else None)
    alone = colour == ORANGE
    axes.yaxis.label.set_color(BLUE if alone else "black")
    right.set_ylabel(f"{_STIFFNESS} ({unit})", color=ORANGE if alone else "black")


def _rising(depth: Array, force: Array) -> bool:
    """Whether a curve is one of loading, from which it is known between its steps."""
    finite = np.isfinite(depth) & np.isfinite(force)
    return bool(finite.all() and depth[0] >= 0 and force[0] >= 0 and (np.diff(depth) > 0).all())


def _exponent(depth: float, force: float, rate: float) -> float | None:
    """Exponent m of the power law F ~ d^m that force and stiffness of one step imply."""
    return rate * depth / force if depth > 0 and force > 0 and rate > 0 else None


def _smooth(
    depth: Array, values: Array, valid: Flags, curve: Callable[[Array], Array], exponent: float | None
) -> tuple[Array, Array, Flags]:
    """Depths, a curve between the steps and below the first of them its power law, and whether the theory holds there."""
    share = np.arange(_BETWEEN) / _BETWEEN
    between = np.append((depth[:-1, None] + np.diff(depth)[:, None] * share).ravel(), depth[-1])
    sound = np.append(np.repeat(valid[:-1] & valid[1:], _BETWEEN), valid[-1])
    sound[::_BETWEEN] = valid
    y = values if depth.size == 1 else curve(between)
    if exponent is None or exponent < 0:
        return between, y, sound
    start = np.linspace(0, depth[0], 3 * _BETWEEN, endpoint=False)
    below = values[0] * (start / depth[0]) ** exponent
    return np.append(start, between), np.append(below, y), np.append(np.full(start.size, valid[0]), sound)


def _title(result: xr.Dataset, valid: Flags) -> str:
    if result.attrs.get("method_reason") == EXACT:
        words = EXACT
    elif "force_error" in result:
        error = result["force_error"].values
        known = error[np.isfinite(error)]
        words = f"method {result.attrs['method']}" + (f", force to {percent(float(known.max()))}" if known.size else "")
    else:
        words = f"method {result.attrs.get('method', 'unknown')}"
    return words[0].upper() + words[1:] + ("" if valid.all() else "; grey where the theory fails")


def _error_band(result: xr.Dataset, axes: Axes, depth: Array, force: Array, colour: str) -> None:
    if "force_error" not in result:
        return
    known = np.isfinite(result["force_error"].values)
    error = np.where(known, result["force_error"].values, 0.0)
    axes.fill_between(
        depth, force * (1 - error), force * (1 + error), where=known, color=colour, alpha=SHADE, linewidth=0
    )


def figure(
    result: xr.Dataset, medium: Body, indenter: Indenter, *, title: str = "", style: StyleName | str = "screen"
) -> Figure:
    """Return force-depth curve, outline and pressure map, and the modulus over depth of graded bodies, side by side on a screen.

    Adhesive contacts get the loop of approach and withdrawal instead, partial slip its cycle, histories both over time.
    """
    with styled(style) as chosen:
        if "stick_radius" in result:
            drawn, (only,) = panels(chosen, 1, title=title)
            slip_loop(result, only)
            return drawn
        if "relaxation" in result.attrs:
            return history_figure(result, indenter, chosen, title=title)
        if "work_of_adhesion" in result.attrs:
            return adhesion_figure(result, medium, indenter, chosen, title=title)
        drawn, (first, second, third, *more) = panels(chosen, 3 + medium.varies, title=title)
        plot_curve(result, first)
        plot_outline(result, second, indenter=indenter)
        _pressure_or_reason(result, medium, indenter, third)
        for axes in more:
            plot_medium(medium, axes, contact_radius=float(result["radius"].values[last_valid(result)]))
    return drawn


def _pressure_or_reason(result: xr.Dataset, medium: Body, indenter: Indenter, axes: Axes) -> None:
    """Some steps have a force and an outline, but a history that gives no pressure."""
    try:
        plot_pressure(result, medium, indenter, axes)
    except ValueError as error:
        axes.set_axis_off()
        axes.text(0.5, 0.5, f"No pressure map:\n{error}", ha="center", va="center", wrap=True)


def save_figure(drawn: Figure, path: str | Path) -> Path:
    """Write a figure as PNG, PDF or SVG, by the ending; whole or not at all."""
    path = Path(path)
    known = sorted(drawn.canvas.get_supported_filetypes())
    if path.suffix.lower().removeprefix(".") not in known:
        raise ValueError(f"{path}: the ending must be one of {', '.join(known)}.")
    with whole_file(path) as temporary:
        drawn.savefig(temporary, dpi=300, format=path.suffix.lower().removeprefix("."))
    return path
