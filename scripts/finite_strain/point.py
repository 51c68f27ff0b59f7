"""One contact: force at large strain over the force of linear theory, both by finite elements on one mesh.

What the mesh does to both forces cancels in their ratio. The linear force is compared with `flatpunch.indent` besides.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np

import flatpunch as fp
from finite_strain.laws import Law
from finite_strain.mesh import mesh
from finite_strain.solver import Body
from finite_strain.tips import Ball, Cone
from flatpunch.compliance import compliance
from flatpunch.contact.curve import Control


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
    unknowns : int
        Size of the mesh.
    seconds : float
        Processor time.
    """

    ratio: float
    linear: float
    radius: float
    unknowns: int
    seconds: float


def point(law: Law, tip: Ball | Cone, thickness: float, depth: float, cells: int) -> Point:
    """Press a tip into a bonded layer (thickness inf: half-space).

    Raises
    ------
    TooFar
        If there is no solution.
    """
    start = process_time()
    young = 2 * (1 + law.poisson)
    if np.isinf(thickness):
        medium: fp.Medium | fp.HalfSpace = fp.HalfSpace(young=young, poisson=law.poisson)
    else:
        medium = fp.Medium([fp.Layer(young, law.poisson, thickness)], base=fp.RigidBase())
    shape = fp.Sphere(tip.radius) if isinstance(tip, Ball) else fp.Cone(inclination=float(np.arctan(tip.slope)))
    # without notes, which would read the table that is being made
    known = fp.Exact().solve(compliance(medium), shape, Control("depth", np.array([depth])), np.zeros(1))
    force, radius = float(known.force[0]), float(known.radius[0])
    body = Body(mesh(radius, thickness, cells), law, force / (np.pi * radius**2))
    linear = body.load(tip, depth, small=True)[0]
    large, contact = body.load(tip, depth)
    return Point(large / linear, linear / force, contact / radius, body.size, process_time() - start)
