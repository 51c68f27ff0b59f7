"""Partial slip of round contacts under a force along the surface."""
