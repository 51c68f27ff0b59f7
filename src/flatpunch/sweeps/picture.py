"""Pictures of a parameter study: one quantity at one step over the first parameter, a line for each of the second; maps of loads.

Further parameters get panels. Many values of a numeric second parameter get a colour bar instead of a legend. Points at
which the theory does not hold are hollow, points that failed are crosses on the axis.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flatpunch._support.checks import Array, BadValue, one_of
from flatpunch.files import units
from flatpunch.plots.style import logarithmic
from flatpunch.sweeps.axes import in_words
from flatpunch.sweeps.study import KINDS

_LEGEND, _PANELS = 8, 9
_STYLE: Any = {"axes.grid": True, "grid.color": "#e0e0e0"}
_SYMBOLS = {"force": "normal force $F$", "depth": "indentation depth $d$", "radius": "mean contact radius $a_0$"}
_LINE = "_a value of the second parameter"
_VIRIDIS = matplotlib.colors.ListedColormap(matplotlib.colormaps["viridis"](np.linspace(0, 0.9, 100)), "viridis")
"""Without its last tenth, which is too pale for lines on white paper."""
_FAILED, _ONE = "#c1121f", "#1f4e79"
_COLOURS = ("#8ecae6", "#ffb703", "#b5e48c", "#e5989b", "#cdb4db", "#d6ccc2", "#a3b18a", "#f4a261")


def parameters(result: xr.Dataset) -> list[str]:
    """Paths of the varied parameters, in order."""
    return [str(name) for name in result["status"].dims]


def figure(
    result: xr.Dataset,
    *,
    quantity: str | None = None,
    step: int = -1,
    width: float | None = None,
    settings: Any = None,
) -> Figure:
    """Draw what `sweep` returned, as a figure: one quantity at one step.

    By default the force, or the depth where forces were prescribed, at the last step, in a width [in] that goes with the number
    of panels. `settings` of Matplotlib take the place of the picture's own. A ValueError says that nothing was solved, or that
    more panels would be needed than a picture shows.
    """
    first, *others = parameters(result)
    values = checked(result, quantity, step).isel(step=step)
    shown = str(values.name)
    _few_enough(result)
    panels = list(itertools.product(*(range(result.sizes[name]) for name in others[1:])))
    columns = len(panels) if len(panels) < 4 else math.ceil(math.sqrt(len(panels)))
    rows = math.ceil(len(panels) / columns)
    finite = values.values[np.isfinite(values.values)]
    factor, unit = units.readable(float(np.abs(finite).max(initial=0.0)), str(values.attrs.get("units", "")))
    size = np.array([1 + 4 * columns, 1 + 3 * rows])
    with matplotlib.rc_context({**_STYLE, **(settings or {})}):
        drawn = Figure(figsize=tuple(size * (width / size[0] if width else 1)), layout="constrained")
        grid = drawn.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
        for at, axes in itertools.zip_longest(panels, grid.flat):
            if at is None:
                axes.set_axis_off()
                continue
            fixed = dict(zip(others[1:], at, strict=True))
            _panel(axes, result.isel(fixed).isel(step=step), shown, factor, first, others[0] if others else None)
            axes.set_title(
                ", ".join(
                    f"{heading(name, parameters(result))} = {value_text(result[name], i)}" for name, i in fixed.items()
                )
            )
        label = _SYMBOLS.get(shown, str(values.attrs.get("long_name", shown))) + where(result, shown, step)
        for axes in grid[:, 0]:
            axes.set_ylabel(f"{label} ({unit})" if unit else label)
        _scale(grid[0, 0], first, result, finite)
        for axes in grid.flat[max(0, len(panels) - columns) : len(panels)]:  # the lowest of each column
            axes.set_xlabel(_label(result, first))
            axes.tick_params(labelbottom=True)
        if others:
            _legend(drawn, grid, result, others[0])
    return drawn


def checked(result: xr.Dataset, quantity: str | None, step: int) -> xr.DataArray:
    """Return the variable to show: the one that is named, or the force, or the depth where forces were prescribed."""
    known = [
        str(name) for name, found in result.data_vars.items() if found.dims[-1:] == ("step",) and found.dtype == float
    ]
    if not known:
        raise ValueError("no point of this study was solved, so there is nothing to show; its `reason` says why.")
    default = "depth" if result.attrs.get("control") == "force" else "force"
    wanted = one_of("quantity", default if quantity is None else quantity, known, wrong="is not in this study")
    steps = result.sizes["step"]
    if not -steps <= step < steps:
        raise BadValue("step", f"{step}", f"is not in this study, whose points have {steps} steps: 0 to {steps - 1}.")
    return result[wanted]


def where(result: xr.Dataset, quantity: str, step: int = -1) -> str:
    """Words for the step of a quantity: what was prescribed there, if it is the same at all points.

    Loads of the first failure belong to no step.
    """
    if quantity.startswith("critical_"):
        return ""
    control = str(result.attrs["control"])
    values = result[control].isel(step=step).values
    values = values[np.isfinite(values)]
    # boundary elements meet what was prescribed to 1e-6 or so
    if values.size and np.ptp(values) <= 1e-4 * np.abs(values).max():
        return f" at {control} {units.text(float(values[0]), str(result[control].attrs['units']))}"
    return ""


def _few_enough(result: xr.Dataset) -> None:
    panels = math.prod(result.sizes[name] for name in parameters(result)[2:])
    if panels > _PANELS:
        raise ValueError(
            f"a picture of this study would need {panels} panels, one for each value beyond the first two parameters; "
            f"{_PANELS} is the most. Name the parameters with the most values first, or draw a part of it."
        )


def _panel(axes: Axes, part: xr.Dataset, shown: str, factor: float, first: str, second: str | None) -> None:
    part = part.isel({first: np.argsort(_positions(part, first))})
    x = _positions(part, first)
    lines = [part] if second is None else [part.isel({second: i}) for i in range(part.sizes[second])]
    for line, colour in zip(lines, _colours(part, second), strict=True):
        y, valid = line[shown].values * factor, line["valid"].values.astype(bool)
        axes.plot(x, y, "-", color=colour, label=_LINE)
        axes.plot(x, np.where(valid, y, np.nan), "o", color=colour, markersize=3)
        axes.plot(x, np.where(valid, np.nan, y), "o", color=colour, markersize=4, markerfacecolor="white")
        bad = line["status"].values == "failed"
        if bad.any():
            axes.plot(
                x[bad], np.zeros(bad.sum()), "x", color=_FAILED, transform=axes.get_xaxis_transform(), clip_on=False
            )


def _positions(part: xr.Dataset, name: str) -> Array:
    """Numbers in readable units, or places in order for texts and flags."""
    values = part[name].values
    return values * _unit(part, name)[0] if _numeric(part, name) else np.arange(values.size, dtype=float)


def _numeric(result: xr.Dataset, name: str) -> bool:
    return result[name].dtype.kind in "if"


def _unit(result: xr.Dataset, name: str) -> tuple[float, str]:
    unit = str(result[name].attrs.get("units", ""))
    if unit == "rad":
        return math.degrees(1.0), "°"
    largest = float(np.abs(result[name].values).max())
    return units.readable(largest, unit) if unit else (1.0, "")


def value_text(coordinate: xr.DataArray, i: int) -> str:
    """Return a value of a parameter as people read it."""
    value, unit = coordinate.values[i], str(coordinate.attrs.get("units", ""))
    if unit == "rad":
        return f"{math.degrees(value):.4g}°"
    if unit:
        return units.text(float(value), unit)
    return f"{value:.4g}" if coordinate.dtype.kind == "f" else str(value).lower()


def heading(name: str, among: Sequence[str]) -> str:
    """Last word of a path, or all of it where another parameter ends the same."""
    last = name.rsplit(".", 1)[-1]
    alike = sum(other.rsplit(".", 1)[-1] == last for other in among) > 1 or last.isdigit()
    return name if alike else last.replace("_", " ")


def _label(result: xr.Dataset, name: str) -> str:
    unit = _unit(result, name)[1] if _numeric(result, name) else ""
    words = in_words(name)
    return f"{words} ({unit})" if unit else words


def geometric(result: xr.Dataset, name: str) -> bool:
    """Whether positive values keep their ratio rather than their distance."""
    if not _numeric(result, name) or result.sizes[name] < 3 or not (result[name].values > 0).all():
        return False
    ordered = np.sort(result[name].values)
    spread = [float(np.std(steps) / np.mean(steps)) for steps in (np.diff(np.log(ordered)), np.diff(ordered))]
    return spread[0] < spread[1]


def _scale(axes: Axes, first: str, result: xr.Dataset, finite: Array) -> None:
    """Logarithmic axes where the values are spaced so, or span more than a decade."""
    if geometric(result, first):
        logarithmic(axes, "x")
    elif not _numeric(result, first):
        axes.set_xticks(range(result.sizes[first]), [value_text(result[first], i) for i in range(result.sizes[first])])
    if finite.size and finite.min() > 0 and finite.max() > 10 * finite.min():
        logarithmic(axes, "y")
    elif finite.size and 0 <= finite.min() < 0.5 * finite.max():
        axes.set_ylim(bottom=0)


def _colours(part: xr.Dataset, second: str | None) -> list[object]:
    if second is None:
        return [_ONE]
    if _barred(part, second):
        return [_VIRIDIS(share) for share in _norm(part, second)(part[second].values)]
    return [_VIRIDIS(share) for share in np.linspace(0, 1, part.sizes[second])]


def _barred(result: xr.Dataset, name: str) -> bool:
    return result.sizes[name] > _LEGEND and _numeric(result, name)


def _norm(result: xr.Dataset, name: str, factor: float = 1.0) -> Normalize:
    values = result[name].values * factor
    kind = LogNorm if geometric(result, name) else Normalize
    return kind(float(values.min()), float(values.max()))


def _legend(drawn: Figure, grid: Array, result: xr.Dataset, name: str) -> None:
    """Tell the lines apart: by a colour bar where there are many numbers."""
    if _barred(result, name):
        factor, _ = _unit(result, name)
        norm = _norm(result, name, factor)
        bar = drawn.colorbar(matplotlib.cm.ScalarMappable(norm, _VIRIDIS), ax=grid, label=_label(result, name))
        if isinstance(norm, LogNorm):
            logarithmic(bar.ax, "y")
        return
    lines = [line for line in grid[0, 0].get_lines() if line.get_label() == _LINE]
    labels = [value_text(result[name], i) for i in range(result.sizes[name])]
    title = heading(name, parameters(result))
    drawn.legend(lines, labels, title=title, loc="outside right upper", frameon=False)


def is_map(result: xr.Dataset, quantity: str | None) -> bool:
    """Whether the critical load is asked for over two parameters that are numbers."""
    names = list(result["status"].dims)
    numeric = len(names) == 2 and all(result[name].dtype.kind in "if" and result.sizes[name] > 1 for name in names)
    return quantity == "critical_force" and "critical_force" in result and numeric


def map_figure(result: xr.Dataset, *, width: float | None = None, settings: Any = None) -> Figure:
    """Draw the critical load over the first two parameters: areas by kind and layer, level lines of the load.

    Takes what `sweep` returned for a case with strengths; width [in] and settings are as of `figure`.
    """
    first, second = (str(name) for name in result["status"].dims)
    axes_values, labels = [], []
    for name in (first, second):
        unit = str(result[name].attrs.get("units", ""))
        factor, readable_unit = units.readable(float(np.abs(result[name].values).max()), unit) if unit else (1.0, "")
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
            factor, unit = units.readable(float(np.nanmax(force)), "N")
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
