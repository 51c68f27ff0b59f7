"""Rigid tips as level sets g(r, z), z upwards from the undeformed surface: g < 0 inside the tip, |grad g| near 1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

import flatpunch as fp
from flatpunch.indenters import Indenter

Level = tuple[np.ndarray, np.ndarray, np.ndarray]
"""g (...), its gradient (2, ...) and its second derivatives (2, 2, ...)."""


class Tip(Protocol):
    """A tip of revolution."""

    @property
    def shape(self) -> Indenter:
        """The tip in linear theory."""

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

    @property
    def shape(self) -> fp.Sphere:
        """The sphere of the package."""
        return fp.Sphere(self.radius)

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
class RoundedCone:
    """A cone that ends in a sphere, tangent to it; sharp at a radius of zero.

    Parameters
    ----------
    angle : float
        Angle between flank and surface [degrees].
    radius : float
        R of the sphere.
    """

    angle: float
    radius: float = 0.0

    @property
    def shape(self) -> fp.Cone | fp.Rounded:
        """The cone of the package."""
        sharp = fp.Cone(float(np.radians(self.angle)))
        return fp.Rounded(sharp, self.radius) if self.radius > 0 else sharp

    @property
    def slope(self) -> float:
        """Slope of the flank."""
        return float(np.tan(np.radians(self.angle)))

    @property
    def end(self) -> float:
        """Radius at which the cap ends."""
        return float(self.radius * np.sin(np.radians(self.angle)))

    def profile(self, r: np.ndarray) -> np.ndarray:
        """Height of the tip's surface above its lowest point, its slope and its second derivative, shape (3, n)."""
        cap = np.clip(r, 0.0, self.end)
        up = np.sqrt(self.radius**2 - cap**2)
        inside = r < self.end
        bend = np.divide(self.radius**2, up**3, out=np.zeros_like(r), where=inside)
        slope = np.divide(cap, up, out=np.full_like(r, self.slope), where=inside)
        return np.stack([self.radius - up + self.slope * (r - cap), slope, bend])
