"""What yield and fracture criteria ask of a stress: von Mises, principal stresses, largest shear."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array


def von_mises(stress: Array) -> Array:
    """Von Mises stress of (xx, yy, zz, yz, xz, xy), shape (6, ...)."""
    xx, yy, zz, yz, xz, xy = stress
    return np.asarray(np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (yz**2 + xz**2 + xy**2)))


def principal(stress: Array) -> Array:
    """Principal stresses, largest first, shape (3, ...): the cubic of the deviator by its angle."""
    mean = (stress[0] + stress[1] + stress[2]) / 3
    a, b, c = stress[0] - mean, stress[1] - mean, stress[2] - mean
    yz, xz, xy = stress[3:]
    size = von_mises(stress)
    third = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        angle = np.arccos(np.clip(np.where(size > 0, 13.5 * third / size**3, 0.0), -1, 1)) / 3
    turns = angle + 2 * np.pi / 3 * np.arange(3).reshape(-1, *([1] * size.ndim))
    # cos falls from the first to the second turn and is in between for the third
    values = mean + 2 / 3 * size * np.cos(turns)
    return np.asarray(values[[0, 2, 1]])
