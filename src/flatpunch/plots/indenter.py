"""Pictures of an indenter: its surface in three dimensions, and its level lines with sections along two directions.

Figures are made without pyplot, as in `plots`. All axes have lengths with the prefix that keeps numbers readable; the height of
the surface is drawn at its own scale, which the title states.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.colors import LightSource
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flatpunch._support.checks import Array, positive, shown
from flatpunch._support.prefixes import text
from flatpunch.files.units import readable
from flatpunch.indenters.profile import Indenter, split_angles
from flatpunch.plots.style import BLUE, ORANGE, StyleName, axes_or_new, panels, styled

_SURFACE, _LINES, _FIRST, _SECOND = "#c3d2df", "#2b3a4a", BLUE, ORANGE


def plot_tip(
    indenter: Indenter,
    axes: Axes | None = None,
    *,
    extent: float | None = None,
    view: Literal["sections", "levels", "surface"] = "sections",
) -> Axes:
    """Draw a tip: its steepest and flattest section, its level lines, or its surface.

    Parameters
    ----------
    indenter : Indenter
        Any indenter.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure. The surface needs three-dimensional axes.
    extent : float, optional
        Half the width of the picture [m]. Without it the reach of the indenter, or a few of its own lengths, or 1 where the
        shape has none.
    view : "sections", "levels" or "surface"
        What is drawn.

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
    if isinstance(indenter, type) or not isinstance(indenter, Indenter):
        raise TypeError(f"indenter = {shown(indenter)} must be an indenter such as Paraboloid(radius=...).")
    half = _half(indenter, extent)
    if view == "surface":
        # a surface has a box of its own
        solid: Axes = surface(indenter, axes_or_new(axes, (5.0, 4.4), projection="3d"), half)
        return solid
    if view not in ("sections", "levels"):
        raise ValueError(f"view = {shown(view)} is unknown; choose 'sections', 'levels' or 'surface'.")
    drawn = axes_or_new(axes, (5.0, 3.6) if view == "sections" else (4.4, 4.4))
    return sections(indenter, drawn, half) if view == "sections" else level_lines(indenter, drawn, half)


def indenter_figure(
    indenter: Indenter, *, extent: float | None = None, title: str = "", style: StyleName | str = "screen"
) -> Figure:
    """Draw an indenter: surface, level lines, and sections.

    Parameters
    ----------
    indenter : Indenter
        Any indenter.
    extent : float, optional
        Half the width of the pictures [m]; as for `plot_tip`.
    title : str
        Title of the figure; the name of the shape by default.
    style : "screen", "one-column" or "two-columns"
        Side by side, or sizes and fonts for one or two columns of a journal.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with `flatpunch.plots.result.save_figure`.
    """
    half = _half(indenter, extent)
    with styled(style) as chosen:
        drawn, (first, second, third) = panels(chosen, 3, title=title or _name(indenter))
        place = first.get_subplotspec()
        first.remove()
        surface(indenter, drawn.add_subplot(place, projection="3d"), half)
        level_lines(indenter, second, half)
        sections(indenter, third, half)
    return drawn


def _half(indenter: Indenter, extent: float | None) -> float:
    if extent is None:
        return _extent(indenter)
    return positive("extent", extent, "It is half the width of the picture.", unit="m")


def surface(indenter: Any, axes: Any, extent: float) -> Any:
    """Draw the surface into three-dimensional axes, apex down, cut where it reaches the lowest height on the border.

    Parameters
    ----------
    indenter : Indenter
    axes : mpl_toolkits.mplot3d.axes3d.Axes3D
    extent : float
        Half the width [m].
    """
    top = _rim(indenter, extent)
    phi = np.unique(np.concatenate([np.linspace(0, 2 * np.pi, 181), split_angles(indenter)]))
    limit = _level_radius(indenter, top, phi, min(extent * np.sqrt(2), indenter.reach))
    share = np.linspace(0, 1, 72)
    r = share[:, None] * limit
    height = np.asarray(indenter.height(r, phi))
    scale, unit = readable(extent, "m")
    rise, height_unit = readable(top, "m")
    x, y, z = r * np.cos(phi) * scale, r * np.sin(phi) * scale, np.minimum(height, top) * rise
    light = LightSource(azdeg=225, altdeg=-25)
    axes.plot_surface(
        x, y, z, color=_SURFACE, rstride=1, cstride=1, linewidth=0, antialiased=False, shade=True, lightsource=light
    )
    for level in _levels(top, rise)[1:]:
        radius = _level_radius(indenter, level, phi, indenter.reach)
        axes.plot(
            radius * np.cos(phi) * scale, radius * np.sin(phi) * scale, level * rise, color=_LINES, lw=0.5, alpha=0.7
        )
    axes.set_xlabel(f"$x$ ({unit})", labelpad=-4)
    axes.set_ylabel(f"$y$ ({unit})", labelpad=-4)
    axes.zaxis.set_rotate_label(False)
    axes.set_zlabel(f"$f$ ({height_unit})", labelpad=-3, rotation=90)
    axes.tick_params(pad=-2, labelsize=min(rcParams["font.size"] - 1, 7))
    axes.locator_params(nbins=3)
    widest = float(limit.max())
    axes.set_box_aspect((1, 1, float(np.clip(top / (2 * widest), 0.35, 1.0))), zoom=0.8)
    axes.set_xlim(-widest * scale, widest * scale)
    axes.set_ylim(-widest * scale, widest * scale)
    # seen from slightly below, as the body that is pressed sees it
    axes.view_init(elev=-16, azim=-62)
    stretch = float(np.clip(top / (2 * widest), 0.35, 1.0)) / (top / (2 * widest))
    axes.set_title("surface" if 0.99 < stretch < 1.01 else f"surface, heights times {stretch:.3g}")
    return axes


def level_lines(indenter: Any, axes: Axes, extent: float) -> Axes:
    """Draw contour lines of the height, at equal steps up to the lowest height on the border.

    Parameters
    ----------
    indenter : Indenter
    axes : matplotlib.axes.Axes
    extent : float
        Half the width [m].
    """
    top = _rim(indenter, extent)
    phi = np.unique(np.concatenate([2 * np.pi * np.arange(720) / 720, split_angles(indenter)]))
    scale, unit = readable(extent, "m")
    rise, height_unit = readable(top, "m")
    levels = _levels(top, rise)
    for i, level in enumerate(levels):
        radius = _level_radius(indenter, float(level), phi, indenter.reach)
        x, y = radius * np.cos(phi) * scale, radius * np.sin(phi) * scale
        if level == 0 and radius.max() < 1e-6 * extent:
            axes.plot(0, 0, "+", color=_LINES, ms=5)
            continue
        axes.fill(x, y, fill=False, edgecolor=_LINES, lw=1.4 if i == 0 else 0.9, ls="--" if i == 0 else "-")
    step = float(levels[1] * rise)
    flat = _level_radius(indenter, 0.0, phi, indenter.reach).max() > 1e-6 * extent
    axes.set_title(f"level lines every {step:.3g} {height_unit}" + (", flat dashed" if flat else ""))
    axes.set_aspect("equal")
    axes.set_xlim(-extent * scale, extent * scale)
    axes.set_ylim(-extent * scale, extent * scale)
    axes.set_xlabel(f"$x$ ({unit})")
    axes.set_ylabel(f"$y$ ({unit})")
    return axes


def sections(indenter: Any, axes: Axes, extent: float) -> Axes:
    """Draw the sections with the steepest and the flattest rise, through the apex.

    Parameters
    ----------
    indenter : Indenter
    axes : matplotlib.axes.Axes
    extent : float
        Half the width [m].
    """
    usable = min(extent, indenter.reach)
    around = np.pi * np.arange(360) / 360
    rim = np.asarray(indenter.height(np.array(usable), around)) + np.asarray(
        indenter.height(np.array(usable), around + np.pi)
    )
    directions = [(float(around[np.argmax(rim)]), _FIRST, "-")]
    if not indenter.round:
        directions.append((float(around[np.argmin(rim)]), _SECOND, "--"))
    t = np.linspace(-usable, usable, 801)
    curves = [
        np.asarray(indenter.height(np.abs(t), np.where(t < 0, angle + np.pi, angle))) for angle, _, _ in directions
    ]
    scale, unit = readable(extent, "m")
    rise, height_unit = readable(max(float(curve.max()) for curve in curves), "m")
    for (angle, colour, line), curve in zip(directions, curves, strict=True):
        axes.plot(t * scale, curve * rise, line, color=colour, lw=1.5, label=f"along {np.degrees(angle):.3g}°")
    axes.set_xlim(-extent * scale, extent * scale)
    axes.set_ylim(bottom=0)
    axes.set_xlabel(f"distance from the apex ({unit})")
    axes.set_ylabel(f"height $f$ ({height_unit})")
    axes.set_title("sections")
    if not indenter.round:
        axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    return axes


def _extent(indenter: Any) -> float:
    if np.isfinite(indenter.reach):
        return float(indenter.reach)
    lengths = [*indenter.rings, *(scale for scale in getattr(indenter, "scales", ())[:2])]
    lengths += [getattr(indenter, name) for name in ("radius", "half_x", "half_y") if hasattr(indenter, name)]
    return 3.0 * max(lengths) if lengths else 1.0


def _name(indenter: Any) -> str:
    tip = getattr(indenter, "tip", None)
    return type(indenter).__name__ + (f" {_name(tip)}" if tip is not None else "")


def _levels(top: float, rise: float) -> Array:
    """Heights of level lines [m] from zero up to `top`, a round number apart in the printed unit."""
    most = 12  # lines, about
    step = float(np.diff(MaxNLocator(most, steps=[1, 2, 5, 10]).tick_values(0.0, top * rise))[0]) / rise
    return np.asarray(step * np.arange(int(top / step * (1 + 1e-9)) + 1))


def _rim(indenter: Any, extent: float) -> float:
    """Lowest height on the circle of radius `extent`: up to there every level line is inside the picture."""
    phi = np.concatenate([np.linspace(0, 2 * np.pi, 721), split_angles(indenter)])
    height = np.asarray(indenter.height(np.array(min(extent, indenter.reach)), phi))
    lowest = float(height.min())
    if not (np.isfinite(lowest) and lowest > 0):
        raise ValueError(
            f"{_name(indenter)} is flat up to {text(extent, 'm')}, so it has no level lines there. Draw a larger extent."
        )
    return lowest


def _level_radius(indenter: Any, level: float, phi: Array, limit: float) -> Array:
    """Radius at which the height along each ray exceeds a level, by bisection."""
    low, high = np.zeros_like(phi), np.full_like(phi, limit if np.isfinite(limit) else 1.0)
    if not np.isfinite(limit):
        for _ in range(400):
            short = np.asarray(indenter.height(high, phi)) <= level
            if not short.any():
                break
            high = np.where(short, 2 * high, high)
    for _ in range(90):
        middle = (low + high) / 2
        above = np.asarray(indenter.height(middle, phi)) > level
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(high)
