"""Edges of an indenter, and which of them are alike."""

from __future__ import annotations

import numpy as np

from flatpunch.indenters.geometry.symmetry import rotational_symmetry
from flatpunch.indenters.profile import Indenter


def wedges_of(indenter: Indenter) -> list[tuple[float, float]]:
    """Polar angles of the edges, rounded ones included [rad], and tangents of half the angle to the next one."""
    angles = np.array(sorted(indenter.corners + indenter.rounded_edges))
    gaps = np.diff(np.append(angles, angles[:1] + 2 * np.pi))
    # half of the angle to the next edge at most [rad]
    half = np.minimum(np.minimum(gaps, np.roll(gaps, 1)) / 2, 1.5)
    return [(float(angle), float(np.tan(h))) for angle, h in zip(angles, half, strict=True)]


def place_of(indenter: Indenter, angle: float) -> float:
    """Place of an edge in the sector that repeats as the indenter is turned, as a share of it: equal for equivalent edges."""
    return round(angle * rotational_symmetry(indenter) / (2 * np.pi), 6) % 1
