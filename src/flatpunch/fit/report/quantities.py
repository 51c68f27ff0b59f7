"""Fitted parameters as quantities with units for people."""

from __future__ import annotations

import re

import numpy as np

from flatpunch.files.units import readable
from flatpunch.fit.parameters.scaling import OF, kind

_UNITS = {
    "young": "Pa",
    "surface_modulus": "Pa",
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
    "spring_constant": "N/m",
    "sensitivity": "",
    "normal": "Pa/m",
    "shear": "Pa/m",
}


_WORDS = {
    "young": "E",
    "surface_modulus": "contact modulus",
    "poisson": "Poisson ratio",
    "thickness": "thickness",
    "radius": "tip radius",
    "inclination": "tip inclination",
    "work_of_adhesion": "work of adhesion",
    "contact": "contact point",
    "equilibrium": "equilibrium share",
    "time": "relaxation time",
    "exponent": "exponent",
    "weights": "share",
    "times": "relaxation time",
    "normal": "normal interface stiffness",
    "shear": "shear interface stiffness",
    "spring_constant": "spring constant",
    "sensitivity": "relative sensitivity",
}


def label(name: str) -> str:
    """A parameter in the words of the field: "E of layer 1" for "layers[0].young"."""
    if OF in name:
        name, _, curve = name.partition(OF)
        return f"{label(name)} ({curve})"
    word = _WORDS.get(kind(name))
    if word is None:
        return name
    owner, index = name.rpartition(".")[0], re.search(r"\[(\d+)\]", name)
    side = f"{name.split('.')[0]} " if name.startswith(("upper.", "lower.")) else ""
    if "layers" in owner:
        return f"{word} of {side}layer {int(index[1]) + 1 if index else ''}"
    if owner.endswith("base"):
        return f"{word} of {side}base"
    if index:
        return f"{word} {int(index[1]) + 1}"
    return word


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


def between(low: float | None, high: float | None, unit: str) -> str:
    """Limits as the end of a sentence; empty if both are open."""
    if low is None and high is None:
        return ""
    low_text, high_text = ("any" if limit is None else quantity(limit, unit) for limit in (low, high))
    return f", between {low_text} and {high_text}"


def axis_label(name: str, unit: str) -> str:
    """Label of an axis of a parameter."""
    return f"{label(name)} ({unit})" if unit else label(name)
