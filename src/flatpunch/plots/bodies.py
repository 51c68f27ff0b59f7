"""Pictures of what is pressed together: Young's modulus of a body over its depth; surface, level lines and sections of a tip.

Figures are made without pyplot, as in `plots`. All axes have lengths with the prefix that keeps numbers readable; the height of
the surface is drawn at its own scale, which the title states. Depth runs downwards; of two bodies the upper one is above zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource
from matplotlib.figure import Figure

from flatpunch._support.checks import Array, non_negative, one_of, positive
from flatpunch._support.declared import numbers_of
from flatpunch._support.prefixes import readable, text
from flatpunch.indenters.geometry.features import radius_above
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import (
    Body,
    Stack,
    underlying,
)
from flatpunch.numerics.extents import ROOM
from flatpunch.plots.outline import framed
from flatpunch.plots.style import (
    BLUE,
    GREY,
    HEADROOM,
    ORANGE,
    SAMPLES,
    THIN,
    StyleName,
    axes_or_new,
    check_label,
    legend_below,
    logarithmic,
    next_colour,
    panels,
    round_step,
    scale_on,
    styled,
)

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d import Axes3D


_SURFACE, _LINES = "#c3d2df", "#2b3a4a"

_BELOW = -20
"""Elevation from which a tip is seen and lit [degrees]: from below, as the body that is pressed sees it."""


def plot_tip(
    indenter: Indenter,
    axes: Axes | None = None,
    *,
    extent: float | None = None,
    view: Literal["sections", "levels", "surface"] = "sections",
    label: str | None = None,
) -> Axes:
    """Draw a tip: its steepest and flattest section, its level lines, or its surface.

    Parameters
    ----------
    indenter : Indenter
        The tip.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure. The surface needs three-dimensional axes. Axes that hold a tip keep their units,
        and the new one has its own colours.
    extent : float, optional
        Half the width of the picture [m]. Without it the reach of the indenter, or a few of its own lengths, or 1 where the
        shape has none.
    view : "sections", "levels" or "surface"
        What is drawn.
    label : str, optional
        Name of the tip in the legend.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    ValueError
        If the tip is flat up to the extent, or the view is unknown.

    See Also
    --------
    plot_medium : What the tip is pressed into.

    Examples
    --------
    >>> axes = fp.plot_tip(fp.Berkovich(tip_radius=50e-9), extent=200e-9)
    >>> axes.get_ylabel()
    'height $f$ (nm)'
    """
    check_indenter(indenter)
    one_of("view", view, _VIEWS)
    check_label(label)
    # a surface has a box of its own
    drawn = axes_or_new(axes, projection="3d" if view == "surface" else None)
    _VIEWS[view](indenter, drawn, _half(indenter, extent), label)
    return drawn


def indenter_figure(
    indenter: Indenter, *, extent: float | None = None, title: str = "", style: StyleName | str = "screen"
) -> Figure:
    """Draw an indenter: surface, level lines, and sections, see `plot_tip`; titled by its shape unless a title is given."""
    half = _half(indenter, extent)
    with styled(style) as chosen:
        drawn, (first, second, third) = panels(chosen, 3, title=title or _name(indenter))
        place = first.get_subplotspec()
        first.remove()
        _surface(indenter, drawn.add_subplot(place, projection="3d"), half)
        _level_lines(indenter, second, half)
        _sections(indenter, third, half)
    return drawn


def _half(indenter: Indenter, extent: float | None) -> float:
    if extent is None:
        return _extent(indenter)
    return positive("extent", extent, "It is half the width of the picture.", unit="m")


def _surface(indenter: Indenter, axes: Axes3D, extent: float, label: str | None = None) -> None:
    """Draw the surface into three-dimensional axes, apex down, cut where it reaches the lowest height on the border."""
    top = _rim(indenter, extent)
    phi = np.unique(np.concatenate([np.linspace(0, 2 * np.pi, SAMPLES), indenter.split_angles]))
    limit = radius_above(indenter, top, phi, extent * np.sqrt(2))
    share = np.linspace(0, 1, SAMPLES // 2)
    r = share[:, None] * limit
    height = np.asarray(indenter.height(r, phi))
    if indenter.flat and extent >= indenter.reach:  # with its side
        r, height = np.vstack([r, limit]), np.vstack([height, np.full_like(limit, top)])
    first, (scale, unit) = not axes.has_data(), scale_on(axes.xaxis, [extent], "m")
    rise, height_unit = scale_on(axes.zaxis, [top], "m")
    colour = _SURFACE if first else next_colour(axes)
    x, y, z = r * np.cos(phi) * scale, r * np.sin(phi) * scale, np.minimum(height, top) * rise
    light = LightSource(altdeg=_BELOW)
    axes.plot_surface(x, y, z, color=colour, rstride=1, cstride=1, linewidth=0, antialiased=False, lightsource=light)
    for level in _levels(top, rise)[1:]:
        radius = radius_above(indenter, level, phi, extent * np.sqrt(2))
        axes.plot(
            radius * np.cos(phi) * scale,
            radius * np.sin(phi) * scale,
            level * rise,
            color=_LINES if first else colour,
            lw=THIN / 2,
        )
    axes.set_xlabel(f"$x$ ({unit})", labelpad=-4)
    axes.set_ylabel(f"$y$ ({unit})", labelpad=-4)
    axes.zaxis.set_rotate_label(False)
    axes.set_zlabel(f"$f$ ({height_unit})", labelpad=-3, rotation="vertical")
    axes.tick_params(pad=-2, labelsize="x-small")
    axes.locator_params(nbins=3)
    widest = float(limit.max()) if first else max(float(limit.max()), axes.get_xlim()[1] / scale)
    tallest = top if first else max(top, axes.get_zlim()[1] / rise)
    aspect = float(np.clip(tallest / (2 * widest), 1 / 3, 1.0))
    axes.set_box_aspect((1, 1, aspect), zoom=1 / ROOM)
    axes.set_xlim(-widest * scale, widest * scale)
    axes.set_ylim(-widest * scale, widest * scale)
    axes.view_init(elev=_BELOW)
    stretch = aspect / (tallest / (2 * widest))
    axes.set_title("surface" if np.isclose(stretch, 1) else f"surface, heights times {stretch:.3g}")
    _named(axes, colour, label)


def _level_lines(indenter: Indenter, axes: Axes, extent: float, label: str | None = None) -> None:
    """Draw contour lines of the height, at equal steps up to the lowest height on the border."""
    top = _rim(indenter, extent)
    phi = np.unique(np.concatenate([np.linspace(0, 2 * np.pi, SAMPLES), indenter.split_angles]))
    first, (scale, unit) = not axes.has_data(), scale_on(axes.xaxis, [extent], "m")
    colour = _LINES if first else next_colour(axes)
    rise, height_unit = readable(top, "m")
    levels = _levels(top, rise)[: 1 if indenter.flat else None]
    for i, level in enumerate(levels):
        radius = radius_above(indenter, float(level), phi, extent * np.sqrt(2))
        x, y = radius * np.cos(phi) * scale, radius * np.sin(phi) * scale
        if level == 0 and radius.max() < 1e-6 * extent:
            axes.plot(0, 0, "+", color=colour)
            continue
        axes.fill(x, y, fill=False, edgecolor=colour, lw=THIN if i else 2 * THIN, ls="--" if i == 0 else "-")
    flat = radius_above(indenter, 0.0, phi, extent * np.sqrt(2)).max() > 1e-6 * extent
    words = "flat" if indenter.flat else f"level lines every {levels[1] * rise:.3g} {height_unit}"
    words += ", dashed" if indenter.flat else ", flat dashed" if flat else ""
    axes.set_title(words if first or axes.get_title() == words else "level lines, of each tip at steps of its own")
    framed(axes, extent * scale if first else max(extent * scale, axes.get_xlim()[1]), unit)
    _named(axes, colour, label)


def _sections(indenter: Indenter, axes: Axes, extent: float, label: str | None = None) -> None:
    """Draw the sections with the steepest and the flattest rise, through the apex."""
    usable = min(extent, indenter.reach)
    around = np.pi * np.arange(SAMPLES) / SAMPLES
    rim = np.asarray(indenter.height(np.array(usable), around)) + np.asarray(
        indenter.height(np.array(usable), around + np.pi)
    )
    directions = [float(around[find(rim)]) for find in ((np.argmax,) if indenter.round else (np.argmax, np.argmin))]
    t = np.linspace(-usable, usable, 4 * SAMPLES + 1)
    curves = [np.asarray(indenter.height(np.abs(t), np.where(t < 0, angle + np.pi, angle))) for angle in directions]
    if indenter.flat and extent >= indenter.reach:  # with its side
        t, curves = t[[0, *range(t.size), -1]], [np.pad(curve, 1, constant_values=extent) for curve in curves]
    top = max(float(curve.max()) for curve in curves) or extent
    first, (scale, unit) = not axes.has_data(), scale_on(axes.xaxis, [extent], "m")
    rise, height_unit = scale_on(axes.yaxis, [top], "m")
    for angle, line, curve in zip(directions, ("-", "--"), curves, strict=False):
        along = f"along {np.degrees(angle):.3g}°"
        name = along if label is None else label if indenter.round else f"{label}, {along}"
        axes.plot(t * scale, curve * rise, line, color=next_colour(axes), label=name)
    half = extent * scale if first else max(extent * scale, axes.get_xlim()[1])
    axes.set_xlim(-half, half)
    axes.set_ylim(0, HEADROOM * top * rise if first else max(HEADROOM * top * rise, axes.get_ylim()[1]))
    axes.set(xlabel=f"distance from the apex ({unit})", ylabel=f"height $f$ ({height_unit})", title="sections")
    if not (first and indenter.round and label is None):
        axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)


_VIEWS: dict[str, Callable[[Indenter, Axes, float, str | None], None]] = {
    "sections": _sections,
    "levels": _level_lines,
    "surface": _surface,
}
"""How each view is drawn."""


def _named(axes: Axes, colour: str, label: str | None) -> None:
    """Name in the legend, and a mark from which the next tip knows that this colour is taken."""
    axes.plot([], [], color=colour, label=label)
    if label is not None:
        axes.legend(frameon=False)


def _extent(indenter: Indenter) -> float:
    if np.isfinite(indenter.reach):
        return float(indenter.reach) * (HEADROOM if indenter.flat else 1.0)
    own = [place.value for place in numbers_of(indenter) if place.number.unit == "m"]
    return 3.0 * max([*indenter.rings, *indenter.scales[:2], *own], default=1 / 3)


def _name(indenter: object) -> str:
    """Its shape, and that of the tip that it was made of."""
    parts = (getattr(indenter, field.name) for field in (fields(indenter) if is_dataclass(indenter) else ()))
    inner = next((part for part in parts if isinstance(part, Indenter)), None)
    return type(indenter).__name__ + (f" {_name(inner)}" if inner else "")


def _levels(top: float, rise: float) -> Array:
    """Heights of level lines [m] from zero up to `top`, a round number apart in the printed unit."""
    step = round_step(top * rise) / rise
    return np.asarray(step * np.arange(int(top / step * (1 + 1e-9)) + 1))


def _rim(indenter: Indenter, extent: float) -> float:
    """Lowest height on the circle of radius `extent`, so that every level line is inside the picture; of a flat end its side."""
    if indenter.flat:
        return extent
    phi = np.concatenate([np.linspace(0, 2 * np.pi, SAMPLES), indenter.split_angles])
    height = np.asarray(indenter.height(np.array(min(extent, indenter.reach)), phi))
    lowest = float(height.min())
    if not (np.isfinite(lowest) and lowest > 0):
        raise ValueError(
            f"{_name(indenter)} is flat up to {text(extent, 'm')}, so it has no level lines there. Draw a larger extent."
        )
    return lowest


_MODULUS, _FACE, _CONTACT = BLUE, GREY, ORANGE


@dataclass(frozen=True, slots=True)
class Profile:
    """Young's modulus of one body along its depth.

    Attributes
    ----------
    pieces : tuple of (ndarray, ndarray)
        Depths z [m] from the contact surface and moduli [Pa] of each layer, then of an elastic base.
    faces : tuple of (float, bool)
        Depth of each layer's lower face [m], and whether it sticks to what is below.
    end : float
        Depth down to which the profile goes [m].
    rigid : bool
        Whether a rigid base begins at the last face.
    """

    pieces: tuple[tuple[Array, Array], ...]
    faces: tuple[tuple[float, bool], ...]
    end: float
    rigid: bool


def profile(body: Stack, reach: float) -> Profile:
    """Modulus over depth of one body, down to `reach` [m] at least and past all its layers."""
    top, pieces, faces = 0.0, [], []
    for layer in body.layers:
        z = np.linspace(0.0, layer.thickness, SAMPLES if layer.varies else 2)
        z = np.unique(np.concatenate([z, layer.breaks]))
        pieces.append((top + z, layer.young_at(z)))
        top += layer.thickness
        faces.append((top, bool(layer.face)))
    end = max(ROOM * top, reach)
    if not body.base.rigid:
        # the modulus of a power law is zero or infinite at the surface itself
        z = np.linspace(0.0, end, SAMPLES + 1)[1:] if body.base.varies else np.array([top, end])
        pieces.append((z, body.base.young_at(z)))
    return Profile(tuple(pieces), tuple(faces), end, body.base.rigid)


def plot_medium(medium: Body, axes: Axes | None = None, *, contact_radius: float = 0.0) -> Axes:
    """Draw Young's modulus over depth, with the faces of the layers: dashed where they slide or lift off.

    Of transversely isotropic bodies it is the modulus in the plane.

    Parameters
    ----------
    medium : Medium, HalfSpace, PowerLawHalfSpace, TwoBodies or FreeLayer
        The body, or two of them: the upper one is then above zero.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    contact_radius : float
        Mean contact radius [m]: a contact feels the body down to about this depth, which is marked; 0 marks nothing.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    plot_tip : The tip.

    Examples
    --------
    >>> coated = fp.Medium([fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)], base=fp.HalfSpace(young=2e9, poisson=0.3))
    >>> axes = fp.plot_medium(coated)
    >>> axes.get_xlabel(), axes.get_ylabel()
    ("Young's modulus $E$ (GPa)", 'depth $z$ (µm)')
    """
    axes = axes_or_new(axes)
    body = underlying(medium)
    bodies = [(side, -1.0 if name == "upper" else 1.0) for name, side in body.sides]
    contact_radius = non_negative("contact_radius", contact_radius, unit="m")
    own = ROOM * float(body.length)
    reach = ROOM * contact_radius or (own if np.isfinite(own) else 1.0)
    profiles = [(profile(body, reach), sign) for body, sign in bodies]
    moduli = np.concatenate([young for found, _ in profiles for _, young in found.pieces])
    wide = moduli.max() > 10 * moduli.min()
    young_factor, young_unit = readable(float(np.sqrt(moduli.max() * moduli.min()) if wide else moduli.max()), "Pa")
    factor, unit = readable(max(found.end for found, _ in profiles), "m")
    for found, sign in profiles:
        for z, young in found.pieces:
            axes.plot(young * young_factor, sign * z * factor, color=_MODULUS)
        _faces(found, sign * factor, axes)
    if wide:
        logarithmic(axes, "x")
    else:
        axes.set_xlim(0, HEADROOM * float(moduli.max()) * young_factor)
    low = -profiles[0][0].end * factor if body.pair else 0.0
    axes.set_ylim(profiles[-1][0].end * factor, low)
    if body.pair:
        axes.axhline(0, color="black", linewidth=THIN)
    _mark_contact(contact_radius * factor, body.pair, axes)
    axes.set_xlabel(f"Young's modulus $E$ ({young_unit})")
    axes.set(ylabel=f"depth $z$ ({unit})" + (", upper body above 0" if body.pair else ""), title="Modulus over depth")
    return axes


def _faces(found: Profile, scale: float, axes: Axes) -> None:
    for depth, bonded in found.faces:
        axes.axhline(scale * depth, color=_FACE, linewidth=THIN, linestyle="-" if bonded else "--")
    if found.rigid:
        top = found.faces[-1][0] if found.faces else 0.0
        axes.axhspan(scale * top, scale * found.end, facecolor="none", edgecolor=_FACE, hatch="///", linewidth=0)
        middle = scale * (top + found.end) / 2
        box = {"facecolor": "white", "edgecolor": "none"}
        axes.text(0.5, middle, "rigid", transform=axes.get_yaxis_transform(), ha="center", va="center", bbox=box)


def _mark_contact(radius: float, pair: bool, axes: Axes) -> None:
    if radius <= 0:
        return
    for depth in (-radius, radius) if pair else (radius,):
        axes.axhline(depth, color=_CONTACT, linestyle=":", label="contact radius" if depth > 0 else None)
    legend_below(axes)
