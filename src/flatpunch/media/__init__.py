"""Elastic bodies as data: layers, bases, media. Nothing here knows of wavenumbers or contact."""

from flatpunch.media.bodies import HalfSpace, Layer, Medium, RigidBase

__all__ = ["HalfSpace", "Layer", "Medium", "RigidBase"]
