"""What a curve is measured on: medium and tip, and what makes the contact adhesive or viscoelastic; its parameters by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from flatpunch._support.checks import BadValue, positive, shown
from flatpunch._support.numbers import numbers_of
from flatpunch._support.readable import readable
from flatpunch.contact.viscoelastic import check_medium
from flatpunch.fits.parameters.numbers import BESIDE, WORK, Numbers, check_names, numbers_in
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
    work_of_adhesion : float, optional
        w [J/m^2]: the contact is adhesive (JKR).
    range_of_action : float, optional
        Largest gap across which the adhesive traction acts [m]; the fit then states whether JKR theory holds.
    relaxation : Prony, StandardLinearSolid or PowerLawRelaxation, optional
        The medium relaxes.

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
    >>> print(Sample(gel, fp.Sphere(radius=5e-6), work_of_adhesion=1e-3).work_of_adhesion)
    0.001
    """

    medium: Body
    indenter: Indenter
    work_of_adhesion: float | None = None
    range_of_action: float | None = None
    relaxation: Relaxation | None = None

    def __post_init__(self) -> None:
        check_indenter(self.indenter)
        if self.range_of_action is not None:
            action = positive("range_of_action", self.range_of_action, unit="m")
            object.__setattr__(self, "range_of_action", action)
            if self.work_of_adhesion is None:
                raise BadValue(
                    "range_of_action", repr(self.range_of_action), "has no meaning without work_of_adhesion."
                )
        if self.work_of_adhesion is not None:
            work = positive(
                "work_of_adhesion",
                self.work_of_adhesion,
                "It is the energy per area gained by contact [J/m^2].",
                unit="J/m**2",
            )
            object.__setattr__(self, "work_of_adhesion", work)
            if self.relaxation is not None:
                raise ValueError(
                    "work_of_adhesion and relaxation do not go together: adhesion of viscoelastic bodies is not solved."
                )
            if self.indenter.flat:
                raise ValueError(
                    "The curve of a flat end is a straight line whatever the work of adhesion, which shows in the pull-off force "
                    "alone. Compare the measured one with flatpunch.pull_off(...)."
                )
        if self.relaxation is not None:
            if not isinstance(self.relaxation, (Prony, StandardLinearSolid, PowerLawRelaxation)):
                raise TypeError(
                    f"relaxation = {shown(self.relaxation)} must be a Prony, a StandardLinearSolid or a PowerLawRelaxation."
                )
            check_medium(self.medium)

    @cached_property
    def numbers(self) -> Numbers:
        """All numbers that can be fitted, by name."""
        found = numbers_in(self.medium, self.indenter)
        if self.work_of_adhesion is not None:
            found[WORK] = BESIDE[WORK]._replace(value=self.work_of_adhesion)
        found.update((each.path, each) for each in numbers_of(self.relaxation, "relaxation"))
        return found

    def check(self, names: Iterable[str]) -> None:
        """Refuse names that are no parameters, and a group of moduli beside one of them."""
        check_names(names, self.numbers, self._advice)

    def _advice(self, name: str) -> str:
        if name == WORK:
            return " Give work_of_adhesion, the value to start from."
        if name == "relaxation.time" and isinstance(self.relaxation, PowerLawRelaxation):
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
        return replace(
            self,
            medium=medium,
            indenter=indenter,
            work_of_adhesion=values.get(WORK, self.work_of_adhesion),
            relaxation=law_with(self.relaxation, law) if law else self.relaxation,
        )


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
