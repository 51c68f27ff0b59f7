"""Fitted parameters as quantities for people: their units, labels, and values in words."""

from __future__ import annotations

import re

from flatpunch._support.prefixes import text
from flatpunch.fits.parameters.scaling import OF, kind

_KINDS = {
    "young": ("Pa", "E"),
    "surface_modulus": ("Pa", "contact modulus"),
    "poisson": ("", "Poisson ratio"),
    "thickness": ("m", "thickness"),
    "normal": ("Pa/m", "normal interface stiffness"),
    "shear": ("Pa/m", "shear interface stiffness"),
    "radius": ("m", "tip radius"),
    "inclination": ("rad", "tip inclination"),
    "work_of_adhesion": ("J/m^2", "work of adhesion"),
    "pull-off force": ("N", "pull-off force"),
    "equilibrium": ("", "equilibrium share"),
    "time": ("s", "relaxation time"),
    "times": ("s", "relaxation time"),
    "exponent": ("", "exponent"),
    "weights": ("", "share"),
    "contact": ("m", "contact point"),
    "baseline": ("N", "baseline"),
    "tilt": ("N/m", "tilt"),
    "drag": ("N s/m", "drag"),
    "spring_constant": ("N/m", "spring constant"),
    "sensitivity": ("", "relative sensitivity"),
    "frame": ("m/N", "frame compliance"),
}
"""Unit and word of each kind of parameter."""

_COLUMNS = {"deepest": "m", "position": "m", "noise": "N"}
"""Units of columns of tables that are no parameters, by their first word."""


def label(name: str) -> str:
    """A parameter in the words of the field: "E of layer 1" for "layers[0].young"."""
    if OF in name:
        name, _, curve = name.partition(OF)
        return f"{label(name)} ({curve})"
    word = _KINDS.get(kind(name), ("", name))[1]
    owner, index = name.rpartition(".")[0], re.search(r"\[(\d+)\]", name)
    side = f"{name.split('.')[0]} " if name.startswith(("upper.", "lower.")) else ""
    if "layers" in owner:
        return f"{word} of {side}layer {int(index[1]) + 1 if index else ''}"
    if owner.endswith("base"):
        return f"{word} of {side}base"
    return f"{word} {int(index[1]) + 1}" if index else word


def unit_of(name: str) -> str:
    """SI unit of a parameter."""
    return _KINDS[kind(name)][0]


def unit_in(column: str) -> str:
    """SI unit of a column of a table, "" where it has none: of "layers[0].young low" that of the modulus."""
    bare = re.sub(r" (stderr|low|high)$", "", column)
    return _COLUMNS.get(bare.split(" ")[0]) or _KINDS.get(kind(bare), ("", ""))[0]


def between(low: float | None, high: float | None, unit: str) -> str:
    """Limits as the end of a sentence; empty if both are open."""
    if low is None and high is None:
        return ""
    low_text, high_text = ("any" if limit is None else text(limit, unit) for limit in (low, high))
    return f", between {low_text} and {high_text}"


def axis_label(name: str, unit: str) -> str:
    """Label of an axis of a parameter."""
    return f"{label(name)} ({unit})" if unit else label(name)
