"""Picture of a body: Young's modulus over depth, with the layers, what is below them, and how far a contact reaches.

Figures are made without pyplot, as in `plots`. Depth runs downwards; of two bodies the upper one is above zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from flatpunch._support.checks import Array, non_negative
from flatpunch.files.units import readable
from flatpunch.media import Body, GradedLayer, HalfSpace, Medium, PowerLawHalfSpace, RigidBase, TwoBodies, underlying
from flatpunch.plots.style import BLUE, GREY, ORANGE, axes_or_new, legend_below

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


def is_graded(medium: Any) -> bool:
    """Whether the modulus varies with depth other than by jumps."""
    medium = underlying(medium)
    if isinstance(medium, TwoBodies):
        return any(is_graded(body) for body in medium.elastic)
    if isinstance(medium, Medium):
        return any(isinstance(layer, GradedLayer) for layer in medium.layers)
    return isinstance(medium, PowerLawHalfSpace)


def profile(body: HalfSpace | Medium | PowerLawHalfSpace | RigidBase, reach: float) -> Profile:
    """Modulus over depth of one body, down to `reach` [m] at least and past all its layers."""
    layers = body.layers if isinstance(body, Medium) else ()
    base = body.base if isinstance(body, Medium) else body
    top, pieces, faces = 0.0, [], []
    samples = 201  # depths in each graded body
    for layer in layers:
        z = np.linspace(0.0, layer.thickness, samples if isinstance(layer, GradedLayer) else 2)
        if isinstance(layer, GradedLayer):
            z = np.unique(np.concatenate([z, layer.breaks]))
            young = layer.young_at(z)
        else:
            young = np.full_like(z, layer.young)
        pieces.append((top + z, young))
        top += layer.thickness
        faces.append((top, layer.bonded))
    # of the base a third of the thickness of all layers is drawn
    end = max(1.3 * top, reach)
    if isinstance(base, HalfSpace):
        pieces.append((np.array([top, end]), np.full(2, base.young)))
    elif isinstance(base, PowerLawHalfSpace):
        # the modulus of a power law is zero or infinite at the surface itself
        z = np.linspace(0.0, end, samples + 1)[1:]
        pieces.append((z, base.modulus * (z / base.depth) ** base.exponent))
    return Profile(tuple(pieces), tuple(faces), end, isinstance(base, RigidBase))


def plot_medium(medium: Body, axes: Axes | None = None, *, contact_radius: float = 0.0) -> Axes:
    """Draw Young's modulus over depth, with the faces of the layers: dashed where they slide.

    Parameters
    ----------
    medium : Medium, HalfSpace, PowerLawHalfSpace or TwoBodies
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
    axes = axes_or_new(axes, (3.6, 4.0))
    body = underlying(medium)
    pair = isinstance(body, TwoBodies)
    bodies = [(body.upper, -1.0), (body.lower, 1.0)] if isinstance(body, TwoBodies) else [(body, 1.0)]
    contact_radius = non_negative("contact_radius", contact_radius, unit="m")
    reach = 1.5 * contact_radius or _own_length(body)
    profiles = [(profile(body, reach), sign) for body, sign in bodies]
    moduli = np.concatenate([young for found, _ in profiles for _, young in found.pieces])
    # over larger ratios of moduli their axis is logarithmic
    wide = moduli.max() > 20 * moduli.min()
    young_factor, young_unit = readable(float(np.sqrt(moduli.max() * moduli.min()) if wide else moduli.max()), "Pa")
    factor, unit = readable(max(found.end for found, _ in profiles), "m")
    for found, sign in profiles:
        for z, young in found.pieces:
            axes.plot(young * young_factor, sign * z * factor, color=_MODULUS, linewidth=1.8)
        _faces(found, sign * factor, axes)
    if wide:
        axes.set_xscale("log")
    else:
        axes.set_xlim(0, 1.08 * float(moduli.max()) * young_factor)
    low = -profiles[0][0].end * factor if pair else 0.0
    axes.set_ylim(profiles[-1][0].end * factor, low)
    if pair:
        axes.axhline(0, color="black", linewidth=0.9)
    _mark_contact(contact_radius * factor, pair, axes)
    axes.set_xlabel(f"Young's modulus $E$ ({young_unit})")
    axes.set_ylabel(f"depth $z$ ({unit})" + (", upper body above 0" if pair else ""))
    axes.set_title("Modulus over depth")
    return axes


def _own_length(medium: Any) -> float:
    length = float(medium.length)
    return 1.5 * length if np.isfinite(length) else 1.0


def _faces(found: Profile, scale: float, axes: Axes) -> None:
    for depth, bonded in found.faces:
        axes.axhline(scale * depth, color=_FACE, linewidth=0.8, linestyle="-" if bonded else (0, (6, 4)))
    if found.rigid:
        top = found.faces[-1][0] if found.faces else 0.0
        axes.axhspan(
            scale * top, scale * found.end, facecolor="none", edgecolor=_FACE, hatch="///", linewidth=0, alpha=0.6
        )
        middle = scale * (top + found.end) / 2
        box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
        axes.text(0.5, middle, "rigid", transform=axes.get_yaxis_transform(), ha="center", va="center", bbox=box)


def _mark_contact(radius: float, pair: bool, axes: Axes) -> None:
    """Dotted lines at the depth of one contact radius."""
    if radius <= 0:
        return
    for depth in (-radius, radius) if pair else (radius,):
        axes.axhline(depth, color=_CONTACT, linestyle=":", label="contact radius" if depth > 0 else None)
    legend_below(axes)
