"""Rigid tips as level sets g(r, z), z upwards from the undeformed surface: g < 0 inside the tip, |grad g| near 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

Level = tuple[np.ndarray, np.ndarray, np.ndarray]
"""g (...), its gradient (2, ...) and its second derivatives (2, 2, ...)."""


class Tip(Protocol):
    """A tip of revolution."""

    def level(self, r: np.ndarray, z: np.ndarray, depth: float) -> Level:
        """g and its derivatives with the lowest point of the tip at z = -depth."""

    def height(self, r: np.ndarray) -> np.ndarray:
        """Height of the tip's surface above its lowest point."""


@dataclass(frozen=True, slots=True)
class Ball:
    """A sphere.

    Parameters
    ----------
    radius : float
        R.
    """

    radius: float = 1.0

    def level(self, r: np.ndarray, z: np.ndarray, depth: float) -> Level:
        """Distance to the sphere."""
        up = z - (self.radius - depth)
        distance = np.hypot(r, up)
        normal = np.stack([r, up]) / distance
        bend = (np.eye(2)[:, :, None, None] - normal[:, None] * normal[None]) / distance
        return distance - self.radius, normal, bend

    def height(self, r: np.ndarray) -> np.ndarray:
        """Height, steep beyond the equator."""
        inside = np.minimum(r, self.radius)
        return np.asarray(self.radius - np.sqrt(self.radius**2 - inside**2) + 10 * (r - inside))
