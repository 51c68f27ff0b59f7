"""What a curve is measured on: medium and tip, and what makes the contact adhesive or viscoelastic; its parameters by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from flatpunch._support.checks import shown
from flatpunch._support.declared import numbers_of
from flatpunch._support.readable import readable
from flatpunch.contact.physics import ELASTIC, Physics
from flatpunch.contact.viscoelastic import check_medium
from flatpunch.fits.parameters.numbers import WORK, Numbers, check_names, numbers_in
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body, PowerLawRelaxation, Prony, Relaxation, StandardLinearSolid, paths


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
        check_indenter(self.indenter)
        if self.adhesive and self.indenter.flat:
            raise ValueError(
                "The curve of a flat end is a straight line whatever the work of adhesion, which shows in the pull-off force "
                "alone. Compare the measured one with flatpunch.pull_off(...)."
            )
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
        if name == WORK:
            return " Give work_of_adhesion, the value to start from."
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
        elastic = {n: v for n, v in values.items() if n != WORK and n not in law}
        medium, indenter = paths.with_values(self.medium, self.indenter, elastic)
        physics = self.physics
        if WORK in values:
            physics = replace(physics, work_of_adhesion=values[WORK])
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
