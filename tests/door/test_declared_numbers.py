"""Declared numbers of all kinds of layers, bases and tips: what is beyond the range, and no number, is refused by name."""

from __future__ import annotations

import math
from typing import Any

import pytest

import flatpunch as fp
from flatpunch._support.declared import KINDS, Number, arguments
from flatpunch.files.tables import indenters, media  # noqa: F401  (all kinds are known once their tables are)
from flatpunch.media import AnyLayer, Body, Interface
from flatpunch.media.laws import LAWS, Constant
from support.public_calls import CALLS

MADE: dict[str, tuple[Any, dict[str, Any]]] = {
    **{
        call: each
        for call, each in CALLS.items()
        if each[0].__module__.startswith(("flatpunch.media", "flatpunch.indenters"))
    },
    "Constant": (Constant, {"value": 1.0}),
    "of_opening cone": (fp.Cone.of_opening, {"half_opening_angle": 0.3}),
    "of_opening pyramid": (fp.Pyramid.of_opening, {"sides": 4, "half_opening_angle": 0.3}),
    "of_radii": (fp.EllipticParaboloid.of_radii, {"radius_x": 1e-6, "radius_y": 2e-6}),
    "through": (fp.PowerLaw.through, {"exponent": 2.0, "height": 1e-7, "radius": 1e-6}),
    "layer": (KINDS["layers"][""].ways[0], {"young": 5e3, "poisson": 0.3, "thickness": 1e-6}),
    "half_space": (KINDS["base"]["half-space"].ways[0], {"young": 5e3, "poisson": 0.3}),
}
"""A valid call of everything that takes declared numbers."""


def beyond(number: Number, many: bool) -> dict[str, Any]:
    """Values that are outside the range, and what is no number."""
    found: dict[str, Any] = {"text": "x", "nan": math.nan, "infinite": math.inf}
    found |= {"nested": [[1.0], [1.0, 2.0]]} if many else {"list": [1.0]}
    if math.isfinite(number.low):
        found["low"] = number.above if number.above >= number.least else number.least - (1 if number.whole else 0.001)
    if math.isfinite(number.high):
        found["high"] = number.below if number.below <= number.most else number.most + (1 if number.whole else 0.001)
    return found


CASES = [
    pytest.param(call, name, bad, id=f"{call}: {name} {what}")
    for call, (made, given) in MADE.items()
    for name, argument in arguments(made).items()
    if (number := argument.number) is not None and name in given
    for what, bad in beyond(number, argument.many).items()
    if (made, what) != (Interface, "infinite")  # no spring
    and (call, name, what) != ("GradedLayer of five constants", "poisson", "high")  # less than 1 there
]


@pytest.mark.parametrize(("call", "name", "bad"), CASES)
def test_beyond_the_range(call: str, name: str, bad: Any) -> None:
    made, given = MADE[call]
    with pytest.raises((ValueError, TypeError)) as caught:
        made(**{**given, name: bad})
    assert name in str(caught.value), caught.value


def test_every_kind_is_tried() -> None:
    tried = {made for made, _ in MADE.values()}
    kinds = {way for section in KINDS.values() for kind in section.values() for way in kind.ways}
    rooms = {each for each in vars(fp.media).values() if isinstance(each, type) and issubclass(each, (AnyLayer, Body))}
    declared = {each for each in kinds | rooms | set(LAWS.values()) if any(a.number for a in arguments(each).values())}
    # of the package: other tests add kinds
    missing = {each for each in declared - tried if each.__module__.startswith("flatpunch.")}
    assert not missing
