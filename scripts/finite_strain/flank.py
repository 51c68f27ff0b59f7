"""Cones, sharp or rounded: a condition on the displacements at a given contact radius A of the undeformed surface.

Nodes of the surface out to A are on the tip, z = f(r) - d. The edges of second-order elements are straight if their nodes are in
line, so that the whole surface is on a flank without a penalty, and there is no contact to search for. The depth d is unknown;
its equation is that no force acts on the node at A, where the contact ends. The tip is made higher in steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from finite_strain.laws import TooFar
from finite_strain.solver import Body
from finite_strain.tips import RoundedCone

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
    """A body whose surface is on a tip out to the radius `contact` of the undeformed state."""

    def __init__(self, body: Body, contact: float, tip: RoundedCone) -> None:
        self.body, self.tip = body, tip
        across, down, place = body.top
        order = np.argsort(place)
        order = order[: np.argmin(np.abs(place[order] - contact)) + 1]
        self.across, self.down, self.place = across[order], down[order], place[order]
        self.free = np.setdiff1d(body.free, self.down[:-1])
        self.number = np.full(body.size, -1)
        self.number[self.free] = np.arange(self.free.size)
        self.moving = self.number[self.across[:-1]] >= 0

    def spaces(self, slope: np.ndarray) -> tuple[sp.csc_matrix, sp.csc_matrix]:
        """Matrices from the independent unknowns to all, and the directions in which forces vanish, at slopes of the nodes.

        In the first, nodes on the tip follow the last one, at the edge. In the second the edge moves by itself: d is given.
        """
        free, inner, number, moving = self.free, self.down[:-1], self.number, self.moving
        size = (self.body.size, free.size)
        test = sp.coo_matrix((np.ones(free.size), (free, number[free])), size)
        test += sp.coo_matrix((slope[:-1][moving], (inner[moving], number[self.across[:-1]][moving])), size)
        follow = sp.coo_matrix((np.ones(inner.size), (inner, np.full(inner.size, number[self.down[-1]]))), size)
        follow -= sp.coo_matrix(
            (np.full(inner.size, slope[-1]), (inner, np.full(inner.size, number[self.across[-1]]))), size
        )
        return (test + follow).tocsc(), test.tocsc()

    def bent(self, force: np.ndarray, bend: np.ndarray) -> sp.csc_matrix:
        """Derivative of the directions in which forces vanish, times the forces, at second derivatives of the tip."""
        at = self.number[self.across[:-1]][self.moving]
        return sp.coo_matrix(
            ((bend[:-1] * force[self.down[:-1]])[self.moving], (at, at)), (self.free.size, self.free.size)
        ).tocsc()

    def profile(self, unknowns: np.ndarray, slope: float, small: bool) -> tuple[np.ndarray, np.ndarray]:
        """Height, slope and second derivative at the nodes, and what the nodes are below the tip when the edge is on it."""
        move = np.zeros_like(self.place) if small else unknowns[self.across]
        profile = slope / self.tip.slope * self.tip.profile(self.place + move)
        off = unknowns[self.down[-1]] + profile[0] - profile[0, -1] - unknowns[self.down]
        return profile * np.array([[1], [0 if small else 1], [0 if small else 1]]), off

    def equilibrium(self, start: np.ndarray, slope: float, *, small: bool = False) -> State:
        """Newton's method with shorter steps where elements would turn inside out."""
        unknowns = start.copy()
        unknowns[self.down] += self.profile(unknowns, slope, small)[1]
        force, stiffness = self.body.forces(unknowns, small)
        for _ in range(ITERATIONS):
            profile, off = self.profile(unknowns, slope, small)
            trial, test = self.spaces(profile[1])
            particular = np.zeros(self.body.size)
            particular[self.down] = off
            matrix = test.T @ stiffness @ trial + self.bent(force, profile[2])
            loads = test.T @ (force + stiffness @ particular)
            step = particular - trial @ splu(matrix.tocsc(), permc_spec="COLAMD").solve(loads)
            change = np.abs(step[: self.body.count]).max()
            step, force, stiffness = self.body.stepped(unknowns, step, small)
            unknowns = unknowns + step
            if change < 1e-9 * slope * self.place[-1]:
                break
        else:
            raise TooFar("Newton's method does not converge")
        height = float(self.profile(unknowns, slope, small)[0][0, -1])
        radius = float(self.place[-1] + (0.0 if small else unknowns[self.across[-1]]))
        depth = float(height - unknowns[self.down[-1]])
        return State(unknowns, slope, depth, float(-2 * np.pi * force[self.down].sum()), radius)

    def steepened(self) -> tuple[State, State]:
        """Equilibrium of linear theory, and at large strain."""
        goal = self.tip.slope
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
