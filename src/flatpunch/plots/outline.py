"""Contacts seen from above: outlines over the level lines of the tip, and maps of the contact pressure.

The mesh of a map ends at the outline and is finer near the apex and the edge.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D

from flatpunch._support.checks import Array, Flags, whole
from flatpunch.bem.bounding_box import overlap_half_widths
from flatpunch.contact import pressure
from flatpunch.contact.curve import NOTABLE_OUTLINE, percent
from flatpunch.contact.dataset import outlines
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body
from flatpunch.numerics.extents import ROOM, covered
from flatpunch.plots.style import (
    PALE,
    SAMPLES,
    THIN,
    Extend,
    axes_or_new,
    check_label,
    check_result,
    colour_bar,
    legend_below,
    next_colour,
    plain,
    printed,
    round_step,
    scale_of,
    scale_on,
    scaled,
)

NO_CONTACT = (
    "this result has no step with a contact at which the theory holds, so there is no outline to draw; see its notes."
)
"""Why there is no picture."""


def plot_outline(
    result: xr.Dataset,
    axes: Axes | None = None,
    *,
    indenter: Indenter | None = None,
    step: int | None = None,
    label: str | None = None,
) -> Axes:
    """Draw contact outlines, over level lines of the indenter if it is given.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure. Axes that hold an outline keep their units, and the new one has its own colour.
    indenter : Indenter, optional
        The indenter it was solved for, whose level lines are drawn.
    step : int, optional
        Which step; by default the last at which the theory holds and the contact has an outline, with up to three earlier ones
        as thin lines.
    label : str, optional
        Name of the outline in the legend.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If no step has a contact at which the theory holds.

    See Also
    --------
    plot_pressure : The pressure of the same contact.
    plot_tip : The tip alone.

    Examples
    --------
    >>> tip = fp.Pyramid(sides=4, inclination=np.radians(20))
    >>> curve = fp.indent(fp.HalfSpace(young=5e3, poisson=0.5), tip, depth=np.linspace(1e-8, 1e-7, 10))
    >>> axes = fp.plot_outline(curve, indenter=tip)
    >>> axes.get_xlabel()
    '$x$ (nm)'
    """
    check_result(result, "phi", "radius")
    check_label(label)
    if indenter is not None:
        check_indenter(indenter)
    axes = axes_or_new(axes, (4.0, 4.0))
    first, colour = not axes.has_data(), next_colour(axes)
    last = chosen_step(result, step)
    phi, contour = result["phi"].values, outlines(result)
    half = half_width(result, indenter, last)
    factor, unit = scale_on(axes.xaxis, [half], "m")
    handles = [] if first else list(axes.get_legend_handles_labels()[0])
    if indenter is not None:
        handles += _level_lines(indenter, half, factor, axes)
    for i in earlier(result, last) if step is None and first else []:
        (thin,) = axes.plot(*closed(contour[i], phi, factor), "--", color=colour, linewidth=THIN)
        thin.set_label("earlier")
        handles = [*[h for h in handles if h.get_label() != "earlier"], thin]
    (thick,) = axes.plot(*closed(contour[last], phi, factor), color=colour, label=label or "contact")
    framed(axes, half * factor if first else max(half * factor, axes.get_xlim()[1]), unit)
    depth = plain(float(result["depth"].values[last]), "m")
    what = "Outline" if outlined(result)[last] else "Several parts, no outline"
    error = float(result["contour_error"].values[last]) if "contour_error" in result else 0.0
    if first:
        # an error over the mean radius that is worth a word
        doubt = f", ± {percent(error)}" if NOTABLE_OUTLINE < error < np.inf else ""
        axes.set_title(f"{what} at $d$ = {depth}{doubt}")
    # below the picture, where nothing is drawn
    legend_below(axes, handles=[thick, *handles], ncols=3, handlelength=1, columnspacing=1)
    return axes


def chosen_step(result: xr.Dataset, step: int | None) -> int:
    """Return the step asked for, counted from the end where it is negative, or the last that can be drawn."""
    if step is None:
        return last_valid(result)
    count = result.sizes["step"]
    whole("step", step, -count, f"The result has {count} steps, counted from 0.", most=count - 1)
    return int(step) % count


def last_valid(result: xr.Dataset) -> int:
    """Last step with an outline before the theory first fails; if it fails from the start, the last step at which it holds.

    A pressure field belongs to the whole history of the contact, so steps beyond a gap are second choice, and those whose
    contact has come apart the last.
    """
    valid = result["valid"].values.astype(bool)
    usable = valid & (result["radius"].values > 0)
    if not usable.any():
        raise ValueError(NO_CONTACT)
    leading, drawn = usable & np.logical_and.accumulate(valid), outlined(result)
    choices = (leading & drawn, usable & drawn, leading, usable)
    return int(np.flatnonzero(next(choice for choice in choices if choice.any()))[-1])


def outlined(result: xr.Dataset) -> Flags:
    """Whether contacts have an outline, shape (steps,)."""
    return np.asarray(np.isfinite(outlines(result)).all(axis=1))


def half_width(result: xr.Dataset, indenter: Indenter | None, step: int) -> float:
    """Half of the width that a picture of one contact shows [m]; of one without an outline where the indenter would overlap."""
    if outlined(result)[step] or indenter is None:
        return ROOM * float(np.nanmax(np.append(outlines(result)[step], result["radius"].values[step])))
    depth = float(result["depth"].values[step])
    if indenter.has_parts:
        return max(float(abs(centre) + width) for width, centre in zip(*indenter.box(depth), strict=True))
    return max(overlap_half_widths(indenter, depth))


def earlier(result: xr.Dataset, last: int) -> list[int]:
    """Up to three steps before the last, at about a quarter, a half and three quarters of its radius."""
    radius = result["radius"].values
    wanted = [int(np.argmin(np.abs(radius[: last + 1] - share * radius[last]))) for share in np.arange(1, 4) / 4]
    drawn = result["valid"].values.astype(bool) & outlined(result) & (radius > 0)
    return [i for i in sorted(set(wanted)) if i != last and drawn[i]]


def closed(contour: Array, phi: Array, factor: float) -> tuple[Array, Array]:
    """Closed curve of an outline, in the units of a picture."""
    contour, phi = np.append(contour, contour[0]) * factor, np.append(phi, phi[0])
    return contour * np.cos(phi), contour * np.sin(phi)


def _level_lines(indenter: Indenter, half: float, factor: float, axes: Axes) -> list[Line2D]:
    """Draw level lines at round heights; their spacing is named in the legend, where no label can cross a line."""
    x = np.linspace(-half, half, SAMPLES)
    r, phi = np.hypot(x[None, :], x[:, None]), np.arctan2(x[:, None], x[None, :])
    reach = indenter.reach_along(phi)
    height = np.where(r <= reach, indenter.height(np.minimum(r, reach), phi), np.nan)
    height[np.isinf(height)] = np.nan
    if not np.nanmax(height) > 0:  # the flat end of a cylinder has no level lines
        return []
    values, unit = scaled(height, "m")
    phi = np.linspace(0, 2 * np.pi, SAMPLES)
    around = np.asarray(indenter.height(np.minimum(half, indenter.reach_along(phi)), phi))
    around = np.where(np.isfinite(around), around, np.nanmax(height))
    top, usual = float(np.nanmax(values)), float(np.median(around)) * scale_of(height, "m")[0]
    spacing = round_step(usual if usual > 0 else top)
    levels = np.arange(1, int(top / spacing) + 1) * spacing
    axes.contour(x * factor, x * factor, values, levels=levels, colors=PALE, linewidths=THIN)
    return [Line2D([], [], color=PALE, linewidth=THIN, label=f"tip, every {spacing:g} {unit}")]


def framed(axes: Axes, half: float, unit: str) -> None:
    """Square picture of the surface about the point of first touch."""
    axes.set_xlim(-half, half)
    axes.set_ylim(-half, half)
    axes.set(aspect="equal", xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})")
    axes.locator_params(nbins=4)


def plot_pressure(
    result: xr.Dataset, medium: Body, indenter: Indenter, axes: Axes | None = None, *, step: int | None = None
) -> Axes:
    """Draw the contact pressure of one step as a map, with a colour bar.

    The outline stays a line in PDF and SVG; the map is an image of the figure's resolution.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    medium : Medium, HalfSpace, ...
        The body it was solved for.
    indenter : Indenter
        The indenter it was solved for.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    step : int, optional
        Which step; by default the last at which the theory holds and the contact has an outline.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    pressure : The numbers.
    plot_outline : Outlines of several steps.

    Examples
    --------
    >>> gel, tip = fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6)
    >>> curve = fp.indent(gel, tip, depth=1e-7)
    >>> axes = fp.plot_pressure(curve, gel, tip)
    >>> axes.get_title()
    'Pressure at $F$ = 627 pN'
    """
    check_result(result, "phi", "radius", "valid")
    check_indenter(indenter)
    axes = axes_or_new(axes)
    last = chosen_step(result, step)
    half = half_width(result, indenter, last)
    factor, unit = scale_of([half], "m")
    contour, phi = outlines(result)[last], result["phi"].values
    has_outline = bool(np.isfinite(contour).all())
    x, y = _mesh(contour, phi, indenter) if has_outline else np.meshgrid(*2 * [np.linspace(-half, half, SAMPLES)])
    # all rays of a round contact are alike
    rays = slice(1) if has_outline and indenter.round else slice(None)
    # the quantity that was prescribed leads back to the same contact, also where another one does not rise with it
    control: dict[str, float] = {result.attrs["control"]: float(result[result.attrs["control"]].values[last])}
    work = result.attrs.get("work_of_adhesion")
    field, error = pressure(
        medium,
        indenter,
        x[:, rays],
        y[:, rays],
        method=result.attrs["method"],
        work_of_adhesion=work,
        range_of_action=result.attrs.get("range_of_action"),
        return_error=True,
        **control,
    )
    _pressures(axes, x * factor, y * factor, np.broadcast_to(field, x.shape), tension=work is not None)
    axes.plot(*closed(contour, phi, factor), color="black", linewidth=THIN)
    framed(axes, half * factor, unit)
    force = plain(float(result["force"].values[last]), "N")
    axes.set_title(f"Pressure at $F$ = {force}{_doubt_of_pressure(field, error)}")
    return axes


def _mesh(contour: Array, phi: Array, indenter: Indenter) -> tuple[Array, Array]:
    """Points on rays from the apex to the outline, shape (along, rays): rays along the edges of a tip are among them."""
    angles = np.unique(
        np.concatenate([np.linspace(0, 2 * np.pi, SAMPLES), indenter.split_angles, phi[:: 1 + phi.size // SAMPLES]])
    )
    edge = np.interp(angles, phi, contour, period=2 * np.pi)
    # the pressure may be infinite at either end: it is taken just inside
    share = np.clip((1 - np.cos(np.linspace(0, np.pi, SAMPLES // 2))) / 2, 1e-4, 1 - 1e-4)
    r = share[:, None] * edge
    return r * np.cos(angles), r * np.sin(angles)


def _pressures(axes: Axes, x: Array, y: Array, field: Array, *, tension: bool) -> QuadMesh:
    """Coloured mesh and its bar; with adhesion tension is red, pressure blue. Infinite pressures are cut."""
    inside = field[np.isfinite(field) & (field != 0)]
    top, singular = covered(np.abs(field[field != 0]))
    factor, unit = scale_of([top], "Pa")
    norm = (
        Normalize(-top * factor, top * factor)
        if tension
        else Normalize(min(0.0, float(inside.min(initial=0.0))) * factor, top * factor)
    )
    shown = np.clip(np.nan_to_num(field, nan=0.0, posinf=top, neginf=-top), -top, top) * factor
    mesh = axes.pcolormesh(
        x, y, shown, cmap="RdBu" if tension else "viridis", norm=norm, shading="gouraud", rasterized=True
    )
    extend: Extend = "min" if tension else "max" if singular else "neither"
    colour_bar(axes, mesh, f"pressure $p$ ({printed(unit)})", extend)
    return mesh


def _doubt_of_pressure(field: Array, error: Array) -> str:
    """Typical error of a pressure over its mean, where it is worth a word."""
    inside = (field != 0) & np.isfinite(field)
    share = float(np.median(error[inside]) / np.abs(field[inside]).mean()) if inside.any() else 0.0
    return f", ± {percent(share)}" if share > 0.01 else ""
