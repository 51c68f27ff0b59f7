"""What acts in a contact beside the elasticity of its bodies: adhesion, relaxation, large strain."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Annotated, ClassVar, Literal, TypedDict, cast

from flatpunch._support.checks import BadValue, one_of
from flatpunch._support.declared import Checked, Number, a_length, a_pressure
from flatpunch._support.prefixes import text
from flatpunch.media.relaxation import Relaxation

FiniteStrain = Literal["neo-hookean"]
NEO_HOOKEAN: FiniteStrain = "neo-hookean"
"""W = mu/2 (I - 3) + kappa/2 (J - 1)^2 with I = J^(-2/3) tr F^T F."""


class PhysicsOf(TypedDict, total=False):
    """Arguments for what acts beside elasticity; see `indent`."""

    work_of_adhesion: float | None
    range_of_action: float | None
    strength: float | None
    relaxation: Relaxation | Sequence[Relaxation | None] | None
    finite_strain: FiniteStrain | None


@dataclasses.dataclass(frozen=True)
class Physics(Checked):
    """What acts beside elasticity; nothing by default.

    Parameters
    ----------
    work_of_adhesion : float, optional
        w [J/m^2]: the contact is adhesive.
    range_of_action : float, optional
        Largest gap across which adhesion acts [m] (Maugis-Dugdale); without it JKR theory holds.
    strength : float, optional
        In its place the adhesive stress [Pa], which is the work over the range.
    relaxation : Relaxation, or sequence of Prony, StandardLinearSolid or None, optional
        psi(t) of the medium, or of each layer and the base.
    finite_strain : {"neo-hookean"}, optional
        Law of the correction for large strains.

    Raises
    ------
    ValueError
        If these do not go together.
    """

    work_of_adhesion: Annotated[
        float | None,
        Number(
            "work of adhesion",
            "J/m^2",
            above=0.0,
            example="1 mJ/m^2",
            remedy="It is the energy per area gained by contact [J/m^2].",
        ),
    ] = None
    range_of_action: Annotated[float | None, a_length("range of action", example="10 nm")] = None
    strength: Annotated[float | None, a_pressure("adhesive strength", example="10 MPa")] = None
    relaxation: Relaxation | Sequence[Relaxation | None] | None = None
    finite_strain: FiniteStrain | None = None

    _called_: ClassVar = {name: name for name in ("work_of_adhesion", "range_of_action", "strength")}

    @property
    def within(self) -> float | None:
        """Range of action [m]; None in JKR theory."""
        if self.strength is None or self.work_of_adhesion is None:
            return self.range_of_action
        return self.work_of_adhesion / self.strength

    @contextmanager
    def named(self) -> Iterator[None]:
        """Errors about the range name the strength, where that was given."""
        try:
            yield
        except BadValue as fault:
            if self.strength is None or fault.field != "range_of_action":
                raise
            raise BadValue("strength", text(self.strength, "Pa"), fault.text) from None

    @property
    def given(self) -> PhysicsOf:
        """What was given, as arguments."""
        values = ((field.name, getattr(self, field.name)) for field in dataclasses.fields(self))
        return cast("PhysicsOf", {name: value for name, value in values if value is not None})

    def _together_(self) -> None:
        if isinstance(self.relaxation, list):
            object.__setattr__(self, "relaxation", tuple(self.relaxation))
        if self.finite_strain is not None:
            one_of("finite_strain", self.finite_strain, (NEO_HOOKEAN,), "None is linear theory.")
            if self.work_of_adhesion is not None or self.relaxation is not None:
                raise ValueError(
                    "finite_strain does not go with work_of_adhesion and relaxation; leave one of them out."
                )
        for name, value in (("range_of_action", self.range_of_action), ("strength", self.strength)):
            if self.work_of_adhesion is None and value is not None:
                raise BadValue(
                    name, repr(value), "has no meaning without work_of_adhesion; give both, or leave it out."
                )
        if self.range_of_action is not None and self.strength is not None:
            raise BadValue(
                "strength",
                text(self.strength, "Pa"),
                "is work_of_adhesion over range_of_action; leave one of them out.",
            )
        if self.work_of_adhesion is not None and self.relaxation is not None:
            raise ValueError(
                "work_of_adhesion and relaxation do not go together: adhesion of viscoelastic bodies is not solved."
            )


ELASTIC = Physics()
