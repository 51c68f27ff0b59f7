"""Picture of an adhesive contact: the loop of approach and withdrawal, with the points of jump-in and pull-off.

The loop is that of a machine which prescribes depth or force, the same as the result was solved for (depth, if it was solved
for radii), up to the largest value in it.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flatpunch._support.checks import Array
from flatpunch.contact import adhesion_loop
from flatpunch.files.units import readable, text
from flatpunch.plots.panels import outline, pressure_map

_APPROACH, _WITHDRAWAL, _EQUILIBRIA = "#1f4e79", "#b8541a", "#8c8c8c"
_MAP_POINTS = 241
"""Points along either side of the pressure map: the tension is greatest where the contact ends."""


def loop_of(result: xr.Dataset, medium: Any, indenter: Any) -> xr.Dataset | None:
    """Return the loop that belongs to a curve of `indent` with adhesion; None if it nowhere presses.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    medium, indenter : object
        What it was solved for.
    """
    by_force = result.attrs["control"] == "force"
    most = float(np.nanmax(result["force" if by_force else "depth"].values))
    if not most > 0:
        return None
    depth, force = (None, most) if by_force else (most, None)
    return adhesion_loop(
        medium, indenter, work_of_adhesion=float(result.attrs["work_of_adhesion"]), depth=depth, force=force
    )


def loop(cycle: xr.Dataset, axes: Axes, *, equilibria: xr.Dataset | None = None) -> Axes:
    """Draw a loop of approach and withdrawal; its area is the energy lost.

    Parameters
    ----------
    cycle : xarray.Dataset
        What `adhesion_loop` returned.
    axes : matplotlib.axes.Axes
        Where to draw.
    equilibria : xarray.Dataset, optional
        Curve of `indent` along radii, drawn beneath: the unstable equilibria too.
    """
    depth, force = cycle["depth"].values, cycle["force"].values
    (by_depth, depth_unit), (by_force, force_unit) = (
        readable(float(np.abs(values).max()), unit) for values, unit in ((depth, "m"), (force, "N"))
    )
    back = cycle["branch"].values == 1
    if equilibria is not None:
        shown = equilibria["depth"].values * by_depth, equilibria["force"].values * by_force
        axes.plot(*shown, ":", color=_EQUILIBRIA, linewidth=1.2, label="all equilibria")
    # from the jump-in on, and after the loss at the last depth back to the first touch
    held = cycle["radius"].values > 0
    within = np.append(depth[held], [depth[-1], 0.0]), np.append(force[held], [0.0, 0.0])
    axes.fill(within[0] * by_depth, within[1] * by_force, color=_WITHDRAWAL, alpha=0.1, linewidth=0)
    axes.plot(depth[~back] * by_depth, force[~back] * by_force, color=_APPROACH, label="approach")
    # the tip leaves: down to no force at the same depth, and away
    left = np.append(depth[back], [depth[-1], 1.2 * min(depth.min(), 0.0)]), np.append(force[back], [0.0, 0.0])
    axes.plot(left[0] * by_depth, left[1] * by_force, "--", color=_WITHDRAWAL, label="withdrawal")
    for jump in json.loads(cycle.attrs["jumps"]):
        _mark(jump, axes, by_depth, by_force, below=cycle.attrs["control"] == "force")
    axes.axhline(0, color="black", linewidth=0.6)
    axes.margins(y=0.17)  # room for labels below
    axes.set_xlabel(f"indentation depth $d$ ({depth_unit})")
    axes.set_ylabel(f"normal force $F$ ({force_unit})")
    axes.set_title(f"Prescribed {cycle.attrs['control']}: {text(cycle.attrs['energy_lost'], 'J')} lost in a loop")
    axes.legend(frameon=False)
    return axes


_NAMES = {"jump_in": "jump-in", "pull_off": "pull-off", "outwards": "jump outwards", "inwards": "jump inwards"}


def _mark(jump: dict[str, Any], axes: Axes, by_depth: float, by_force: float, *, below: bool) -> None:
    """Draw a point and its label at one jump."""
    at = jump["depth"] * by_depth, jump["force"] * by_force
    colour = _APPROACH if jump["kind"] in ("jump_in", "outwards") else _WITHDRAWAL
    axes.plot(*at, "o", color=colour, markersize=5)
    force, depth = (text(float(f"{jump[name]:.3g}"), unit) for name, unit in (("force", "N"), ("depth", "m")))
    label = f"{_NAMES[jump['kind']]}\n{force} at {depth}"
    # beside the lines: below the approach, and on the way back within the loop, or below it where pull-off is its lowest point
    offset, side = ((9, -5), "top") if below or colour == _APPROACH else ((8, 4), "bottom")
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
    axes.annotate(label, at, xytext=offset, textcoords="offset points", color=colour, fontsize=8, va=side, bbox=box)


def figure(result: xr.Dataset, medium: Any, indenter: Any, *, title: str = "") -> Figure:
    """Return loop, outline and (of round tips) pressure map side by side; the last two at the largest contact.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned, with adhesion.
    medium, indenter : object
        What it was solved for.
    title : str
        Heading over all three.
    """
    shown = 3 if indenter.round else 2  # adhesive pressure is known under round tips only
    drawn = Figure(figsize=(4.4 * shown, 4.2), layout="constrained")
    left, middle, *right = drawn.subplots(1, shown, width_ratios=(1.25, 1, 1.15)[:shown])
    cycle = loop_of(result, medium, indenter)
    by_radius = result.attrs["control"] == "radius"
    if cycle is not None:
        loop(cycle, left, equilibria=result if by_radius else None)
    else:
        _curve_alone(result, left)
    step = _largest(result)
    outline(result, indenter, middle, step=step)
    for axes in right:
        pressure_map(result, medium, indenter, axes, step=step, points=_MAP_POINTS)
    if title:
        drawn.suptitle(title, fontsize=12)
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
    (by_depth, depth_unit), (by_force, force_unit) = (
        readable(float(np.nanmax(np.abs(result[name].values))), unit) for name, unit in (("depth", "m"), ("force", "N"))
    )
    axes.plot(result["depth"].values * by_depth, result["force"].values * by_force, "--", color=_WITHDRAWAL)
    axes.set_xlabel(f"indentation depth $d$ ({depth_unit})")
    axes.set_ylabel(f"normal force $F$ ({force_unit})")
    axes.set_title("Withdrawal")
