"""Picture of a body: Young's modulus over depth, with the layers, what is below them, and how far a contact reaches.

Figures are made without pyplot, as in `plots`. Depth runs downwards; of two bodies the upper one is above zero.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from flatpunch._support.checks import Array, non_negative
from flatpunch._support.prefixes import readable
from flatpunch.media import (
    Body,
    Stack,
    underlying,
)
from flatpunch.numerics.extents import ROOM
from flatpunch.plots.style import BLUE, GREY, HEADROOM, ORANGE, SAMPLES, THIN, axes_or_new, legend_below, logarithmic

_MODULUS, _FACE, _CONTACT = BLUE, GREY, ORANGE


@dataclass(frozen=True, slots=True)
class Profile:
    """Young's modulus of one body along its depth.

    Attributes
    ----------
    pieces : tuple of (ndarray, ndarray)
        Depths z [m] from the contact surface and moduli [Pa] of each layer, then of an elastic base.
    faces : tuple of (float, bool)
        Depth of each layer's lower face [m], and whether it sticks to what is below.
    end : float
        Depth down to which the profile goes [m].
    rigid : bool
        Whether a rigid base begins at the last face.
    """

    pieces: tuple[tuple[Array, Array], ...]
    faces: tuple[tuple[float, bool], ...]
    end: float
    rigid: bool


def is_graded(medium: Body) -> bool:
    """Whether the modulus varies with depth other than by jumps."""
    return medium.varies


def profile(body: Stack, reach: float) -> Profile:
    """Modulus over depth of one body, down to `reach` [m] at least and past all its layers."""
    top, pieces, faces = 0.0, [], []
    for layer in body.layers:
        z = np.linspace(0.0, layer.thickness, SAMPLES if layer.varies else 2)
        z = np.unique(np.concatenate([z, layer.breaks]))
        pieces.append((top + z, layer.young_at(z)))
        top += layer.thickness
        faces.append((top, bool(layer.face)))
    end = max(ROOM * top, reach)
    if not body.base.rigid:
        # the modulus of a power law is zero or infinite at the surface itself
        z = np.linspace(0.0, end, SAMPLES + 1)[1:] if body.base.varies else np.array([top, end])
        pieces.append((z, body.base.young_at(z)))
    return Profile(tuple(pieces), tuple(faces), end, body.base.rigid)


def plot_medium(medium: Body, axes: Axes | None = None, *, contact_radius: float = 0.0) -> Axes:
    """Draw Young's modulus over depth, with the faces of the layers: dashed where they slide or lift off.

    Of transversely isotropic bodies it is the modulus in the plane.

    Parameters
    ----------
    medium : Medium, HalfSpace, PowerLawHalfSpace, TwoBodies or FreeLayer
        The body, or two of them: the upper one is then above zero.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    contact_radius : float
        Mean contact radius [m]: a contact feels the body down to about this depth, which is marked; 0 marks nothing.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    plot_tip : The tip.

    Examples
    --------
    >>> coated = fp.Medium([fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)], base=fp.HalfSpace(young=2e9, poisson=0.3))
    >>> axes = fp.plot_medium(coated)
    >>> axes.get_xlabel(), axes.get_ylabel()
    ("Young's modulus $E$ (GPa)", 'depth $z$ (µm)')
    """
    axes = axes_or_new(axes)
    body = underlying(medium)
    bodies = [(side, -1.0 if name == "upper" else 1.0) for name, side in body.sides]
    contact_radius = non_negative("contact_radius", contact_radius, unit="m")
    reach = ROOM * contact_radius or _own_length(body)
    profiles = [(profile(body, reach), sign) for body, sign in bodies]
    moduli = np.concatenate([young for found, _ in profiles for _, young in found.pieces])
    wide = moduli.max() > 10 * moduli.min()
    young_factor, young_unit = readable(float(np.sqrt(moduli.max() * moduli.min()) if wide else moduli.max()), "Pa")
    factor, unit = readable(max(found.end for found, _ in profiles), "m")
    for found, sign in profiles:
        for z, young in found.pieces:
            axes.plot(young * young_factor, sign * z * factor, color=_MODULUS)
        _faces(found, sign * factor, axes)
    if wide:
        logarithmic(axes, "x")
    else:
        axes.set_xlim(0, HEADROOM * float(moduli.max()) * young_factor)
    low = -profiles[0][0].end * factor if body.pair else 0.0
    axes.set_ylim(profiles[-1][0].end * factor, low)
    if body.pair:
        axes.axhline(0, color="black", linewidth=THIN)
    _mark_contact(contact_radius * factor, body.pair, axes)
    axes.set_xlabel(f"Young's modulus $E$ ({young_unit})")
    axes.set_ylabel(f"depth $z$ ({unit})" + (", upper body above 0" if body.pair else ""))
    axes.set_title("Modulus over depth")
    return axes


def _own_length(medium: Body) -> float:
    length = float(medium.length)
    return ROOM * length if np.isfinite(length) else 1.0


def _faces(found: Profile, scale: float, axes: Axes) -> None:
    for depth, bonded in found.faces:
        axes.axhline(scale * depth, color=_FACE, linewidth=THIN, linestyle="-" if bonded else "--")
    if found.rigid:
        top = found.faces[-1][0] if found.faces else 0.0
        axes.axhspan(scale * top, scale * found.end, facecolor="none", edgecolor=_FACE, hatch="///", linewidth=0)
        middle = scale * (top + found.end) / 2
        box = {"facecolor": "white", "edgecolor": "none"}
        axes.text(0.5, middle, "rigid", transform=axes.get_yaxis_transform(), ha="center", va="center", bbox=box)


def _mark_contact(radius: float, pair: bool, axes: Axes) -> None:
    if radius <= 0:
        return
    for depth in (-radius, radius) if pair else (radius,):
        axes.axhline(depth, color=_CONTACT, linestyle=":", label="contact radius" if depth > 0 else None)
    legend_below(axes)
