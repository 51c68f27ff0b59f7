"""The numbers of a medium and a tip, by name: what may be varied.

Names are attribute paths: "layers[0].young", "base.poisson", "layers[1].young.entries[3]" (a node of a table),
"upper.layers[0].thickness" of two bodies, "indenter.radius". A half-space by itself is its own base.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.indenters import RadialProfile
from flatpunch.media import (
    Constant,
    DepthTable,
    GradedLayer,
    HalfSpace,
    Layer,
    Medium,
    PowerLawHalfSpace,
    RigidBase,
    TwoBodies,
)
from flatpunch.media.laws import Law

UNITS = {
    **dict.fromkeys(("young", "modulus", "top", "bottom"), "Pa"),
    **dict.fromkeys(("thickness", "depth", "radius", "height_removed", "f"), "m"),
    **dict.fromkeys(("half_x", "half_y", "half_z", "half_width", "half_height", "height_at_axes"), "m"),
    **dict.fromkeys(("inclination", "inclinations", "directions", "tilt_x", "tilt_y"), "rad"),
    **dict.fromkeys(("A", "B"), "1/m"),
}
"""SI units by the name of an attribute; numbers that are not listed have none."""

_NO_SHAPE = {"r", "kinks", "limit", "unit", "start", "smoothing", "near", "reach", "corners"}
"""Numbers of indenters that say where and how a shape is given, not which shape it is."""

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
        "young", "poisson" or "thickness" of a layer or base; of others the name of the attribute.
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


def parameters(medium: Any, indenter: Any) -> list[Parameter]:
    """All numbers of a medium and a tip that can be varied."""
    found = medium_parameters(medium)
    if dataclasses.is_dataclass(indenter) and not isinstance(indenter, type):
        found += _tip_parameters(indenter, "indenter")
    return found


def medium_parameters(medium: Any) -> list[Parameter]:
    """All numbers of a medium that can be varied."""
    found = []
    if isinstance(medium, TwoBodies):
        elastic = 0
        for side in ("upper", "lower"):
            body = getattr(medium, side)
            if not isinstance(body, RigidBase):
                found += _body_parameters(body, f"{side}.", elastic)
                elastic += 1
        return found
    return _body_parameters(medium, "", 0)


def with_values(medium: Any, indenter: Any, values: Mapping[str, float]) -> tuple[Any, Any]:
    """Medium and tip with some numbers replaced; those of one table or list are replaced together."""
    both = {"medium": medium, "indenter": indenter}
    tree: dict[Any, Any] = {}
    for name, value in values.items():
        path = [int(step) if step.isdigit() else step for step in re.findall(r"[^.\[\]]+", name)]
        side = "indenter" if path[0] == "indenter" else "medium"
        branch = tree.setdefault(side, {})
        *way, last = path[1:] if side == "indenter" else path
        for step in way:
            branch = branch.setdefault(step, {})
        branch[last] = float(value)
    both |= {side: _replaced(both[side], changes) for side, changes in tree.items()}
    return both["medium"], both["indenter"]


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


def _body_parameters(body: Any, prefix: str, index: int) -> list[Parameter]:
    found: list[Parameter] = []
    layers = body.layers if isinstance(body, Medium) else ()
    for i, layer in enumerate(layers):
        name = f"{prefix}layers[{i}]"
        if isinstance(layer, Layer):
            found += [
                Parameter(f"{name}.{kind}", getattr(layer, kind), UNITS.get(kind, ""), index, i, kind)
                for kind in ("young", "poisson", "thickness")
            ]
        else:
            found += _law_parameters(layer, name, index, i)
    base = body.base if isinstance(body, Medium) else body
    if isinstance(base, HalfSpace):
        found += [
            Parameter(f"{prefix}base.{kind}", getattr(base, kind), UNITS.get(kind, ""), index, len(layers), kind)
            for kind in ("young", "poisson")
        ]
    if isinstance(base, PowerLawHalfSpace):
        found += [
            Parameter(
                f"{prefix}base.{kind}",
                getattr(base, kind),
                UNITS.get(kind, ""),
                index,
                0,
                kind,
                step=_step(getattr(base, kind)),
            )
            for kind in ("modulus", "depth", "exponent", "poisson")
        ]
    return found


def _law_parameters(layer: GradedLayer, name: str, index: int, part: int) -> list[Parameter]:
    found = []
    for kind in ("young", "poisson"):
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
        elif dataclasses.is_dataclass(law):
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


def _tip_parameters(tip: Any, name: str) -> list[Parameter]:
    found = []
    for field in dataclasses.fields(tip):
        value = getattr(tip, field.name)
        if not field.init or field.name in _NO_SHAPE:
            continue
        unit = UNITS.get(field.name, "")
        if _is_number(value) and value != 0:
            found.append(Parameter(f"{name}.{field.name}", float(value), unit, -1, 0, field.name, step=_step(value)))
        elif isinstance(value, tuple) and value and all(map(_is_number, value)):
            step = _heights_step(value) if isinstance(tip, RadialProfile) else None
            found += [
                Parameter(f"{name}.{field.name}[{j}]", each, unit, -1, 0, field.name, step=step or _step(each))
                for j, each in enumerate(value)
                if each != 0
            ]
        elif dataclasses.is_dataclass(value) and not isinstance(value, type):
            found += _tip_parameters(value, f"{name}.{field.name}")
    return found


def _is_number(value: Any) -> bool:
    return isinstance(value, float)


def _step(value: float) -> float:
    return _STEP * abs(value) if value else _STEP


def _heights_step(heights: Iterable[float]) -> float:
    """Heights of a profile ascend; the slopes between them must not change their sign."""
    rises = np.diff(np.array(list(heights)))
    return float(_STEP * rises[rises > 0].min(initial=np.inf))


def _table_step(law: DepthTable, j: int) -> float:
    """A step that leaves the signs of the slopes on both sides, on which the monotone cubic depends, as they are."""
    entries = np.array(law.entries)
    rises = np.abs(np.diff(entries[max(j - 1, 0) : j + 2]))
    return float(_STEP * min(abs(entries[j]) or 1.0, *rises[rises > 0], np.inf))


def _table_with(law: DepthTable, j: int) -> Callable[[float], Law]:
    def changed(value: float) -> Law:
        return DepthTable(law.depths, (*law.entries[:j], value, *law.entries[j + 1 :]))

    return changed


def _law_with(law: Any, field: str) -> Callable[[float], Law]:
    def changed(value: float) -> Law:
        found: Law = dataclasses.replace(law, **{field: value})
        return found

    return changed


def _replaced(thing: Any, changes: Any) -> Any:
    """A frozen object with the numbers of nested `changes` in their places."""
    if not isinstance(changes, dict):
        return Constant(changes) if isinstance(thing, Constant) else changes
    if isinstance(thing, tuple):
        entries = list(thing)
        for j, change in changes.items():
            entries[j] = _replaced(entries[j], change)
        return tuple(entries)
    if isinstance(thing, (HalfSpace, PowerLawHalfSpace)) and "base" in changes:
        return _replaced(thing, changes["base"])
    return dataclasses.replace(
        thing, **{name: _replaced(getattr(thing, name), change) for name, change in changes.items()}
    )
