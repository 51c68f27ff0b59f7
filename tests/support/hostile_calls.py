"""Seeded hostile calls: any value in the place of any argument of every public constructor and function."""

from __future__ import annotations

import inspect
import random
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pint

import flatpunch as fp
from support.public_calls import BALL, BODY, CALLS, CURVE, GEL

REGISTRY = pint.UnitRegistry()
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


class NoArray:
    """Refuses to be an array, and to be shown."""

    def __array__(self, *_: object, **__: object) -> None:
        raise RuntimeError

    def __repr__(self) -> str:
        raise RuntimeError


MORE: dict[str, tuple[Any, dict[str, Any]]] = {
    "load": (fp.load, {"path": "none.nc"}),
    "read_case": (fp.read_case, {"path": EXAMPLES / "knee_insert_sliding_on_tray.toml"}),
    "read_curve": (fp.read_curve, {"path": EXAMPLES / "fit" / "thin_gel.csv"}),
    "Medium": (fp.Medium, {"layers": [fp.Layer(5e3, 0.4, 1e-6)], "base": fp.RigidBase()}),
    "TwoBodies": (fp.TwoBodies, {"upper": BODY, "lower": BODY}),
    "Formula": (fp.Formula, {"text": "1 + z"}),
    "fit_batch": (fp.fit_batch, {"curves": [CURVE], "medium": BODY, "indenter": BALL, "free": ["base.young"]}),
}

VALUES: list[Any] = [
    *(None, True, "", "5e3", "x" * 10_000, "\0", "layers[0].young", b"1", 1 + 0j, 10**400, -1, 0, 5e-324, 1e-20, 1e20),
    *(1e300, float("nan"), -np.inf, np.longdouble("1e4000"), np.ma.masked, np.datetime64("2020"), Decimal("sNaN")),
    *(Fraction(1, 3), {}, {1.0}, [], [1.0, "a"], [2.0, 1.0], [[1.0], [1.0, 2.0]], np.zeros((0, 3)), np.ones((2, 2, 2))),
    *(np.array([1, None], dtype=object), np.zeros(2, dtype=[("a", "f8")]), object(), int, len, NoArray(), range(5)),
    *(REGISTRY.Quantity(3.0, "kelvin"), REGISTRY.Quantity(3, "N/m"), REGISTRY.Quantity([1.0, 2.0], "kPa")),
    *(BODY, GEL, BALL, fp.RigidBase, fp.Sphere, fp.indent, CURVE, fp.indent(BODY, BALL, depth=[1e-8, 2e-8])),
    *({"base.young": (1e3, 1e4)}, ["nonsense"], fp.Pyramid(3, 0.3), fp.Cylinder(1e-6), fp.Cone(1.5)),
]

LEFT_OUT = {"axes", "progress", "workers", "scheduler", "store", "cache"}
"""What draws, starts processes or writes files."""


def hostile_calls(seed: int, count: int) -> Iterator[tuple[str, Any, dict[str, Any]]]:
    """Label, function and arguments, one to three of which are anything."""
    calls = {**CALLS, **MORE}
    rng = random.Random(seed)
    for _ in range(count):
        name = rng.choice(list(calls))
        function, valid = calls[name]
        known = [p for p, what in inspect.signature(function).parameters.items() if what.kind < 4 and what.kind != 2]
        names = sorted({p for p in known if p not in LEFT_OUT and p != "given"} or set(valid))
        chosen = rng.sample(names, min(len(names), rng.choice([1, 1, 2, 3])))
        yield f"{name}, {', '.join(chosen)}", function, {**valid, **{p: rng.choice(VALUES) for p in chosen}}
