"""Critical loads of a parameter study, and the map on which the kind of the first failure changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from flatpunch.fields import critical_load
from flatpunch.files import Case
from flatpunch.files.units import readable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = ("yield", "tensile", "shear", "interface tension", "interface shear")
"""Kinds of failure in the order of their numbers."""

_COLOURS = ("#8ecae6", "#ffb703", "#b5e48c", "#e5989b", "#cdb4db", "#d6ccc2", "#a3b18a", "#f4a261")


def first_failure(case: Case, steps: int) -> dict[str, Any]:
    """Critical load of a case with strengths, as variables along the steps (all of which are alike)."""
    assert case.stress is not None
    found = critical_load(case.medium, case.indenter, **case.stress.critical(case.medium))
    values = {
        "critical_force": (found.force, "N", "load at the first failure"),
        "critical_depth": (found.depth, "m", "depth at the first failure"),
        "critical_radius": (found.radius, "m", "contact radius at the first failure"),
        "critical_kind": (float(KINDS.index(found.kind)), "", "kind of the first failure: " + _numbered(KINDS)),
        "critical_layer": (float(found.layer), "", "layer of the first failure, from the surface; the base comes last"),
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


def map_figure(result: xr.Dataset) -> Figure:
    """Draw the critical load over the first two parameters: areas by kind and layer, level lines of the load.

    Parameters
    ----------
    result : xarray.Dataset
        What `sweep` returned for a case with strengths.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    first, second = (str(name) for name in result["status"].dims)
    axes_values, labels = [], []
    for name in (first, second):
        unit = str(result[name].attrs.get("units", ""))
        factor, readable_unit = readable(float(np.abs(result[name].values).max()), unit) if unit else (1.0, "")
        axes_values.append(result[name].values * factor)
        words = name.replace(".", " ").replace("_", " ")
        labels.append(f"{words} ({readable_unit})" if readable_unit else words)
    force = result["critical_force"].isel(step=0).values.T
    force = np.where(np.isfinite(force) & (force > 0), force, np.nan)
    kind, layer = (result[f"critical_{name}"].isel(step=0).values.T for name in ("kind", "layer"))
    places = sorted({(int(k), int(i)) for k, i in zip(kind.ravel(), layer.ravel(), strict=True) if np.isfinite(k)})
    number = np.full(kind.shape, np.nan)
    for n, (k, i) in enumerate(places):
        number[(kind == k) & (layer == i)] = n
    drawn = Figure(figsize=(6.4, 4.4), layout="constrained")
    axes = drawn.subplots()
    colours = ListedColormap([_COLOURS[n % len(_COLOURS)] for n in range(len(places))])
    norm = BoundaryNorm(np.arange(len(places) + 1) - 0.5, max(len(places), 1))
    axes.pcolormesh(*axes_values, number, cmap=colours, norm=norm, shading="nearest", rasterized=True)
    if np.isfinite(force).sum() > 3 and np.nanmax(force) > np.nanmin(force):
        factor, unit = readable(float(np.nanmax(force)), "N")
        levels = np.geomspace(np.nanmin(force) * factor, np.nanmax(force) * factor, 8)[1:-1]
        lines = axes.contour(*axes_values, force * factor, levels=levels, colors="black", linewidths=0.8)
        axes.clabel(lines, fmt=lambda value: f"{value:.3g} {unit}", fontsize=7)
    for values, scale in zip(axes_values, (axes.set_xscale, axes.set_yscale), strict=True):
        if (values > 0).all() and values.max() > 8 * values.min():
            scale("log")
    layers = int(np.nanmax(layer)) if places else 0
    patches = [
        Patch(color=_COLOURS[n % len(_COLOURS)], label=f"{KINDS[k]}, layer {i + 1}") for n, (k, i) in enumerate(places)
    ]
    drawn.legend(handles=patches, loc="outside right upper", frameon=False, fontsize=8)
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    axes.set_title("First failure and its load" + (", layers counted from the surface" if layers else ""), fontsize=10)
    return drawn
