"""The numbers of a fit as records: path, value, declaration, owner. From the declaration come limits, unit, label and scale."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple, Self

import numpy as np

from flatpunch._support.checks import TINY, shown
from flatpunch._support.numbers import Number, Place, a_length, a_pressure, a_ratio, numbers_of
from flatpunch._support.paths import steps
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, Interface, Material, Stack
from flatpunch.sensitivities.parameters import Parameter, parameters

OF = " @ "
"""Between the path of a number and the name of the one curve that it belongs to."""
NUISANCE = ("contact", "baseline", "tilt", "drag")
"""Contact point and coefficients of the background."""
CALIBRATION = ("spring_constant", "sensitivity")
"""Numbers of the calibration that may be drawn; the first is given in N/m, the second relative to the one used."""
WORK = "work_of_adhesion"
PULL_OFF = "pull-off force"
FRAME = "frame"
IMPRINT = "imprint"
_EDGE = 1e-3
"""Share of a range that fits stay away from an end that does not belong to it."""

BESIDE: dict[str, Place] = {
    name: Place(name, 0.0, number, None)
    for name, number in {
        "contact": Number("contact point", "m"),
        "baseline": Number("baseline", "N"),
        "tilt": Number("tilt", "N/m"),
        "drag": Number("drag", "N s/m"),
        "spring_constant": Number("spring constant", "N/m", above=0.0),
        "sensitivity": a_ratio("relative sensitivity", above=0.0),
        FRAME: Number("frame compliance", "m/N"),
        IMPRINT: a_ratio("thinning by the imprint over its depth", least=0.0, most=1.0),
        WORK: Number("work of adhesion", "J/m^2", above=0.0),
        PULL_OFF: Number("pull-off force", "N"),
        "deepest": Number("largest depth", "m"),
        "noise": Number("noise", "N"),
        "position x": Number("position x", "m"),
        "position y": Number("position y", "m"),
    }.items()
}
"""What a fit has beside the numbers of medium and tip."""

_RATIOS = "all moduli at their ratios"
_GROUPS = {"young": a_pressure("E", about=_RATIOS), "surface_modulus": a_pressure("contact modulus", about=_RATIOS)}
"""All moduli of a material as one number: the last where they vary with depth."""
_OF_MEDIA = {
    "young": a_pressure("E"),
    "poisson": a_ratio("Poisson ratio", above=-1.0, most=0.5),
    "thickness": a_length("thickness"),
    "normal spring": Number("normal interface stiffness", "Pa/m", above=0.0),
    "shear spring": Number("shear interface stiffness", "Pa/m", above=0.0),
}
"""Declarations of the numbers of media that have none of their own."""


def numbers_in(medium: Body, indenter: Indenter | None) -> dict[str, Place]:
    """All numbers of a medium and a tip that can be fitted, and the groups of moduli at their ratios, by path."""
    tip = {each.path: each for each in numbers_of(indenter, "indenter")}
    bodies = dict(medium.sides) if medium.single or medium.pair else {}
    listed = parameters(medium, indenter)
    own = {each.name: _of_medium(medium, each) for each in listed if each.body >= 0 and bodies}
    groups = [group for name, body in bodies.items() for group in _groups(body, f"{name}." if name else "")]
    return {**own, **{each.path: each for each in groups}, **{p.name: tip[p.name] for p in listed if p.body < 0}}


def _of_medium(medium: Body, parameter: Parameter) -> Place:
    """The record of a number of a medium, whose classes declare none."""
    way = steps(parameter.name)
    *above, last = way[:-1] if isinstance(way[-1], int) else way
    words = parameter.kind if parameter.kind.startswith(str(last)) else f"{parameter.kind} {last}"
    number = Number(words.replace("_", " "), parameter.unit, above=0.0 if parameter.unit else -np.inf)
    return Place(parameter.name, parameter.value, _OF_MEDIA.get(words, number), owner_at(medium, above))


def owner_at(thing: object, way: Iterable[str | int]) -> object:
    """What is at the end of a path; a half-space by itself is its own base."""
    found: Any = thing
    for step in way:
        found = found[step] if isinstance(step, int) else getattr(found, step)
    return found


def _groups(body: Stack, prefix: str) -> Iterator[Place]:
    """The moduli of materials that have more than a Young's modulus, as one number each."""
    parts: list[tuple[str, Any]] = [(f"{prefix}layers[{i}]", layer) for i, layer in enumerate(body.layers)]
    for path, part in (*parts, (f"{prefix}base", body.base)):
        if not (part.rigid or part.power_law or (part.isotropic and "young" in part.numbers)):
            name = "surface_modulus" if part.varies else "young"
            yield Place(f"{path}.{name}", getattr(part, name), _GROUPS[name], part)


def is_group(number: Place) -> bool:
    """Whether it stands for all moduli of a material."""
    return number.number in _GROUPS.values()


def members(group: Place, numbers: Mapping[str, Place]) -> list[str]:
    """Names of the moduli that a group stands for."""
    start = f"{group.path.rpartition('.')[0]}."
    inside = (each for name, each in numbers.items() if name.startswith(start) and not is_group(each))
    return [each.path for each in inside if each.number.unit == "Pa"]


def check_names(
    names: Iterable[str], numbers: Mapping[str, Place], advice: Callable[[str], str] = lambda name: ""
) -> None:
    """Refuse names that are no numbers of a case, and a group of moduli beside one of them."""
    names = tuple(names)
    for name in names:
        if name not in numbers:
            known = ", ".join(numbers)
            raise ValueError(f"free parameter {shown(name)} is not part of this case; it has {known}.{advice(name)}")
    for group in (numbers[name] for name in names if is_group(numbers[name])):
        if inside := [name for name in members(group, numbers) if name in names]:
            raise ValueError(
                f"free parameters {group.path} and {inside[0]} exclude each other: the first is all moduli of the material at "
                "their ratios. Fit it, or the moduli one by one."
            )


def smooth(number: Place) -> bool:
    """Whether a force is smooth in a number, at all values that its declaration allows."""
    owner = number.owner
    if is_group(number) or isinstance(owner, Interface):
        return True
    if not isinstance(owner, Material) or owner.varies or owner.power_law:
        return False
    return not owner.anisotropic or number.number.unit == "m"


class Scale(NamedTuple):
    """How a number follows from its internal value x: offset + unit x, unit exp x, or arctan exp x."""

    form: str
    offset: float = 0.0
    unit: float = 1.0

    @classmethod
    def of(cls, number: Place) -> Self:
        """That of a declaration; numbers without a range are in units of their value."""
        what = number.number
        if what.positive or what.slanted:
            return cls("logarithm" if what.positive else "slope")
        ranged = np.isfinite([what.low, what.high]).all()
        return cls("plain", unit=1.0 if ranged else abs(number.value) or 1.0)

    def external(self, x: Any) -> Any:
        """Values [SI]."""
        with np.errstate(over="ignore"):
            if self.form == "plain":
                return self.offset + self.unit * x
            return np.arctan(np.exp(x)) if self.form == "slope" else self.unit * np.exp(x)

    def slope(self, x: Any) -> Any:
        """Derivative of the values by x."""
        if self.form == "plain":
            return self.unit * np.ones_like(x)
        return 1 / (2 * np.cosh(x)) if self.form == "slope" else self.unit * np.exp(x)

    def internal(self, value: float) -> float:
        """Internal value, clipped to what has one."""
        if self.form == "plain":
            return (value - self.offset) / self.unit
        return float(np.log(np.tan(value) if self.form == "slope" else max(value, TINY) / self.unit))


def ends(number: Place) -> tuple[float, float]:
    """Internal values at the ends of the range of a number, a little inside; infinite where there is none."""
    what, scale = number.number, Scale.of(number)
    if scale.form == "slope":
        return -np.inf, np.inf
    edge = _EDGE * (what.high - what.low) if np.isfinite([what.low, what.high]).all() else 0.0
    low = max(what.least, what.above + edge)
    return scale.internal(low) if low > 0 or scale.form == "plain" else -np.inf, scale.internal(
        min(what.most, what.below - edge)
    )
