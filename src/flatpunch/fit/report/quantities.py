"""Fitted parameters as quantities with units for people."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flatpunch.files.units import readable
from flatpunch.fit.parameters.scaling import kind

if TYPE_CHECKING:
    pass


_UNITS = {
    "young": "Pa",
    "thickness": "m",
    "radius": "m",
    "inclination": "rad",
    "poisson": "",
    "contact": "m",
    "baseline": "N",
    "tilt": "N/m",
    "sine": "N",
    "cosine": "N",
    "wavelength": "m",
    "drag": "N s/m",
    "work_of_adhesion": "J/m^2",
    "time": "s",
    "times": "s",
    "equilibrium": "",
    "exponent": "",
    "weights": "",
}


def unit_of(name: str) -> str:
    """SI unit of a parameter."""
    return _UNITS[kind(name)]


def quantity(value: float, unit: str) -> str:
    """Value in words, with a prefix or in degrees."""
    if not np.isfinite(value):
        return str(value)
    if unit == "rad":
        return f"{np.degrees(value):.4g} deg"
    if not unit:
        return f"{value:.4g}"
    factor, prefixed = readable(abs(value), unit)
    return f"{value * factor:.4g} {prefixed}"
