"""A case drawn to scale: section through layers, base and tip, as plain numbers for the page."""

from __future__ import annotations

import numpy as np

from flatpunch._support.paths import Plain
from flatpunch.app.limits import DRAWN
from flatpunch.app.plain import plain, short
from flatpunch.files.units import text
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Material, underlying
from flatpunch.media.plane import from_plane


def sketch(medium: Body, indenter: Indenter, radius: float, depth: float) -> Plain | None:
    """Return layers, base and the section of the tip along x; None for two bodies, which have no one surface.

    Largest contact radius and depth [m] set the scale where there are no layers.
    """
    sides = underlying(medium).sides
    if len(sides) > 1:
        return None
    ((_, body),) = sides
    half = min(3 * radius, float(indenter.reach))
    x = np.linspace(-half, half, DRAWN.tip)
    height = np.asarray(indenter.height(np.abs(x), np.where(x < 0, np.pi, 0.0)))
    return {
        "layers": [
            {"thickness": layer.thickness, "label": _stiffness(layer), "bonded": bool(layer.face)}
            for layer in body.layers
        ],
        "base": _stiffness(body.base),
        "tip": {"x": short(x), "height": short(height)},
        "radius": plain(radius),
        "depth": plain(depth),
    }


def _stiffness(part: Material) -> str:
    """Young's moduli in words, from one face to the other where they vary."""
    if part.rigid:
        return "rigid"
    if part.power_law:
        return type(part).__name__
    young, axial, *_ = from_plane(part.plane_at(part.sampled_depths))
    moduli = (
        [(young, " in plane"), (axial, " axial")] if part.anisotropic else [(part.young_at(part.sampled_depths), "")]
    )
    pairs = ((dict.fromkeys(text(float(ends[j]), "Pa") for j in (0, -1)), word) for ends, word in moduli)
    return "E = " + ", ".join(f"{' to '.join(pair)}{word}" for pair, word in pairs)
