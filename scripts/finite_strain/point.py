"""One contact: force at large strain over the force of linear theory, both by finite elements on one mesh.

What the mesh does to both forces cancels in their ratio. The linear force is compared with `flatpunch.indent` besides.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np

import flatpunch as fp
from finite_strain.flank import Flank
from finite_strain.laws import Law
from finite_strain.mesh import cone_mesh, mesh
from finite_strain.solver import Body
from finite_strain.tips import RoundedCone, Tip
from flatpunch.compliances import compliance
from flatpunch.contact.curve import Control
from flatpunch.indenters import Indenter


@dataclass(frozen=True, slots=True)
class Point:
    """Result of a contact.

    Attributes
    ----------
    ratio : float
        Force at large strain over that of linear theory, both by finite elements.
    linear : float
        Linear force of finite elements over that of `flatpunch.indent`.
    radius : float
        Contact radius in the deformed state over that of `flatpunch.indent`.
    depth : float
        Depth over the one that was asked for; not 1 under cones, whose contact radius is prescribed.
    unknowns : int
        Size of the mesh.
    seconds : float
        Processor time.
    """

    ratio: float
    linear: float
    radius: float
    depth: float
    unknowns: int
    seconds: float


class Linear:
    """Linear theory of `flatpunch` for a bonded layer of shear modulus 1 (thickness inf: half-space)."""

    def __init__(self, law: Law, thickness: float) -> None:
        young = 2 * (1 + law.poisson)
        if np.isinf(thickness):
            self.medium: fp.Medium | fp.HalfSpace = fp.HalfSpace(young=young, poisson=law.poisson)
        else:
            self.medium = fp.Medium([fp.Layer(young, law.poisson, thickness)], base=fp.RigidBase())

    def at(self, shape: Indenter, depth: float) -> tuple[float, float]:
        """Force and contact radius, without notes, which would read the table that is being made."""
        known = fp.Exact().solve(compliance(self.medium), shape, Control("depth", np.array([depth])), np.zeros(1))
        return float(known.force[0]), float(known.radius[0])


def point(law: Law, tip: Tip, thickness: float, depth: float, cells: int) -> Point:
    """Press a sphere or a rounded cone into a bonded layer (thickness inf: half-space).

    Raises
    ------
    TooFar
        If there is no solution.
    """
    start = process_time()
    force, radius = Linear(law, thickness).at(tip.shape, depth)
    body = Body(mesh(radius, thickness, cells), law, force / (np.pi * radius**2))
    linear = body.load(tip, depth, small=True)[0]
    large, contact = body.load(tip, depth)
    return Point(large / linear, linear / force, contact / radius, 1.0, body.size, process_time() - start)


def cone_point(law: Law, tip: RoundedCone, thickness: float, depth: float, cells: int) -> Point:
    """Press a cone into a bonded layer (thickness inf: half-space) to about the depth.

    Results under a sharp cone with a cell at the apex of 1/5 of the others, and of half of that, are extrapolated. Under a
    rounded one the cells at the apex are a sixth of the cap.

    Raises
    ------
    TooFar
        If there is no solution.
    """
    start, theory = process_time(), Linear(law, thickness)
    # about the radius in the undeformed state
    contact = theory.at(tip.shape, depth)[1] * (1 + np.sin(np.radians(tip.angle)) ** 2 / 5)
    apexes = (0.2 / cells, 0.1 / cells) if tip.radius == 0 else (min(1 / cells, tip.end / contact / 6),)
    found = []
    for apex in apexes:
        body = Body(cone_mesh(contact, thickness, cells, apex), law, 1.0)
        small, large = Flank(body, contact, tip).steepened()
        linear = small.force / theory.at(tip.shape, small.depth)[0]
        force, radius = theory.at(tip.shape, large.depth)
        found.append([large.force / (force * linear), linear, large.radius / radius, large.depth / depth])
    ratio, linear, radius, reached = 2 * np.array(found[-1]) - found[0] if tip.radius == 0 else found[0]
    return Point(ratio, linear, radius, reached, body.size, process_time() - start)
