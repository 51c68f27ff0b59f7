"""The second-order theory corrected by a few boundary element solutions: their accuracy at its speed (T9.3)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from flatpunch._validation import Array, positive
from flatpunch.compliance import Kernel
from flatpunch.contact import first_order
from flatpunch.contact.causes import steepness
from flatpunch.contact.control import Loading
from flatpunch.contact.correction import (
    AREA,
    FORCE,
    OUTLINE,
    RADIUS,
    Ratios,
    correction,
    end_error,
    reference_outline,
    tabulated,
)
from flatpunch.contact.curve import Control, Curve, first_failure
from flatpunch.contact.error_estimate import beside_flat_end, estimates
from flatpunch.contact.expansion import PathPoint, PerturbedContact
from flatpunch.contact.perturbed import Series, controlled, superpose_expansion
from flatpunch.contact.second_order import expansion_of
from flatpunch.contact.tabulated import FORCE_ERROR as TABLE_ERROR
from flatpunch.contact.tabulated import tabulated_rows
from flatpunch.indenters.profile import Indenter

_ANGLES, _CELLS = 360, 256
_EDGE_ERROR = 0.5
"""Force error of the grid times the cells per side where the pressure is still nearly singular at the edge of a flat end."""


class RefinedExpansion:
    """The second-order series times its corrections, with the interface of a series.

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
        self.series: Series = expansion_of(kernel, indenter)
        self.base, self.rtol = self.series.base, rtol
        self.table = tabulated_rows(kernel, indenter) if tables and rtol >= TABLE_ERROR else None
        self.correction = correction(kernel, indenter, self.series, _ANGLES, cells, folder)

    def ratios(self, radius: Array) -> Ratios:
        """Corrections at base radii, those of the smallest positive one at zero."""
        live = radius[radius > 0]
        places = np.where(radius > 0, radius, live.min() if live.size else 1.0)
        if self.table is not None and places.max() <= np.exp(self.table.nodes[-1]):
            return tabulated(self.table, places)
        return self.correction.at(places, self.rtol)

    def descent(self, radius: Array) -> Loading:
        """Depth and its derivative at base radii, shape (n,): those of the series."""
        return self.series.descent(radius)

    def loading(self, radius: Array) -> PathPoint:
        """Depth, force and their derivatives at base radii, shape (n,)."""
        ratios = self.ratios(radius)
        series = self.series.unperturbed if ratios.over_base else self.series.loading
        return self._corrected(radius, series(radius), ratios)

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at base radii, shape (n,)."""
        return self.evaluate_with(radius, self.ratios(radius))

    def evaluate_with(self, radius: Array, ratios: Ratios) -> PerturbedContact:
        """The same with ratios that are known already."""
        contact = self.series.evaluate(radius)
        path = self._corrected(radius, self.series.unperturbed(radius) if ratios.over_base else contact, ratios)
        return replace(
            contact,
            force=path.force,
            stiffness=path.stiffness,
            mean_radius=radius * np.exp(ratios.values[:, RADIUS]),
            area=np.pi * radius**2 * np.exp(ratios.values[:, AREA]),
        )

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Outlines a(phi), shape (n, p); the correction is interpolated linearly between its angles."""
        return self.corrected_outline(contact, self.ratios(contact.radius), phi)

    def corrected_outline(self, contact: PerturbedContact, ratios: Ratios, phi: Array) -> Array:
        """The same with ratios that are known already."""
        shape = reference_outline(self.series, contact, phi)
        logs = ratios.values[:, OUTLINE:]
        if phi.size == _ANGLES and np.array_equal(phi, np.arange(_ANGLES) * (2 * np.pi / _ANGLES)):
            shape *= np.exp(logs)
            return shape
        position = np.mod(phi, 2 * np.pi) / (2 * np.pi) * _ANGLES
        left = np.floor(position).astype(int) % _ANGLES
        share = position - np.floor(position)
        return np.asarray(shape * np.exp(logs[:, left] * (1 - share) + logs[:, (left + 1) % _ANGLES] * share))

    def _corrected(self, radius: Array, path: Loading, ratios: Ratios) -> PathPoint:
        factor = np.exp(ratios.values[:, FORCE])
        slope = np.where(path.depth_slope > 0, path.depth_slope, 1.0)
        stiffness = factor * (path.stiffness + path.force * ratios.slopes[:, FORCE] / slope)
        return PathPoint(radius, path.depth, factor * path.force, stiffness, path.depth_slope)


def solve(
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    phi: Array,
    *,
    rtol: float = 5e-4,
    cells: int = _CELLS,
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
    cells : int
        Cells per side of their grids.
    cache : path, optional
        Folder in which the solutions are kept, so that a later session need not repeat them.
    tables : bool
        Whether the corrections of standard tips on one layer that come with the package may replace solutions; they hold
        the force to 0.02 %.
    """
    rtol = positive("rtol", rtol)
    if indenter.round:
        return first_order.solve(kernel, indenter, control, phi)
    if not (control.values > 0).any():
        return first_order.solve(kernel, indenter, control, phi)
    expansion = RefinedExpansion(kernel, indenter, rtol, cells, _folder(cache), tables)
    contact, ratios = _controlled(kernel, indenter, expansion, control)
    traced = ratios.traced
    contour = expansion.corrected_outline(contact, ratios, phi)
    shape_error = ratios.outline_error + end_error(indenter, contour, contact.mean_radius, cells)
    contour[~traced] = np.nan
    notes = first_failure(
        ~traced,
        contact.depth,
        "the contact has holes or several parts, so it has no outline a(phi); the radius is that of a disc of equal area.",
    )
    notes += tuple(expansion.correction.notes)
    notes += steepness(indenter, contact.mean_radius, contact.depth)
    return Curve(
        depth=contact.depth,
        force=contact.force,
        radius=contact.mean_radius,
        area=contact.area,
        stiffness=contact.stiffness,
        contour=contour,
        valid=np.ones(contact.depth.size, dtype=bool),
        notes=notes,
        extra=estimates(
            ratios.error + _EDGE_ERROR / cells * beside_flat_end(indenter, contact.radius),
            np.where(traced, shape_error, np.inf),
        ),
    )


def _folder(cache: str | Path | None) -> str | None:
    return None if cache is None else str(cache)


def pressure(
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    r: Array,
    phi: Array,
    *,
    rtol: float = 5e-4,
    cells: int = _CELLS,
    cache: str | Path | None = None,
    tables: bool = True,
) -> Array:
    """Pressure at polar coordinates (r, phi), each of shape (n,) [Pa]."""
    if indenter.round:
        return first_order.pressure(kernel, indenter, control, r, phi)
    expansion = RefinedExpansion(kernel, indenter, positive("rtol", rtol), cells, _folder(cache), tables)
    return superpose_expansion(kernel, indenter, expansion, control, r, phi)


def covered(kernel: Kernel, indenter: Indenter, control: Control) -> bool:
    """Whether the corrections that come with the package answer these steps, without any boundary elements."""
    if tabulated_rows(kernel, indenter) is None:
        return False
    expansion = RefinedExpansion(kernel, indenter, TABLE_ERROR, _CELLS)
    assert expansion.table is not None
    end = expansion.evaluate(np.exp(expansion.table.nodes[-1:] - 1e-9))
    last = {"depth": end.depth, "force": end.force, "radius": end.mean_radius}[control.name]
    return bool(control.values.max() < last[0])


def _controlled(
    kernel: Kernel, indenter: Indenter, expansion: RefinedExpansion, control: Control
) -> tuple[PerturbedContact, Ratios]:
    """Contacts at the prescribed values; boundary elements are spent only on the range that these need."""
    first = controlled(kernel, indenter, expansion.series, control)
    if control.name == "depth":
        ratios = expansion.ratios(first.radius)
        return replace(expansion.evaluate_with(first.radius, ratios), depth=control.values), ratios
    contact = controlled(kernel, indenter, expansion, control)
    return contact, expansion.ratios(contact.radius)
