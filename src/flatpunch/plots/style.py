"""How pictures look: sizes for the screen and for one or two columns of a journal, colours, and axes to draw on.

The colours differ in lightness as well as in hue (blue, orange, green of Okabe and Ito 2008, darkened), and lines differ in their
dashes, so that pictures can be read in grey and by colour-blind readers.
"""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from matplotlib import rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation

from flatpunch._support.checks import Array, shown
from flatpunch._support.prefixes import readable

BLUE, ORANGE, GREEN = "#0b4f86", "#c8590a", "#1b7f5c"
GREY, PALE = "#8c8c8c", "#a9b4bd"

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
    line : float
        Width of the main lines [pt].
    """

    width: float | None
    panel: tuple[float, float]
    across: int
    font: float
    line: float

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
            "lines.linewidth": self.line,
            "axes.linewidth": 0.8,
            "axes.grid": False,
            "legend.frameon": False,
            "axes.unicode_minus": True,
            "svg.fonttype": "none",
            "pdf.fonttype": 42,
        }

    def heading(self, title: str, width: float) -> list[str]:
        """Lines of a title that fit into a figure of some width [in]; a letter is about half as wide as high."""
        return textwrap.wrap(title, max(int(72 * width / (0.55 * (self.font + 2))), 12))


STYLES: dict[StyleName, Style] = {
    "screen": Style(None, (4.4, 4.0), 4, 10, 1.6),
    "one-column": Style(3.5, (3.5, 2.9), 1, 8, 1.2),
    "two-columns": Style(7.2, (2.4, 2.4), 3, 7, 1.1),
}
"""The screen, and one and two columns of common journals (89 and 183 mm)."""


def style_of(name: str) -> Style:
    """Return a style by its name.

    Raises
    ------
    ValueError
        If there is none of that name.
    """
    for known, style in STYLES.items():
        if name == known:
            return style
    raise ValueError(f"style = {shown(name)} is unknown; choose one of {', '.join(map(repr, STYLES))}.")


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
    height = style.panel[1] * rows * (min(style.across / across, 1.5) if style.width is not None else 1)
    heading = style.heading(title, width)
    drawn = Figure(
        figsize=(width, height + 0.15 * bool(title) + 0.15 * len(heading)),
        layout="compressed" if across == 1 else "constrained",
    )
    grid = drawn.subplots(rows, across, squeeze=False)
    for empty in grid.flat[count:]:
        empty.set_axis_off()
    if title:
        drawn.suptitle("\n".join(heading))
    return drawn, list(grid.flat[:count])


def axes_or_new(axes: Axes | None, size: tuple[float, float] = (5.0, 4.0), **how: Any) -> Axes:
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


def legend_below(axes: Axes, **how: Any) -> None:
    """Legend below the label of the horizontal axis, at a distance that goes with the font and not with the axes."""
    drawn = axes.get_figure()
    assert drawn is not None
    down = ScaledTranslation(0, -3.4 * rcParams["font.size"] / 72, drawn.dpi_scale_trans)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, 0), bbox_transform=axes.transAxes + down, borderaxespad=0, **how
    )


def logarithmic(axes: Axes, which: str) -> None:
    """Make the axis "x" or "y" logarithmic; over three decades and less it has plain numbers at 1, 2 and 5 of each."""
    getattr(axes, f"set_{which}scale")("log")
    low, high = getattr(axes, f"get_{which}lim")()
    if high <= 1e3 * low:
        axis: Axis = getattr(axes, f"{which}axis")
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
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
