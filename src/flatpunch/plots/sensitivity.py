"""Pictures of depth sensitivities, which depth a force comes from, and of designs: what they achieve, within which bounds."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flatpunch._support.checks import Array, instance
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import readable
from flatpunch.designs import Design
from flatpunch.designs.statement import UNITS
from flatpunch.numerics.extents import ROOM, covered
from flatpunch.plots.style import (
    BLUE,
    GREY,
    HEADROOM,
    ORANGE,
    SHADE,
    THIN,
    StyleName,
    axes_or_new,
    check_label,
    check_result,
    colour_bar,
    legend_below,
    next_colour,
    scale_of,
    scale_on,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr


_PLACE = re.compile(r"(?P<side>upper\.|lower\.)?(?:layers\[(?P<layer>\d+)\]|base)\.")


def plot_sensitivity(result: xr.Dataset, axes: Axes | None = None, *, label: str | None = None) -> Axes:
    """Draw the depth sensitivity of one contact beside its layers, or that of a curve as a map over depth and indentation depth.

    Parameters
    ----------
    result : xarray.Dataset
        What `sensitivity` returned.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure. Axes that hold a sensitivity keep their units, and the new one has its own colour.
    label : str, optional
        Name of the curve in the legend.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If the result has no depth sensitivity.

    See Also
    --------
    sensitivity : The numbers.
    plot_curve : The curve that they belong to.

    Examples
    --------
    >>> import flatpunch as fp
    >>> film = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
    >>> axes = fp.plot_sensitivity(fp.sensitivity(film, fp.Sphere(20e-6), depth=100e-9))
    """
    if "parameter" in getattr(result, "coords", ()) and "depth_sensitivity" not in result:
        raise ValueError("result has no depth_sensitivity: that of a power-law half-space is not computed.")
    check_result(result, "depth_sensitivity")
    check_label(label)
    axes = axes_or_new(axes)
    if "step" in result["depth_sensitivity"].dims:
        _map(result, axes)
    else:
        _profile(result, axes, label)
    if not axes.yaxis_inverted():
        axes.invert_yaxis()
    return axes


def _profile(result: xr.Dataset, axes: Axes, label: str | None) -> None:
    z, layer, values = (result[name].values for name in ("z", "layer", "depth_sensitivity"))
    radius = float(result["contact_radius"])
    # the base goes on without end; what is below a few radii hardly counts
    shown = np.abs(z) <= max(4 * radius, ROOM * float(np.abs(_faces(z, layer)).max(initial=0.0)))
    first, colour = not axes.has_data(), next_colour(axes)
    factor, unit = scale_on(axes.yaxis, z[shown], "m")
    for start, end in _pieces(z, layer):
        part = np.arange(start, end)[shown[start:end]]
        if not part.size:
            continue
        top = 0.0 if start == 0 and z[0] > 0 else z[start]
        depth = np.concatenate([[top], z[part]]) if top != z[start] else z[part]
        drawn = np.concatenate([values[part][:1], values[part]]) if top != z[start] else values[part]
        depth, drawn = _between(depth, drawn)
        axes.plot(drawn / factor, depth * factor, color=colour, label=label)
        axes.fill_betweenx(depth * factor, 0, drawn / factor, color=colour, alpha=SHADE, linewidth=0)
        # one name for all layers
        label = None
    # the shares of a second curve would lie on those of the first
    for (start, end), share in zip(_pieces(z, layer), layer_shares(result), strict=True) if first else ():
        seen = z[start:end][shown[start:end]]
        if seen.size and np.isfinite(share):
            place = (1 / HEADROOM, (seen[0] + seen[-1]) / 2 * factor)
            axes.annotate(f"{100 * share:.1f} %", place, xycoords=("axes fraction", "data"), ha="right", va="center")
    for face in _faces(z, layer):
        axes.axhline(face * factor, color=GREY, linewidth=THIN)
    dashed = ("contact radius", ORANGE) if first else (None, colour)
    axes.axhline(radius * factor, color=dashed[1], linewidth=THIN, linestyle="--", label=dashed[0])
    # the shares of the layers are written beside the curve
    along = [
        min(0.0, HEADROOM * float(values[shown].min()) / factor),
        max(ROOM * float(values[shown].max()) / factor, 0.0),
    ]
    down = [min(float(z[shown].min()), 0.0) * factor, max(float(z[shown].max()), 0.0) * factor]
    if not first:
        along, down = [*along, *axes.get_xlim()], [*down, *axes.get_ylim()]
    axes.set_xlim(min(along), max(along))
    axes.set_ylim(min(down), max(down))
    axes.set(xlabel=rf"$\partial \ln F/\partial \ln E(z)$ (1/{unit})", ylabel=f"depth $z$ ({unit})")
    legend_below(axes)


def _between(z: Array, values: Array) -> tuple[Array, Array]:
    """Shape-preserving curve through the values in one layer, at nine more depths in each interval."""
    if z.size < 3 or (np.diff(z) <= 0).any():
        return z, values
    fine = np.interp(np.linspace(0, z.size - 1, 10 * (z.size - 1) + 1), np.arange(z.size), z)
    return fine, np.asarray(scipy.interpolate.PchipInterpolator(z, values)(fine))


def _map(result: xr.Dataset, axes: Axes) -> None:
    z, values = result["z"].values, result["depth_sensitivity"].values
    depth, radius = result["contact_depth"].values, result["contact_radius"].values
    shown = np.abs(z) <= max(
        4 * float(radius.max()), ROOM * float(np.abs(_faces(z, result["layer"].values)).max(initial=0.0))
    )
    down, down_unit = scale_of(z[shown], "m")
    along, along_unit = scale_of(depth, "m")
    # faces are there twice; the map takes both sides a little apart
    places = z[shown] + 1e-9 * np.abs(z[shown]).max() * np.arange(shown.sum())
    drawn = values[:, shown].T / down
    # small contacts at the surface would take all colours
    top, cut = covered(drawn)
    options: Plain = {"shading": "gouraud", "cmap": "viridis", "vmax": top, "rasterized": True}
    mesh = axes.pcolormesh(depth * along, places * down, drawn, **options)
    for face in _faces(z, result["layer"].values):
        axes.axhline(face * down, color="white", linewidth=THIN)
    axes.plot(depth * along, radius * down, color="white", linestyle="--", linewidth=THIN, label="contact radius")
    axes.set_ylim(top=max(float(z[shown].max()), 0.0) * down, bottom=min(float(z[shown].min()), 0.0) * down)
    label = rf"$\partial \ln F/\partial \ln E(z)$ (1/{down_unit})"
    colour_bar(axes, mesh, label, "max" if cut else "neither")
    axes.set(xlabel=f"indentation depth $d$ ({along_unit})", ylabel=f"depth $z$ ({down_unit})")
    # white on the pale paper below the axes cannot be read
    axes.legend(labelcolor="white", loc="lower right", frameon=False)


def layer_shares(result: xr.Dataset) -> list[float]:
    """Share of each layer in the force, in the order of the drawn depths: the sum over its moduli; NaN where a law has none."""
    names, units, force = (result[name].values for name in ("parameter", "unit", "force"))
    z, layer = result["z"].values, result["layer"].values
    layers = {sign: int(layer[np.sign(z) == sign].max(initial=0)) for sign in (-1.0, 1.0)}
    found: dict[tuple[float, int], float] = {}
    for name, unit, share in zip(names, units, force, strict=True):
        place = _PLACE.match(name)
        if place is not None and unit == "Pa":
            sign = -1.0 if place["side"] == "upper." else 1.0
            key = sign, int(place["layer"]) if place["layer"] else layers[sign]
            found[key] = found.get(key, 0.0) + float(share)
    return [found.get((float(np.sign(z[a])), int(layer[a])), float("nan")) for a, _ in _pieces(z, layer)]


def _pieces(z: Array, layer: Array) -> list[tuple[int, int]]:
    """First and last depth of each layer; of two bodies each has its own layers."""
    jumps = np.flatnonzero((np.diff(layer) != 0) | (np.diff(np.sign(z)) != 0)) + 1
    ends = [0, *jumps.tolist(), z.size]
    return list(pairwise(ends))


def _faces(z: Array, layer: Array) -> Array:
    """Depths at which layers meet, 0 between two bodies."""
    return np.array([0.0 if z[b - 1] < 0 < z[b] else z[b] for _, b in _pieces(z, layer)[:-1]])


def plot_design(result: Design, axes: Axes | None = None) -> Axes:
    """Draw the prescribed quantity with that of the design and of the case before; of a load, both loads.

    Parameters
    ----------
    result : Design
        What `design` returned.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    design : Makes the result.

    Examples
    --------
    >>> film = fp.Layer(young=2e9, poisson=0.4, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=70e9, poisson=0.22))
    >>> wanted = fp.Target("stiffness", 50e3, force=2e-3)
    >>> found = fp.design(film, fp.Sphere(radius=20e-6), vary={"layers[0].young": (1e9, 9e9)}, objective=wanted)
    >>> axes = fp.plot_design(found)
    >>> print(axes.get_ylabel())
    stiffness (kN/m)
    """
    instance("result", result, (Design,), "a Design, as `design` returns it")
    axes = axes_or_new(axes)
    if not result.control:
        loads = np.array([result.before[0], result.achieved[0]])
        endless = np.isinf(loads)
        factor, unit = readable(float(loads[~endless].max()), "N")
        axes.bar([0, 1], np.where(endless, 0.0, loads) * factor, color=[GREY, BLUE])
        axes.set_xticks([0, 1], ["before", "design"])
        axes.set_ylabel(f"critical load ({unit})")
        if endless[1]:
            axes.text(1, 0.5, "nothing fails", ha="center", transform=axes.get_xaxis_transform())
        return axes
    along, along_unit = readable(float(result.at.max()), UNITS[result.control])
    up, unit = readable(float(result.wanted.max()), UNITS[result.quantity])
    order = np.argsort(result.at)
    x = result.at[order] * along
    axes.plot(x, result.before[order] * up, "--", marker=".", color=GREY, label="before")
    axes.plot(x, result.achieved[order] * up, color=BLUE, marker=".", label="design")
    axes.plot(x, result.wanted[order] * up, "o", color="black", markerfacecolor="none", label="prescribed")
    axes.set(xlabel=f"{result.control} ({along_unit})", ylabel=f"{result.quantity} ({unit})")
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.legend(frameon=False)
    return axes


def design_figure(result: Design, *, title: str = "", style: StyleName | str = "screen") -> Figure:
    """The prescribed quantity, and each number between its bounds."""
    with styled(style) as chosen:
        one = chosen.across == 1
        width = chosen.width or 10
        drawn = Figure(figsize=(width, width if one else width / 2), layout="constrained")
        first, second = drawn.subplots(*((2, 1) if one else (1, 2)))
        plot_design(result, first)
        _bounds(result, second)
        if title:
            drawn.suptitle("\n".join(chosen.heading(title, width)))
    return drawn


def _bounds(result: Design, axes: Axes) -> None:
    """Start and found value of each number, from its lower bound to its upper one, in logarithms where they are positive."""
    for row, each in enumerate(result.values):
        numbers: Array = np.array([each.low, each.start, each.found, each.high])
        if each.low > 0:
            numbers = np.log(numbers)
        place = (numbers - numbers[0]) / (numbers[3] - numbers[0])
        axes.plot([0, 1], [row, row], color="#d9d9d9", linewidth=4, solid_capstyle="butt")
        axes.plot(place[1], row, "o", color=GREY, markerfacecolor="white", label="" if row else "before")
        axes.plot(place[2], row, "o", color=BLUE, label="" if row else "design")
    axes.set_yticks(range(len(result.values)), [each.name for each in result.values])
    axes.set_xticks([0, 1], ["lower bound", "upper bound"])
    axes.set_ylim(len(result.values) - 0.5, -0.5)
