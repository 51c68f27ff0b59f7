"""How far pictures and the page reach: around a contact, and in their colours."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array

ROOM = 1.25
"""Length that is shown over the largest length of what is drawn; at 1 the picture ends at the outline."""

_COVERED = 0.98
"""Share of the values that the colours cover where a few exceed the others by far; at 0.99 single cells take all colours."""


def covered(values: Array) -> tuple[float, bool]:
    """Upper end of the colours, and whether values exceed it: the largest, unless a few exceed all others by far."""
    finite = values[np.isfinite(values)]
    most = float(finite.max(initial=0.0)) or 1.0
    usual = float(np.quantile(finite, _COVERED)) if finite.size else 0.0
    far = usual > 0 and (most > ROOM * usual or finite.size < values.size)
    return (usual, True) if far else (most, False)
