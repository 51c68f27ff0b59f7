"""Panels of the pictures of a result: force over depth, outline, pressure map."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.path import Path as Outline
from scipy.ndimage import distance_transform_edt

from flatpunch._support.checks import Array, Flags
from flatpunch.bem.height import overlap_half_widths
from flatpunch.contact import pressure
from flatpunch.contact.curve import NOTABLE_OUTLINE, percent
from flatpunch.contact.default import EXACT
from flatpunch.files.units import readable

_FORCE, _STIFFNESS, _OUTLINE, _INVALID = "#1f4e79", "#b8541a", "#c1121f", "#8c8c8c"

_MAP_POINTS = 121
"""Points along either side of a pressure map."""

_NOTABLE = 0.01
"""Median error of a pressure over its mean above which a picture shows it."""


_FREE = 0.87
"""Half-widths of the picture up to which labels of level lines are written."""


def force_depth(result: xr.Dataset, axes: Axes) -> Axes:
    """Draw force and stiffness over depth; steps at which the theory does not hold are grey.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    axes : matplotlib.axes.Axes
        Where to draw; the stiffness gets a second axis on the right.
    """
    depth, depth_unit = _scaled(result["depth"].values, "m")
    force, force_unit = _scaled(result["force"].values, "N")
    stiffness, stiffness_unit = _scaled(result["stiffness"].values, "N/m")
    valid = result["valid"].values.astype(bool)
    marker = "o" if depth.size < 4 else ""
    right = axes.twinx()
    right.grid(visible=False)
    for target, values, colour, line in ((axes, force, _FORCE, "-"), (right, stiffness, _STIFFNESS, "--")):
        target.plot(depth, np.where(valid, values, np.nan), line, color=colour, marker=marker)
        if not valid.all():
            target.plot(depth, np.where(valid, np.nan, values), line, color=_INVALID, marker=marker)
        target.set_ylim(bottom=0)
    axes.set_xlim(left=0)
    axes.set_xlabel(f"indentation depth $d$ ({depth_unit})")
    axes.set_ylabel(f"normal force $F$ ({force_unit})", color=_FORCE)
    right.set_ylabel(f"stiffness d$F$/d$d$ ({stiffness_unit})", color=_STIFFNESS)
    _error_band(result, axes, depth, force)
    axes.set_title("Force (solid) and stiffness (dashed)" + ("" if valid.all() else ", grey where the theory fails"))
    return axes


def _error_band(result: xr.Dataset, axes: Axes, depth: Array, force: Array) -> None:
    """Draw the estimated error of the force as a band, and say how large it is."""
    if "force_error" not in result:
        return
    known = np.isfinite(result["force_error"].values)
    error = np.where(known, result["force_error"].values, 0.0)
    axes.fill_between(
        depth, force * (1 - error), force * (1 + error), where=known, color=_FORCE, alpha=0.25, linewidth=0
    )
    exact = result.attrs.get("method_reason") == EXACT
    said = EXACT if exact else f"force to {percent(float(error.max()))} ({result.attrs['method']})"
    axes.text(0.03, 0.95, said, transform=axes.transAxes, va="top", fontsize=7.5)


def outline(result: xr.Dataset, indenter: Any, axes: Axes, *, step: int | None = None) -> Axes:
    """Draw contact outlines over level lines of the indenter.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    indenter : object
        The indenter it was solved for.
    axes : matplotlib.axes.Axes
        Where to draw.
    step : int, optional
        Which step; by default the last at which the theory holds and the contact has an outline, with three earlier ones thinner.
    """
    last = _last_valid(result) if step is None else step
    phi, contour = result["phi"].values, result["contour"].values
    half = _half_width(result, indenter, last)
    factor, unit = readable(half, "m")
    _level_lines(indenter, half, factor, axes)
    for i in _earlier(result, last) if step is None else []:
        axes.plot(*_curve(contour[i], phi, factor), color=_OUTLINE, linewidth=0.8, alpha=0.45)
    axes.plot(*_curve(contour[last], phi, factor), color=_OUTLINE, linewidth=1.8)
    _frame(axes, half * factor, unit)
    depth, depth_unit = _scaled(result["depth"].values[last : last + 1], "m")
    what = "Contact outline (red)" if _outlined(result)[last] else "Several parts, no outline"
    axes.set_title(f"{what} at $d$ = {depth[0]:.3g} {depth_unit}{_outline_doubt(result, last)}")
    return axes


def _outline_doubt(result: xr.Dataset, step: int) -> str:
    """Estimated error of an outline over its mean radius, where it is worth a word."""
    error = float(result["contour_error"].values[step]) if "contour_error" in result else 0.0
    return f", $\\pm$ {percent(error)}" if NOTABLE_OUTLINE < error < np.inf else ""


def pressure_map(
    result: xr.Dataset, medium: Any, indenter: Any, axes: Axes, *, step: int | None = None, points: int = _MAP_POINTS
) -> Axes:
    """Draw the contact pressure of one step as a map, with a colour bar.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    medium, indenter : object
        What it was solved for.
    axes : matplotlib.axes.Axes
        Where to draw.
    step : int, optional
        Which step; by default the last at which the theory holds and the contact has an outline.
    points : int
        Number of points along either side of the map.
    """
    last = _last_valid(result) if step is None else step
    half = _half_width(result, indenter, last)
    x = np.linspace(-half, half, points)
    # the quantity that was prescribed leads back to the same contact, also where another one does not rise with it
    control: dict[str, Any] = {result.attrs["control"]: float(result[result.attrs["control"]].values[last])}
    work = result.attrs.get("work_of_adhesion")
    field, error = pressure(
        medium,
        indenter,
        x[None, :],
        x[:, None],
        method=result.attrs["method"],
        work_of_adhesion=work,
        return_error=True,
        **control,
    )
    factor, unit = readable(half, "m")
    values, pressure_unit = _scaled(field, "Pa", quantile=True)
    rim = _curve(result["contour"].values[last], result["phi"].values, factor)
    draw = _coloured if work is None else _tension_and_pressure
    mesh = draw(axes, x * factor, values, f"pressure $p$ ({pressure_unit})", bool(np.isfinite(rim).all()))
    axes.plot(*rim, color=_OUTLINE, linewidth=1.0)
    if np.isfinite(rim).all():
        mesh.set_clip_path(Outline(np.column_stack(rim)), axes.transData)
    axes.grid(visible=False)
    _frame(axes, half * factor, unit)
    force, force_unit = _scaled(result["force"].values[last : last + 1], "N")
    axes.set_title(f"Pressure at $F$ = {force[0]:.3g} {force_unit}{_doubt(field, error)}")
    return axes


def _doubt(field: Array, error: Array) -> str:
    """Typical error of a pressure over its mean, where it is worth a word."""
    inside = (field != 0) & np.isfinite(field)
    share = float(np.median(error[inside]) / np.abs(field[inside]).mean()) if inside.any() else 0.0
    return f", $\\pm$ {percent(share)}" if share > _NOTABLE else ""


def _shown(values: Array, clipped: bool) -> Array:
    """Values where there are any; if `clipped` they go on beyond the rim, where the outline will cut them off."""
    empty = values == 0
    if not clipped or empty.all():
        return np.where(empty, np.nan, values)
    rows, columns = distance_transform_edt(empty, return_distances=False, return_indices=True)
    return np.asarray(values[rows, columns])


def _coloured(axes: Axes, x: Array, values: Array, label: str, clipped: bool) -> QuadMesh:
    inside = values[values != 0]
    largest = float(inside.max()) if inside.size else 1.0
    # Pressure is infinite at the edge of a flat end and at a sharp apex: there, colours must not depend on how near a pixel
    # comes to it. Elsewhere the largest pressure is at most a few per cent above this quantile.
    quantile = float(np.quantile(inside, 0.995)) if inside.size else 1.0
    top = largest if largest < 1.1 * quantile else quantile
    # what is infinite would be left blank
    shown, bottom = np.nan_to_num(_shown(values, clipped), nan=np.nan, posinf=top), min(0.0, float(values.min()))
    mesh = axes.pcolormesh(x, x, shown, cmap="viridis", vmin=bottom, vmax=top, shading="nearest", rasterized=True)
    drawn = axes.get_figure()
    assert drawn is not None
    drawn.colorbar(mesh, ax=axes, label=label, shrink=0.82, extend="max" if top < largest else "neither")
    return mesh


def _tension_and_pressure(axes: Axes, x: Array, values: Array, label: str, clipped: bool) -> QuadMesh:
    """Draw an adhesive pressure: tension red, pressure blue, none white.

    At the edge tension is infinite: a twentieth of the contact, along the edge, takes the darkest red.
    """
    inside = values[values != 0]
    lowest = float(np.quantile(inside, 0.05)) if inside.size else -1.0
    limit = max(float(inside.max()) if inside.size else 1.0, -lowest)
    shown = np.nan_to_num(_shown(values, clipped), nan=np.nan, neginf=-limit)
    mesh = axes.pcolormesh(x, x, shown, cmap="RdBu", vmin=-limit, vmax=limit, shading="nearest", rasterized=True)
    drawn = axes.get_figure()
    assert drawn is not None
    drawn.colorbar(mesh, ax=axes, label=label, shrink=0.82, extend="min")
    return mesh


def _scaled(values: Array, unit: str, *, quantile: bool = False) -> tuple[Array, str]:
    """Values in the unit that keeps the largest of them readable."""
    finite = np.abs(values[np.isfinite(values)])
    largest = float(finite.max()) if finite.size else 0.0
    if quantile and finite.any():
        largest = float(np.quantile(finite[finite > 0], 0.9))
    factor, prefixed = readable(largest, unit)
    return values * factor, prefixed


def _last_valid(result: xr.Dataset) -> int:
    """Last step with an outline before the theory first fails; if it fails from the start, the last step at which it holds.

    A pressure field belongs to the whole history of the contact, so steps beyond a gap are second choice, and those whose
    contact has come apart the last.
    """
    valid = result["valid"].values.astype(bool)
    usable = valid & (result["radius"].values > 0)
    if not usable.any():
        raise ValueError(
            "this result has no step with a contact at which the theory holds, so there is no outline to draw; see its notes."
        )
    leading, outlined = usable & np.logical_and.accumulate(valid), _outlined(result)
    choices = (leading & outlined, usable & outlined, leading, usable)
    return int(np.flatnonzero(next(choice for choice in choices if choice.any()))[-1])


def _outlined(result: xr.Dataset) -> Flags:
    """Whether contacts have an outline, shape (steps,)."""
    return np.asarray(np.isfinite(result["contour"].values).all(axis=1))


def _half_width(result: xr.Dataset, indenter: Any, step: int) -> float:
    """Half of the width that a picture of one contact shows [m]; of one without an outline where the indenter would overlap."""
    if _outlined(result)[step]:
        return 1.25 * float(np.max(result["contour"].values[step]))
    return max(overlap_half_widths(indenter, float(result["depth"].values[step])))


def _earlier(result: xr.Dataset, last: int) -> list[int]:
    """Up to three steps before the last, at about a quarter, a half and three quarters of its radius."""
    radius = result["radius"].values
    wanted = [int(np.argmin(np.abs(radius[: last + 1] - share * radius[last]))) for share in (0.25, 0.5, 0.75)]
    drawn = result["valid"].values.astype(bool) & _outlined(result) & (radius > 0)
    return [i for i in sorted(set(wanted)) if i != last and drawn[i]]


def _curve(contour: Array, phi: Array, factor: float) -> tuple[Array, Array]:
    closed, phi = np.append(contour, contour[0]) * factor, np.append(phi, phi[0])
    return closed * np.cos(phi), closed * np.sin(phi)


def _level_lines(indenter: Any, half: float, factor: float, axes: Axes) -> None:
    x = np.linspace(-half, half, 241)
    r, phi = np.hypot(x[None, :], x[:, None]), np.arctan2(x[:, None], x[None, :])
    inside = r <= indenter.reach
    height = np.where(inside, indenter.height(np.minimum(r, indenter.reach), phi), np.nan)
    if not np.nanmax(height) > 0:  # the flat end of a cylinder has no level lines
        return
    values, unit = _scaled(height, "m")
    lines = axes.contour(x * factor, x * factor, values, levels=8, colors="#4a4a4a", linewidths=0.6)
    name = {level: f"{level:g} {unit}" for level in lines.levels}
    # the frame would cut labels beside it
    trial = axes.clabel(lines, fmt=name, fontsize=6.5, inline=False)
    cut = {text.get_text() for text in trial if np.abs(text.get_position()).max() > _FREE * half * factor}
    for text in trial:
        text.remove()
    axes.clabel(lines, [level for level in lines.levels if name[level] not in cut], fmt=name, fontsize=6.5)


def _frame(axes: Axes, half: float, unit: str) -> None:
    axes.set_xlim(-half, half)
    axes.set_ylim(-half, half)
    axes.set_aspect("equal")
    axes.set_xlabel(f"$x$ ({unit})")
    axes.set_ylabel(f"$y$ ({unit})")
