"""A case drawn to scale: section through layers, base and tip, as plain numbers for the page."""

from __future__ import annotations

from typing import Any

import numpy as np

from flatpunch.app.limits import DRAWN
from flatpunch.app.plain import plain, short
from flatpunch.files.units import text
from flatpunch.media import GradedLayer, Medium, RigidBase, TwoBodies, underlying


def sketch(medium: Any, indenter: Any, radius: float, depth: float) -> dict[str, Any] | None:
    """Return layers, base and the section of the tip along x; None for two bodies, which have no one surface.

    Parameters
    ----------
    medium, indenter : object
        The case.
    radius, depth : float
        Largest contact radius and its depth [m]; they set the scale where there are no layers.
    """
    body = underlying(medium)
    if isinstance(body, TwoBodies):
        return None
    layers = body.layers if isinstance(body, Medium) else ()
    base = body.base if isinstance(body, Medium) else body
    half = min(3 * radius, float(indenter.reach))
    x = np.linspace(-half, half, DRAWN.tip)
    height = np.asarray(indenter.height(np.abs(x), np.where(x < 0, np.pi, 0.0)))
    return {
        "layers": [
            {"thickness": layer.thickness, "label": _stiffness(layer), "bonded": layer.bonded} for layer in layers
        ],
        "base": "rigid" if isinstance(base, RigidBase) else _stiffness(base),
        "tip": {"x": short(x), "height": short(height)},
        "radius": plain(radius),
        "depth": plain(depth),
    }


def _stiffness(thing: Any) -> str:
    if isinstance(thing, GradedLayer):
        ends = [text(float(value), "Pa") for value in thing.young_at(np.array([0.0, thing.thickness]))]
        return f"E = {ends[0]} to {ends[1]}"
    return f"E = {text(thing.young, 'Pa')}" if hasattr(thing, "young") else type(thing).__name__
