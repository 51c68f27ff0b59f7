"""Picture of an adhesive contact: the loop of approach and withdrawal, with the points of jump-in and pull-off.

The loop is that of a machine which prescribes depth or force, the same as the result was solved for (depth, if it was solved
for radii), up to the largest value in it.
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
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.numerics.extents import ROOM
from flatpunch.plots.outline import plot_outline
from flatpunch.plots.pressure import plot_pressure
from flatpunch.plots.style import BLUE, GREY, ORANGE, SHADE, THIN, Style, panels, plain, scale_of, scaled

_APPROACH, _WITHDRAWAL, _EQUILIBRIA = BLUE, ORANGE, GREY


def loop_of(result: xr.Dataset, medium: Body, indenter: Indenter) -> xr.Dataset | None:
    """Return the loop that belongs to a curve of `indent` with adhesion; None if it nowhere presses."""
    by_force = result.attrs["control"] == "force"
    most = float(np.nanmax(result["force" if by_force else "depth"].values))
    if not most > 0:
        return None
    depth, force = (None, most) if by_force else (most, None)
    return adhesion_loop(
        medium, indenter, work_of_adhesion=float(result.attrs["work_of_adhesion"]), depth=depth, force=force
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
    axes.set_xlabel(f"indentation depth $d$ ({depth_unit})")
    axes.set_ylabel(f"normal force $F$ ({force_unit})")
    axes.set_title(f"Prescribed {cycle.attrs['control']}: {plain(cycle.attrs['energy_lost'], 'J')} lost in a loop")
    axes.legend(loc="upper left")
    return axes


_NAMES = {"jump_in": "jump-in", "pull_off": "pull-off", "outwards": "jump outwards", "inwards": "jump inwards"}
_MARKS = {"jump_in": "o", "pull_off": "s", "outwards": "^", "inwards": "v"}


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


def figure(result: xr.Dataset, medium: Body, indenter: Indenter, style: Style, *, title: str = "") -> Figure:
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
        raise ValueError(
            "this result has no step with a contact at which the theory holds, so there is no outline to draw; see its notes."
        )
    return int(np.argmax(radius))


def _curve_alone(result: xr.Dataset, axes: Axes) -> None:
    """Draw a curve that nowhere presses, so that no loop begins on it."""
    depth, depth_unit = scaled(result["depth"].values, "m")
    force, force_unit = scaled(result["force"].values, "N")
    axes.plot(depth, force, color=_WITHDRAWAL)
    axes.set_xlabel(f"indentation depth $d$ ({depth_unit})")
    axes.set_ylabel(f"normal force $F$ ({force_unit})")
    axes.set_title("Withdrawal")
