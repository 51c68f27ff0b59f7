"""How pictures look: sizes for the screen and for one or two columns of a journal, colours, and axes to draw on.

The colours differ in lightness as well as in hue (blue, orange, green of Okabe and Ito 2008, darkened), and lines differ in their
dashes, so that pictures can be read in grey and by colour-blind readers.
"""

from __future__ import annotations

import re
import sys
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import NoneType
from typing import Any, Literal

import numpy as np
from matplotlib import rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation

from flatpunch._support.checks import Array, BadValue, instance, shown
from flatpunch._support.prefixes import PREFIXES, readable
from flatpunch.numerics.extents import ROOM

BLUE, ORANGE, GREEN = "#0b4f86", "#c8590a", "#1b7f5c"
GREY, PALE = "#8c8c8c", "#a9b4bd"
COLOURS = (BLUE, ORANGE, GREEN, "#7b3294", "#b2182b", "#4d4d4d")
"""Colours of curves drawn one after the other on the same axes."""

WIDE = 6.0
"""Width of a single large panel on the screen [in]."""

THIN = 0.8
"""Width of axes, level lines and other thin lines [pt]; main lines are twice as wide."""

SHADE = 0.2
"""Opacity of coloured areas; at half of it they are lost in print, at twice they hide lines."""

HEADROOM = 1.05
"""Upper end of an axis over the largest value on it."""

SAMPLES = 200
"""Points along a drawn line and cells along a map; half of them show corners in print, twice doubles time and size."""

_ROUND = (1, 2, 5)
"""First digits of round numbers."""

_POINTS = 72
"""Points in an inch."""

Extend = Literal["neither", "both", "min", "max"]
StyleName = Literal["screen", "one-column", "two-columns"]


@dataclass(frozen=True, slots=True)
class Style:
    """Sizes of a picture.

    Attributes
    ----------
    width : float
        Width of the whole picture [in]; None leaves it to the number of panels.
    panel : tuple of float
        Width and height of a panel [in].
    across : int
        Panels in a row.
    font : float
        Size of labels [pt]; titles are as large.
    """

    width: float | None
    panel: tuple[float, float]
    across: int
    font: float

    @property
    def settings(self) -> Any:
        """Settings of Matplotlib."""
        return {
            "font.size": self.font,
            "axes.titlesize": self.font,
            "axes.labelsize": self.font,
            "legend.fontsize": self.font - 1,
            "xtick.labelsize": self.font - 1,
            "ytick.labelsize": self.font - 1,
            "figure.titlesize": self.font + 2,
            "lines.linewidth": 2 * THIN,
            "axes.linewidth": THIN,
            "axes.grid": False,
            "legend.frameon": False,
            "axes.unicode_minus": True,
            "svg.fonttype": "none",
            "pdf.fonttype": 42,
        }

    def heading(self, title: str, width: float) -> list[str]:
        """Lines of a title that fit into a figure of some width [in]; a letter is about half as wide as high."""
        return textwrap.wrap(title, int(_POINTS * width / ((self.font + 2) / 2)))


STYLES: dict[StyleName, Style] = {
    "screen": Style(None, (4.4, 4.0), 4, 10),
    "one-column": Style(3.5, (3.5, 3.0), 1, 8),
    "two-columns": Style(7.2, (2.4, 2.4), 3, 8),
}
"""The screen, and one and two columns of common journals (89 and 183 mm)."""


def style_of(name: str) -> Style:
    """Return a style by its name; ValueError if there is none."""
    for known, style in STYLES.items():
        if name == known:
            return style
    raise BadValue("style", shown(name), f"is unknown; choose one of {', '.join(map(repr, STYLES))}.")


@contextmanager
def styled(name: str) -> Iterator[Style]:
    """Draw in a style."""
    style = style_of(name)
    with rc_context(style.settings):
        yield style


def panels(style: Style, count: int, *, title: str = "") -> tuple[Figure, list[Axes]]:
    """Figure with some panels in rows, as the style has it."""
    rows = -(-count // style.across)
    across = -(-count // rows)
    width = style.width if style.width is not None else style.panel[0] * across
    # panels of a page with fewer of them in a row grow, but not to the width of the page
    height = style.panel[1] * rows * (min(style.across / across, 4 / 3) if style.width is not None else 1)
    heading = style.heading(title, width)
    drawn = Figure(
        figsize=(width, height + (bool(title) + len(heading)) * style.font / _POINTS),
        layout="compressed" if across == 1 else "constrained",
    )
    grid = drawn.subplots(rows, across, squeeze=False)
    for empty in grid.flat[count:]:
        empty.set_axis_off()
    if title:
        drawn.suptitle("\n".join(heading))
    return drawn, list(grid.flat[:count])


def sheet(style: Style, share: float = 3 / 4, across: int = 1) -> tuple[float, float]:
    """Width of a figure of unequal panels, so many of them side by side, and a height of this share of it [in]."""
    width = style.width or (WIDE if across == 1 else across * style.panel[0])
    return width, share * width


def axes_or_new(axes: Axes | None, size: tuple[float, float] = (WIDE, 3 / 4 * WIDE), **how: object) -> Axes:
    """Axes as given, or those of a new figure: one of pyplot if the caller works with it, so that a notebook shows it."""
    if axes is not None:
        if not hasattr(axes, "pcolormesh"):
            raise TypeError(f"axes = {shown(axes)} must be axes of Matplotlib; leave them out for a new figure.")
        return axes
    pyplot = sys.modules.get("matplotlib.pyplot")
    drawn = (
        Figure(figsize=size, layout="constrained")
        if pyplot is None
        else pyplot.figure(figsize=size, layout="constrained")
    )
    made: Axes = drawn.add_subplot(**how)
    return made


def check_label(label: object) -> None:
    """Refuse what is no name of a curve in the legend."""
    instance("label", label, (str, NoneType), "a text, or None")


def check_result(result: Any, *names: str, argument: str = "result") -> None:
    """Refuse what is no result with these variables."""
    if not hasattr(result, "data_vars") or any(name not in result for name in names):
        raise TypeError(
            f"{argument} = {shown(result)} must be a dataset with {' and '.join(names)}, as the function that computes "
            "them returns it."
        )


def scale_on(axis: Axis, values: Array | Sequence[float], unit: str) -> tuple[float, str]:
    """Factor and printed unit for an axis: those of its label where it shows this unit already, else as `scale_of`."""
    shown_unit = re.search(r"\(([^()]*)\)$", axis.get_label_text())
    if shown_unit is not None and axis.axes.has_data():
        for exponent, prefix in PREFIXES.items():
            if shown_unit[1] == printed(prefix + unit):
                return 10.0 ** (-exponent * (2 if unit == "m^2" else 1)), shown_unit[1]
    return scale_of(values, unit)


def next_colour(axes: Axes) -> str:
    """Colour of the next curve on axes: one that no curve of `plot_...` on them has."""
    drawn = {line.get_color() for line in axes.get_lines()}
    return next((colour for colour in COLOURS if colour not in drawn), COLOURS[len(drawn) % len(COLOURS)])


def legend_below(axes: Axes, **how: object) -> None:
    """Legend below the label of the horizontal axis, at a distance that goes with the font and not with the axes."""
    drawn = axes.get_figure()
    assert drawn is not None
    down = ScaledTranslation(0, -4 * rcParams["font.size"] / _POINTS, drawn.dpi_scale_trans)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, 0), bbox_transform=axes.transAxes + down, borderaxespad=0, **how
    )


def colour_bar(axes: Axes, drawn: ScalarMappable, label: str, extend: Extend = "neither") -> None:
    """Bar of the colours of a map beside its axes, as high as they are."""
    figure = axes.get_figure()
    assert figure is not None
    figure.colorbar(drawn, ax=axes, label=label, shrink=1 / ROOM, extend=extend)


def round_step(top: float) -> float:
    """Round distance between about ten level lines from zero to a height."""
    return float(np.diff(MaxNLocator(10, steps=[*_ROUND, 10]).tick_values(0.0, top))[0])


def logarithmic(axes: Axes, which: str) -> None:
    """Make the axis "x" or "y" logarithmic; over three decades and less it has plain numbers at 1, 2 and 5 of each."""
    getattr(axes, f"set_{which}scale")("log")
    low, high = getattr(axes, f"get_{which}lim")()
    if high <= 1e3 * low:
        axis: Axis = getattr(axes, f"{which}axis")
        axis.set_major_locator(LogLocator(subs=_ROUND))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def scaled(values: Array, unit: str) -> tuple[Array, str]:
    """Values in the unit that keeps the largest of them readable, and that unit as it is printed."""
    factor, prefixed = scale_of(values, unit)
    return values * factor, prefixed


def scale_of(values: Array | Sequence[float], unit: str) -> tuple[float, str]:
    """Factor and printed unit that keep the largest of some values readable."""
    finite = np.abs(np.asarray(values, dtype=float))
    finite = finite[np.isfinite(finite)]
    factor, prefixed = readable(float(finite.max()) if finite.size else 0.0, unit)
    return factor, printed(prefixed)


def printed(unit: str) -> str:
    """A unit as it is printed: µm² for µm^2."""
    return unit.replace("^2", "²")


def plain(value: float, unit: str, digits: int = 3) -> str:
    """A value as it is printed: −137 pN, with a true minus sign."""
    factor, prefixed = readable(value, unit)
    number = f"{float(f'{value * factor:.{digits}g}'):.6g}" if value else "0"
    return f"{number} {printed(prefixed)}".rstrip().replace("-", "−")
