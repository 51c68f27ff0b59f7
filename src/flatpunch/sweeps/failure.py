"""Critical loads of a parameter study, and the map on which the kind of the first failure changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from flatpunch._support.paths import Plain
from flatpunch.files.units import readable
from flatpunch.stresses import CriticalLoad
from flatpunch.sweeps.axes import in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = ("yield", "tensile", "shear", "interface tension", "interface shear")
"""Kinds of failure in the order of their numbers."""

_COLOURS = ("#8ecae6", "#ffb703", "#b5e48c", "#e5989b", "#cdb4db", "#d6ccc2", "#a3b18a", "#f4a261")


def critical_variables(found: CriticalLoad | None, steps: int) -> Plain:
    """Critical load of a case as variables along the steps (all of which are alike); not numbers where it was not found."""
    force, depth, radius, kind, layer = (
        (found.force, found.depth, found.radius, float(KINDS.index(found.kind)), float(found.layer))
        if found
        else np.full(5, np.nan)
    )
    values = {
        "critical_force": (force, "N", "load at the first failure"),
        "critical_depth": (depth, "m", "depth at the first failure"),
        "critical_radius": (radius, "m", "contact radius at the first failure"),
        "critical_kind": (kind, "", "kind of the first failure: " + _numbered(KINDS)),
        "critical_layer": (layer, "", "layer of the first failure, from the surface; the base comes last"),
    }
    return {
        name: ("step", np.full(steps, value), {"units": unit, "long_name": text} if unit else {"long_name": text})
        for name, (value, unit, text) in values.items()
    }


def _numbered(names: tuple[str, ...]) -> str:
    return ", ".join(f"{i} {name}" for i, name in enumerate(names))


def is_map(result: xr.Dataset, quantity: str | None) -> bool:
    """Whether the critical load is asked for over two parameters that are numbers."""
    names = list(result["status"].dims)
    numeric = len(names) == 2 and all(result[name].dtype.kind in "if" and result.sizes[name] > 1 for name in names)
    return quantity == "critical_force" and "critical_force" in result and numeric


def map_figure(result: xr.Dataset, *, width: float | None = None, settings: Any = None) -> Figure:
    """Draw the critical load over the first two parameters: areas by kind and layer, level lines of the load.

    Takes what `sweep` returned for a case with strengths; width [in] and settings are as of `picture.figure`.
    """
    import matplotlib
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    from flatpunch.plots.style import logarithmic
    from flatpunch.sweeps.picture import geometric

    first, second = (str(name) for name in result["status"].dims)
    axes_values, labels = [], []
    for name in (first, second):
        unit = str(result[name].attrs.get("units", ""))
        factor, readable_unit = readable(float(np.abs(result[name].values).max()), unit) if unit else (1.0, "")
        axes_values.append(result[name].values * factor)
        words = in_words(name)
        labels.append(f"{words} ({readable_unit})" if readable_unit else words)
    force = result["critical_force"].isel(step=0).values.T
    force = np.where(np.isfinite(force) & (force > 0), force, np.nan)
    kind, layer = (result[f"critical_{name}"].isel(step=0).values.T for name in ("kind", "layer"))
    places = sorted({(int(k), int(i)) for k, i in zip(kind.ravel(), layer.ravel(), strict=True) if np.isfinite(k)})
    number = np.full(kind.shape, np.nan)
    for n, (k, i) in enumerate(places):
        number[(kind == k) & (layer == i)] = n
    with matplotlib.rc_context(settings or {}):
        drawn = Figure(figsize=(width, width) if width else None, layout="constrained")
        axes = drawn.subplots()
        colours = ListedColormap([_COLOURS[n % len(_COLOURS)] for n in range(len(places))])
        norm = BoundaryNorm(np.arange(len(places) + 1) - 0.5, max(len(places), 1))
        for name, which in ((first, "x"), (second, "y")):
            if geometric(result, name):
                logarithmic(axes, which)
        axes.pcolormesh(*axes_values, number, cmap=colours, norm=norm, shading="nearest", rasterized=True)
        axes.plot(*map(np.ravel, np.meshgrid(*axes_values)), ".", color="black", ms=2, clip_on=False, zorder=3)
        if np.isfinite(force).sum() > 3 and np.nanmax(force) > np.nanmin(force):
            factor, unit = readable(float(np.nanmax(force)), "N")
            levels = np.geomspace(np.nanmin(force) * factor, np.nanmax(force) * factor, 10)[1:-1]
            if levels[-1] > 2 * levels[0]:
                levels = np.array([float(f"{level:.1e}") for level in levels])
            lines = axes.contour(*axes_values, force * factor, levels=levels, colors="black", linewidths=1)
            # each level has its number, in the middle of its longest line, where no edge cuts it off
            longest = (max(level, key=len) for level in lines.allsegs if level)
            middles = [tuple(line[len(line) // 2]) for line in longest]
            axes.clabel(lines, fmt=lambda value: f"{value:.3g} {unit}", fontsize="x-small", manual=middles)
        for axis, values in zip((axes.xaxis, axes.yaxis), axes_values, strict=True):
            # cells of the outermost points reach beyond them
            axis.set_view_interval(float(values.min()), float(values.max()), ignore=True)
        layers = int(np.nanmax(layer)) if places else 0
        patches = [
            Patch(color=_COLOURS[n % len(_COLOURS)], label=f"{KINDS[k]}, layer {i + 1}")
            for n, (k, i) in enumerate(places)
        ]
        drawn.legend(handles=patches, loc="outside lower center", ncols=2, frameon=False, fontsize="small")
        axes.set_xlabel(labels[0])
        axes.set_ylabel(labels[1])
        axes.set_title(
            "First failure and its load" + (" (layer 1 is the top, the last the base)" if layers else ""),
            fontsize="medium",
        )
        return drawn
