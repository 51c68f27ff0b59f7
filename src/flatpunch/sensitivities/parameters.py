"""The numbers of a medium and a tip, by name: what may be varied.

Names are attribute paths: "layers[0].young", "base.poisson", "layers[1].young.entries[3]" (a node of a table),
"upper.layers[0].thickness" of two bodies, "indenter.radius". A half-space by itself is its own base.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch._support.declared import Number, Place, numbers_of
from flatpunch._support.paths import steps
from flatpunch.media import Body, DepthTable, Interface
from flatpunch.media.laws import Law
from flatpunch.media.paths import LayerOrBase, layers_and_bases, replaced

_CENTRAL = np.array([-4, -3, -2, -1, 1, 2, 3, 4], dtype=np.intp)
_BACKWARDS = -np.arange(_CENTRAL.size + 1, dtype=np.intp)
"""Steps of central differences, and of those at the upper end of a range."""


def _weights(places: Indices, used: Indices) -> Array:
    """Weights of the samples at `places` of the polynomial through those at `used`, for its slope at zero."""
    found = np.zeros(places.size)
    found[np.isin(places, used)] = np.linalg.solve(np.vander(used, increasing=True).T, np.eye(used.size)[1])
    return found


_WEIGHTS = tuple(_weights(_CENTRAL, _CENTRAL[np.abs(_CENTRAL) <= n]) for n in (4, 3))
"""Central differences of order eight and six: the error of the former is the eighth power of the step times the ninth derivative
over 630."""
_BEHIND = tuple(_weights(_BACKWARDS, _BACKWARDS[:n]) for n in (_BACKWARDS.size, _BACKWARDS.size - 2))
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
    path : str
        Attribute path.
    value : float
        Its value [SI].
    number : Number
        Its declaration.
    owner : object
        The object whose field it is.
    body : int
        Which of the elastic bodies it belongs to; -1 for the tip.
    part : int
        Layer from the surface down; the base comes last.
    kind : str
        Field of the layer or base that is or holds it: "young", "poisson", "thickness"; of its lower face the whole path,
        "bonded.normal", "bonded.membrane.tension"; of tips what the number is.
    law : callable or None
        Of a number in a law of depth: the law with another value.
    step : float
        Scale of the differences by which laws and shapes are differentiated.
    """

    path: str
    value: float
    number: Number
    owner: object
    body: int
    part: int
    kind: str
    law: Callable[[float], Law] | None = None
    step: float = 0.0

    @property
    def unit(self) -> str:
        """SI unit, empty for a number without dimension."""
        return self.number.unit or ""


def parameters(medium: Body, indenter: object) -> list[Parameter]:
    """All numbers of a medium and a tip that can be varied."""
    return medium_parameters(medium) + _tip_parameters(indenter)


def medium_parameters(medium: Body) -> list[Parameter]:
    """All numbers of a medium that can be varied."""
    pair = len(medium.elastic) > 1
    return [
        found
        for part in layers_and_bases(medium)
        for place in part.places
        if not (pair and place.number.shared) and (found := _of_medium(part, place)) is not None
    ]


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


def _of_medium(part: LayerOrBase, place: Place) -> Parameter | None:
    """A number of a layer or base, None for one that does not enter its elastic constants."""
    field, *inside = steps(place.path.removeprefix(f"{part.path}."))
    held = getattr(part.material, str(field))
    if isinstance(held, Interface):
        return Parameter(*place, part.body, part.part, ".".join(map(str, (field, *inside))))
    if field not in (*part.material.numbers, "thickness"):
        return None
    if callable(held):
        step = _table_step(held, int(inside[-1])) if isinstance(held, DepthTable) else _step(place.value)
        law = partial(replaced, held, inside)
        return Parameter(*place, part.body, part.part, str(field), law, step)
    # a power law by differences, not from waves
    step = _step(place.value) if part.material.power_law else 0.0
    return Parameter(*place, part.body, part.part, str(field), step=step)


def _tip_parameters(tip: object) -> list[Parameter]:
    places = list(numbers_of(tip, "indenter"))
    # the slopes between numbers that ascend must not change their sign
    rises = np.diff([each.value for each in places if each.number.ascending])
    least = float(_STEP * rises[rises > 0].min(initial=np.inf))
    return [
        Parameter(*place, -1, 0, place.number.what, step=least if place.number.ascending else _step(place.value))
        for place in places
        if place.value != 0
    ]


def _step(value: float) -> float:
    return _STEP * abs(value) if value else _STEP


def _table_step(law: DepthTable, j: int) -> float:
    """A step that leaves the signs of the slopes on both sides, on which the monotone cubic depends, as they are."""
    entries = np.array(law.entries)
    rises = np.abs(np.diff(entries[max(j - 1, 0) : j + 2]))
    return float(_STEP * min(abs(entries[j]) or 1.0, *rises[rises > 0], np.inf))
