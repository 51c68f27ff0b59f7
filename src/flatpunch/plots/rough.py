"""Pictures of rough contacts: area over pressure beside theories, pressure and gap, sizes of patches, asperities."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from flatpunch._support.checks import Array
from flatpunch.numerics.extents import ROOM, covered
from flatpunch.plots.style import (
    BLUE,
    COLOURS,
    StyleName,
    axes_or_new,
    check_result,
    colour_bar,
    logarithmic,
    panels,
    plain,
    printed,
    scale_of,
    styled,
)
from flatpunch.rough.solution import patch_sizes

_THEORIES = {
    "persson": ("Persson", "--"),
    "greenwood_williamson": ("Greenwood, Williamson", "-."),
    "bearing_area": ("bearing area", ":"),
}


def plot_rough(contact: xr.Dataset, axes: Axes | None = None, *, theories: xr.Dataset | None = None) -> Axes:
    """Draw the share of the area in contact over the mean pressure, with theories if they are given.

    Parameters
    ----------
    contact : xarray.Dataset
        What `rough_contact` returned.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    theories : xarray.Dataset, optional
        What `rough_theories` returned for it.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    rough_theories : Where each of them is good.
    rough_contact : The contact.

    Examples
    --------
    >>> rough = fp.self_affine(64, 10e-9, rms_slope=0.1, cut_off=80e-9)
    >>> steel = fp.HalfSpace(young=210e9, poisson=0.3)
    >>> contact = fp.rough_contact(steel, rough, pressure=np.geomspace(1e8, 2e10, 6))
    >>> axes = fp.plot_rough(contact, theories=fp.rough_theories(contact, steel, rough))
    >>> axes.get_ylabel()
    'share of the area in contact (%)'
    """
    check_result(contact, "mean_pressure", "area_fraction_corrected", argument="contact")
    if theories is not None:
        check_result(theories, *_THEORIES, argument="theories")
    axes = axes_or_new(axes)
    pressure, share = contact["mean_pressure"].values, 100 * contact["area_fraction_corrected"].values
    factor, unit = scale_of(pressure, "Pa")
    touching = (pressure > 0) & (share > 0)
    axes.plot(pressure[touching] * factor, share[touching], "o-", color=BLUE, markersize=4, label="boundary elements")
    for colour, (name, (label, dashes)) in zip(COLOURS[1:], _THEORIES.items(), strict=False):
        if theories is not None:
            axes.plot(
                pressure[touching] * factor, 100 * theories[name].values[touching], dashes, color=colour, label=label
            )
    logarithmic(axes, "x")
    logarithmic(axes, "y")
    axes.set(xlabel=f"mean pressure ({printed(unit)})", ylabel="share of the area in contact (%)", title="Contact area")
    if theories is not None:
        axes.legend(loc="lower right")
    return axes


def rough_figure(
    contact: xr.Dataset,
    last: xr.Dataset,
    theories: xr.Dataset | None = None,
    *,
    title: str = "",
    style: StyleName | str = "screen",
) -> Figure:
    """Return area over pressure of all steps, with theories, and pressure, gap and patch sizes of one step with fields."""
    with styled(style) as chosen:
        drawn, (first, second, third, fourth) = panels(chosen, 4, title=title)
        plot_rough(contact, first, theories=theories)
        p, gap = last["pressure"].values[-1], last["gap"].values[-1]
        mean = plain(float(last["mean_pressure"].values[-1]), "Pa")
        _map(last, np.where(p > 0, p, np.nan), second, "Pa", "pressure", f"Pressure at {mean}", covered(p[p > 0]))
        _map(last, gap, third, "m", "gap", f"Gap at {mean}", covered(gap))
        _patches(last, fourth)
    return drawn


def asperities_figure(
    contact: xr.Dataset, positions: ArrayLike, *, title: str = "", style: StyleName | str = "screen"
) -> Figure:
    """Return the forces of asperities over depth, and their contacts at the last step, seen from above."""
    with styled(style) as chosen:
        drawn, (left, right) = panels(chosen, 2, title=title)
        depth, force = contact["depth"].values, contact["asperity_force"].values
        (along, x_unit), (up, y_unit) = scale_of(depth, "m"), scale_of(force, "N")
        left.plot(depth * along, force * up, color=BLUE, linewidth=1, marker="o" if depth.size < 3 else "")
        left.set(xlabel=f"depth ({x_unit})", ylabel=f"force of each asperity ({y_unit})", title="Forces")
        places, radius, last = np.asarray(positions, dtype=float), contact["radius"].values[-1], force[-1]
        factor, unit = scale_of(places.ravel(), "m")
        from matplotlib.collections import EllipseCollection

        discs = EllipseCollection(
            2 * radius * factor,
            2 * radius * factor,
            0,
            units="xy",
            offsets=places * factor,
            transOffset=right.transData,
        )
        discs.set_array(last * up)
        right.add_collection(discs)
        spread = ROOM * radius.max() + 0.1 * np.ptp(places)
        right.set_xlim(*(factor * (places[:, 0].min() - spread), factor * (places[:, 0].max() + spread)))
        right.set_ylim(*(factor * (places[:, 1].min() - spread), factor * (places[:, 1].max() + spread)))
        right.set(aspect="equal", xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})")
        right.set_title(f"Contacts at $F$ = {plain(float(contact['force'].values[-1]), 'N')}")
        colour_bar(right, discs, f"force ({y_unit})")
    return drawn


def _map(
    result: xr.Dataset, values: Array, axes: Axes, unit: str, name: str, title: str, ends: tuple[float, bool]
) -> None:
    top, cut = ends
    x, y = result["x"].values, result["y"].values
    (factor, length), (scale, shown) = scale_of([x[-1] - x[0], y[-1] - y[0]], "m"), scale_of([top], unit)
    half = (x[1] - x[0]) / 2
    extent = [(each + sign * half) * factor for axis in (x, y) for each, sign in ((axis[0], -1), (axis[-1], 1))]
    drawn = axes.imshow(
        values * scale,
        origin="lower",
        extent=(extent[0], extent[1], extent[2], extent[3]),
        cmap="viridis" if unit == "Pa" else "Greys_r",
        vmin=0,
        vmax=top * scale,
        interpolation="nearest",
    )
    axes.set_facecolor("white")
    axes.set(xlabel=f"$x$ ({length})", ylabel=f"$y$ ({length})", title=title)
    colour_bar(axes, drawn, f"{name} ({printed(shown)})", "max" if cut else "neither")


def _patches(last: xr.Dataset, axes: Axes) -> None:
    """Number of patches larger than an area."""
    along_x, along_y = json.loads(last.attrs["topography"])["periodic"]
    sizes = np.sort(patch_sizes(last["pressure"].values[-1] > 0, (along_x, along_y)))[::-1]
    cell = float(last["x"].values[1] - last["x"].values[0]) ** 2
    factor, unit = scale_of(sizes * cell if sizes.size else [1.0], "m^2")
    axes.step(sizes * cell * factor, np.arange(1, sizes.size + 1), color=BLUE, where="post")
    if sizes.size:
        logarithmic(axes, "x")
        logarithmic(axes, "y")
    axes.set(xlabel=f"area of a patch ({printed(unit)})", ylabel="patches that are larger")
    axes.set_title(f"{sizes.size} patches")
