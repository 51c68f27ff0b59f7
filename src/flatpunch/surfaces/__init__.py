"""Rough surfaces: heights on a grid, random ones, and their summits."""

from flatpunch.surfaces.topography import Summits, Topography, self_affine

__all__ = ["Summits", "Topography", "self_affine"]
