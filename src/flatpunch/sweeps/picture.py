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
from scipy.interpolate import RegularGridInterpolator

from flatpunch._support.checks import Array, BadValue, one_of
from flatpunch.files import units
from flatpunch.files.analyses import in_words as criterion_in_words
from flatpunch.plots.style import SAMPLES, logarithmic
from flatpunch.sweeps.axes import in_words, value_in_words

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
    return value_in_words(coordinate.values[i], str(coordinate.attrs.get("units", "")))


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
    """Whether the critical load is asked for, was found somewhere, and varies over two parameters that are numbers."""
    names = parameters(result)
    numeric = len(names) == 2 and all(_numeric(result, name) and result.sizes[name] > 1 for name in names)
    return quantity == "critical_force" and "critical_margin" in result and numeric


def map_figure(result: xr.Dataset, *, width: float | None = None, settings: Any = None) -> Figure:
    """Draw the critical load over the first two parameters: areas by criterion, level lines of the load.

    Areas end where the next criterion is reached at the same load: strength over stress of each, at the first failure, is
    interpolated between the points, and the smallest comes first. Takes what `sweep` returned for a case with strengths; width
    [in] and settings are as of `figure`.
    """
    names = parameters(result)
    result = result.sortby(names).isel(step=0)
    scales = [_unit(result, name) for name in names]
    values = [result[name].values * factor for name, (factor, _) in zip(names, scales, strict=True)]
    with matplotlib.rc_context(settings or {}):
        drawn = Figure(figsize=(width, width) if width else None, layout="constrained")
        axes = drawn.subplots()
        for name, which in zip(names, "xy", strict=True):
            if geometric(result, name):
                logarithmic(axes, which)
        fine, first = _first_criteria(result, names, values)
        seen = np.unique(first[np.isfinite(first)]).astype(int)
        place = {n: i for i, n in enumerate(seen)}
        number = np.full(first.shape, np.nan)
        for n, i in place.items():
            number[first == n] = i
        colours = ListedColormap([_COLOURS[i % len(_COLOURS)] for i in place.values()] or ["white"])
        norm = BoundaryNorm(np.arange(max(len(place), 1) + 1) - 0.5, max(len(place), 1))
        axes.pcolormesh(*fine, number, cmap=colours, norm=norm, shading="nearest", rasterized=True)
        axes.plot(*map(np.ravel, np.meshgrid(*values)), ".", color="black", ms=2, clip_on=False, zorder=3)
        for axis, own, (_, unit), name in zip((axes.xaxis, axes.yaxis), values, scales, names, strict=True):
            axis.set_view_interval(float(own.min()), float(own.max()), ignore=True)
            axis.set_label_text(f"{in_words(name)} ({unit})" if unit else in_words(name))
        _load_lines(axes, result, values)
        criteria = [criterion_in_words(str(result["criterion"].values[n])) for n in place]
        patches = [Patch(color=_COLOURS[i % len(_COLOURS)], label=each) for i, each in enumerate(criteria)]
        drawn.legend(handles=patches, loc="outside lower center", ncols=2, frameon=False, fontsize="small")
        axes.set_title("First failure and its load (layer 1 is the top, the last the base)", fontsize="medium")
        return drawn


def _first_criteria(result: xr.Dataset, names: Sequence[str], values: Sequence[Array]) -> tuple[list[Array], Array]:
    """A fine grid over two parameters, and the place of the criterion that is reached first there, nan where none is known."""
    logs = [geometric(result, name) for name in names]
    places = [np.log(own) if log else own for own, log in zip(values, logs, strict=True)]
    fine = [np.linspace(own[0], own[-1], 2 * SAMPLES) for own in places]
    with np.errstate(divide="ignore"):
        margin = np.log(result["critical_margin"].transpose(*names, "criterion").values)
    # criteria without any stress are never first
    margin = np.where(np.isposinf(margin), np.nanmax(margin, initial=0.0, where=np.isfinite(margin)), margin)
    between = RegularGridInterpolator(places, margin)(tuple(np.meshgrid(*fine)))
    known = np.isfinite(between).all(axis=-1)
    first = np.where(known, np.argmin(between, axis=-1), np.nan)
    return [np.exp(own) if log else own for own, log in zip(fine, logs, strict=True)], first


def _load_lines(axes: Axes, result: xr.Dataset, values: Sequence[Array]) -> None:
    """Level lines of the load of the first failure, each with its number."""
    force = result["critical_force"].values.T
    force = np.where(np.isfinite(force) & (force > 0), force, np.nan)
    if np.isfinite(force).sum() <= 3 or np.nanmax(force) == np.nanmin(force):
        return
    factor, unit = units.readable(float(np.nanmax(force)), "N")
    levels = np.geomspace(np.nanmin(force) * factor, np.nanmax(force) * factor, 10)[1:-1]
    if levels[-1] > 2 * levels[0]:
        levels = np.array([float(f"{level:.1e}") for level in levels])
    lines = axes.contour(*values, force * factor, levels=levels, colors="black", linewidths=1)
    # in the middle of that straight piece of each level that is farthest from the frame, which would cut the number off
    inside = [np.concatenate([(line[1:] + line[:-1]) / 2 for line in level]) for level in lines.allsegs if level]
    across = [axes.transAxes.inverted().transform(axes.transData.transform(line)) for line in inside]
    best = [int(np.argmin(np.abs(place - 0.5).max(axis=1))) for place in across]
    places = [tuple(line[i]) for line, i in zip(inside, best, strict=True)]
    axes.clabel(lines, fmt=lambda value: f"{value:.3g} {unit}", fontsize="x-small", manual=places)
