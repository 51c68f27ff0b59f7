"""Rotational symmetry of an indenter, found by looking."""

from __future__ import annotations

import numpy as np

from flatpunch.indenters.profile import Indenter

_MOST = 24


def rotational_symmetry(indenter: Indenter) -> int:
    """Largest n <= 24 for which turning the indenter by 2 pi/n leaves it as it is; 1 if there is none."""
    phi = 0.1234 + 2 * np.pi * np.arange(97) / 97
    reach = indenter.reach if np.isfinite(indenter.reach) else 1.0
    r = reach * np.array([1.0] if indenter.exponent is not None else [1e-3, 0.03, 0.1, 0.3, 0.6, 0.99])[:, None]
    f = np.asarray(indenter.height(r, phi))
    for fold in range(_MOST, 1, -1):
        turned = np.asarray(indenter.height(r, phi + 2 * np.pi / fold))
        if np.all(np.abs(turned - f) <= 1e-12 * f.max(axis=1, keepdims=True)):
            return fold
    return 1
