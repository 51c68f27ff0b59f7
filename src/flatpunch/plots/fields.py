"""Pictures of fields: sections through the layers, stresses along the axis, tractions at interfaces."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from types import NoneType
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flatpunch._support.checks import Array, follows, one_of, shown
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import readable
from flatpunch.compliances.stack import interfaces
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, underlying
from flatpunch.plots.style import (
    BLUE,
    GREY,
    ORANGE,
    SAMPLES,
    THIN,
    StyleName,
    axes_or_new,
    legend_below,
    panels,
    styled,
)
from flatpunch.stresses import Strength, fields

if TYPE_CHECKING:
    import xarray as xr

_NAMES = {
    "von_mises": "von Mises stress",
    "max_shear": "largest shear stress",
    "hydrostatic": "mean normal stress",
    "utilisation": "von Mises stress over yield stress",
    "principal": "largest principal stress",
}
_SYMBOLS = {name: rf"$\sigma_{{{name}}}$" for name in ("xx", "yy", "zz", "yz", "xz", "xy")}
_NUMBER = 0.1
"""Share of the width of a picture that the number of a level line takes."""
_LINE: Plain = {"color": "black", "linewidth": THIN}


def plot_fields(
    result: xr.Dataset,
    axes: Axes | None = None,
    *,
    quantity: str = "von_mises",
    medium: Body | None = None,
    strengths: Sequence[Strength | None] | None = None,
) -> Axes:
    """Draw a plane of a result of `fields` as a map with level lines; interfaces are drawn if the medium is given.

    Parameters
    ----------
    result : xarray.Dataset
        What `fields` returned for points on a plane: two dimensions, along two of x, y and z.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    quantity : str
        "von_mises", "max_shear", "hydrostatic", "principal" (the largest), a component of stress such as "xx", or
        "utilisation": von Mises over yield stress, which takes the strengths.
    medium : Medium, optional
        Whose interfaces are drawn.
    strengths : sequence of Strength or None, optional
        Of the layers from the surface down and the base.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If the points are no plane, or the quantity is not known.

    See Also
    --------
    fields : The numbers.
    plot_pressure : The pressure at the surface.

    Examples
    --------
    >>> x, z = np.meshgrid(np.linspace(-2e-6, 2e-6, 21), np.linspace(0, 2e-6, 15))
    >>> found = fp.fields(fp.HalfSpace(70e9, 0.3), fp.Sphere(1e-5), x, 0.0, z, depth=50e-9)
    >>> axes = fp.plot_fields(found)
    """
    one_of("quantity", quantity, (*_NAMES, *_SYMBOLS))
    if strengths is not None and not (
        follows(strengths, list, tuple) and all(follows(each, Strength, NoneType) for each in strengths)
    ):
        raise TypeError(
            f"strengths = {shown(strengths)} must be a list of Strength or None, of the layers and the base."
        )
    axes = axes_or_new(axes)
    across, down, names = _plane(result)
    values, label, unit = _quantity(result, quantity, strengths)
    length = float(max(np.abs(across).max(), np.abs(down).max()))
    factor, length_unit = readable(length, "m")
    signed = bool(np.nanmin(values) < 0 < np.nanmax(values))
    top = float(np.nanmax(np.abs(values[np.isfinite(values)])))
    colours: Plain = {"cmap": "RdBu_r", "vmin": -top, "vmax": top} if signed else {"cmap": "viridis"}
    mesh = axes.pcolormesh(across * factor, down * factor, values, shading="nearest", rasterized=True, **colours)
    ends = (0.0, min(top, 1.0)) if quantity == "utilisation" else (float(np.nanmin(values)), float(np.nanmax(values)))
    levels = np.asarray(MaxNLocator().tick_values(*ends))
    if names[1] == "z":
        if not axes.yaxis_inverted():
            axes.invert_yaxis()
        for face in _faces(medium):
            axes.axhline(face * factor, **_LINE)
    plane = np.stack([across, down]) * factor
    # layer by layer: stresses jump at interfaces
    for i in np.unique(result["layer"].values):
        part = np.where(result["layer"].values == i, values, np.nan)
        if np.isfinite(part).any(axis=0).sum() > 1 and np.isfinite(part).any(axis=1).sum() > 1:
            lines = axes.contour(
                across * factor, down * factor, part, levels=levels, colors="black", linewidths=THIN / 2
            )
            box = np.stack([plane.min(axis=(1, 2)), plane.max(axis=(1, 2))])
            inside = plane[:, result["layer"].values == i]
            places = _label_places(lines, box, np.stack([inside.min(axis=1), inside.max(axis=1)]))
            axes.clabel(lines, fontsize="x-small", fmt="%.3g", manual=places)
    drawn = axes.get_figure()
    assert drawn is not None
    drawn.colorbar(mesh, ax=axes, label=f"{label} ({unit})" if unit else label)
    axes.set(xlabel=f"${names[0]}$ ({length_unit})", ylabel=f"${names[1]}$ ({length_unit})")
    return axes


def _label_places(lines: QuadContourSet, picture: Array, layer: Array) -> list[tuple[float, float]]:
    """Where level lines are numbered in boxes ((left, top), (right, bottom)): far from edges and other numbers."""
    width = picture[1] - picture[0]
    places: list[tuple[float, float]] = []
    for segments in lines.allsegs:
        drawn = [points for points in segments if len(points)]
        if not drawn:
            continue
        longest = max(drawn, key=lambda points: float((np.ptp(points, axis=0) / width).sum()))
        room = (np.minimum(longest - layer[0], layer[1] - longest) / width).min(axis=1)
        for other in places:
            apart = np.abs(longest - np.array(other)) / width
            room = np.where(apart.max(axis=1) > _NUMBER, room, 0.0)
        best = int(np.argmax(room))
        # beside edges, and on lines no longer than a number, there is no room for one
        if room[best] > _NUMBER / 2 and (np.ptp(longest, axis=0) / width).max() > _NUMBER:
            places.append((float(longest[best, 0]), float(longest[best, 1])))
    return places


def _plane(result: xr.Dataset) -> tuple[Array, Array, tuple[str, str]]:
    """Coordinates along the two directions that vary, shape (n, m) each."""
    if "von_mises" not in getattr(result, "data_vars", ()):
        raise TypeError(f"result = {shown(result)} must be what `fields` returned.")
    if result["von_mises"].ndim != 2 or min(result["von_mises"].shape) < 2:
        raise ValueError(
            f"result has points of shape {result['von_mises'].shape}; a picture needs a plane of at least 2 x 2 points."
        )
    varying = [name for name in ("x", "y", "z") if np.ptp(result[name].values) > 0]
    if len(varying) != 2:
        raise ValueError(
            f"result varies along {', '.join(varying) or 'nothing'}; a plane varies along two of x, y and z."
        )
    return result[varying[0]].values, result[varying[1]].values, (varying[0], varying[1])


def _quantity(result: xr.Dataset, quantity: str, strengths: Sequence[Strength | None] | None) -> tuple[Array, str, str]:
    """Values in a readable unit, their name and unit."""
    if quantity == "utilisation":
        limits = np.array([np.nan if s is None or s.yield_stress is None else s.yield_stress for s in strengths or ()])
        layer = result["layer"].values
        if not np.isfinite(limits).any():
            raise ValueError("quantity = 'utilisation' takes strengths with a yield stress.")
        limits = np.append(limits, np.full(max(0, int(layer.max()) + 1 - limits.size), np.nan))
        return result["von_mises"].values / limits[layer], _NAMES[quantity], ""
    if quantity in _SYMBOLS:
        values, name = result["stress"].sel(component=quantity).values, _SYMBOLS[quantity]
    elif quantity == "principal":
        values, name = result["principal"].values[0], _NAMES[quantity]
    else:
        values, name = result[quantity].values, _NAMES[quantity]
    factor, unit = readable(float(np.abs(values[np.isfinite(values)]).max(initial=0.0)), "Pa")
    return values * factor, name, unit


def _faces(medium: Body | None) -> Array:
    body = underlying(medium).single if medium is not None else None
    return interfaces(body) if body else np.zeros(0)


def axis_stresses(
    medium: Body, indenter: Indenter, axes: Axes, *, deepest: float, scale: float | None = None, **contact: Any
) -> Axes:
    """Draw s_xx and s_zz along the axis to a depth [m], layer by layer, so that jumps at interfaces show.

    `scale` is the length that chooses the unit of the axis [m], by default that depth; `contact` has further arguments of
    `fields`.
    """
    faces = _faces(medium)
    body = underlying(medium).single
    if body and body.base.rigid:
        deepest = min(deepest, body.thickness)
    ends = [0.0, *[float(face) for face in faces if face < deepest], deepest]
    depth, drawn = [], []
    for start, end in pairwise(ends):
        # just inside the layer on either end
        z = start + (end - start) * np.linspace(1e-9, 1 - 1e-9, SAMPLES)
        found = fields(medium, indenter, 0.0, 0.0, z, **contact)
        depth.append(z)
        drawn.append(found["stress"].sel(component=["xx", "zz"]).values)
    largest = max(float(np.abs(each).max()) for each in drawn)
    factor, unit = readable(largest, "Pa")
    length_factor, length_unit = readable(scale or deepest, "m")
    for row, (name, colour) in enumerate((("xx", ORANGE), ("zz", BLUE))):
        for i, (z, values) in enumerate(zip(depth, drawn, strict=True)):
            label = _SYMBOLS[name] if i == 0 else None
            axes.plot(values[row] * factor, z * length_factor, color=colour, label=label)
    for face in faces[faces < deepest]:
        axes.axhline(face * length_factor, **_LINE)
    axes.axvline(0, color=GREY, linewidth=THIN)
    axes.set_ylim(deepest * length_factor, 0)
    axes.set(xlabel=f"stress on the axis ({unit})", ylabel=f"$z$ ({length_unit})")
    legend_below(axes, ncols=2, frameon=False)
    return axes


def interface_tractions(
    medium: Body, indenter: Indenter, axes: Axes, *, reach: float, scale: float | None = None, **contact: Any
) -> Axes:
    """Draw normal and shear traction at every interface along x up to `reach` [m], on both sides unless they are alike.

    Other arguments as for `axis_stresses`.
    """
    contact = {key: value for key, value in contact.items() if key != "side"}
    alike = indenter.round and not contact.get("friction")
    x = reach * np.linspace(0.0 if alike else -1.0, 1.0, SAMPLES + 1)
    faces = _faces(medium)
    if not faces.size:
        axes.text(0.5, 0.5, "no interfaces", ha="center", va="center", transform=axes.transAxes)
        axes.set_axis_off()
        return axes
    found = [fields(medium, indenter, x, 0.0, face, side="above", **contact)["stress"] for face in faces]
    factor, unit = readable(max(float(np.abs(each.sel(component=["zz", "xz"])).max()) for each in found), "Pa")
    length_factor, length_unit = readable(scale or reach, "m")
    for i, stress in enumerate(found):
        colour = f"C{i}"
        for name, style in (("zz", "-"), ("xz", "--")):
            axes.plot(
                x * length_factor,
                stress.sel(component=name).values * factor,
                style,
                color=colour,
                label=f"{_SYMBOLS[name]}, interface {i + 1}",
            )
    axes.axhline(0, color=GREY, linewidth=THIN)
    axes.set(xlabel=f"$x$ ({length_unit})", ylabel=f"traction ({unit})")
    legend_below(axes, ncols=2, frameon=False)
    return axes


def figure(
    result: xr.Dataset,
    medium: Body,
    indenter: Indenter,
    contact: Plain,
    *,
    strengths: Sequence[Strength | None] = (),
    title: str = "",
    style: StyleName | str = "screen",
) -> Figure:
    """Return the plane of a result, stresses along the axis and tractions at the interfaces, in a style of `plots.style`."""
    with styled(style) as chosen:
        drawn, (left, middle, right) = panels(chosen, 3, title=title)
        _draw(result, medium, indenter, contact, strengths, (left, middle, right))
    return drawn


def _draw(
    result: xr.Dataset,
    medium: Body,
    indenter: Indenter,
    contact: Plain,
    strengths: Sequence[Strength | None],
    axes: tuple[Axes, Axes, Axes],
) -> None:
    left, middle, right = axes
    limited = [strength is not None and strength.yield_stress is not None for strength in strengths]
    # a layer without a yield stress would be blank
    judged = len(limited) > int(result["layer"].max()) and all(limited)
    plot_fields(result, left, quantity="utilisation" if judged else "von_mises", medium=medium, strengths=strengths)
    span = [float(np.ptp(result[name].values)) for name in ("x", "y", "z")]
    scale = max(float(np.abs(result[name].values).max()) for name in ("x", "y", "z"))
    axis_stresses(medium, indenter, middle, deepest=span[2] or max(span), scale=scale, **contact)
    interface_tractions(medium, indenter, right, reach=max(span[:2]) / 2 or max(span), scale=scale, **contact)
