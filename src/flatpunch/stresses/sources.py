"""Sources of fields: round loads exactly, pressures on cells; those of solved contacts and of prescribed loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Protocol

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import ROUNDING, Array, Flags
from flatpunch._support.paths import Plain
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact import BoundaryElements, FirstOrder, Method, indent, method_of, pressure
from flatpunch.contact.curve import Control
from flatpunch.contact.dataset import outlines
from flatpunch.contact.histories import control_with
from flatpunch.contact.limits import check_deepest
from flatpunch.contact.physics import Physics
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body
from flatpunch.stresses.axisymmetric.contact_load import contact_load
from flatpunch.stresses.axisymmetric.panels import REACH, SECOND_REACH, RoundLoad, missing
from flatpunch.stresses.axisymmetric.radial import COMPONENTS
from flatpunch.stresses.axisymmetric.round_load import round_fields
from flatpunch.stresses.axisymmetric.uniform_disc import UniformDisc
from flatpunch.stresses.bodies import Located
from flatpunch.stresses.cells import Cells, cell_fields
from flatpunch.stresses.loads import DiscLoad, Load

if TYPE_CHECKING:
    import xarray as xr

_CHECKED = 4
"""Points at which round loads are calculated a second time: so many of those closest to the rim and to the middle of the load,
of those with the largest stresses, and of all."""


class Source(Protocol):
    """A load that knows its fields."""

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress (6, n), displacement (3, n), and the estimated error of stress over the size of the pressure."""


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
    again : callable, optional
        Makes the same load on other panels and by other rules; without it the load itself is known in closed form.
    own_error : float
        Error of the load itself, as a share of its scale.
    """

    load: RoundLoad
    pressure: float = 1.0
    traction: float = 0.0
    center: tuple[float, float] = (0.0, 0.0)
    again: Callable[[], RoundLoad] | None = None
    own_error: float = 0.0

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress, displacement and error at points of one body; the error as a share of the scale of the pressure."""
        x, y = x - self.center[0], y - self.center[1]
        found = self._at(self.load, at, x, y, direction, REACH)
        stress, displacement = found[:6], found[6:]
        r = np.hypot(x, y)
        stress[:, self._singular(r, at.depth)] = np.nan
        orders = np.hypot(r - self.load.radius, at.depth), np.hypot(r, at.depth), -np.abs(stress).max(axis=0)
        first = [np.argsort(each, kind="stable")[:_CHECKED] for each in orders]
        spread = np.linspace(0, x.size - 1, _CHECKED).astype(int)
        some = np.unique(np.concatenate([*first, spread]))
        part = replace(at, chosen=at.chosen[some], depth=at.depth[some], layer=at.layer[some])
        second = self.load if self.again is None else self.again()
        other = self._at(second, part, x[some], y[some], direction, SECOND_REACH)[:6]
        size = max(abs(self.pressure), abs(self.traction)) * self.load.scale
        with np.errstate(invalid="ignore"):
            apart = np.abs(other - stress[:, some]) * missing(at.body, self.load, r[some], part.depth)
        # infinite stresses agree
        error = float(apart[np.isfinite(apart)].max(initial=0.0))
        return stress, displacement, ROUNDING + self.own_error + (error / size if size > 0 else 0.0)

    def _singular(self, r: Array, depth: Array) -> Flags:
        """Points of the surface at a ring of infinite stress: of infinite pressure, or where a traction jumps."""
        rings = [edge.radius for edge in self.load.edges if edge.power < 0 or (edge.power == 0 and self.traction)]
        at_ring = np.isclose(r[:, None], rings, rtol=ROUNDING, atol=0.0).any(axis=1)
        return np.asarray(at_ring & (depth <= ROUNDING * self.load.radius))

    def _at(self, load: RoundLoad, at: Located, x: Array, y: Array, direction: float, reach: float) -> Array:
        return round_fields(
            load,
            at,
            x,
            y,
            pressure=self.pressure,
            # on the upper body the friction of the lower one acts backwards
            traction=-self.traction if at.upper else self.traction,
            direction=direction,
            reach=reach,
        )


@dataclass(frozen=True, slots=True)
class CellSource:
    """A pressure on cells.

    Attributes
    ----------
    cells : Cells
        Pressure and traction.
    own_error : float
        Error of the pressure over the largest, where it is known otherwise.
    coarser : Cells or None
        The same contact solved on cells twice as wide, for the estimate of the error.
    """

    cells: Cells
    own_error: float = 0.0
    coarser: Cells | None = None

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Stress, displacement and error at points of one body."""
        stress, displacement, error = cell_fields(self.cells, at, x, y, direction, self.coarser)
        return stress, displacement, error + self.own_error


@dataclass(frozen=True, slots=True)
class Nothing:
    """No contact."""

    def fields(self, at: Located, x: Array, y: Array, direction: float) -> tuple[Array, Array, float]:
        """Zero."""
        nothing = np.zeros((COMPONENTS, x.size))
        return nothing[:6], nothing[6:], 0.0


def prescribed_sources(loads: Sequence[Load], friction: float) -> list[Source]:
    """Sources of prescribed loads; friction adds to their own traction."""
    found: list[Source] = []
    for load in loads:
        if isinstance(load, DiscLoad):
            traction = load.traction + friction * load.pressure
            found.append(RoundSource(UniformDisc(load.radius), load.pressure, traction, load.center))
        else:
            pressure, traction_of_cells = load.cells
            along = traction_of_cells + friction * pressure
            found.append(CellSource(Cells(pressure, along, load.spacing, load.center, uniform=True)))
    return found


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
    if work_of_adhesion is None and control.name == "depth":
        check_deepest(medium, float(control.values.max()))
    if control.values.size != 1:
        raise ValueError(
            f"{control.name} has {control.values.size} values; fields belong to one contact. Give one of them."
        )
    return Contact(medium, indenter, control, chosen, physics.work_of_adhesion)


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
