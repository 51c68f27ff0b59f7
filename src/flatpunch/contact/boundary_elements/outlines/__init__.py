"""Outline, mean radius and area of a boundary element solution, with one solution on finer cells along each edge of the tip."""

from flatpunch.contact.boundary_elements.outlines.trace import Trace, traced

__all__ = ["Trace", "traced"]
