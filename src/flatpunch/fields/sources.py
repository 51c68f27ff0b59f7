"""Loads as sources of fields: solved contacts, and prescribed discs and patches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import Array
from flatpunch.compliance import compliance
from flatpunch.contact import MethodName, indent, pressure
from flatpunch.contact.curve import Control, control_from
from flatpunch.fields.bodies import Located
from flatpunch.fields.cells import Cells, cell_fields
from flatpunch.fields.contact_load import contact_load
from flatpunch.fields.loads import DiscLoad, Load
from flatpunch.fields.round_load import RoundLoad, round_fields
from flatpunch.fields.uniform_disc import UniformDisc
from flatpunch.indenters import Cylinder
from flatpunch.media import GradedLayer, Medium

_ROUND_ERROR = 1e-8
"""Error of round loads on homogeneous surfaces over the largest pressure, away from the rim (tests measure it)."""

_GRADED_ERROR = 1e-4, 1e-3
"""The same under a graded surface, where what it adds to the half-space decays slowly: of contacts, and of discs, whose pressure
jumps at the rim."""


_SAMPLED, _SUPERPOSED = 192, 128
"""Cells along each side of a contact that is no disc: of boundary elements, and of a superposed pressure, which is expensive."""


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
    """

    load: RoundLoad
    pressure: float = 1.0
    traction: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)

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
        layers = at.body.layers if isinstance(at.body, Medium) else ()
        graded = bool(layers) and isinstance(layers[0], GradedLayer)
        return stress, displacement, _GRADED_ERROR[isinstance(self.load, UniformDisc)] if graded else _ROUND_ERROR


@dataclass(frozen=True, slots=True)
class CellSource:
    """A pressure on cells; `own_error` is what its pressure itself may be off, over the largest."""

    cells: Cells
    own_error: float = 0.0

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress, displacement and error at points of one body."""
        stress, displacement, error = cell_fields(self.cells, at, x, y, direction)
        return stress, displacement, error + self.own_error


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
        else:
            pressure, traction_of_cells = load.cells
            cells = Cells(pressure, traction_of_cells + friction * pressure, load.spacing, load.center)
            found.append(CellSource(cells))
    return found


def contact_sources(
    medium: Any,
    indenter: Any,
    given: dict[str, Any],
    method: MethodName | None,
    friction: float,
    *,
    work_of_adhesion: float | None = None,
    **options: Any,
) -> tuple[list[Source], dict[str, Any]]:
    """Source of a contact, and what a result says about it: depth, force, radius, method, notes."""
    if method == "bem" or not getattr(indenter, "round", False):
        return _on_cells(medium, indenter, given, method, friction, work_of_adhesion, options)
    curve = indent(medium, indenter, method=method, work_of_adhesion=work_of_adhesion, **given, **options)
    about = _about(curve)
    if not about["radius"] > 0:
        return [Nothing()], about
    kernel = compliance(medium)
    edge = work_of_adhesion is not None or isinstance(indenter, Cylinder)
    load = contact_load(kernel, indenter, about["radius"], about["depth"], edge=edge)
    return [RoundSource(load, 1.0, friction)], about


def _about(curve: Any) -> dict[str, Any]:
    if curve.sizes["step"] != 1:
        raise ValueError(
            f"{curve.attrs['control']} has {curve.sizes['step']} values; fields belong to one contact. Give one of them."
        )
    solved = {name: float(curve[name].values[0]) for name in ("depth", "force", "radius")}
    return {
        **solved,
        "method": curve.attrs["method"],
        "valid": int(curve["valid"].values[0]),
        "notes": curve.attrs["notes"],
    }


def _on_cells(
    medium: Any,
    indenter: Any,
    given: dict[str, Any],
    method: MethodName | None,
    friction: float,
    work: float | None,
    options: dict[str, Any],
) -> tuple[list[Source], dict[str, Any]]:
    """Source of a contact whose pressure is known on cells."""
    if work is not None:
        raise ValueError(
            "work_of_adhesion goes with round tips: the adhesive pressure of others is not computed, nor with method='bem'."
        )
    if method in (None, "bem"):
        return _boundary_elements(medium, indenter, given, friction, options)
    curve = indent(medium, indenter, method=method, **given, **options)
    about = _about(curve)
    if not about["radius"] > 0:
        return [Nothing()], about
    half = float(np.nanmax(curve["contour"].values[0])) * (1 + 4 / _SUPERPOSED)
    if not np.isfinite(half):
        raise ValueError(
            f"method = {method!r} finds no outline here, so its pressure cannot be sampled. Choose method='bem'."
        )
    h = 2 * half / _SUPERPOSED
    # the mean of two by two points in each cell, scaled to the force
    fine = (np.arange(2 * _SUPERPOSED) - (2 * _SUPERPOSED - 1) / 2) * h / 2
    sampled = pressure(medium, indenter, fine[None, :], fine[:, None], method=method, **given, **options)
    sampled = np.where(np.isfinite(sampled), sampled, 0.0).reshape(_SUPERPOSED, 2, _SUPERPOSED, 2).mean(axis=(1, 3))
    sampled *= about["force"] / (sampled.sum() * h**2)
    # force and outline are estimated, the superposed pressure is no better than both together
    error = sum(float(curve[name].values[0]) for name in ("force_error", "contour_error") if name in curve)
    return [CellSource(Cells(sampled, friction * sampled, h, (0.0, 0.0)), error)], about


def _boundary_elements(
    medium: Any, indenter: Any, given: dict[str, Any], friction: float, options: dict[str, Any]
) -> tuple[list[Source], dict[str, Any]]:
    """Source of a contact solved by boundary elements; a mean radius is turned into a depth by the fast method."""
    control = control_from(**given)
    if control.values.size != 1:
        raise ValueError(
            f"{control.name} has {control.values.size} values; fields belong to one contact. Give one of them."
        )
    if control.name == "radius":
        control = Control("depth", indent(medium, indenter, radius=control.values)["depth"].values)
    unknown = set(options) - {"grid", "tolerance", "limit"}
    if unknown:
        raise TypeError(
            f"{', '.join(sorted(unknown))} is no setting here: boundary elements have grid, tolerance and limit."
        )
    if control.values[0] == 0:
        return [Nothing()], {"depth": 0.0, "force": 0.0, "radius": 0.0, "method": "bem", "valid": 1, "notes": ""}
    targets: dict[str, Any] = {"depths" if control.name == "depth" else "forces": control.values}
    settings: dict[str, Any] = {"grid": _SAMPLED, "tolerance": 1e-6, **options}
    (solution,) = bem.solve(compliance(medium), indenter, **targets, **settings)
    about = {
        "depth": solution.depth,
        "force": solution.force,
        "radius": solution.radius,
        "method": "bem",
        "valid": int(solution.converged),
        "notes": "\n".join(solution.notes),
    }
    grid, values = solution.grid, solution.pressure
    return [CellSource(Cells(values, friction * values, grid.spacing, grid.center))], about
