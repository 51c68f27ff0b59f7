"""The numbers of a medium and a tip, by name: what may be varied.

Names are attribute paths: "layers[0].young", "base.poisson", "layers[1].young.entries[3]" (a node of a table),
"upper.layers[0].thickness" of two bodies, "indenter.radius". A half-space by itself is its own base.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch._support.numbers import numbers_of
from flatpunch.media import (
    AnyLayer,
    Body,
    Constant,
    DepthTable,
    Stack,
)
from flatpunch.media.laws import Law

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

UNITS = {
    **dict.fromkeys(("young", "modulus", "top", "bottom", "young_in_plane", "young_axial", "shear"), "Pa"),
    **dict.fromkeys(("thickness", "depth"), "m"),
}
"""SI units of the numbers of media by the name of an attribute; numbers that are not listed have none."""

_CENTRAL, _BACKWARDS = np.array([-4, -3, -2, -1, 1, 2, 3, 4], dtype=np.intp), -np.arange(9, dtype=np.intp)
"""Steps of central differences, and of those at the upper end of a range."""


def _weights(places: Indices, used: Indices) -> Array:
    """Weights of the samples at `places` of the polynomial through those at `used`, for its slope at zero."""
    found = np.zeros(places.size)
    found[np.isin(places, used)] = np.linalg.solve(np.vander(used, increasing=True).T, np.eye(used.size)[1])
    return found


_WEIGHTS = tuple(_weights(_CENTRAL, _CENTRAL[np.abs(_CENTRAL) <= n]) for n in (4, 3))
"""Central differences of order eight and six: the error of the former is the eighth power of the step times the ninth derivative
over 630."""
_BEHIND = tuple(_weights(_BACKWARDS, _BACKWARDS[:n]) for n in (9, 7))
"""Backward differences of order eight and six."""

_STEP = 1e-2
"""Step over the number itself: the difference of an analytic function of order one is then exact to 1e-13."""

_AGREES = 1e-9
"""Distance between the two orders, as logarithmic derivatives, above which a shorter step is tried."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number.

    Attributes
    ----------
    name : str
        Attribute path.
    value : float
        Its value [SI].
    unit : str
        SI unit.
    body : int
        Which of the elastic bodies it belongs to; -1 for the tip.
    part : int
        Layer from the surface down; the base comes last.
    kind : str
        "young", "poisson" or "thickness" of a layer or base (all five constants of a transversely isotropic one); of tips what
        the number is.
    law : callable or None
        Of a number in a law of depth: the law with another value.
    step : float
        Scale of the differences by which laws and shapes are differentiated.
    """

    name: str
    value: float
    unit: str
    body: int
    part: int
    kind: str
    law: Callable[[float], Law] | None = None
    step: float = 0.0


def parameters(medium: Body, indenter: object) -> list[Parameter]:
    """All numbers of a medium and a tip that can be varied."""
    return medium_parameters(medium) + _tip_parameters(indenter)


def medium_parameters(medium: Body) -> list[Parameter]:
    """All numbers of a medium that can be varied."""
    found = []
    sides = [(name, body) for name, body in medium.sides if not body.rigid]
    for index, (name, body) in enumerate(sides):
        found += _body_parameters(body, f"{name}." if name else "", index)
    # two power-law half-spaces share their exponent: neither varies alone
    return [each for each in found if len(sides) < 2 or each.kind != "exponent"]


def difference(function: Callable[[float], Array], value: float, step: float) -> Array:
    """Derivative of a piecewise analytic function by a difference of order eight; see `difference_and_error`."""
    return difference_and_error(function, value, step)[0]


def difference_and_error(function: Callable[[float], Array], value: float, step: float) -> tuple[Array, Array]:
    """Derivative of a piecewise analytic function by a central difference of order eight, and its distance to that of order six.

    Steps are made shorter where the function refuses its argument, and where the two orders disagree: monotone cubics of tables
    have kinks as functions of their entries. At the end of a range, such as a Poisson ratio of 1/2, the difference is taken
    backwards.
    """
    refused: Exception | None = None
    best: tuple[Array, Array] | None = None
    apart = np.inf
    for places, weights, scale in (
        *((_CENTRAL, _WEIGHTS, s) for s in (1.0, 0.1, 0.01)),
        (_BACKWARDS, _BEHIND, 0.5),
    ):
        if best is not None and places is _BACKWARDS:
            break
        h = step * scale
        try:
            samples = np.array([function(value + j * h) for j in places])
        except ValueError as refusal:
            refused = refused or refusal
            continue
        eighth, sixth = (np.asarray(np.tensordot(w, samples, 1) / h) for w in weights)
        error, size = np.abs(eighth - sixth), np.abs(samples).max(axis=0)
        share = float(np.max(np.divide(error * max(abs(value), step), size, out=np.zeros_like(error), where=size > 0)))
        if share < apart:
            best, apart = (eighth, error), share
        if apart <= _AGREES:
            break
    if best is None:
        assert refused is not None
        raise refused
    return best


def _body_parameters(body: Stack, prefix: str, index: int) -> list[Parameter]:
    found: list[Parameter] = []
    for i, layer in enumerate(body.layers):
        name = f"{prefix}layers[{i}]"
        if layer.varies:
            found += _law_parameters(layer, name, index, i)
        else:
            found += [
                Parameter(f"{name}.{kind}", getattr(layer, kind), UNITS.get(kind, ""), index, i, kind)
                for kind in (*layer.numbers, "thickness")
            ]
        found += [
            Parameter(f"{name}.bonded.{kind}", value, "Pa/m", index, i, f"{kind} spring")
            for kind, value in (("normal", layer.face.normal), ("shear", layer.face.shear))
            if value
        ]
    for kind in body.base.numbers:
        value = getattr(body.base, kind)
        # by differences, not from waves
        step = _step(value) if body.power_law else 0.0
        unit = UNITS.get(kind, "")
        found.append(Parameter(f"{prefix}base.{kind}", value, unit, index, len(body.layers), kind, step=step))
    return found


def _law_parameters(layer: AnyLayer, name: str, index: int, part: int) -> list[Parameter]:
    found = []
    for kind in layer.numbers:
        law = getattr(layer, kind)
        if isinstance(law, Constant):
            found.append(
                Parameter(
                    f"{name}.{kind}", law.value, UNITS.get(kind, ""), index, part, kind, Constant, _step(law.value)
                )
            )
        elif isinstance(law, DepthTable):
            for j, value in enumerate(law.entries):
                found.append(
                    Parameter(
                        f"{name}.{kind}.entries[{j}]",
                        value,
                        UNITS.get(kind, ""),
                        index,
                        part,
                        kind,
                        _table_with(law, j),
                        _table_step(law, j),
                    )
                )
        elif dataclasses.is_dataclass(law) and not isinstance(law, type):
            for field in dataclasses.fields(law):
                value = getattr(law, field.name)
                if field.init and _is_number(value):
                    found.append(
                        Parameter(
                            f"{name}.{kind}.{field.name}",
                            value,
                            UNITS.get(field.name, ""),
                            index,
                            part,
                            kind,
                            _law_with(law, field.name),
                            _step(value),
                        )
                    )
    found.append(Parameter(f"{name}.thickness", layer.thickness, "m", index, part, "thickness"))
    return found


def _tip_parameters(tip: object) -> list[Parameter]:
    places = list(numbers_of(tip, "indenter"))
    # the slopes between numbers that ascend must not change their sign
    rises = np.diff([each.value for each in places if each.number.ascending])
    least = float(_STEP * rises[rises > 0].min(initial=np.inf))
    return [
        Parameter(path, value, number.unit or "", -1, 0, number.what, step=least if number.ascending else _step(value))
        for path, value, number, _ in places
        if value != 0
    ]


def _is_number(value: object) -> bool:
    return isinstance(value, float)


def _step(value: float) -> float:
    return _STEP * abs(value) if value else _STEP


def _table_step(law: DepthTable, j: int) -> float:
    """A step that leaves the signs of the slopes on both sides, on which the monotone cubic depends, as they are."""
    entries = np.array(law.entries)
    rises = np.abs(np.diff(entries[max(j - 1, 0) : j + 2]))
    return float(_STEP * min(abs(entries[j]) or 1.0, *rises[rises > 0], np.inf))


def _table_with(law: DepthTable, j: int) -> Callable[[float], Law]:
    def changed(value: float) -> Law:
        return DepthTable(law.depths, (*law.entries[:j], value, *law.entries[j + 1 :]))

    return changed


def _law_with(law: DataclassInstance, field: str) -> Callable[[float], Law]:
    def changed(value: float) -> Law:
        found: object = dataclasses.replace(law, **{field: value})
        assert callable(found)
        return found

    return changed
