"""Edges of an indenter, and which of them are alike."""

from __future__ import annotations

import numpy as np

from flatpunch.indenters.geometry.symmetry import rotational_symmetry
from flatpunch.indenters.profile import Indenter


def wedges_of(indenter: Indenter) -> list[tuple[float, float, bool]]:
    """Polar angles of the edges [rad], tangents of half the angle to the next one, and whether they are rounded."""
    rounded = tuple(getattr(indenter, "rounded_edges", ()))
    angles = np.array(sorted(indenter.corners + rounded))
    gaps = np.diff(np.append(angles, angles[:1] + 2 * np.pi))
    # half of the angle to the next edge at most [rad]
    half = np.minimum(np.minimum(gaps, np.roll(gaps, 1)) / 2, 1.5)
    return [(float(angle), float(np.tan(h)), angle in rounded) for angle, h in zip(angles, half, strict=True)]


def place_of(indenter: Indenter, angle: float) -> float:
    """Where in the sector that turning the indenter repeats an edge lies, as a share of it: alike for edges that are alike."""
    return round(angle * rotational_symmetry(indenter) / (2 * np.pi), 6) % 1
