"""Which published formulas apply to a sample and a tip, and the force that each of them gives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from flatpunch._support.checks import Array, BadValue
from flatpunch._support.kinds import one_of
from flatpunch.fit.half_space import published
from flatpunch.indenters import Cone, Cylinder, Paraboloid, Pyramid, Sphere
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, HalfSpace, Interface, Layer, Medium, RigidBase

Equivalent = Callable[[Array, float], Array]

OLIVER_PHARR = "oliver-pharr"
"""Name of the evaluation by stiffness and contact area, which goes with every tip."""


@dataclass(frozen=True, slots=True)
class Reported:
    """Half-space model of the software: F = factor E* d^exponent.

    Parameters
    ----------
    name : str
        What it is called.
    factor : float
        [m^(2 - exponent)].
    exponent : float
    """

    name: str
    factor: float
    exponent: float

    def force(self, depth: Array) -> Array:
        """Force for E* = 1 Pa."""
        return np.asarray(self.factor * depth**self.exponent)


def half_space_models(indenter: Indenter) -> dict[str, Reported]:
    """The half-space formulas in use for a tip by their names, the usual one first; none for most tips."""
    if isinstance(indenter, (Sphere, Paraboloid)):
        return {"hertz": Reported("hertz", 4 / 3 * math.sqrt(indenter.radius), 1.5)}
    if isinstance(indenter, Cylinder):
        return {"flat": Reported("flat", 2 * indenter.radius, 1.0)}
    if isinstance(indenter, Cone):
        factors = {"sneddon": 2 / math.pi}
    else:
        four = isinstance(indenter, Pyramid) and indenter.sides == 4
        factors = {"bilodeau": 0.7453, "rico": 1 / math.sqrt(2)} if four else {}
    return {name: Reported(name, factor * _slope(indenter), 2.0) for name, factor in factors.items()}


def half_space_model(indenter: Indenter, name: str | None = None) -> Reported:
    """One of the half-space formulas for a tip, the first that fits it if no name is given.

    Names are "hertz", "sneddon", "flat", and for pyramids "bilodeau" (0.7453 E* tan(alpha) d^2, alpha the face's half opening
    angle) or "rico" (1/sqrt(2) instead of 0.7453).
    """
    found = half_space_models(indenter)
    if not found:
        raise ValueError(
            f"indenter = {type(indenter).__name__}: no half-space formula is in use for it; there are those for Sphere, "
            "Paraboloid, Cone, Cylinder and Pyramid(sides=4)."
        )
    if name is None:
        return next(iter(found.values()))
    return found[one_of("model", name, found, wrong=f"does not belong to a {type(indenter).__name__}")]


def _slope(indenter: Indenter) -> float:
    """tan(alpha) of a cone or a pyramid, alpha the half opening angle; d tan(alpha) is the radius or half-width at depth d."""
    assert isinstance(indenter, (Cone, Pyramid))
    return 1 / math.tan(indenter.inclination)


@dataclass(frozen=True, slots=True)
class Formula:
    """A published formula for one sample and tip.

    Parameters
    ----------
    name : str
        By its authors.
    force : callable
        (depths [m], Young's modulus of the layer [Pa]) -> forces [N].
    remark : str
        What the formula was made for, where the sample differs.
    """

    name: str
    force: Callable[[Array, float], Array]
    remark: str = ""


def layer_on_top(medium: Body) -> tuple[Medium, Layer]:
    """Return the sample and the homogeneous layer at its surface, whose modulus formulas give; ValueError without one."""
    if not isinstance(medium, Medium) or not medium.layers or not isinstance(medium.layers[0], Layer):
        raise BadValue("layers[0]", "", "must be a homogeneous layer on top of a Medium: its modulus is looked for.")
    return medium, medium.layers[0]


def formulas(medium: Medium, indenter: Indenter) -> list[Formula]:
    """Return the published formulas for one layer on a base and a tip with a half-space model; none for more layers.

    Formulas for thin layers are factors on the half-space force; those for films on substrates are equivalent moduli at the
    contact radius of the half-space, as they are used.
    """
    top, base, tip = layer_on_top(medium)[1], medium.base, half_space_model(indenter)
    if len(medium.layers) != 1 or isinstance(top.bonded, Interface):
        return []
    nu, h, bonded, star = top.poisson, top.thickness, bool(top.bonded), 1 / (1 - top.poisson**2)
    ball, pyramid = isinstance(indenter, (Sphere, Paraboloid)), isinstance(indenter, Pyramid)
    shape = "paraboloid" if ball else "flat" if isinstance(indenter, Cylinder) else "cone"
    found: list[Formula] = []

    def x(d: Array) -> Array:
        """Half-space contact radius, or half-width of the tip at this depth for cones, over the thickness."""
        if isinstance(indenter, (Sphere, Paraboloid)):
            return np.sqrt(indenter.radius * d) / h
        if isinstance(indenter, Cylinder):
            return np.full_like(d, indenter.radius / h)
        return d * _slope(indenter) / h

    def add(name: str, of: Callable[[Array], Array], *made_for: str) -> None:
        """A factor on the half-space force."""
        rigid = "" if isinstance(base, RigidBase) else "for a rigid base"
        remark = "; ".join(filter(None, (*made_for, rigid)))
        found.append(Formula(name, lambda d, young: young * star * tip.force(d) * of(d), remark))

    half = "" if nu == 0.5 else "for nu = 0.5"
    if ball:
        add("Dimitriadis", lambda d: published.dimitriadis(x(d), nu, bonded))
    if bonded:
        add("Garcia", lambda d: published.garcia(x(d), shape), "for cones" if pyramid else "", half)
    if bonded and isinstance(indenter, (Sphere, Paraboloid)):
        radius = indenter.radius
        if published.LONG[0] <= radius / h < published.LONG[1]:
            add("Long", lambda d: published.long(x(d), radius / h), "for large strains", half)
        thin = "for bonded incompressible layers much thinner than the contact"
        found.append(Formula("Chadwick", lambda d, young: published.chadwick(radius, d, young, h), thin))
    if pyramid:
        ours = published.PYRAMID_FORCE[4] * _slope(indenter) / tip.factor
        add("flatpunch", lambda d: ours * published.pyramid(x(d), 4, bonded), "of this project", half)
    if isinstance(base, HalfSpace):
        narrow = 2 / math.pi if shape == "cone" else 1.0
        laws = equivalents(medium)
        if ball:
            substrate = base.surface_modulus
            laws["Clifford"] = lambda a, film: published.clifford(a, film, nu, substrate, base.poisson)
        found += [
            Formula(name, partial(_over_half_space, tip, law, lambda d: narrow * x(d), star), MADE_FOR.get(name, ""))
            for name, law in laws.items()
        ]
    return found


MADE_FOR = {"Gao": "for bodies of similar stiffness", "Perriot-Barthel": "for moduli that differ by up to 100 times"}
"""Films and substrates for which formulas were made."""


def _over_half_space(
    tip: Reported, law: Equivalent, x: Callable[[Array], Array], star: float, depth: Array, young: float
) -> Array:
    """Half-space force at the equivalent modulus [N]."""
    return tip.force(depth) * law(x(depth), young * star)


def equivalents(film: Medium) -> dict[str, Equivalent]:
    """Equivalent plane-strain moduli of one film on a half-space by published formulas.

    Each is a function of contact radius over thickness and of the film's plane-strain modulus [Pa].
    """
    base = film.base
    assert isinstance(base, HalfSpace)
    nu, substrate = layer_on_top(film)[1].poisson, base.surface_modulus
    return {
        "Gao": lambda x, e: published.gao(x, e, substrate, nu),
        "Perriot-Barthel": lambda x, e: published.perriot_barthel(x, e, substrate),
        "Bec": lambda x, e: published.bec(x, e, substrate),
    }
