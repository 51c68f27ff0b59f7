"""Static equilibrium by Newton's method; contact by penalty at the quadrature points of the surface.

Displacements are of second order on quadrilaterals, pressures linear in each cell (Q2/P1). The contact pressure is -eps g where
that is positive, g the distance of the deformed point from the true tip. Forces at two penalties are extrapolated.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from skfem import Basis, ElementQuad2, ElementVector, FacetBasis, MeshQuad

from finite_strain.laws import Law, TooFar
from finite_strain.tips import Level, Tip

LOADING, PENALTIES = 30.0, (60.0, 120.0)
"""Penalties during loading and at the end, times the length of a surface cell over mu max(1, mean pressure/mu)^2.

Below about a quarter of the square of the pressure, waves of tangential displacement grow: where the tip is entered they gain
volume.
"""
POINTS = 5
"""Order of the quadrature of the contact."""


class Body:
    """Discretised layer: arrays that do not change during loading."""

    def __init__(self, mesh: MeshQuad, law: Law, pressure: float) -> None:
        self.law, self.mesh = law, mesh
        element = ElementVector(ElementQuad2())
        basis = Basis(mesh, element, intorder=5)
        radius = basis.global_coordinates().value[0]
        self.weight = basis.dx * radius
        rows = []
        for function in basis.basis:
            grad, value = function[0].grad, function[0].value
            rows.append(np.stack([grad[0, 0], grad[0, 1], grad[1, 0], grad[1, 1], value[0] / radius]))
        cells, points = radius.shape
        # strain matrix (cell, point, 5, 18) and pressure shapes (point, 3)
        self.strain = np.ascontiguousarray(np.stack(rows).transpose(2, 3, 1, 0))
        self.shape = np.column_stack([np.ones(points), 2 * basis.X.T - 1])
        self.count = basis.N
        self.dofs = np.hstack([basis.element_dofs.T, basis.N + np.arange(3 * cells).reshape(cells, 3)])
        self.size = basis.N + 3 * cells
        top = mesh.facets_satisfying(lambda x: np.isclose(x[1], 0.0))
        surface = FacetBasis(mesh, element, facets=top, intorder=POINTS)
        self.place = surface.global_coordinates().value
        self.trace = np.ascontiguousarray(np.stack([f[0].value for f in surface.basis]).transpose(2, 3, 1, 0))
        self.surface = surface.element_dofs.T
        self.measure = surface.dx * self.place[0]
        self.pressure, self.lengths = pressure, surface.dx.sum(axis=1)[:, None]
        self.penalty = LOADING / self.lengths
        bottom = mesh.p[1].min()
        axis = basis.get_dofs(lambda x: np.isclose(x[0], 0.0)).all(["u^1"])
        base = basis.get_dofs(lambda x: np.isclose(x[1], bottom)).all()
        side = basis.get_dofs(lambda x: np.isclose(x[0], mesh.p[0].max())).all()
        fixed = np.unique(np.concatenate([axis, base, side]))
        self.free = np.setdiff1d(np.arange(self.size), fixed)
        self.rows = np.repeat(self.dofs, self.dofs.shape[1], axis=1).ravel()
        self.columns = np.tile(self.dofs, (1, self.dofs.shape[1])).ravel()
        nodes = [basis.get_dofs(top).all([name]) for name in ("u^1", "u^2")]
        self.top = (*nodes, basis.doflocs[0, nodes[0]])
        self.linear: sp.csc_matrix | None = None

    def inside(self, unknowns: np.ndarray) -> tuple[np.ndarray, sp.csc_matrix]:
        """Internal forces and their derivative."""
        cells, points = self.weight.shape
        local = unknowns[self.dofs]
        gradient = (self.strain @ local[:, None, :18, None])[..., 0].transpose(2, 0, 1).copy()
        gradient[[0, 3, 4]] += 1
        pressure = local[:, 18:] @ self.shape.T
        stress, tangent, cofactor, volume = self.law.stress(gradient, pressure)
        flat = self.strain.reshape(cells, points * 5, 18)
        weighted = (stress * self.weight).transpose(1, 2, 0).reshape(cells, 1, points * 5)
        force = np.empty((cells, 21))
        force[:, :18] = (weighted @ flat)[:, 0]
        gap = (volume - 1 - pressure / self.law.bulk) * self.weight
        force[:, 18:] = gap @ self.shape
        matrix = np.empty((cells, 21, 21))
        product = (tangent * self.weight).transpose(2, 3, 0, 1) @ self.strain
        matrix[:, :18, :18] = flat.transpose(0, 2, 1) @ product.reshape(cells, points * 5, 18)
        column = ((cofactor * self.weight).transpose(1, 2, 0)[:, :, None, :] @ self.strain)[:, :, 0]
        matrix[:, :18, 18:] = column.transpose(0, 2, 1) @ self.shape
        matrix[:, 18:, :18] = matrix[:, :18, 18:].transpose(0, 2, 1)
        mass = self.shape * self.weight[..., None] / self.law.bulk
        matrix[:, 18:, 18:] = -self.shape.T @ mass
        total = np.bincount(self.dofs.ravel(), force.ravel(), self.size)
        stiffness = sp.coo_matrix((matrix.ravel(), (self.rows, self.columns)), (self.size, self.size)).tocsc()
        return total, stiffness

    def contact(self, unknowns: np.ndarray, tip: Tip, depth: float, small: bool) -> Level:
        """Contact pressure at the points of the surface, gradient and second derivatives of the gap."""
        move = (self.trace @ unknowns[self.surface][:, None, :, None])[..., 0].transpose(2, 0, 1)
        if small:
            gap = tip.height(self.place[0]) - depth - move[1]
            slope = np.stack([np.zeros_like(gap), -np.ones_like(gap)])
            bend = np.zeros((2, 2, *gap.shape))
        else:
            gap, slope, bend = tip.level(self.place[0] + move[0], self.place[1] + move[1], depth)
        return np.maximum(-self.penalty * gap, 0.0), slope, bend

    def pushed(self, pressure: np.ndarray, slope: np.ndarray, bend: np.ndarray) -> tuple[np.ndarray, sp.csc_matrix]:
        """Contact forces on the body and minus their derivative."""
        load = np.einsum("fq,ifq,fqin->fn", pressure * self.measure, slope, self.trace)
        matrix = ((pressure > 0) * self.penalty * slope[:, None] * slope[None] - pressure * bend) * self.measure
        block = np.einsum("fqin,ijfq,fqjm->fnm", self.trace, matrix, self.trace, optimize=True)
        rows, columns = np.broadcast_arrays(self.surface[:, :, None], self.surface[:, None, :])
        stiff = sp.coo_matrix((block.ravel(), (rows.ravel(), columns.ravel())), (self.size, self.size))
        return np.bincount(self.surface.ravel(), load.ravel(), self.size), stiff.tocsc()

    def equilibrium(self, start: np.ndarray, tip: Tip, depth: float, small: bool) -> np.ndarray:
        """Unknowns in equilibrium by Newton's method with shorter steps where elements would invert."""
        unknowns, free = start.copy(), self.free
        force, stiffness = self.forces(unknowns, small)
        for attempt in range(30):
            load, stiff = self.pushed(*self.contact(unknowns, tip, depth, small))
            residual, full = force - load, stiffness + stiff
            step = np.zeros(self.size)
            step[free] = splu(full.tocsc()[free][:, free], permc_spec="COLAMD").solve(-residual[free])
            change = np.abs(step[: self.count]).max()
            if 7 < attempt < 13:
                # contact that opens and closes in turn
                step /= 2
            step, force, stiffness = self.stepped(unknowns, step, small)
            unknowns += step
            if change < 1e-7 * depth:
                return unknowns
        raise TooFar("Newton's method does not converge")

    def stepped(
        self, unknowns: np.ndarray, step: np.ndarray, small: bool
    ) -> tuple[np.ndarray, np.ndarray, sp.csc_matrix]:
        """The step, halved until no element turns inside out; internal forces and their derivative after it."""
        for _ in range(8):
            try:
                return step, *self.forces(unknowns + step, small)
            except TooFar:
                step = step / 2
        raise TooFar("Newton's method turns elements inside out")

    def forces(self, unknowns: np.ndarray, small: bool) -> tuple[np.ndarray, sp.csc_matrix]:
        """Internal forces and their derivative, at small or at large strain."""
        if not small:
            return self.inside(unknowns)
        if self.linear is None:
            self.linear = self.inside(np.zeros(self.size))[1]
        return self.linear @ unknowns, self.linear

    def load(self, tip: Tip, depth: float, *, small: bool = False, steps: int = 6) -> tuple[float, float]:
        """Press to the depth: force over the shear modulus, extrapolated to rigid contact, and contact radius."""
        unknowns, previous = np.zeros(self.size), np.zeros(self.size)
        reached, ago, width = 0.0, 0.0, 1.0 if small else 1 / steps
        while reached < 1:
            target = reached + width if 1 - reached > 1.001 * width else 1.0
            here = depth * target
            self.penalty = LOADING * max(1.0, self.pressure * target) ** 2 / self.lengths
            try:
                if reached == 0:
                    guess = self.equilibrium(unknowns, tip, here, True)
                else:
                    guess = unknowns + (unknowns - previous) * (target - reached) / (reached - ago)
                new = guess if small else self.equilibrium(guess, tip, here, False)
            except (TooFar, RuntimeError):
                width /= 2
                if width < 0.02:
                    raise
                continue
            previous, unknowns, ago, reached = unknowns, new, reached, target
        forces = []
        for factor in PENALTIES:
            self.penalty = factor * max(1.0, self.pressure) ** 2 / self.lengths
            unknowns = self.equilibrium(unknowns, tip, depth, small)
            pressure, slope, _ = self.contact(unknowns, tip, depth, small)
            forces.append(-2 * np.pi * (pressure * slope[1] * self.measure).sum())
        move = 0 if small else (self.trace @ unknowns[self.surface][:, None, :, None])[..., 0, 0]
        return float(2 * forces[-1] - forces[-2]), float((self.place[0] + move)[pressure > 0].max())
