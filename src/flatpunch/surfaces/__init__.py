"""Rough surfaces: heights on a grid, random ones, and their summits."""

from flatpunch.surfaces.synthesis import self_affine
from flatpunch.surfaces.topography import Summits, Topography

__all__ = ["Summits", "Topography", "self_affine"]
