"""Points of the table by other finite elements, which share no element, mesh, contact or code with those that made it.

python -m finite_strain.independent        (in scripts; a few minutes)

felupe: bilinear quadrilaterals with constant pressure and dilatation (Q1/P0, three fields). The contact is a condition on the
nodes, on a sphere or a cone, with the force of each node as its multiplier, without a penalty. Forces are over those of `indent`,
and over the same ratio at `SMALL` times the depth and the curvature or slope on the same mesh: linear theory holds there, and the
ratio is the error of the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass

import felupe
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

import flatpunch as fp
from finite_strain.mesh import growing

STEPS, ITERATIONS = 14, 60
"""Steps of loading, and the most Newton steps of each."""
SMALL = 1e-4
"""Strains of the linear solution over those of the other."""
CELLS = (12, 24)
"""Cells under the contact if they were as wide as the widest there."""
POINTS = (
    (0.2, 0.4999, 0.32),
    (0.5, 0.4999, 0.5),
    (0.1, 0.47, 0.5),
    (1.0, 0.47, 0.5),
    (2.0, 0.4999, 0.25),
    (1.0, 0.42, 0.5),
)
"""h/R, Poisson ratio, d/h of spheres."""
CONES = ((20.0, 0.4999, 0.1), (35.0, 0.4999, 0.25), (45.0, 0.4999, 0.1), (30.0, 0.47, 0.4))
"""Angle [degrees], Poisson ratio, d/h of cones."""
ROUNDED = ((30.0, 0.4999, 0.3, 0.2), (40.0, 0.47, 0.35, 0.25))
"""Angle [degrees], Poisson ratio, R/h, d/h of rounded cones."""

Shape = fp.Sphere | fp.Cone | fp.Rounded
"""Tips of the package."""


@dataclass(frozen=True)
class Ball:
    """A sphere that is pressed in."""

    radius: float

    def eased(self, share: float) -> tuple[Ball, float]:
        """The tip at a share of the load, and the share of the contact radius."""
        return self, share**0.5

    def distance(self, place: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Gap of places (n, 2), its gradient and its curvature; z first."""
        apart = place - [self.radius - depth, 0.0]
        distance = np.linalg.norm(apart, axis=1)
        return distance - self.radius, apart / distance[:, None], 1 / distance


@dataclass(frozen=True)
class Flank:
    """A cone that becomes steeper as it is pressed in, so that its contact radius stays."""

    slope: float

    def eased(self, share: float) -> tuple[Flank, float]:
        """As of `Ball`."""
        return Flank(share * self.slope), 1.0

    def distance(self, place: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As of `Ball`."""
        normal = np.array([-1.0, self.slope]) / np.hypot(1, self.slope)
        return (place + np.array([depth, 0.0])) @ normal, np.tile(normal, (len(place), 1)), np.zeros(len(place))


@dataclass(frozen=True)
class Capped:
    """A cone that ends in a sphere, pressed in."""

    slope: float
    radius: float

    def eased(self, share: float) -> tuple[Capped, float]:
        """As of `Ball`."""
        return self, share**0.5

    def distance(self, place: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As of `Ball`, to the flank where its slope is reached."""
        gap, normal, bend = Ball(self.radius).distance(place, depth)
        apex = self.radius * (np.hypot(1, self.slope) - 1)
        away, straight, none = Flank(self.slope).distance(place, depth + apex)
        flank = normal[:, 1] > -self.slope * normal[:, 0]
        return np.where(flank, away, gap), np.where(flank[:, None], straight, normal), np.where(flank, none, bend)


class Layer:
    """A bonded layer of shear modulus and thickness 1 under a rigid tip."""

    def __init__(self, tip: Ball | Flank | Capped, poisson: float, contact: float, cells: int) -> None:
        growth, edge, away = 1 + 1.6 / cells**0.8, contact / (5 * cells), 1 / cells**0.8
        near, end = 0.95 * contact, 1.06 * contact
        r = np.concatenate(
            [
                growing(near, 0, edge, growth, contact / cells),
                np.linspace(near, end, int(np.ceil((end - near) / edge)) + 1)[1:],
                growing(end, end + 10, edge, growth, 4 * away)[1:],
            ]
        )
        r, z = np.sort(r), np.sort(growing(0, -1, min(contact / cells, 0.1), growth, 1.5 * away))
        self.nodes = np.stack([np.tile(z, r.size), np.repeat(r, z.size)], axis=1)
        column, row = np.divmod(np.arange((r.size - 1) * (z.size - 1)), z.size - 1)
        first = column * z.size + row
        cell = np.stack([first, first + 1, first + z.size + 1, first + z.size], axis=1)
        region = felupe.RegionQuad(felupe.Mesh(self.nodes, cell, "quad"))
        self.field = felupe.FieldsMixed(region, n=3, axisymmetric=True)
        bulk = 2 * (1 + poisson) / (3 * (1 - 2 * poisson))
        self.body = felupe.SolidBody(felupe.NearlyIncompressible(felupe.NeoHooke(mu=1), bulk=bulk), self.field)
        held = np.zeros(self.nodes.shape, bool)
        held[(self.nodes[:, 0] <= z[0]) | (self.nodes[:, 1] >= r[-1])] = True
        held[self.nodes[:, 1] == 0, 1] = True
        self.sizes = [part.values.size for part in self.field.fields]
        self.free = np.concatenate([np.flatnonzero(~held), np.arange(held.size, sum(self.sizes))])
        self.top = np.flatnonzero((self.nodes[:, 0] == 0) & (self.nodes[:, 1] < 1.4 * contact))
        self.tip, self.contact = tip, contact

    def inside(self, unknowns: np.ndarray) -> tuple[np.ndarray, sp.csc_matrix]:
        """Internal forces and their derivative."""
        for part, values in zip(self.field.fields, np.split(unknowns, np.cumsum(self.sizes)[:-1]), strict=True):
            part.values[:] = values.reshape(part.values.shape)
        force = np.asarray(self.body.assemble.vector(self.field).todense()).ravel()
        return force, self.body.assemble.matrix(self.field).tocsc()

    def load(self, depth: float) -> float:
        """Force at a depth, over the shear modulus."""
        at, size = 2 * self.top[:, None] + np.arange(2), sum(self.sizes)
        unknowns, nodal = np.zeros(size), np.zeros(self.top.size)
        unknowns[-self.sizes[2] :] = 1
        for share in np.arange(1, STEPS + 1) / STEPS:
            tip, width = self.tip.eased(share)
            start = np.flatnonzero(self.nodes[self.top, 1] < self.contact * width)
            for attempt in range(ITERATIONS):
                force, matrix = self.inside(unknowns)
                gap, normal, bend = tip.distance(self.nodes[self.top] + unknowns[at], share * depth)
                touching = np.flatnonzero(nodal > 20 * self.contact * gap) if attempt else start
                nodal[np.setdiff1d(np.arange(nodal.size), touching)] = 0
                n, dofs = normal[touching], at[touching]
                turn = (np.eye(2) - n[:, :, None] * n[:, None]) * (nodal * bend)[touching, None, None]
                rows, columns = np.repeat(dofs, 2, axis=1).ravel(), np.tile(dofs, (1, 2)).ravel()
                matrix = (matrix - sp.coo_matrix((turn.ravel(), (rows, columns)), (size, size))).tocsc()
                rows = np.repeat(np.arange(touching.size), 2)
                gaps = sp.coo_matrix((n.ravel(), (rows, dofs.ravel())), (touching.size, size)).tocsc()
                residual = force - gaps.T @ nodal[touching]
                held = gaps[:, self.free]
                whole = sp.bmat([[matrix[self.free][:, self.free], -held.T], [-held, None]]).tocsc()
                step = splu(whole).solve(np.concatenate([-residual[self.free], gap[touching]]))
                unknowns[self.free] += step[: self.free.size]
                nodal[touching] += step[self.free.size :]
                if attempt > 1 and np.abs(step[: self.free.size - sum(self.sizes[1:])]).max() < 1e-9 * depth:
                    break
            else:
                raise ArithmeticError("Newton's method does not converge")
        return float(-nodal @ normal[:, 0])


def scaled(tip: Shape, scale: float) -> tuple[Shape, Ball | Flank | Capped]:
    """A tip whose heights are a share of those of another, as far as slopes are small."""
    if isinstance(tip, fp.Sphere):
        return fp.Sphere(tip.radius / scale), Ball(tip.radius / scale)
    flank = tip if isinstance(tip, fp.Cone) else tip.tip
    assert isinstance(flank, fp.Cone)  # no pyramids here
    slope = scale * float(np.tan(flank.inclination))
    cone = fp.Cone(inclination=float(np.arctan(slope)))
    if isinstance(tip, fp.Cone):
        return cone, Flank(slope)
    # the cap ends at the same radius
    radius = tip.radius * float(np.sin(flank.inclination) / np.sin(cone.inclination))
    return fp.Rounded(cone, radius), Capped(slope, radius)


def ratio(tip: Shape, poisson: float, depth: float, cells: int) -> tuple[float, float]:
    """Force at large strain over that of `indent`, as it is and over the error of the mesh in linear theory."""
    medium = fp.Medium([fp.Layer(2 * (1 + poisson), poisson, 1.0)], base=fp.RigidBase())
    parts: list[float] = []
    contact = float(fp.indent(medium, tip, depth=depth).radius[0])
    for scale in (1.0, SMALL):
        shape, rigid = scaled(tip, scale)
        known = float(fp.indent(medium, shape, depth=scale * depth).force[0])
        parts.append(Layer(rigid, poisson, contact, cells).load(scale * depth) / known)
    return parts[0], parts[0] / parts[1]


def main() -> None:
    """Print both ratios of forces at each point on each mesh, beside the table."""
    places: list[tuple[Shape, float, float]] = [(fp.Sphere(1 / over), p, d) for over, p, d in POINTS]
    places += [(fp.Cone(inclination=float(np.radians(angle))), p, d) for angle, p, d in CONES]
    places += [(fp.SpheroCone(float(np.radians(angle)), over), p, d) for angle, p, over, d in ROUNDED]
    for tip, poisson, depth in places:
        found = [ratio(tip, poisson, depth, cells) for cells in CELLS]
        medium = fp.Medium([fp.Layer(1.0, poisson, 1.0)], base=fp.RigidBase())
        table = fp.indent(medium, tip, depth=depth, finite_strain="neo-hookean")
        known, error = float(table.strain_factor[0]), float(table.force_error[0])
        others = " ".join(f"{each:.5f} {free:.5f}" for each, free in found)
        print(f"{tip!r} {poisson:g} {depth:g}: {others}, table {known:.5f} +- {error:.5f}", flush=True)


if __name__ == "__main__":
    main()
