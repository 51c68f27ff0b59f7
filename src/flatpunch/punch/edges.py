"""Edge intensities of flat-punch pressures for power-law displacements, harmonic by harmonic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.punch.family import punch_family
from flatpunch.punch.harmonics import Edges, solve_edges
from flatpunch.punch.matrix import edge_strength
from flatpunch.punch.power_law import PowerLawPunch, power_law_punch


@dataclass(frozen=True, slots=True)
class PowerLawEdges:
    """Edge functionals of a power-law half-space, in closed form, with the interface of `Edges`.

    Attributes
    ----------
    punch : PowerLawPunch
        The closed forms.
    strength : ndarray, shape (nb,)
        Edge strengths e of the flat punches.
    """

    punch: PowerLawPunch
    strength: Array

    def stiffening(self, orders: Indices) -> Array:
        """k_m = (m - 1)(1 - k)/2, shape (nb, len(orders))."""
        return np.repeat([[self.punch.stiffening(int(m)) for m in orders]], self.strength.size, axis=0)

    def power_edge(self, exponent: float, orders: Indices) -> Array:
        """S of the pressure for r^n cos(m phi): R_m e D1, shape (nb, len(orders))."""
        response = np.array([self.punch.outline_response(exponent, int(m)) for m in orders])
        return np.asarray(self.strength[:, None] * response * exponent * self.punch.power_depth(exponent))


@dataclass(frozen=True, slots=True)
class KnownEdges:
    """Edge functionals read from a table for certain orders and one exponent, with the interface of `Edges`.

    Attributes
    ----------
    stiff, power : ndarray, shape (nb, orders)
        k_m, and S[A_m^-1 b[r^n]].
    """

    stiff: Array
    power: Array

    def stiffening(self, orders: Indices) -> Array:
        """k_m of the orders it was made for."""
        return self.stiff

    def power_edge(self, exponent: float, orders: Indices) -> Array:
        """S of the pressure for r^n cos(m phi), for the exponent and the orders it was made for."""
        return self.power


def known_edges(kernel: Kernel, beta: Array, orders: Indices, exponent: float) -> KnownEdges | None:
    """Edge functionals that are read from the medium's table, if it has one that holds them."""
    table = kernel.solution
    if table is None or not table.responds_to(exponent) or not beta.all() or not table.covers(beta):
        return None
    return KnownEdges(*table.edges(beta, orders, exponent))


def edges_of(kernel: Kernel, beta: Array, orders: Indices) -> Edges | PowerLawEdges:
    """Edge functionals at radii beta, shape (nb,); beta = 0 is the half-space of the surface material."""
    if kernel.exponent:
        return PowerLawEdges(power_law_punch(kernel), edge_strength(punch_family(kernel).at(beta)))
    return solve_edges(kernel, beta, orders) if beta.all() else Edges.half_space(beta.size)
