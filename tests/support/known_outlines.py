"""Distance between outlines, which differences along rays exceed where rays meet the flanks of narrow lobes at an angle."""

from __future__ import annotations

import numpy as np


def distance(contour: np.ndarray, other: np.ndarray) -> float:
    """Largest distance of points of either outline from the other one, which runs straight between its own.

    Both are radii at equal polar angles from 0; of the other one the points on the rays of the first are taken, or it could not
    help missing those between.
    """
    first, second = (radii * np.exp(2j * np.pi * np.arange(radii.size) / radii.size) for radii in (contour, other))
    return max(_farthest(first, second), _farthest(second[:: max(1, second.size // first.size)], first))


def _farthest(points: np.ndarray, outline: np.ndarray) -> float:
    side = np.roll(outline, -1) - outline
    along = (points[:, None] - outline) * np.conj(side)
    share = np.clip(along.real / np.abs(side) ** 2, 0.0, 1.0)
    return float(np.abs(points[:, None] - outline - share * side).min(axis=1).max())
