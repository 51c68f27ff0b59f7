"""Picture of a design: what is prescribed and achieved, and where the numbers lie between their bounds."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flatpunch._support.checks import Array, instance
from flatpunch._support.prefixes import readable
from flatpunch.designs import Design
from flatpunch.designs.targets import UNITS
from flatpunch.plots.style import BLUE, GREY, StyleName, axes_or_new, styled


def plot_design(result: Design, axes: Axes | None = None) -> Axes:
    """Draw the prescribed quantity with that of the design and of the case before; of a load, both loads.

    Parameters
    ----------
    result : Design
        What `design` returned.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    design : Makes the result.

    Examples
    --------
    >>> film = fp.Layer(young=2e9, poisson=0.4, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=70e9, poisson=0.22))
    >>> wanted = fp.Target("stiffness", 50e3, force=2e-3)
    >>> found = fp.design(film, fp.Sphere(radius=20e-6), vary={"layers[0].young": (1e9, 9e9)}, objective=wanted)
    >>> axes = fp.plot_design(found)
    >>> print(axes.get_ylabel())
    stiffness (kN/m)
    """
    instance("result", result, (Design,), "a Design, as `design` returns it")
    axes = axes_or_new(axes)
    if not result.control:
        loads = np.array([result.before[0], result.achieved[0]])
        endless = np.isinf(loads)
        factor, unit = readable(float(loads[~endless].max()), "N")
        axes.bar([0, 1], np.where(endless, 0.0, loads) * factor, color=[GREY, BLUE])
        axes.set_xticks([0, 1], ["before", "design"])
        axes.set_ylabel(f"critical load ({unit})")
        if endless[1]:
            axes.text(1, 0.5, "nothing fails", ha="center", transform=axes.get_xaxis_transform())
        return axes
    along, along_unit = readable(float(result.at.max()), UNITS[result.control])
    up, unit = readable(float(result.wanted.max()), UNITS[result.quantity])
    order = np.argsort(result.at)
    x = result.at[order] * along
    axes.plot(x, result.before[order] * up, "--", marker=".", color=GREY, label="before")
    axes.plot(x, result.achieved[order] * up, color=BLUE, marker=".", label="design")
    axes.plot(x, result.wanted[order] * up, "o", color="black", markerfacecolor="none", label="prescribed")
    axes.set_xlabel(f"{result.control} ({along_unit})")
    axes.set_ylabel(f"{result.quantity} ({unit})")
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.legend(frameon=False)
    return axes


def figure(result: Design, *, title: str = "", style: StyleName | str = "screen") -> Figure:
    """The prescribed quantity, and each number between its bounds."""
    with styled(style) as chosen:
        one = chosen.across == 1
        width = chosen.width or 10
        drawn = Figure(figsize=(width, width if one else width / 2), layout="constrained")
        first, second = drawn.subplots(*((2, 1) if one else (1, 2)))
        plot_design(result, first)
        _bounds(result, second)
        if title:
            drawn.suptitle("\n".join(chosen.heading(title, width)))
    return drawn


def _bounds(result: Design, axes: Axes) -> None:
    """Start and found value of each number, from its lower bound to its upper one, in logarithms where they are positive."""
    for row, each in enumerate(result.values):
        numbers: Array = np.array([each.low, each.start, each.found, each.high])
        if each.low > 0:
            numbers = np.log(numbers)
        place = (numbers - numbers[0]) / (numbers[3] - numbers[0])
        axes.plot([0, 1], [row, row], color="#d9d9d9", linewidth=4, solid_capstyle="butt")
        axes.plot(place[1], row, "o", color=GREY, markerfacecolor="white", label="" if row else "before")
        axes.plot(place[2], row, "o", color=BLUE, label="" if row else "design")
    axes.set_yticks(range(len(result.values)), [each.name for each in result.values])
    axes.set_xticks([0, 1], ["lower bound", "upper bound"])
    axes.set_ylim(len(result.values) - 0.5, -0.5)
