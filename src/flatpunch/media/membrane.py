"""Membranes: tension, in-plane stiffness and bending stiffness of a face, which has no thickness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from flatpunch._support.checks import Array
from flatpunch._support.declared import Checked, a_bending_stiffness, a_tension, numbers_of
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable


@readable
@dataclass(frozen=True, slots=True)
class Membrane(Checked):
    """Membrane in an interface or on a surface: the cortex of a cell, graphene, the surface tension of a soft gel.

    It moves with the face on which it lies, and the traction jumps across it by what it takes to bend, tilt and stretch it. An
    isotropic film of thickness t is a membrane with stretching = E t/(1 - nu^2), shear = E t/(2 (1 + nu)) and
    bending = E t^3/(12 (1 - nu^2)) to waves that are long against t.

    Parameters
    ----------
    tension : float
        Tension, or surface stress, that strains do not change [N/m], >= 0.
    stretching : float
        In-plane force per width and strain, the strain across it zero [N/m], >= 0.
    shear : float
        In-plane shear force per width and shear strain [N/m], >= 0. Normal contacts do not depend on it.
    bending : float
        Bending moment per width and curvature [J], >= 0.

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range.

    See Also
    --------
    Interface, Medium : Take one.

    Examples
    --------
    >>> cortex = fp.Interface(membrane=fp.Membrane(tension=1e-3))
    >>> cell = fp.Medium([fp.Layer(500, 0.5, thickness=0.2e-6, bonded=cortex)], base=fp.HalfSpace(500, 0.5))
    >>> force = [fp.indent(body, fp.Sphere(2e-6), depth=0.5e-6).force[0] for body in (cell, cell.base)]
    >>> print(f"{float(force[0] / force[1]):.2f} times the force without tension")
    2.70 times the force without tension
    """

    tension: Annotated[float, a_tension("tension of the membrane")] = 0.0
    stretching: Annotated[float, a_tension("stretching stiffness of the membrane")] = 0.0
    shear: Annotated[float, a_tension("shear stiffness of the membrane")] = 0.0
    bending: Annotated[float, a_bending_stiffness("bending stiffness of the membrane")] = 0.0

    def __bool__(self) -> bool:
        """Whether it carries anything."""
        return any((self.tension, self.stretching, self.shear, self.bending))

    def stiffness(self, k: Array) -> Array:
        """Jump of the tractions along a wave, across it and normal to the face per displacement [Pa/m]; shape (3, n)."""
        along, across = self.stretching * k**2, self.shear * k**2
        return np.stack([along, across, self.tension * k**2 + self.bending * k**4])

    def reach(self, modulus: float) -> float:
        """Distance over which it spreads a load on a body of this modulus [m]."""
        return max(self.tension / modulus, self.stretching / modulus, float(np.cbrt(self.bending / modulus)))

    def in_words(self) -> str:
        """Its numbers with units, for tables."""
        own = [f"{each.path} {text(each.value, each.number.unit or '')}" for each in numbers_of(self) if each.value]
        return ", ".join(["a membrane", *own])
