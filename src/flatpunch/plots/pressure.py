"""Map of the contact pressure on a mesh that ends at the outline and is finer near the apex and the edge."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize

from flatpunch._support.checks import Array
from flatpunch.contact import pressure
from flatpunch.contact.curve import percent
from flatpunch.contact.dataset import outlines
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body
from flatpunch.numerics.extents import covered
from flatpunch.plots.outline import chosen_step, closed, framed, half_width
from flatpunch.plots.style import (
    SAMPLES,
    THIN,
    Extend,
    axes_or_new,
    check_result,
    colour_bar,
    plain,
    printed,
    scale_of,
)


def plot_pressure(
    result: xr.Dataset, medium: Body, indenter: Indenter, axes: Axes | None = None, *, step: int | None = None
) -> Axes:
    """Draw the contact pressure of one step as a map, with a colour bar.

    The outline stays a line in PDF and SVG; the map is an image of the figure's resolution.

    Parameters
    ----------
    result : xarray.Dataset
        What `indent` returned.
    medium : Medium, HalfSpace, ...
        The body it was solved for.
    indenter : Indenter
        The indenter it was solved for.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    step : int, optional
        Which step; by default the last at which the theory holds and the contact has an outline.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    pressure : The numbers.
    plot_outline : Outlines of several steps.

    Examples
    --------
    >>> gel, tip = fp.HalfSpace(young=5e3, poisson=0.5), fp.Sphere(radius=5e-6)
    >>> curve = fp.indent(gel, tip, depth=1e-7)
    >>> axes = fp.plot_pressure(curve, gel, tip)
    >>> axes.get_title()
    'Pressure at $F$ = 627 pN'
    """
    check_result(result, "phi", "radius", "valid")
    check_indenter(indenter)
    axes = axes_or_new(axes)
    last = chosen_step(result, step)
    half = half_width(result, indenter, last)
    factor, unit = scale_of([half], "m")
    contour, phi = outlines(result)[last], result["phi"].values
    outlined = bool(np.isfinite(contour).all())
    x, y = _mesh(contour, phi, indenter) if outlined else _square(half)
    # all rays of a round contact are alike
    rays = slice(1) if outlined and indenter.round else slice(None)
    # the quantity that was prescribed leads back to the same contact, also where another one does not rise with it
    control: dict[str, float] = {result.attrs["control"]: float(result[result.attrs["control"]].values[last])}
    work = result.attrs.get("work_of_adhesion")
    field, error = pressure(
        medium,
        indenter,
        x[:, rays],
        y[:, rays],
        method=result.attrs["method"],
        work_of_adhesion=work,
        range_of_action=result.attrs.get("range_of_action"),
        return_error=True,
        **control,
    )
    _draw(axes, x * factor, y * factor, np.broadcast_to(field, x.shape), tension=work is not None)
    axes.plot(*closed(contour, phi, factor), color="black", linewidth=THIN)
    framed(axes, half * factor, unit)
    force = plain(float(result["force"].values[last]), "N")
    axes.set_title(f"Pressure at $F$ = {force}{_doubt(field, error)}")
    return axes


def _mesh(contour: Array, phi: Array, indenter: Indenter) -> tuple[Array, Array]:
    """Points on rays from the apex to the outline, shape (along, rays): rays along the edges of a tip are among them."""
    angles = np.unique(
        np.concatenate([np.linspace(0, 2 * np.pi, SAMPLES), indenter.split_angles, phi[:: 1 + phi.size // SAMPLES]])
    )
    edge = np.interp(angles, phi, contour, period=2 * np.pi)
    # the pressure may be infinite at either end: it is taken just inside
    share = np.clip((1 - np.cos(np.linspace(0, np.pi, SAMPLES // 2))) / 2, 1e-4, 1 - 1e-4)
    r = share[:, None] * edge
    return r * np.cos(angles), r * np.sin(angles)


def _square(half: float) -> tuple[Array, Array]:
    x, y = np.meshgrid(*2 * [np.linspace(-half, half, SAMPLES)])
    return x, y


def _draw(axes: Axes, x: Array, y: Array, field: Array, *, tension: bool) -> QuadMesh:
    """Coloured mesh and its bar; with adhesion tension is red, pressure blue. Infinite pressures are cut."""
    inside = field[np.isfinite(field) & (field != 0)]
    top, singular = covered(np.abs(field[field != 0]))
    factor, unit = scale_of([top], "Pa")
    norm = (
        Normalize(-top * factor, top * factor)
        if tension
        else Normalize(min(0.0, float(inside.min(initial=0.0))) * factor, top * factor)
    )
    shown = np.clip(np.nan_to_num(field, nan=0.0, posinf=top, neginf=-top), -top, top) * factor
    mesh = axes.pcolormesh(
        x, y, shown, cmap="RdBu" if tension else "viridis", norm=norm, shading="gouraud", rasterized=True
    )
    extend: Extend = "min" if tension else "max" if singular else "neither"
    colour_bar(axes, mesh, f"pressure $p$ ({printed(unit)})", extend)
    return mesh


def _doubt(field: Array, error: Array) -> str:
    """Typical error of a pressure over its mean, where it is worth a word."""
    inside = (field != 0) & np.isfinite(field)
    share = float(np.median(error[inside]) / np.abs(field[inside]).mean()) if inside.any() else 0.0
    return f", ± {percent(share)}" if share > 0.01 else ""
