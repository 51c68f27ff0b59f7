"""Solved contacts as sources of fields: round ones exactly, all others by their pressure on cells."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import Array, BadValue
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact import BoundaryElements, FirstOrder, Method, indent, method_of, pressure
from flatpunch.contact.curve import Control
from flatpunch.contact.dataset import outlines
from flatpunch.contact.histories import control_with
from flatpunch.contact.limits import deepest
from flatpunch.contact.physics import Physics
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body
from flatpunch.stresses.axisymmetric.contact_load import contact_load
from flatpunch.stresses.cells import Cells
from flatpunch.stresses.sources import CellSource, Nothing, RoundSource, Source

if TYPE_CHECKING:
    import xarray as xr

_SAMPLED, _SUPERPOSED = 192, 128
"""Cells along each side of a contact that is no disc: of boundary elements, and of a superposed pressure, which is expensive."""


@dataclass(frozen=True, slots=True)
class Contact:
    """One contact to be solved, its arguments checked.

    Attributes
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them.
    indenter : Indenter
        What is pressed in.
    control : Control
        The one depth, force or radius.
    method : Method or None
        Contact method; None for the default.
    work : float or None
        Work of adhesion [J/m^2].
    """

    medium: Body
    indenter: Indenter
    control: Control
    method: Method | None = None
    work: float | None = None

    @property
    def kernel(self) -> Kernel:
        """Surface compliance of the medium."""
        return compliance(self.medium)

    @property
    def exact(self) -> bool:
        """Whether the fields are those of a round pressure, which is exact."""
        return self.indenter.round and not isinstance(self.method, BoundaryElements)


def contact_of(
    medium: Body,
    indenter: Indenter,
    given: Plain,
    method: str | Method | None = None,
    work_of_adhesion: float | None = None,
) -> Contact:
    """Check the arguments of one contact, before any work.

    Parameters
    ----------
    medium, indenter, method, work_of_adhesion
        As for `indent`.
    given : dict
        Values of depth, force and radius by name, all but one None.

    Raises
    ------
    ValueError, TypeError
        Names the argument.
    """
    check_indenter(indenter)
    chosen = None if method is None else method_of(method)
    compliance(medium)  # refuses what is no medium
    physics = Physics(work_of_adhesion)
    control = control_with(physics, chosen, indenter, **given)
    if work_of_adhesion is None:
        _check_depth(medium, control)
    if control.values.size != 1:
        raise ValueError(
            f"{control.name} has {control.values.size} values; fields belong to one contact. Give one of them."
        )
    return Contact(medium, indenter, control, chosen, physics.work_of_adhesion)


def _check_depth(medium: Body, control: Control) -> None:
    deep = deepest(medium)
    if control.name == "depth" and control.values.max() >= deep:
        raise BadValue(
            "depth",
            f"{text(float(control.values.max()), 'm')}",
            f"is more than the {text(deep, 'm')} of the layers on their rigid base: no tip gets there. Ask for "
            "less depth.",
        )


def contact_sources(contact: Contact, friction: float) -> tuple[list[Source], Plain]:
    """Source of a contact, and what a result says about it: depth, force, radius, method, notes."""
    if not contact.exact:
        if contact.work is not None:
            return _adhesive(contact, friction)
        if isinstance(contact.method, FirstOrder):
            return _superposed(contact, friction)
        return _boundary_elements(contact, friction)
    _, about = solved(contact)
    if not about["radius"] > 0:
        return [Nothing()], about
    edge = contact.work is not None or contact.indenter.flat
    make = partial(contact_load, contact.kernel, contact.indenter, about["radius"], about["depth"], edge=edge)
    load = make()
    # the force of the contact is known from moments of the tip, by another road
    apart = abs(load.force - about["force"]) / (np.pi * load.radius**2 * load.scale) if load.scale > 0 else 0.0
    return [RoundSource(load, 1.0, friction, again=partial(make, again=True), own_error=apart)], about


def solved(contact: Contact) -> tuple[xr.Dataset, Plain]:
    """A contact by `indent`, and its depth, force and radius with its method and notes."""
    target: Plain = {contact.control.name: contact.control.values}
    curve = indent(contact.medium, contact.indenter, method=contact.method, work_of_adhesion=contact.work, **target)
    numbers = {name: float(curve[name].values[0]) for name in ("depth", "force", "radius")}
    return curve, {
        **numbers,
        "method": curve.attrs["method"],
        "valid": int(curve["valid"].values[0]),
        "notes": curve.attrs["notes"],
    }


def _superposed(contact: Contact, friction: float) -> tuple[list[Source], dict[str, object]]:
    curve, about = solved(contact)
    if not about["radius"] > 0:
        return [Nothing()], about
    outline = outlines(curve)[0]
    half = float(outline.max()) * (1 + 4 / _SUPERPOSED)
    if not np.isfinite(outline).all():
        raise ValueError(
            "method = 'first-order' finds no outline here, so its pressure cannot be sampled. Choose method='bem'."
        )
    h = 2 * half / _SUPERPOSED
    # the mean of two by two points in each cell, scaled to the force
    fine = (np.arange(2 * _SUPERPOSED) - (2 * _SUPERPOSED - 1) / 2) * h / 2
    target: Plain = {contact.control.name: contact.control.values}
    sampled, error = pressure(
        contact.medium,
        contact.indenter,
        fine[None, :],
        fine[:, None],
        method=contact.method,
        return_error=True,
        **target,
    )
    sampled, error = (_joined(np.where(np.isfinite(values), values, 0.0)) for values in (sampled, error))
    share = float(error.max() / sampled.max())
    sampled *= about["force"] / (sampled.sum() * h**2)
    return [CellSource(Cells(sampled, friction * sampled, h, (0.0, 0.0)), share)], about


def _adhesive(contact: Contact, friction: float) -> tuple[list[Source], dict[str, object]]:
    """Source of an adhesive contact: its outline by `indent`, and the pressure that makes the surface follow the tip inside."""
    curve, about = solved(contact)
    outline = outlines(curve)[0]
    if not about["radius"] > 0:
        return [Nothing()], about
    if not np.isfinite(outline).all():
        raise ValueError(
            "The adhesive contact has no outline here, so its pressure is not known. Ask for another depth."
        )
    reach = float(outline.max()) * (1 + 8 / _SAMPLED)

    def cells(count: int) -> Cells:
        grid = bem.Grid(count, count, 2 * reach / count)
        r, phi = grid.polar
        mask = r < np.interp(phi, np.linspace(0, 2 * np.pi, outline.size + 1), np.append(outline, outline[0]))
        face = np.where(mask, contact.indenter.height(np.where(mask, r, 0.0), phi), 0.0)
        stuck = bem.solve_punch(contact.kernel, mask, grid, depth=about["depth"], face=face, tolerance=1e-6)
        return _cells(stuck, friction)

    fine = cells(_SAMPLED)
    # the outline is known to second order only, which the force on the cells shows
    share = abs(fine.force - about["force"]) / (float(curve["area"].values[0]) * float(np.abs(fine.pressure).max()))
    return [CellSource(fine, own_error=share, coarser=cells(_SAMPLED // 2))], about


def _joined(values: Array) -> Array:
    n = _SUPERPOSED
    return np.asarray(values.reshape(n, 2, n, 2).mean(axis=(1, 3)))


def _boundary_elements(contact: Contact, friction: float) -> tuple[list[Source], dict[str, object]]:
    """Source of a contact solved by boundary elements; a mean radius is turned into a depth by the contact method."""
    control = contact.control
    own = contact.method if isinstance(contact.method, BoundaryElements) else BoundaryElements()
    if control.name == "radius":
        fast = replace(contact, method=None) if contact.method is own else contact
        control = Control("depth", solved(fast)[0]["depth"].values)
    if control.values[0] == 0:
        return [Nothing()], {"depth": 0.0, "force": 0.0, "radius": 0.0, "method": "bem", "valid": 1, "notes": ""}
    solution, wider = _solutions(contact.kernel, contact.indenter, control, own)
    about = {
        "depth": solution.depth,
        "force": solution.force,
        "radius": solution.radius,
        "method": "bem",
        "valid": int(solution.converged),
        "notes": "\n".join(solution.notes),
    }
    fine, coarse = (None if each is None else _cells(each, friction) for each in (solution, wider))
    assert fine is not None
    return [CellSource(fine, coarser=coarse)], about


def _cells(solution: bem.Solution, friction: float) -> Cells:
    grid, values = solution.grid, solution.pressure
    return Cells(values, friction * values, grid.spacing, grid.center)


def _solutions(
    kernel: Kernel, indenter: Indenter, control: Control, own: BoundaryElements
) -> tuple[bem.Solution, bem.Solution | None]:
    """Boundary element solutions on the cells asked for, and on cells twice as wide for the estimate of the error."""
    grid = _SAMPLED if own.grid is None else own.grid
    settings: Plain = {"limit": own.limit, "single": own.single, control.name + "s": control.values}
    settings["tolerance"] = own.tolerance or (1e-5 if own.single else 1e-6)
    (solution,) = bem.solve(kernel, indenter, grid=grid, **settings)
    half = solution.grid.coarser()
    if half is None:
        return solution, None
    try:
        (wider,) = bem.solve(kernel, indenter, grid=half, **settings)
    except bem.ContactTouchesEdge:
        return solution, None
    return solution, wider
