"""Pictures of contacts with a history: loops of approach and withdrawal with adhesion, of partial slip, and forces over time.

An adhesive loop is that of a machine which prescribes depth or force, the same as the result was solved for (depth, if it was
solved for radii), up to the largest value in it.
"""

from __future__ import annotations

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flatpunch._support.checks import Array
from flatpunch._support.paths import Plain
from flatpunch.contact import adhesion_loop
from flatpunch.contact.slip.steps import loading_and_cycle
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.numerics.extents import ROOM
from flatpunch.plots.outline import NO_CONTACT, plot_outline, plot_pressure
from flatpunch.plots.style import (
    BLUE,
    GREEN,
    GREY,
    HEADROOM,
    ORANGE,
    SHADE,
    THIN,
    Style,
    panels,
    plain,
    scale_of,
    scaled,
)

_APPROACH, _WITHDRAWAL, _EQUILIBRIA = BLUE, ORANGE, GREY


def loop_of(result: xr.Dataset, medium: Body, indenter: Indenter) -> xr.Dataset | None:
    """Return the loop that belongs to a curve of `indent` with adhesion; None if it nowhere presses."""
    by_force = result.attrs["control"] == "force"
    most = float(np.nanmax(result["force" if by_force else "depth"].values))
    if not most > 0:
        return None
    depth, force = (None, most) if by_force else (most, None)
    return adhesion_loop(
        medium,
        indenter,
        work_of_adhesion=float(result.attrs["work_of_adhesion"]),
        range_of_action=result.attrs.get("range_of_action"),
        depth=depth,
        force=force,
    )


def loop(cycle: xr.Dataset, axes: Axes, *, equilibria: xr.Dataset | None = None) -> Axes:
    """Draw a loop of `adhesion_loop`, whose area is the energy lost; unstable equilibria, of `indent` along radii, beneath."""
    depth, force = cycle["depth"].values, cycle["force"].values
    (by_depth, depth_unit), (by_force, force_unit) = scale_of(depth, "m"), scale_of(force, "N")
    back = cycle["branch"].values == 1
    if equilibria is not None:
        shown = equilibria["depth"].values * by_depth, equilibria["force"].values * by_force
        axes.plot(*shown, ":", color=_EQUILIBRIA, label="all equilibria")
    # from the jump-in on, and after the loss at the last depth back to the first touch
    held = cycle["radius"].values > 0
    within = np.append(depth[held], [depth[-1], 0.0]), np.append(force[held], [0.0, 0.0])
    axes.fill(within[0] * by_depth, within[1] * by_force, color=_WITHDRAWAL, alpha=SHADE, linewidth=0)
    # the tip leaves: down to no force at the same depth, and away
    left = np.append(depth[back], [depth[-1], ROOM * min(depth.min(), 0.0)]), np.append(force[back], [0.0, 0.0])
    axes.axhline(0, color="black", linewidth=THIN)
    # both lines are unbroken; the wide one shows on both sides where they coincide
    axes.plot(left[0] * by_depth, left[1] * by_force, color=_WITHDRAWAL, linewidth=4 * THIN, label="withdrawal")
    axes.plot(depth[~back] * by_depth, force[~back] * by_force, color=_APPROACH, label="approach")
    for jump in json.loads(cycle.attrs["jumps"]):
        _mark(jump, axes, (by_depth, depth_unit), (by_force, force_unit))
    low, high = float(force.min()) * by_force, float(force.max()) * by_force
    # room for the legend above the curve
    axes.set_ylim(low - 0.1 * (high - low), high + 0.5 * (high - low))
    axes.set(xlabel=f"indentation depth $d$ ({depth_unit})", ylabel=f"normal force $F$ ({force_unit})")
    axes.set_title(f"Prescribed {cycle.attrs['control']}: {plain(cycle.attrs['energy_lost'], 'J')} lost in a loop")
    axes.legend(loc="upper left")
    return axes


_NAMES = {"jump_in": "jump-in", "pull_off": "pull-off", "outwards": "jump outwards", "inwards": "jump inwards"}
_MARKS = {"jump_in": "o", "pull_off": "s", "outwards": "^", "inwards": "v"}


def slip_loop(result: xr.Dataset, axes: Axes) -> Axes:
    """Draw the first loading of `partial_slip` through its steps, and the cycle of its largest displacement."""
    loading, repeated = loading_and_cycle(result)
    (by_place, place_unit), (by_force, force_unit) = scale_of(loading[0], "m"), scale_of(loading[1], "N")
    scale = np.array([[by_place], [by_force]])
    first, cycle = loading * scale, repeated * scale
    axes.fill(*cycle, color=_WITHDRAWAL, alpha=SHADE, linewidth=0)
    axes.plot(*cycle, color=_WITHDRAWAL, label="cycle")
    axes.plot(*first, color=_APPROACH, label="first loading")
    axes.axhline(0, color="black", linewidth=THIN)
    axes.set(xlabel=f"displacement along the surface ({place_unit})", ylabel=f"tangential force $T$ ({force_unit})")
    lost = float(result["dissipated_energy"].max())
    axes.set_title(f"Friction {result.attrs['friction']:g}: {plain(lost, 'J')} lost in a cycle")
    axes.legend(loc="upper left")
    return axes


def _mark(jump: Plain, axes: Axes, of_depth: tuple[float, str], of_force: tuple[float, str]) -> None:
    """Draw a point at one jump; the legend names it with its values, where no label can cross a line."""
    colour = _APPROACH if jump["kind"] in ("jump_in", "outwards") else _WITHDRAWAL
    at = [jump[name] * by for name, (by, _) in (("depth", of_depth), ("force", of_force))]
    depth, force = (
        f"{value:.3g} {unit}".replace("-", "−") for value, unit in zip(at, (of_depth[1], of_force[1]), strict=True)
    )
    axes.plot(
        *at,
        _MARKS[jump["kind"]],
        color=colour,
        markeredgecolor="black",
        label=f"{_NAMES[jump['kind']]}: {force} at {depth}",
        zorder=4,
    )


def adhesion_figure(result: xr.Dataset, medium: Body, indenter: Indenter, style: Style, *, title: str = "") -> Figure:
    """Return loop, outline and (of round tips) pressure map side by side; the last two at the largest contact."""
    # adhesive pressure is known under round tips only
    drawn, (left, middle, *right) = panels(style, 3 if indenter.round else 2, title=title)
    cycle = loop_of(result, medium, indenter)
    by_radius = result.attrs["control"] == "radius"
    if cycle is not None:
        loop(cycle, left, equilibria=result if by_radius else None)
    else:
        _curve_alone(result, left)
    step = _largest(result)
    plot_outline(result, middle, indenter=indenter, step=step)
    for axes in right:
        plot_pressure(result, medium, indenter, axes, step=step)
    return drawn


def _largest(result: xr.Dataset) -> int:
    radius: Array = np.where(result["valid"].values, result["radius"].values, 0.0)
    if not radius.max() > 0:
        raise ValueError(NO_CONTACT)
    return int(np.argmax(radius))


def _curve_alone(result: xr.Dataset, axes: Axes) -> None:
    """Draw a curve that nowhere presses, so that no loop begins on it."""
    depth, depth_unit = scaled(result["depth"].values, "m")
    force, force_unit = scaled(result["force"].values, "N")
    axes.plot(depth, force, color=_WITHDRAWAL)
    axes.set(xlabel=f"indentation depth $d$ ({depth_unit})", ylabel=f"normal force $F$ ({force_unit})")
    axes.set_title("Withdrawal")


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
    axes.set(xlabel=depth_label, ylabel=force_label, title="Force over depth, arrows in the sense of time")
    return axes


def radius_over_time(result: xr.Dataset, axes: Axes) -> Axes:
    """Draw the mean contact radius over time."""
    time, time_label = _quantity(result, "time", "time $t$", "s")
    radius, radius_label = _quantity(result, "radius", "mean contact radius $a_0$", "m")
    _line(axes, time, radius, _RADIUS, "-", result)
    axes.set_ylim(bottom=0)
    axes.set(xlabel=time_label, ylabel=radius_label, title="Contact radius")
    return axes


def history_figure(result: xr.Dataset, indenter: Indenter, style: Style, *, title: str = "") -> Figure:
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
