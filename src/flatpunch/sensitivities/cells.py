"""Contacts on cells: the weights over the wavenumber from the correlation of two pressures.

With Q(D) the correlation of p* and p at the distance vector D, the angular mean of P* P is the sum of Q J_0(k |D|): one sum over
the different distances on the grid, exact in the angle. A pressure acts through its mean displacement of a cell, which at
wavelengths beyond a few cells is sin(kh/2)/(kh/2) of that at its centre.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from flatpunch import bem
from flatpunch._support.checks import AT_ONCE, Array, Indices
from flatpunch._support.paths import Plain
from flatpunch.bem.grid import IndenterHeight
from flatpunch.bem.solution import reaches_end
from flatpunch.compliances import Kernel
from flatpunch.compliances.layered import SATURATION
from flatpunch.contact.curve import FEW_ANGLES, Control
from flatpunch.contact.methods import BoundaryElements
from flatpunch.indenters.geometry.features import beside_flat_end
from flatpunch.indenters.profile import Indenter
from flatpunch.media.paths import with_values
from flatpunch.punch.wavenumbers import composite_gauss, panel_edges
from flatpunch.sensitivities.parameters import Parameter, difference
from flatpunch.sensitivities.round import Spectrum, first_panel


@dataclass(frozen=True, slots=True)
class CellContact:
    """A contact solved on cells, and the flat punch on the same cells.

    Attributes
    ----------
    solution : bem.Solution
        The contact.
    punch : ndarray, shape (ny, nx)
        Pressure of the flat punch on the same cells per depth [Pa/m].
    stiffness : float
        dF/dd [N/m], from contacts of other depths: that of the punch is up to 3e-3 off, as its pressure is singular at the edge.
    """

    solution: bem.Solution
    punch: Array
    stiffness: float

    @property
    def missing(self) -> float:
        """What the stiffness exceeds that of the punch on the cells by [N/m]."""
        return self.stiffness - float(self.punch.sum()) * self.solution.grid.cell_area


_STEP = 0.03
"""Change of ln d over which forces on cells give the stiffness: twice as much changes it by 1e-4 under stiff films, half as much
by 2e-5, and cells that join the contact leave about as much."""


def cell_contact(kernel: Kernel, indenter: Indenter, control: Control, method: BoundaryElements) -> CellContact:
    """Solve one contact on cells, and the flat punch under it."""
    solution = _solved(kernel, indenter, method, **{"depths" if control.name == "depth" else "forces": control.values})
    flat = bem.solve_punch(kernel, solution.contact, solution.grid, **_accuracy(method), angles=FEW_ANGLES)
    pressure = np.asarray(flat.pressure) * solution.contact
    if isinstance(method.grid, bem.Grid):
        # cells that stay while the contact grows join it one by one: forces scatter more than the punch is off
        return CellContact(solution, pressure, flat.force)
    try:
        less, more = (
            _solved(kernel, indenter, method, depths=depth) for depth in solution.depth * np.exp([-_STEP, _STEP])
        )
    except ValueError:
        # the tip ends at this depth: the punch alone is left
        return CellContact(solution, pressure, flat.force)
    growth = float(np.log(more.force / less.force)) / (2 * _STEP)
    return CellContact(solution, pressure, solution.force / solution.depth * growth)


def spectrum_of_cells(kernel: Kernel, contact: CellContact, reach: float | None = None) -> Spectrum:
    """Weights of the force at fixed depth, as far as layers act, and up to k times the half-width = `reach` at least."""
    grid = contact.solution.grid
    distances, pairs = _correlation(contact.punch, contact.solution.pressure)
    h = grid.spacing
    a = h * float(np.sqrt(distances[-1])) / 2
    # wavenumber times the width of a cell at which all integrals end
    last = 4.0 * a / h
    if not kernel.graded:
        # wavenumber times the length of a homogeneous surface layer at which integrals end: exp(-24) of the layers' response is
        # left
        felt = 0.0 if kernel.homogeneous else kernel.cutoff * a / kernel.length * 12.0 / SATURATION
        last = min(last, max(4.0, felt, reach or 0.0))
    first = 0
    if not kernel.homogeneous:
        floor = kernel.series.floor if kernel.series is not None else kernel.floor
        first = first_panel(floor * a / kernel.length)
    x, w = composite_gauss(panel_edges(first, last))
    k = x / a
    mean = np.empty(k.size)
    step = max(1, AT_ONCE // distances.size)
    r = h * np.sqrt(distances)
    for start in range(0, k.size, step):
        some = slice(start, start + step)
        mean[some] = scipy.special.j0(np.outer(k[some], r)) @ pairs
    smeared = np.sinc(k * h / (2 * np.pi))
    weights = -(w / a) * k * mean * smeared * h**4 / (2 * np.pi)
    return Spectrum(k, weights[None], np.array([-contact.solution.force]))


def _correlation(first: Array, second: Array) -> tuple[Indices, Array]:
    """Squares of the different distances between cells [cells^2], ascending, and the sums of first times second over them."""
    rows, columns = np.flatnonzero(second.any(axis=1)), np.flatnonzero(second.any(axis=0))
    window = np.ix_(range(rows[0], rows[-1] + 1), range(columns[0], columns[-1] + 1))
    first, second = first[window], second[window]
    ny, nx = first.shape
    shape = tuple(scipy.fft.next_fast_len(2 * n - 1, real=True) for n in (ny, nx))
    spectrum = np.conj(scipy.fft.rfft2(first, shape)) * scipy.fft.rfft2(second, shape)
    product = scipy.fft.irfft2(spectrum, shape)
    dy, dx = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    square = dy[:, None] ** 2 + dx[None, :] ** 2
    inside = (dy[:, None] < ny) & (dx[None, :] < nx)
    total = np.bincount(square[inside], weights=product[inside])
    found = np.flatnonzero(np.bincount(square[inside]))
    return found, np.asarray(total[found], dtype=float)


def force_by_tip(
    kernel: Kernel, indenter: Indenter, contact: CellContact, method: BoundaryElements, wanted: list[Parameter]
) -> Array:
    """Derivatives of the force at fixed depth by numbers of the tip: minus the work of p* on the change of the shape.

    What p* misses at the edge acts there. Its work on the shape f itself is known, K d - F; that on a change of the shape is
    taken in proportion to the change along the rim. Beside a flat end, along a straight one, and where the tip itself ends, most
    of the rim is near an edge, at a place that cells do not know: derivatives are differences of forces.
    """
    solution = contact.solution
    found = np.empty(len(wanted))
    ended = reaches_end(IndenterHeight(indenter)(solution.grid), np.asarray(solution.contact))
    if ended or not indenter.rising or beside_flat_end(indenter, np.array([solution.radius]))[0]:
        for column, parameter in enumerate(wanted):
            steps, forces = [0.0], [solution.force]
            for step in (-_STEP, _STEP):
                try:
                    other = with_values(None, indenter, {parameter.path: parameter.value * np.exp(step)})[1]
                except ValueError:
                    # the end of the range of the number
                    continue
                steps.append(step)
                forces.append(_solved(kernel, other, method, depths=solution.depth).force)
            first = len(steps) // 3
            growth = np.log(forces[-1] / forces[first]) / (steps[-1] - steps[first])
            found[column] = solution.force * growth / parameter.value
        return found
    r, phi = (values[solution.contact] for values in solution.grid.polar)
    weight = contact.punch[solution.contact] * solution.grid.cell_area
    # the stresses at the edge are as its pressure, and their work as the square
    at_rim = np.where(scipy.ndimage.binary_erosion(solution.contact)[solution.contact], 0.0, weight**2)
    at_rim *= contact.missing * solution.depth / float(at_rim @ indenter.height(r, phi))
    for column, parameter in enumerate(wanted):

        def height(value: float, name: str = parameter.path) -> Array:
            return np.asarray(with_values(None, indenter, {name: value})[1].height(r, phi))

        found[column] = -float((weight + at_rim) @ difference(height, parameter.value, parameter.step))
    return found


def _solved(kernel: Kernel, indenter: Indenter, method: BoundaryElements, **target: Any) -> bem.Solution:
    (solution,) = bem.solve(kernel, indenter, **target, grid=method.grid, **_accuracy(method))
    return solution


def _accuracy(method: BoundaryElements) -> Plain:
    """Derivatives take the pressure itself, not only the force, so that gap errors are small."""
    return {"tolerance": 1e-8 if method.tolerance is None else method.tolerance, "limit": method.limit}
