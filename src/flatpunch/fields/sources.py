"""Loads as sources of fields: solved contacts, and prescribed discs and patches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliance import compliance
from flatpunch.contact import indent
from flatpunch.fields.bodies import Located
from flatpunch.fields.contact_load import contact_load
from flatpunch.fields.loads import DiscLoad, Load
from flatpunch.fields.round_load import RoundLoad, round_fields
from flatpunch.fields.uniform_disc import UniformDisc
from flatpunch.indenters import Cylinder

_ROUND_ERROR = 1e-8
"""Error of round loads on homogeneous surfaces over the largest pressure, away from the rim (tests measure it)."""

_GRADED_ERROR = 1e-4
"""The same under a graded surface, whose pressure is a slowly converging series."""


class Source(Protocol):
    """A load that knows its fields."""

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress (6, n), displacement (3, n), and the estimated error of stress over the largest pressure."""


@dataclass(frozen=True, slots=True)
class RoundSource:
    """A round load at a place of its own.

    Attributes
    ----------
    load : RoundLoad
        Its pressure.
    pressure, traction : float
        Factors of the load as pressure and as traction.
    center : (float, float)
        Its place [m].
    error : float
        Estimated error over the largest pressure.
    """

    load: RoundLoad
    pressure: float = 1.0
    traction: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)
    error: float = _ROUND_ERROR

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress, displacement and error at points of one body."""
        stress, displacement = round_fields(
            self.load,
            at,
            x - self.center[0],
            y - self.center[1],
            pressure=self.pressure,
            # on the upper body the friction of the lower one acts backwards
            traction=-self.traction if at.upper else self.traction,
            direction=direction,
        )
        return stress, displacement, self.error


@dataclass(frozen=True, slots=True)
class Nothing:
    """No contact."""

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Zero."""
        return np.zeros((6, x.size)), np.zeros((3, x.size)), 0.0


def prescribed_sources(loads: Sequence[Load], friction: float) -> list[Source]:
    """Sources of prescribed loads; friction adds to their own traction."""
    found: list[Source] = []
    for load in loads:
        if isinstance(load, DiscLoad):
            traction = load.traction + friction * load.pressure
            found.append(RoundSource(UniformDisc(load.radius), load.pressure, traction, load.center))
    return found


def contact_sources(
    medium: Any,
    indenter: Any,
    given: dict[str, Any],
    method: str | None,
    friction: float,
    *,
    work_of_adhesion: float | None = None,
    **options: Any,
) -> tuple[list[Source], dict[str, Any]]:
    """Source of a contact, and what a result says about it: depth, force, radius, method, notes."""
    curve = indent(medium, indenter, method=method, work_of_adhesion=work_of_adhesion, **given, **options)
    if curve.sizes["step"] != 1:
        raise ValueError(
            f"{curve.attrs['control']} has {curve.sizes['step']} values; fields belong to one contact. Give one of them."
        )
    solved = {name: float(curve[name].values[0]) for name in ("depth", "force", "radius")}
    about = {**solved, "method": curve.attrs["method"], "valid": bool(curve["valid"].values[0]), "notes": curve.attrs["notes"]}
    if not solved["radius"] > 0:
        return [Nothing()], about
    kernel = compliance(medium)
    edge = work_of_adhesion is not None or isinstance(indenter, Cylinder)
    load = contact_load(kernel, indenter, solved["radius"], solved["depth"], edge=edge)
    error = _GRADED_ERROR if kernel.graded else _ROUND_ERROR
    return [RoundSource(load, 1.0, friction, error=error)], about
