"""What acts in a contact beside the elasticity of its bodies: adhesion, relaxation, large strain."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal, TypedDict, cast

from flatpunch._support.checks import BadValue, one_of
from flatpunch._support.declared import Checked, Number, a_length
from flatpunch.media.relaxation import Relaxation

FiniteStrain = Literal["neo-hookean"]
NEO_HOOKEAN: FiniteStrain = "neo-hookean"
"""W = mu/2 (I - 3) + kappa/2 (J - 1)^2 with I = J^(-2/3) tr F^T F."""


class PhysicsOf(TypedDict, total=False):
    """Arguments for what acts beside elasticity; see `indent`."""

    work_of_adhesion: float | None
    range_of_action: float | None
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
    range_of_action: Annotated[float | None, a_length("range of action", example="10 nm", varies=False)] = None
    relaxation: Relaxation | Sequence[Relaxation | None] | None = None
    finite_strain: FiniteStrain | None = None

    _called_: ClassVar = {"work_of_adhesion": "work_of_adhesion", "range_of_action": "range_of_action"}

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
        if self.work_of_adhesion is None and self.range_of_action is not None:
            raise BadValue("range_of_action", repr(self.range_of_action), "has no meaning without work_of_adhesion.")
        if self.work_of_adhesion is not None and self.relaxation is not None:
            raise ValueError(
                "work_of_adhesion and relaxation do not go together: adhesion of viscoelastic bodies is not solved."
            )


ELASTIC = Physics()
