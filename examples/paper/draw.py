"""Figures 2 to 12 in the paper's axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from flatpunch._support.checks import Array
from paper.cases import TITLES
from paper.data import FAST, NAMES, Curves, Map, Outlines
from paper.style import BEM, FIRST, SECOND, THICKNESS_COLOURS, sheet

_COLOURS = {"first-order": FIRST, "second-order": SECOND, "bem": BEM}
_DASHES = {"first-order": "-", "second-order": (0, (4, 2))}


def eccentricity(found: Map, method: str) -> Figure:
    """e - e_g over e_g and log10(h/a0); the half-space is on the left, as in the paper."""
    figure, ((axes,),) = sheet(1, 1, width=4.6, height=3.7)
    e_g, log_h, excess = found.fine[method]
    _contours(figure, axes, log_h, e_g, excess, np.round(np.arange(-0.08, 0.0801, 0.01), 3), extra=0.002)
    if method == "bem":
        _dots(axes, found)
    axes.set_title(f"$e - e_g$, {TITLES[found.body]}\n{NAMES[method]}")
    return figure


def eccentricity_difference(found: Map, method: str) -> Figure:
    """e of a fast method minus e of the boundary elements, at their points."""
    figure, ((axes,),) = sheet(1, 1, width=4.6, height=3.7)
    difference = found.excess[method] - found.excess["bem"]
    largest = float(np.nanmax(np.abs(difference)))
    step = next(s for s in (0.001, 0.002, 0.005, 0.01, 0.02, 0.05) if largest / s < 9 or s == 0.05)
    # no line at zero, where only the scatter of the boundary elements would be drawn
    count = int(np.ceil(largest / step + 0.5))
    levels = np.round((np.arange(-count, count) + 0.5) * step, 5)
    log_h = np.sort(found.log_thickness[0])
    rows = [np.interp(log_h, x[::-1], y[::-1]) for x, y in zip(found.log_thickness, difference, strict=True)]
    _contours(figure, axes, log_h, found.eccentricity, np.array(rows), levels)
    _dots(axes, found)
    axes.set_title(f"$e$({NAMES[method]}) $-$ $e$(boundary elements)\n{TITLES[found.body]}")
    return figure


def _dots(axes: Axes, found: Map) -> None:
    """Where the boundary elements were solved."""
    x = found.log_thickness[1:]
    axes.plot(x, np.broadcast_to(found.eccentricity[1:, None], x.shape), ".k", ms=1.5)


def _contours(
    figure: Figure, axes: Axes, x: Array, y: Array, z: Array, levels: Array, *, extra: float | None = None
) -> None:
    bound = float(np.max(np.abs(levels)))
    filled = axes.contourf(x, y, z, levels=levels, cmap="RdBu_r", vmin=-bound, vmax=bound, alpha=0.75, extend="both")
    lines = axes.contour(x, y, z, levels=levels, colors="k", linewidths=0.6)
    # the line of zero also runs along the axis e_g = 0
    axes.clabel(lines, [level for level in levels if level != 0], fontsize=7, fmt="%g", inline_spacing=2)
    lines.set_linestyle("solid")
    if extra is not None:
        dotted = axes.contour(x, y, z, levels=[-extra, extra], colors="k", linewidths=0.6, linestyles="dotted")
        axes.clabel(dotted, fontsize=6, fmt="%g", inline_spacing=2)
    figure.colorbar(filled, ax=axes, pad=0.02, ticks=levels[:: max(1, levels.size // 9)])
    axes.set_xlim(float(x.max()), float(x.min()))
    axes.set_ylim(0.0, float(y.max()))
    for label in axes.texts:
        # half a number at the border is none
        label.set_visible(0.01 < label.get_position()[1] / float(y.max()) < 0.99)
    axes.set_xlabel(r"$\log_{10}(h/a_0)$")
    axes.set_ylabel(r"$e_g$")


def radii(panels: list[list[Curves]]) -> Figure:
    """a0/h over d/d_max, one panel for each set of curves."""
    figure, (row,) = sheet(1, len(panels))
    for axes, sets in zip(row, panels, strict=True):
        for colour, curve in zip(THICKNESS_COLOURS, sets, strict=False):
            for method in FAST:
                line = curve.lines[method]
                axes.plot(line.depth / curve.deepest, line.radius, color=colour, ls=_DASHES[method], lw=_width(method))
            axes.plot(curve.bem["depth"] / curve.deepest, curve.bem["radius"], "o", color=colour, mfc="w", ms=4)
        axes.set_yscale("log")
        _depth_axis(axes, sets, "$a_0/h$")
    _legend(figure, panels[0])
    return figure


def forces(panels: list[list[Curves]]) -> Figure:
    """F over the half-space's largest force: the same method's (left), the exact one (right)."""
    figure, rows = sheet(len(panels), 2, height=3.45)
    for row, sets in zip(rows, panels, strict=True):
        for axes, same in zip(row, (True, False), strict=True):
            for colour, curve in zip(THICKNESS_COLOURS, sets, strict=False):
                for method in FAST:
                    scale = curve.own[method] if same else curve.exact
                    line = curve.lines[method]
                    axes.plot(
                        line.depth / curve.deepest,
                        line.force / scale,
                        color=colour,
                        ls=_DASHES[method],
                        lw=_width(method),
                    )
                axes.plot(
                    curve.bem["depth"] / curve.deepest,
                    curve.bem["force"] / curve.exact,
                    "o",
                    color=colour,
                    mfc="w",
                    ms=4,
                )
            axes.set_yscale("log")
            _depth_axis(axes, sets, r"$F\,/\,F_\infty(d_\mathrm{max})$")
            whose = "by the same method" if same else "exact"
            axes.set_title(f"{axes.get_title()}\n$F_\\infty$ {whose}")
    _legend(figure, panels[0])
    return figure


def _width(method: str) -> float:
    return 1.4 if method == "first-order" else 1.0


def _depth_axis(axes: Axes, sets: list[Curves], label: str) -> None:
    case = sets[0]
    shape = f"$e_g = {case.eccentricity:g}$" if case.shape == "ellipse" else "square pyramid"
    axes.set_title(f"{TITLES[case.body]}, {shape}")
    axes.set_xlabel(r"$d/d_\mathrm{max}$")
    axes.set_ylabel(label)
    axes.set_xlim(0, 1.02)


def _legend(figure: Figure, sets: list[Curves]) -> None:
    handles: list[Any] = [
        Line2D([], [], color=colour, label=rf"$h/a_\infty = {curve.thickness:g}$")
        for colour, curve in zip(THICKNESS_COLOURS, sets, strict=False)
    ]
    handles += [Line2D([], [], color="k", ls=_DASHES[m], lw=_width(m), label=NAMES[m]) for m in FAST]
    handles.append(Line2D([], [], color="k", marker="o", mfc="w", ms=4, ls="", label=NAMES["bem"]))
    figure.legend(handles=handles, loc="outside lower center", ncols=4)


def pyramid_outlines(pair: list[Outlines]) -> Figure:
    """Contact outline over the cells in contact."""
    figure, (row,) = sheet(1, len(pair), width=3.6, height=4.0)
    figure.set_layout_engine("compressed")  # for axes of equal scales
    for axes, found in zip(row, pair, strict=True):
        half = float(np.max(found.contours["first-order"])) * 1.06
        axes.pcolormesh(
            found.x, found.y, np.where(found.mask, 0.78, np.nan), cmap="gray", vmin=0, vmax=1, rasterized=True
        )
        for method in FAST:
            a = np.append(found.contours[method], found.contours[method][0])
            phi = np.append(found.phi, 2 * np.pi)
            axes.plot(a * np.cos(phi), a * np.sin(phi), color=_COLOURS[method], ls=_DASHES[method], label=NAMES[method])
        axes.set_aspect("equal")
        axes.set_xlim(-half, half)
        axes.set_ylim(-half, half)
        times = "" if abs(found.thickness - 1) < 5e-3 else f"{found.thickness:.3g}\\,"
        axes.set_title(f"{TITLES[found.body]}, $h = {times}a_0$")
        axes.set_xlabel(r"$x\,\tan\alpha/d$")
        axes.set_ylabel(r"$y\,\tan\alpha/d$")
    handles, _ = row[0].get_legend_handles_labels()
    handles.append(Patch(color="0.78", label=NAMES["bem"]))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def tension(radius: Array, largest: Array, pull: Array, others: dict[str, tuple[Array, Array]]) -> Figure:
    """Tension at the base of a sliding layer over a0/h."""
    figure, ((axes,),) = sheet(1, 1, width=5.2, height=3.6)
    axes.loglog(radius, largest, color=SECOND, label="tension / peak pressure, round paraboloid")
    for colour, (name, (x, y)) in zip((FIRST, BEM, "#2a7f3f"), others.items(), strict=False):
        axes.plot(x, y, "o", ms=3.5, mfc="w", color=colour, label=name)
    axes.loglog(radius, pull, color="0.6", ls="--", label="force in tension / normal force, round")
    axes.set_xlabel(r"$a_0/h$")
    axes.set_ylabel("relative size")
    axes.set_title("Tensile stress between an unbonded layer and its base")
    axes.legend()
    return figure
