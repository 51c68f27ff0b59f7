"""Random media of all kinds: written to case files and forms of the page, they are read back to the last bit."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.app.form import case_text, form_of, toml_text
from flatpunch.app.jobs.common import case_of
from flatpunch.files.cases import case_from

Pair = tuple[dict[str, Any], Any]
"""A table of a case file, and the object that it describes."""

REST = {"indenter": {"kind": "sphere", "radius": "1 um"}, "control": {"depth": "1 nm"}}


class Draw:
    """Random tables with their objects."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)

    def number(self, unit: str, low: float, high: float) -> tuple[Any, float]:
        value = float(np.exp(self.rng.uniform(np.log(low), np.log(high))))
        return (f"{value!r} {unit}" if unit else value), value

    def one_of(self, *ways: Any) -> Any:
        return ways[self.rng.integers(len(ways))]()

    def modulus(self) -> tuple[Any, float]:
        return self.number("Pa", 1e9, 9e9)

    def ratio(self) -> tuple[Any, float]:
        return self.number("", 0.1, 0.3)

    def five(self) -> tuple[list[Any], dict[str, float]]:
        written, values = zip(
            *(self.modulus(), self.modulus(), self.ratio(), self.ratio(), self.modulus()), strict=True
        )
        names = ("young_in_plane", "young_axial", "poisson_in_plane", "poisson_axial", "shear")
        return list(written), dict(zip(names, values, strict=True))

    def anisotropic(self) -> Pair:
        (young, axial, poisson, poisson_axial, shear), constants = self.five()
        table = {
            "young": young,
            "poisson": poisson,
            "young_axial": axial,
            "poisson_axial": poisson_axial,
            "shear": shear,
        }
        return table, constants

    def face(self) -> Pair:
        normal, shear = self.number("Pa/m", 1e12, 1e15), self.number("Pa/m", 1e12, 1e15)
        return self.one_of(
            lambda: ({}, True),
            lambda: ({"bonded": False}, False),
            lambda: ({"interface_normal": normal[0]}, fp.Interface(normal[1])),
            lambda: (
                {"interface_normal": normal[0], "interface_shear": shear[0]},
                fp.Interface(normal[1], shear[1]),
            ),
            lambda: ({"interface_shear": "0 Pa/m"}, fp.Interface(shear=0.0)),
        )

    def law(self, h: float) -> tuple[Any, Any]:
        top, bottom, power = self.modulus(), self.modulus(), self.number("", 0.5, 3.0)
        ends = {"top": top[0], "bottom": bottom[0]}
        return self.one_of(
            lambda: ({"law": "linear", **ends}, fp.LinearModulus(top[1], bottom[1], h)),
            lambda: ({"law": "exponential", **ends}, fp.ExponentialModulus(top[1], bottom[1], h)),
            lambda: ({"law": "power", **ends, "exponent": power[0]}, fp.PowerModulus(top[1], bottom[1], h, power[1])),
            lambda: ({"depths": ["0 m", f"{h!r} m"], "values": list(ends.values())}, ([0.0, h], [top[1], bottom[1]])),
            lambda: ({"formula": "1e9 + 1e14*z"}, fp.Formula("1e9 + 1e14*z")),
        )

    def layer(self) -> Pair:
        (thickness, h), (face, bonded) = self.number("m", 1e-7, 1e-5), self.face()
        common = {"thickness": thickness, **face}

        def plain() -> Pair:
            (young, e), (poisson, nu) = self.modulus(), self.ratio()
            return {"young": young, "poisson": poisson, **common}, fp.Layer(e, nu, h, bonded)

        def graded() -> Pair:
            (young, e), (poisson, nu) = self.law(h), self.ratio()
            return {"young": young, "poisson": poisson, **common}, fp.GradedLayer(e, nu, h, bonded)

        def anisotropic() -> Pair:
            table, constants = self.anisotropic()
            return {**table, **common}, fp.TransverselyIsotropicLayer(**constants, thickness=h, bonded=bonded)

        found: Pair = self.one_of(plain, graded, anisotropic)
        return found

    def base(self) -> Pair:
        def plain() -> Pair:
            (young, e), (poisson, nu) = self.modulus(), self.ratio()
            return {"kind": "half-space", "young": young, "poisson": poisson}, fp.HalfSpace(e, nu)

        def anisotropic() -> Pair:
            table, constants = self.anisotropic()
            return {"kind": "half-space", **table}, fp.TransverselyIsotropicHalfSpace(**constants)

        found: Pair = self.one_of(plain, anisotropic, lambda: ({"kind": "rigid"}, fp.RigidBase()))
        return found

    def body(self) -> Pair:
        listed, (table, base) = [self.layer() for _ in range(self.rng.integers(1, 4))], self.base()
        layers = [layer for _, layer in listed]
        return {"layers": [each for each, _ in listed], "base": table}, fp.Medium(layers, base)

    def power_law(self) -> Pair:
        (modulus, e), (depth, length) = self.modulus(), self.number("m", 1e-7, 1e-5)
        (exponent, k), (poisson, nu) = self.number("", 0.1, 0.9), self.ratio()
        table = {"kind": "power-law-half-space", "modulus": modulus, "depth": depth, "exponent": exponent}
        return {"base": {**table, "poisson": poisson}}, fp.PowerLawHalfSpace(e, length, k, nu)

    def medium(self) -> Pair:
        def two() -> Pair:
            (upper, first), (lower, second) = self.body(), self.body()
            return {"upper": upper, "lower": lower}, fp.TwoBodies(first, second)

        found: Pair = self.one_of(self.body, self.body, self.body, two, self.power_law)
        return found


@pytest.mark.parametrize("seed", range(60))
def test_media_go_round(seed: int) -> None:
    table, medium = Draw(seed).medium()
    written = toml_text({**table, **REST})
    assert case_from(tomllib.loads(written), Path("case.toml")).medium == medium
    form = form_of(tomllib.loads(written))
    assert case_of(form).medium == medium
    assert form_of(tomllib.loads(case_text(form))) == form
