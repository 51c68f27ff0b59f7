"""Pictures of a result: force and stiffness over depth, the contact outline on the indenter, the pressure map.

Each function draws into axes it is given and returns them; `figure` puts all three side by side. Figures are made without
pyplot, so nothing depends on a display or on a global state. Units get the prefix that keeps numbers readable.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from flatpunch.files.results import whole_file
from flatpunch.plots.panels import _last_valid, force_depth, outline, pressure_map

_STYLE: Any = {"axes.grid": True, "grid.alpha": 0.25, "grid.linewidth": 0.6, "font.size": 9, "axes.titlesize": 10}


def figure(result: xr.Dataset, medium: Any, indenter: Any, *, title: str = "") -> Figure:
    """Return force-depth curve, outline and pressure map side by side, and the modulus over depth of graded bodies.

    Adhesive contacts get the loop of approach and withdrawal, histories force and depth over time instead.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    medium, indenter : object
        What it was solved for.
    title : str
        Heading over all three.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with `save_figure`, or with its own `savefig`.
    """
    import matplotlib

    # these modules draw with what is here
    from flatpunch.plots import adhesion as plots_adhesion
    from flatpunch.plots import history as plots_history
    from flatpunch.plots import medium as plots_medium

    with matplotlib.rc_context(_STYLE):
        if "relaxation" in result.attrs:
            return plots_history.figure(result, medium, indenter, title=title)
        if "work_of_adhesion" in result.attrs:
            return plots_adhesion.figure(result, medium, indenter, title=title)
        graded = plots_medium.is_graded(medium)
        layout = ConstrainedLayoutEngine(wspace=0.06 if graded else None)
        drawn = Figure(figsize=(16.8 if graded else 13.2, 4.2), layout=layout)
        left, middle, right, *more = drawn.subplots(
            1, 4 if graded else 3, width_ratios=(1.15, 1, 1.15, 0.75)[: 3 + graded]
        )
        for axes in more:
            plots_medium.modulus_depth(medium, axes, contact_radius=float(result["radius"].values[_last_valid(result)]))
        force_depth(result, left)
        outline(result, indenter, middle)
        try:
            pressure_map(result, medium, indenter, right)
        except ValueError as error:  # some steps have a force and an outline, but a history that gives no pressure
            right.set_axis_off()
            right.text(0.5, 0.5, f"No pressure map:\n{error}", ha="center", va="center", wrap=True)
        if title:
            drawn.suptitle(title, fontsize=12)
    return drawn


def save_figure(drawn: Figure, path: str | Path) -> Path:
    """Write a figure as PNG, PDF or SVG, by the ending; whole or not at all."""
    path = Path(path)
    known = sorted(drawn.canvas.get_supported_filetypes())
    if path.suffix.lower().removeprefix(".") not in known:
        raise ValueError(f"{path}: the ending must be one of {', '.join(known)}.")
    with whole_file(path) as temporary:
        drawn.savefig(temporary, dpi=200)
    return path
