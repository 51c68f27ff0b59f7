"""Sharp cones: the flank is a linear condition on the displacements, at a given contact radius A of the undeformed surface.

Nodes of the surface out to A are on the flank, z = s r - d. The edges of second-order elements are straight if their nodes are in
line, so that the whole surface is on the flank without a penalty, and there is no contact to search for. The depth d is unknown;
its equation is that no force acts on the node at A, where the contact ends. The flank is made steeper in steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from finite_strain.laws import TooFar
from finite_strain.solver import Body

ITERATIONS, SMALL = 25, 0.1
"""Most steps of Newton's method, and the first slope, from the linear solution."""
WIDTH, LEAST = 4.0, 0.1
"""First and least step of the angle [degrees]."""


@dataclass(frozen=True, slots=True)
class State:
    """Equilibrium under a cone.

    Attributes
    ----------
    unknowns : ndarray
        Displacements and pressures.
    slope : float
        Tangent of the angle between flank and surface.
    depth : float
        Depth.
    force : float
        Force over the shear modulus.
    radius : float
        Contact radius in the deformed state.
    """

    unknowns: np.ndarray
    slope: float
    depth: float
    force: float
    radius: float


class Flank:
    """A body whose surface is on a flank out to the radius `contact` of the undeformed state."""

    def __init__(self, body: Body, contact: float) -> None:
        self.body = body
        across, down, place = body.top
        order = np.argsort(place)
        order = order[: np.argmin(np.abs(place[order] - contact)) + 1]
        self.across, self.down, self.place = across[order], down[order], place[order]

    def spaces(self, slope: float) -> tuple[sp.csc_matrix, sp.csc_matrix]:
        """Matrices from the independent unknowns to all, and the directions in which forces vanish.

        In the first, nodes on the flank follow the last one, at the edge. In the second the edge moves by itself: d is given.
        """
        free, inner = np.setdiff1d(self.body.free, self.down[:-1]), self.down[:-1]
        size, number = (self.body.size, free.size), np.full(self.body.size, -1)
        number[free] = np.arange(free.size)
        moving = number[self.across[:-1]] >= 0
        rows, columns = inner[moving], number[self.across[:-1][moving]]
        test = sp.coo_matrix((np.ones(free.size), (free, number[free])), size)
        test += sp.coo_matrix((np.full(rows.size, slope), (rows, columns)), size)
        follow = sp.coo_matrix((np.ones(inner.size), (inner, np.full(inner.size, number[self.down[-1]]))), size)
        follow -= sp.coo_matrix(
            (np.full(inner.size, slope), (inner, np.full(inner.size, number[self.across[-1]]))), size
        )
        return (test + follow).tocsc(), test.tocsc()

    def equilibrium(self, start: np.ndarray, slope: float, *, small: bool = False) -> State:
        """Newton's method with shorter steps where elements would turn inside out."""
        trial, test = self.spaces(0.0 if small else slope)
        unknowns = start.copy()
        place = self.place + (0.0 if small else unknowns[self.across])
        unknowns[self.down] = unknowns[self.down[-1]] + slope * (place - place[-1])
        force, stiffness = self.body.forces(unknowns, small)
        for _ in range(ITERATIONS):
            step = -(trial @ splu((test.T @ stiffness @ trial).tocsc(), permc_spec="COLAMD").solve(test.T @ force))
            change = np.abs(step[: self.body.count]).max()
            step, force, stiffness = self.body.stepped(unknowns, step, small)
            unknowns = unknowns + step
            if change < 1e-9 * slope * self.place[-1]:
                break
        else:
            raise TooFar("Newton's method does not converge")
        radius = float(self.place[-1] + (0.0 if small else unknowns[self.across[-1]]))
        depth = float(slope * radius - unknowns[self.down[-1]])
        return State(unknowns, slope, depth, float(-2 * np.pi * force[self.down].sum()), radius)

    def steepened(self, angle: float) -> tuple[State, State]:
        """Equilibrium of linear theory, and at large strain.

        Parameters
        ----------
        angle : float
            Angle between flank and surface [degrees].
        """
        goal = float(np.tan(np.radians(angle)))
        linear = self.equilibrium(np.zeros(self.body.size), goal, small=True)
        first, width = min(goal, SMALL), WIDTH
        now = before = self.equilibrium(linear.unknowns * first / goal, first)
        while now.slope < goal:
            slope = min(goal, float(np.tan(np.arctan(now.slope) + np.radians(width))))
            share = (slope - now.slope) / (now.slope - before.slope) if before is not now else 0.0
            try:
                before, now = now, self.equilibrium(now.unknowns + share * (now.unknowns - before.unknowns), slope)
            except TooFar:
                width /= 2
                if width < LEAST:
                    raise
        return linear, now
