"""What a curve is measured on, medium, tip and physics, and its numbers as records: limits, unit and scale by declaration."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple, Self, cast

import numpy as np

from flatpunch._support.checks import TINY, instance, shown
from flatpunch._support.declared import Number, Place, a_ratio, numbers_of
from flatpunch._support.readable import readable
from flatpunch.compliances import compliance
from flatpunch.compliances.kernel import check_no_membrane
from flatpunch.contact.adhesion.case import check_range
from flatpunch.contact.physics import ELASTIC, Physics, PhysicsOf
from flatpunch.contact.viscoelastic import check_medium
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import (
    Body,
    Interface,
    Material,
    Membrane,
    PowerLawRelaxation,
    Prony,
    Relaxation,
    StandardLinearSolid,
    paths,
)
from flatpunch.media.paths import groups
from flatpunch.sensitivities.parameters import parameters

OF = " @ "
"""Between the path of a number and the name of the one curve that it belongs to."""
NUISANCE = ("contact", "baseline", "tilt", "drag")
"""Contact point and coefficients of the background."""
CALIBRATION = ("spring_constant", "sensitivity")
"""Numbers of the calibration that may be drawn; the first is given in N/m, the second relative to the one used."""
ADHESION = WORK, RANGE, STRENGTH = "work_of_adhesion", "range_of_action", "strength"
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


class Numbers(dict[str, Place]):
    """Records by name; `members` has for each group of moduli the names of those that it moves at their ratios."""

    members: Mapping[str, tuple[str, ...]] = MappingProxyType({})


def numbers_in(medium: Body, indenter: Indenter | None) -> Numbers:
    """All numbers of a medium and a tip that can be fitted, and the groups of moduli at their ratios, by path."""
    listed = [Place(each.path, each.value, each.number, each.owner) for each in parameters(medium, indenter)]
    if not (medium.single or medium.pair):
        listed = [each for each in listed if each.path.startswith("indenter.")]
    known = groups(medium) if medium.single or medium.pair else []
    places = sorted([*listed, *(each.place for each in known)], key=lambda each: each.path.startswith("indenter."))
    found = Numbers({each.path: each for each in places})
    found.members = {each.place.path: each.members for each in known}
    return found


def check_names(names: Iterable[str], numbers: Numbers, advice: Callable[[str], str] = lambda name: "") -> None:
    """Refuse names that are no numbers of a case, and a group of moduli beside one of them."""
    names = tuple(names)
    for name in names:
        if name not in numbers:
            known = ", ".join(numbers)
            raise ValueError(f"free parameter {shown(name)} is not part of this case; it has {known}.{advice(name)}")
    for group in names:
        if inside := [name for name in numbers.members.get(group, ()) if name in names]:
            raise ValueError(
                f"free parameters {group} and {inside[0]} exclude each other: the first is all moduli of the material at "
                "their ratios. Fit it, or the moduli one by one."
            )


def smooth(number: Place) -> bool:
    """Whether a force is smooth in a number that is no group, at all values that its declaration allows."""
    owner = number.owner
    if not isinstance(owner, Material) or owner.varies or owner.power_law:
        return isinstance(owner, (Interface, Membrane))
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


@readable
@dataclass(frozen=True)
class Sample:
    """Known values, and starting values of the free ones.

    Parameters
    ----------
    medium, indenter : object
        Layers and tip.
    physics : Physics
        Adhesion, relaxation and large strain, as arguments of `fit`.

    Raises
    ------
    ValueError
        If these do not go together.

    See Also
    --------
    flatpunch.fit : Makes it from its arguments.
    flatpunch.files.describe_sample : In words.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> from flatpunch.fits import Sample
    >>> print(list(Sample(gel, fp.Sphere(radius=5e-6)).numbers))
    ['layers[0].young', 'layers[0].poisson', 'layers[0].thickness', 'indenter.radius']
    """

    medium: Body
    indenter: Indenter
    physics: Physics = ELASTIC

    def __post_init__(self) -> None:
        instance("medium", self.medium, (Body,), "a body, such as HalfSpace or Medium")
        check_indenter(self.indenter)
        check_no_membrane(self.medium)
        instance("physics", self.physics, (Physics,), "a Physics")
        if self.adhesive and self.indenter.flat:
            raise ValueError(
                "The curve of a flat end is a straight line whatever the work of adhesion, which shows in the pull-off force "
                "alone. Compare the measured one with flatpunch.pull_off(...)."
            )
        if self.physics.within is not None:
            with self.physics.named():
                check_range(compliance(self.medium), self.indenter, self.physics.within)
        relaxation = self.physics.relaxation
        if relaxation is not None:
            if not isinstance(relaxation, (Prony, StandardLinearSolid, PowerLawRelaxation)):
                raise TypeError(
                    f"relaxation = {shown(relaxation)} must be a Prony, a StandardLinearSolid or a PowerLawRelaxation."
                )
            check_medium(self.medium)

    @property
    def adhesive(self) -> bool:
        """Whether the contact is adhesive."""
        return self.physics.work_of_adhesion is not None

    @property
    def relaxing(self) -> bool:
        """Whether the medium relaxes."""
        return self.physics.relaxation is not None

    @cached_property
    def numbers(self) -> Numbers:
        """All numbers that can be fitted, by name."""
        found = numbers_in(self.medium, self.indenter)
        found.update((each.path, each) for each in numbers_of(self.physics))
        return found

    def check(self, names: Iterable[str]) -> None:
        """Refuse names that are no parameters, and a group of moduli beside one of them."""
        check_names(names, self.numbers, self._advice)

    def _advice(self, name: str) -> str:
        if name in ADHESION:
            return f" Give {name}, the value to start from."
        if name == "relaxation.time" and isinstance(self.physics.relaxation, PowerLawRelaxation):
            return " The time of a power law is that at which the modulus is young: fit young, and keep the time."
        return " Give relaxation, with values to start from." if name.startswith("relaxation") else ""

    def value(self, name: str) -> float:
        """Value of a parameter, SI."""
        self.check([name])
        return self.numbers[name].value

    def replaced(self, values: Mapping[str, float]) -> Sample:
        """Return the sample with some parameters replaced."""
        self.check(values)
        law = {n: v for n, v in values.items() if n.startswith("relaxation.")}
        adhesion = cast("PhysicsOf", {n: v for n, v in values.items() if n in ADHESION})
        elastic = {n: v for n, v in values.items() if n not in adhesion and n not in law}
        medium, indenter = paths.with_values(self.medium, self.indenter, elastic)
        physics = replace(self.physics, **adhesion)
        if law:
            physics = replace(physics, relaxation=law_with(physics.relaxation, law))
        return Sample(medium, indenter, physics)


def normalised(law: Prony) -> bool:
    """Whether the modulus of the medium is the instantaneous one, as it is unless another equilibrium was given."""
    # decimal weights add up to one to rounding only
    return abs(sum(law.weights) + law.equilibrium - 1) < 1e-9


def law_with(law: Any, values: Mapping[str, float]) -> Relaxation:
    """A relaxation function with some parameters replaced."""
    if not isinstance(law, Prony):
        found: Relaxation = replace(law, **{name.removeprefix("relaxation."): v for name, v in values.items()})
        return found
    columns = {"weights": np.array(law.weights), "times": np.array(law.times)}
    for name, value in values.items():
        attribute, _, index = name.removeprefix("relaxation.").partition("[")
        columns[attribute][int(index[:-1])] = value
    if not normalised(law):
        return Prony(columns["weights"], columns["times"], law.equilibrium)
    # weights that add up to more than one leave no equilibrium
    return Prony(columns["weights"], columns["times"], max(1 - float(columns["weights"].sum()), 0.0))
