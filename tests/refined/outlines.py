"""How far outlines lie apart, which rays do not tell where they meet the flanks of needles aslant."""

from __future__ import annotations

import numpy as np


def distance(contour: np.ndarray, other: np.ndarray) -> float:
    """Largest distance of the points of one outline from the other, which runs straight between its own.

    Both are radii at equal polar angles from 0; their numbers may differ.
    """
    points, start = (radii * np.exp(2j * np.pi * np.arange(radii.size) / radii.size) for radii in (contour, other))
    side = np.roll(start, -1) - start
    along = (points[:, None] - start) * np.conj(side)
    share = np.clip(along.real / np.abs(side) ** 2, 0.0, 1.0)
    return float(np.abs(points[:, None] - start - share * side).min(axis=1).max())
