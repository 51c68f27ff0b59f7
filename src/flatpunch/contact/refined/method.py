"""The round contact of the mean profile corrected by a few boundary element solutions: their accuracy at its speed (T9.4).

Second order in its place, and then corrected less, has been tried: it needs as many solutions to a twentieth, on layers costs as
much as the solutions it saves and more, and under stiff films it has poles. It stands beside the corrections that come with the
package, which need none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from flatpunch._support.ceilings import CELLS
from flatpunch._support.checks import Array, Flags, positive, whole
from flatpunch.bem.grid import SMALLEST
from flatpunch.compliance import Kernel
from flatpunch.contact.curve import Control, ControlName, Curve, first_failure
from flatpunch.contact.limits import cut_off, steepness
from flatpunch.contact.perturbation import first_order
from flatpunch.contact.perturbation.error import estimates
from flatpunch.contact.perturbation.perturbed_contact import PathPoint, PerturbedContact, selected
from flatpunch.contact.perturbation.series_method import controlled
from flatpunch.contact.refined.one_solution import FORCE, RADIUS
from flatpunch.contact.refined.round_series import round_series
from flatpunch.contact.refined.solutions import Correction, Refined, correction
from flatpunch.contact.refined.table import ANGLES, tabulated, tabulated_rows
from flatpunch.contact.refined.table import FORCE_ERROR as TABLE_ERROR
from flatpunch.contact.round.radius_search import Loading
from flatpunch.indenters.geometry.edges import wedges_of
from flatpunch.indenters.geometry.flat_end import beside_flat_end, flat_radius
from flatpunch.indenters.profile import Indenter

_Points = TypeVar("_Points", PerturbedContact, Refined)

_CELLS = 256
_FEWER, _EDGES, _STIFF, _LONG_WAVE = 192, 5, 2.0, 0.1
"""Cells per side for tips with at least so many edges, on films that make waves of this k h so many times as compliant: none of
so many needles carries much, and finer cells are laid along them anyway. Outlines of 38 such contacts are off by less than those
from 256 cells (0.62 for 0.68 % rms), forces by 1.6e-4 at most in the place of 1.2e-4."""
_EDGE_ERROR = 0.5
"""Force error of the grid times the cells per side where the pressure is still nearly singular at the edge of a flat end."""
_SHALLOW = 1e-4
"""Share of the largest depth below which mean radii are those of a flat end."""
_PHI = np.asarray(np.arange(ANGLES) * (2 * np.pi / ANGLES))


class RefinedExpansion:
    """Refined contacts over the radius of the round contact of equal depth, with the interface of a series.

    Parameters
    ----------
    kernel, indenter
        Medium and indenter.
    rtol : float
        Wanted relative interpolation error of the force.
    cells : int
        Cells per side of the boundary element grids.
    folder : str, optional
        Where their solutions are kept on disk.
    tables : bool
        Whether the corrections that come with the package may take their place.
    """

    def __init__(
        self,
        kernel: Kernel,
        indenter: Indenter,
        rtol: float,
        cells: int,
        folder: str | None = None,
        tables: bool = True,
    ) -> None:
        self.series = round_series(kernel, indenter)
        self.base, self.rtol = self.series.base, rtol
        self.table = tabulated_rows(kernel, indenter) if tables and rtol >= TABLE_ERROR else None
        self.correction = correction(kernel, indenter, self.series, ANGLES, cells, folder)

    def descent(self, radius: Array) -> Loading:
        """Depth and its derivative at base radii, shape (n,): those of the round contact."""
        return self.series.descent(radius)

    def loading(self, radius: Array) -> PathPoint:
        """Depth, force and their derivatives at base radii, shape (n,)."""
        return Sought(self).loading(radius)

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at base radii, shape (n,)."""
        contact = self.series.evaluate(radius)
        live = contact.depth > 0
        return corrected(contact, live, self.refined(selected(contact, live))) if live.any() else contact

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Outlines a(phi), shape (n, p)."""
        live = contact.depth > 0
        contour = np.zeros((live.size, phi.size))
        if live.any():
            some = self.series.evaluate(contact.radius[live])
            contour[live] = self.contour(self.refined(some), phi)
        return contour

    def refined(self, contact: PerturbedContact, nodes: Array | None = None, *, exactly: bool = False) -> Refined:
        """What boundary elements, or the table, say beside round contacts, shape (n,), all of positive depth.

        Solutions are those at `nodes`, if these are given. With `exactly` a few contacts have ones of their own.
        """
        if self.tabulated(contact):
            assert self.table is not None
            return tabulated(self.table, contact.radius)
        return self.correction.at(contact, self.rtol, nodes, exactly=exactly)

    @staticmethod
    def contour(refined: Refined, phi: Array) -> Array:
        """Outlines a(phi) of refined contacts, shape (n, p), their logarithms linear between angles."""
        logarithm = refined.shape[:, 2:]
        if phi.size == ANGLES and np.array_equal(phi, _PHI):
            return np.asarray(np.exp(logarithm))
        position = np.mod(phi, 2 * np.pi) / (2 * np.pi) * ANGLES
        left = np.floor(position).astype(int) % ANGLES
        share = position - np.floor(position)
        return np.asarray(np.exp(logarithm[:, left] * (1 - share) + logarithm[:, (left + 1) % ANGLES] * share))

    def tabulated(self, contact: PathPoint | PerturbedContact) -> bool:
        """Whether the corrections that come with the package reach that far."""
        return self.table is not None and bool(contact.radius.max() <= np.exp(self.table.nodes[-1]))


class Sought:
    """Forces and mean radii of refined contacts, by which those with prescribed ones are found.

    Parameters
    ----------
    expansion : RefinedExpansion
        The contacts.
    nodes : array, shape (n,), optional
        ln d of the solutions that they are interpolated between; else more are made wherever they are looked for.
    """

    def __init__(self, expansion: RefinedExpansion, nodes: Array | None = None) -> None:
        self.base, self._expansion, self._nodes = expansion.base, expansion, nodes

    def descent(self, radius: Array) -> Loading:
        """Depth and its derivative at base radii, shape (n,)."""
        return self._expansion.descent(radius)

    def loading(self, radius: Array) -> PathPoint:
        """Depth, force and their derivatives at base radii, shape (n,)."""
        path = self._expansion.series.loading(radius)
        live = path.depth > 0
        force, stiffness = np.array(path.force), np.array(path.stiffness)
        if live.any():
            some = selected(path, live)
            if self._expansion.tabulated(some):
                refined = self._refined(some.radius)
                force[live], stiffness[live] = refined.force, refined.stiffness
            else:
                force[live], stiffness[live], _ = self._correction.loading(some, self._expansion.rtol, self._nodes)
        return PathPoint(radius, path.depth, force, stiffness, path.depth_slope)

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at base radii, shape (n,), but for their areas."""
        path, contact = self.loading(radius), self._expansion.series.evaluate(radius)
        live, mean_radius = path.depth > 0, np.array(radius)
        if live.any():
            some = selected(path, live)
            mean_radius[live] = (
                np.exp(self._refined(some.radius).shape[:, 0])
                if self._expansion.tabulated(some)
                else self._correction.mean_radius(some, self._expansion.rtol, self._nodes)
            )
        return replace(contact, force=path.force, stiffness=path.stiffness, mean_radius=mean_radius)

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Outlines a(phi), shape (n, p)."""
        return self._expansion.outline(contact, phi)

    @property
    def _correction(self) -> Correction:
        return self._expansion.correction

    def _refined(self, radius: Array) -> Refined:
        return self._expansion.refined(self._expansion.series.evaluate(radius))


def corrected(contact: PerturbedContact, live: Flags, refined: Refined) -> PerturbedContact:
    """Round contacts with force, stiffness, radius and area refined where they are `live`."""
    found = {
        "force": refined.force,
        "stiffness": refined.stiffness,
        "mean_radius": np.exp(refined.shape[:, 0]),
        "area": np.pi * np.exp(2 * refined.shape[:, 1]),
    }
    values = {name: np.array(getattr(contact, name)) for name in found}
    for name, value in values.items():
        value[live] = found[name]
    return replace(contact, **values)


def solve(
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    phi: Array,
    *,
    rtol: float = 5e-4,
    cells: int | None = None,
    cache: str | Path | None = None,
    tables: bool = True,
) -> Curve:
    """A whole curve; round indenters are solved exactly.

    Parameters
    ----------
    kernel, indenter, control, phi
        Medium, indenter, prescribed values, and polar angles of the outline.
    rtol : float
        Relative error of the force that the interpolation between boundary element solutions may have.
    cells : int, optional
        Cells per side of their grids; 256, or 192 for tips with five or more edges on films stiffer than their base.
    cache : path, optional
        Folder in which the solutions are kept, so that a later session need not repeat them.
    tables : bool
        Whether the corrections of standard tips on one layer that come with the package may replace solutions; they hold
        the force to 0.02 %.
    """
    rtol, cells, folder = _settings(kernel, indenter, rtol, cells, cache)
    if indenter.round:
        return first_order.solve(kernel, indenter, control, phi)
    if not (control.values > 0).any():
        return first_order.solve(kernel, indenter, control, phi)
    still = _untouched(indenter, control)
    if still.any():
        options: dict[str, Any] = {"rtol": rtol, "cells": cells, "cache": cache, "tables": tables}
        radius = control.values
        curve = solve(kernel, indenter, Control("radius", np.where(still, 0.0, radius)), phi, **options)
        area = np.where(still, np.pi * radius**2, curve.area)
        return replace(curve, radius=np.where(still, radius, curve.radius), area=area)
    expansion = RefinedExpansion(kernel, indenter, rtol, cells, folder, tables)
    if expansion.table is None:
        expansion.correction.call_helpers(control.values.size)
    contact, refined = _contacts(kernel, indenter, expansion, control)
    if refined is None:
        return first_order.solve(kernel, indenter, control, phi)
    live = contact.depth > 0
    contact = corrected(contact, live, refined)
    if control.name == "force":
        contact = replace(contact, force=control.values)
    contour, traced = np.zeros((live.size, phi.size)), np.ones(live.size, dtype=bool)
    contour[live], traced[live] = expansion.contour(refined, phi), refined.traced
    force_error, shape_error = np.zeros(live.size), np.zeros(live.size)
    force_error[live] = refined.error + _EDGE_ERROR / cells * beside_flat_end(indenter, contact.radius[live])
    shape_error[live] = refined.shape_error
    contour[~traced] = np.nan
    notes = first_failure(
        ~traced,
        contact.depth,
        "the contact has holes or several parts, so it has no outline a(phi); the radius is the mean length of rays in contact.",
    )
    notes += tuple(expansion.correction.notes)
    notes += steepness(indenter, contact.mean_radius, contact.depth)
    notes += cut_off(indenter, contour, phi, contact.depth)
    return Curve(
        depth=contact.depth,
        force=contact.force,
        radius=contact.mean_radius,
        area=contact.area,
        stiffness=contact.stiffness,
        contour=contour,
        valid=np.ones(contact.depth.size, dtype=bool),
        notes=notes,
        extra=estimates(force_error, np.where(traced, shape_error, np.inf)),
    )


def _untouched(indenter: Indenter, control: Control) -> Flags:
    """Steps whose prescribed radius is no larger than a flat end, which takes no depth; shape (n,)."""
    return (control.name == "radius") & (control.values > 0) & (control.values <= flat_radius(indenter))


def _settings(
    kernel: Kernel, indenter: Indenter, rtol: float, cells: int | None, cache: str | Path | None
) -> tuple[float, int, str | None]:
    """Tolerance, cells and folder, checked."""
    if cache is not None and not isinstance(cache, str | PathLike):
        raise TypeError(f"cache = {cache!r} must be a folder, as text or Path; None keeps nothing on disk.")
    folder = None if cache is None else str(cache)
    if cells is None:
        many = len(wedges_of(indenter)) >= _EDGES
        cells = _FEWER if many and kernel.response(np.array([_LONG_WAVE]))[0] > _STIFF else _CELLS
    return (
        positive("rtol", rtol),
        whole("cells", cells, SMALLEST, "It is the number of cells per side.", most=CELLS),
        folder,
    )


def covered(kernel: Kernel, indenter: Indenter, control: Control) -> bool:
    """Whether the corrections that come with the package answer these steps, without any boundary elements."""
    if tabulated_rows(kernel, indenter) is None:
        return False
    expansion = RefinedExpansion(kernel, indenter, TABLE_ERROR, _CELLS)
    assert expansion.table is not None
    end = expansion.evaluate(np.exp(expansion.table.nodes[-1:] - 1e-9))
    last = {"depth": end.depth, "force": end.force, "radius": end.mean_radius}[control.name]
    return bool(control.values.max() < last[0])


def _contacts(
    kernel: Kernel, indenter: Indenter, expansion: RefinedExpansion, control: Control
) -> tuple[PerturbedContact, Refined | None]:
    """Round contacts at which the refined ones have the prescribed values, at exactly these depths or forces.

    And those refined ones that have a depth, None if none has.
    """
    if control.name == "depth":
        contact, nodes = controlled(kernel, indenter, expansion.series, control), None
    else:
        wanted, depth = _expected(kernel, indenter, expansion, control)
        if expansion.correction.sparse(depth):
            each = [
                _contacts(kernel, indenter, expansion, Control(control.name, value[None])) for value in control.values
            ]
            found = [refined for _, refined in each if refined is not None]
            return _joined([contact for contact, _ in each]), _joined(found) if found else None
        nodes = _nodes(kernel, expansion, control.name, wanted, depth) if depth.size else None
        contact = controlled(kernel, indenter, Sought(expansion, nodes), control)
        contact = replace(expansion.series.evaluate(contact.radius), depth=contact.depth)
    live = contact.depth > 0
    if not live.any():
        return contact, None
    # other controls have asked for the contacts around already
    return contact, expansion.refined(selected(contact, live), nodes, exactly=control.name == "depth")


def _joined(parts: Sequence[_Points]) -> _Points:
    """Contacts one after the other."""
    columns = {part.name: np.concatenate([getattr(some, part.name) for some in parts]) for part in fields(parts[0])}
    return replace(parts[0], **columns)


def _expected(kernel: Kernel, indenter: Indenter, expansion: RefinedExpansion, control: Control) -> tuple[Array, Array]:
    """Prescribed values in order, each once, and depths at which they are expected; none where these need not be known."""
    none = np.empty(0), np.empty(0)
    if expansion.table is not None and covered(kernel, indenter, control):
        return none
    wanted = np.unique(control.values[control.values > 0])
    if not wanted.size:
        return none
    try:
        depth = controlled(kernel, indenter, expansion.series, Control(control.name, wanted)).depth
    except ValueError:
        # round contacts may end before the others do; if these end too the search says so
        return none
    # radii below that of a flat end, or hardly above, tell no depth
    told = depth > (_SHALLOW * depth.max() if control.name == "radius" else 0.0)
    # under stiff films the depth of round contacts may turn back
    return wanted[told], np.maximum.accumulate(depth[told])


def _nodes(kernel: Kernel, expansion: RefinedExpansion, name: ControlName, wanted: Array, depth: Array) -> Array | None:
    """ln d of the solutions that carry forces or radii expected at some depths; None where the search has to find them."""
    column, ends = (FORCE, wanted / kernel.modulus) if name == "force" else (RADIUS, wanted)
    try:
        return expansion.correction.reaching(column, ends[[0, -1]], depth[[0, -1]], expansion.rtol)
    except ValueError:
        # beyond the end of the tip, or of what the medium resolves
        return None
