"""The picture of a result: force and stiffness over depth, the contact outline on the indenter, the pressure.

`figure` puts the three side by side, or as the style of a journal has it. Figures are made without pyplot, so nothing depends on
a display or on a global state. Units get the prefix that keeps numbers readable.
"""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flatpunch._support.whole_file import whole_file
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.plots import adhesion, history
from flatpunch.plots.curve import plot_curve
from flatpunch.plots.medium import is_graded, plot_medium
from flatpunch.plots.outline import last_valid, plot_outline
from flatpunch.plots.pressure import plot_pressure
from flatpunch.plots.style import StyleName, panels, styled


def figure(
    result: xr.Dataset, medium: Body, indenter: Indenter, *, title: str = "", style: StyleName | str = "screen"
) -> Figure:
    """Return force-depth curve, outline and pressure map, and the modulus over depth of graded bodies, side by side on a screen.

    Adhesive contacts get the loop of approach and withdrawal, histories force and depth over time instead.
    """
    with styled(style) as chosen:
        if "relaxation" in result.attrs:
            return history.figure(result, indenter, chosen, title=title)
        if "work_of_adhesion" in result.attrs:
            return adhesion.figure(result, medium, indenter, chosen, title=title)
        graded = is_graded(medium)
        drawn, (first, second, third, *more) = panels(chosen, 3 + graded, title=title)
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
