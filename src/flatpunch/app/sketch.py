"""A case drawn to scale: section through layers, base and tip, as plain numbers for the page."""

from __future__ import annotations

import numpy as np

from flatpunch._support.paths import Plain
from flatpunch.app.limits import DRAWN
from flatpunch.app.plain import plain, short
from flatpunch.files.units import text
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, FreeLayer, GradedLayer, Medium, RigidBase, TwoBodies, underlying
from flatpunch.media.transverse import TransverselyIsotropicHalfSpace, TransverselyIsotropicLayer


def sketch(medium: Body | FreeLayer, indenter: Indenter, radius: float, depth: float) -> Plain | None:
    """Return layers, base and the section of the tip along x; None for two bodies, which have no one surface.

    Largest contact radius and depth [m] set the scale where there are no layers.
    """
    body = medium.held_down if isinstance(medium, FreeLayer) else underlying(medium)
    if isinstance(body, TwoBodies):
        return None
    layers = body.layers if isinstance(body, Medium) else ()
    base = body.base if isinstance(body, Medium) else body
    half = min(3 * radius, float(indenter.reach))
    x = np.linspace(-half, half, DRAWN.tip)
    height = np.asarray(indenter.height(np.abs(x), np.where(x < 0, np.pi, 0.0)))
    return {
        "layers": [
            {"thickness": layer.thickness, "label": _stiffness(layer), "bonded": bool(layer.bonded)} for layer in layers
        ],
        "base": "rigid" if isinstance(base, RigidBase) else _stiffness(base),
        "tip": {"x": short(x), "height": short(height)},
        "radius": plain(radius),
        "depth": plain(depth),
    }


def _stiffness(thing: object) -> str:
    if isinstance(thing, GradedLayer):
        ends = dict(zip(thing.laws, thing.constants_at(np.array([0.0, thing.thickness])), strict=True))
        words = {"young": " in plane", "young_axial": " axial"} if thing.anisotropic else {"young": ""}
        pairs = ((dict.fromkeys(text(float(e), "Pa") for e in ends[name]), word) for name, word in words.items())
        return "E = " + ", ".join(f"{' to '.join(pair)}{word}" for pair, word in pairs)
    if isinstance(thing, (TransverselyIsotropicHalfSpace, TransverselyIsotropicLayer)):
        return f"E = {text(thing.young_in_plane, 'Pa')} in plane, {text(thing.young_axial, 'Pa')} axial"
    return f"E = {text(thing.young, 'Pa')}" if hasattr(thing, "young") else type(thing).__name__
