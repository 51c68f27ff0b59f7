"""Contact curves through a few boundary element solutions: their accuracy at the cost of an interpolation.

Standard tips on one layer on a rigid base have their solutions in a table that comes with the package.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flatpunch._support.checks import ROUNDING, Array
from flatpunch._support.prefixes import text
from flatpunch.bem import NotConverged
from flatpunch.bem.curves import DEFAULT_CELLS
from flatpunch.bem.outline import enough_rays
from flatpunch.compliances import Kernel
from flatpunch.contact.boundary_elements.error import along_rays, located
from flatpunch.contact.curve import FORCE_ERROR, UNITS, Control, Curve, first_failure
from flatpunch.contact.limits import cut_off
from flatpunch.contact.perturbation import first_order
from flatpunch.contact.perturbation.error import estimates
from flatpunch.contact.refined.interpolation import Interpolation
from flatpunch.contact.refined.refinement import Refinement, refinement
from flatpunch.contact.refined.table import ANGLES, tabulated
from flatpunch.indenters.geometry.features import flat_radius
from flatpunch.indenters.profile import Indenter


def solve(
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    phi: Array,
    *,
    rtol: float = FORCE_ERROR,
    cells: int | None = None,
    cache: str | None = None,
) -> Curve:
    """A whole curve; round indenters are solved exactly.

    Parameters
    ----------
    kernel, indenter, control, phi
        Medium, indenter, prescribed values, and polar angles of the outline.
    rtol : float
        Relative error of the force that the interpolation may have. Below 5e-4 the table that comes with the package is not used.
    cells : int, optional
        Cells per side of the boundary element grids, 256 by default.
    cache : str, optional
        Folder in which the solutions are kept.
    """
    # a mean radius up to that of a flat end takes no depth
    still = (control.name == "radius") & (control.values <= flat_radius(indenter))
    live = np.asarray((control.values > 0) & ~still)
    if indenter.round:
        return first_order.solve(kernel, indenter, control, phi)
    if not live.any():
        nothing = first_order.solve(kernel, indenter, Control(control.name, np.zeros_like(control.values)), phi)
        radius = np.where(still, control.values, 0.0)
        return replace(nothing, radius=radius, area=np.pi * radius**2)
    # outlines are traced on the rays that are asked for: in between they may turn
    rays = ANGLES if ANGLES % phi.size == 0 else enough_rays(phi.size)
    solutions = refinement(kernel, indenter, rays, cells or DEFAULT_CELLS, cache)
    try:
        x, curve = _positions(kernel, indenter, solutions, Control(control.name, control.values[live]), rtol)
    except NotConverged as error:
        raise NotConverged(
            f"{control.name} up to {text(float(control.values.max()), UNITS[control.name])}: {error}"
        ) from None
    found = curve.at(x)

    def filled(values: Array) -> Array:
        whole = np.zeros((live.size, *values.shape[1:]))
        whole[live] = values
        return whole

    depth, force = filled(np.exp(x)), filled(kernel.modulus * np.exp(found.force))
    radius, area = np.exp(found.shape[:, 0]), np.pi * np.exp(2 * found.shape[:, 1])
    contour = filled(_outlines(found.shape[:, 2:], phi))
    radius, area = filled(radius), filled(area)
    if control.name == "radius":
        radius, area = control.values, np.where(still, np.pi * control.values**2, area)
    contour_error = along_rays(filled(found.shape_error), contour)
    untraced = np.asarray(~np.isfinite(contour).all(axis=1))
    notes = first_failure(
        untraced,
        depth,
        "the contact has holes or several parts, so it has no outline a(phi); the radius is the mean length of rays in contact.",
    )
    notes += tuple(dict.fromkeys(note for sample in curve.samples for note in sample.notes))
    return Curve(
        depth=control.values if control.name == "depth" else depth,
        force=control.values if control.name == "force" else force,
        radius=radius,
        area=area,
        stiffness=filled(found.growth) * force / np.where(live, depth, 1.0),
        contour=contour,
        valid=np.isfinite(filled(found.force_error)) & located(contour_error),
        notes=notes + cut_off(indenter, contour, phi, depth),
        extra=estimates(filled(found.force_error), np.where(untraced, np.inf, contour_error)),
    )


def covered(kernel: Kernel, indenter: Indenter, control: Control) -> bool:
    """Whether the table that comes with the package has all steps, so that no boundary elements are needed."""
    table = tabulated(kernel, indenter)
    return table is not None and bool(_logarithms(kernel, control).max() <= _largest(table, control))


def _positions(
    kernel: Kernel, indenter: Indenter, solutions: Refinement, control: Control, rtol: float
) -> tuple[Array, Interpolation]:
    """ln d of contacts with the prescribed values > 0, shape (n,), and the curve that has them."""
    wanted = _logarithms(kernel, control)
    if rtol >= FORCE_ERROR and covered(kernel, indenter, control):
        curve = tabulated(kernel, indenter)
        assert curve is not None
    elif control.name == "depth":
        curve = solutions.along_depths(wanted, rtol)
    else:
        curve = solutions.enclosing(control.name, wanted, rtol)
    return (wanted if control.name == "depth" else curve.positions(control.name, wanted)), curve


def _logarithms(kernel: Kernel, control: Control) -> Array:
    """ln d, ln F/E* or ln a0 of prescribed values, -inf for zero; depths that differ by rounding are the same."""
    with np.errstate(divide="ignore"):
        logarithm = np.log(control.values / (kernel.modulus if control.name == "force" else 1.0))
    return np.asarray(ROUNDING * np.round(logarithm / ROUNDING) if control.name == "depth" else logarithm)


def _largest(table: Interpolation, control: Control) -> float:
    """Largest such logarithm in a table."""
    last = table.samples[-1]
    return {"depth": float(table.nodes[-1]), "force": last.force, "radius": float(last.shape[0])}[control.name]


def _outlines(logarithm: Array, phi: Array) -> Array:
    """a(phi) at other angles, shape (n, p), from ln a at equal angles, linear in between."""
    count = logarithm.shape[1]
    place = np.mod(phi, 2 * np.pi) / (2 * np.pi) * count
    left = np.floor(place + 1e-9).astype(int)
    share = np.maximum(place - left, 0.0)
    return np.asarray(np.exp(logarithm[:, left % count] * (1 - share) + logarithm[:, (left + 1) % count] * share))
