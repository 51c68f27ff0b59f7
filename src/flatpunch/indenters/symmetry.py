"""Rotational symmetry of an indenter, found by looking."""

from __future__ import annotations

import numpy as np

from flatpunch._validation import Array
from flatpunch.indenters.profile import Indenter

_MOST = 24


def sample_radii(indenter: Indenter, count: int) -> Array:
    """Radii at which to look at an indenter of any size: up to its reach, or from atoms to metres if it has none."""
    if np.isfinite(indenter.reach):
        return np.asarray(indenter.reach * np.geomspace(1e-6, 0.999, count))
    return np.geomspace(1e-10, 1e3, 2 * count)


def rotational_symmetry(indenter: Indenter) -> int:
    """Largest n <= 24 for which turning the indenter by 2 pi/n leaves it as it is; 1 if there is none."""
    phi = 0.1234 + 2 * np.pi * np.arange(97) / 97
    r = (np.ones(1) if indenter.exponent is not None else sample_radii(indenter, 12))[:, None]
    f = np.asarray(indenter.height(r, phi))
    for fold in range(_MOST, 1, -1):
        turned = np.asarray(indenter.height(r, phi + 2 * np.pi / fold))
        if np.all(np.abs(turned - f) <= 1e-12 * f.max(axis=1, keepdims=True)):
            return fold
    return 1
