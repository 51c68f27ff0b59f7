"""Half-width of a needle under a sharp edge, from the load that it carries.

Across, a needle is a wedge of slope m pressed into a half-plane, whose load per length is q = E* m b whatever lies far away. What
is near bends the surface a little: with a curvature k of the gap besides, load and second moment of the pressure are

    q = E* (m b + pi/4 k b^2),    M = E* (m b^3/6 + pi/16 k b^4),

and with b_0 = q/(E* m) the half-width b is the root beside b_0 of b^3 - 3 b_0 b^2 + 12 M/(E* m) = 0. It is known to a fraction of
a cell, where counting cells is off by half of one along hundreds of them that are equally wide. A few cells have another moment
than the pressure that they stand for; which one, wedges on such cells tell.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from flatpunch._validation import Array, Flags
from flatpunch.bem.shape import IndenterHeight
from flatpunch.compliance import Kernel
from flatpunch.indenters.profile import Indenter

_BESIDE = 1e-6
"""Distance from the edge at which its slope is taken, over that from the point of first touch."""
_THIN = 0.25
"""Half-widths over the length of the medium up to which its surface is a half-plane's, but for a curvature."""
_MOST = 48
"""Cells of a half-width up to which their moment differs from the pressure's (there by 3e-4)."""


@dataclass(frozen=True, slots=True)
class Wedge:
    """The wedge that an edge is across.

    Attributes
    ----------
    stiffness : ndarray, shape (n,)
        E* m at places along the edge [Pa]: load per length over half-width.
    widest : float
        Half-width up to which this holds [m].
    """

    stiffness: Array
    widest: float

    def half_widths(self, places: Flags, spacing: float, load: Array, moment: Array) -> tuple[Array, Array]:
        """Half-widths without curvature and with it [m], shape (n,) each.

        Parameters
        ----------
        places : ndarray of bool
            Which of the places along the edge are meant.
        spacing : float
            Cells across [m].
        load, moment : ndarray, shape (n,)
            Sum of the pressure [Pa] over the cells of one side, and of their pressure times the square of their distance from
            the edge [Pa m^2].
        """
        b, wedge = 2 * load / self.stiffness[places], 2 * moment / self.stiffness[places] / spacing**2
        return spacing * b, spacing * _bent(b, wedge)


def wedge_of(kernel: Kernel, indenter: Indenter, angle: float, along: Array) -> Wedge | None:
    """The wedge at distances along an edge at a polar angle [m, rad]; None where the surface has no modulus of its own."""
    if kernel.exponent:
        return None
    phi = np.repeat(np.mod([angle, angle + _BESIDE], 2 * np.pi), along.size)
    on, beside = IndenterHeight(indenter).at(np.tile(along, 2), phi).reshape(2, -1)
    return Wedge(kernel.modulus * (beside - on) / (_BESIDE * along), _THIN * kernel.length)


def _bent(load: Array, moment: Array) -> Array:
    """Half-width with curvature of a wedge on cells, from 2 q/(E* m) and M/(E* m) of one side; in cells, shape (n,)."""
    loads, moments = _wedges_on_cells()
    # the pressure has the moment of its cells times that of a wedge over that of a wedge's cells
    straight = np.where(load < loads[-1], np.interp(load, loads, moments), load**3 / 6)
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.arccos(np.clip(1 - moment / straight, -1.0, 1.0))
    return np.nan_to_num(load * (1 + 2 * np.cos((2 * np.pi - turn) / 3)))


@cache
def _wedges_on_cells() -> tuple[Array, Array]:
    """Half-width and moment of wedges that just reach another cell on either side, in cells; between, the moment is linear."""
    y = np.arange(_MOST + 1) + 0.5

    def logarithm(distance: Array) -> Array:
        """Integral of ln|distance - eta| over a cell."""
        ends = distance + 0.5, distance - 0.5
        upper, lower = (end * np.log(np.maximum(np.abs(end), np.finfo(float).tiny)) for end in ends)
        return np.asarray(upper - lower - 1)

    sinking = -2 / np.pi * (logarithm(y[:, None] - y) + logarithm(y[:, None] + y))
    found = [(0.0, 0.0)]
    for cells in range(1, _MOST + 1):
        # as many pressures and the depth, from the centres of these cells and of the next
        system = np.column_stack([sinking[: cells + 1, :cells], -np.ones(cells + 1)])
        pressure = np.linalg.solve(system, -y[: cells + 1])[:-1]
        found.append((2 * pressure.sum(), 2 * pressure @ y[:cells] ** 2))
    loads, moments = np.array(found).T
    return loads, moments
