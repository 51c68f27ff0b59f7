"""Rigid tips as level sets g(r, z), z upwards from the undeformed surface: g < 0 inside the tip, |grad g| near 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

Level = tuple[np.ndarray, np.ndarray, np.ndarray]
"""g (...), its gradient (2, ...) and its second derivatives (2, 2, ...)."""


class Tip(Protocol):
    """A tip of revolution."""

    def eased(self, share: float) -> Tip:
        """The tip at a share of the load: with slopes in proportion, or as it is."""

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

    def eased(self, share: float) -> Ball:
        """The sphere itself: its contact grows with the depth."""
        return self

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


@dataclass(frozen=True, slots=True)
class Cone:
    """A cone of the given slope, its apex rounded by a sphere of radius `rounding`.

    Parameters
    ----------
    slope : float
        Tangent of the angle between the flank and the surface.
    rounding : float
        Radius of the apex; 0 is sharp.
    """

    slope: float
    rounding: float = 0.0

    def eased(self, share: float) -> Cone:
        """The tip whose slopes are this share of the full ones."""
        return Cone(self.slope * share, self.rounding / share)

    def level(self, r: np.ndarray, z: np.ndarray, depth: float) -> Level:
        """Vertical distance to the surface times the cosine of the flank's angle."""
        cosine = 1 / np.hypot(1, self.slope)
        ball = np.maximum(self.rounding**2 - r**2, (self.rounding * cosine) ** 2)
        cap = (r < self.rounding * self.slope * cosine) & (self.rounding > 0)
        root = np.sqrt(np.where(cap, ball, 1.0))
        rise = np.where(cap, r / root, self.slope)
        bend = np.zeros((2, 2, *r.shape))
        bend[0, 0] = np.where(cap, self.rounding**2 / root**3, 0.0) * cosine
        return (
            (self.height(r) - depth - z) * cosine,
            np.stack([rise, -np.ones_like(r)]) * cosine,
            bend,
        )

    def height(self, r: np.ndarray) -> np.ndarray:
        """Height of cap and flank."""
        cosine = 1 / np.hypot(1, self.slope)
        touch = self.rounding * self.slope * cosine
        cap = self.rounding - np.sqrt(np.maximum(self.rounding**2 - np.minimum(r, touch) ** 2, 0.0))
        return np.asarray(cap + self.slope * np.maximum(r - touch, 0.0))
