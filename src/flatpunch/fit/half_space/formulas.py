"""Which published formulas apply to a sample and a tip, and the force that each of them gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, BadValue
from flatpunch._support.kinds import one_of
from flatpunch.fit.half_space import published
from flatpunch.indenters import Cone, Cylinder, Paraboloid, Pyramid, Sphere
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, HalfSpace, Interface, Layer, Medium, RigidBase

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
    """The half-space formulas in use for a tip by their names, the usual one first; ValueError for tips without one."""
    if isinstance(indenter, (Sphere, Paraboloid)):
        return {"hertz": Reported("hertz", 4 / 3 * math.sqrt(indenter.radius), 1.5)}
    if isinstance(indenter, Cone):
        return {"sneddon": Reported("sneddon", 2 / (math.pi * math.tan(indenter.inclination)), 2.0)}
    if isinstance(indenter, Cylinder):
        return {"flat": Reported("flat", 2 * indenter.radius, 1.0)}
    if isinstance(indenter, Pyramid) and indenter.sides == 4:
        slope = 1 / math.tan(indenter.inclination)
        return {
            "bilodeau": Reported("bilodeau", 0.7453 * slope, 2.0),
            "rico": Reported("rico", slope / math.sqrt(2), 2.0),
        }
    raise ValueError(
        f"indenter = {type(indenter).__name__}: no half-space formula is in use for it; there are those for Sphere, "
        "Paraboloid, Cone, Cylinder and Pyramid(sides=4)."
    )


def has_half_space_model(indenter: Indenter) -> bool:
    """Whether a half-space formula is in use for a tip."""
    try:
        return bool(half_space_models(indenter))
    except ValueError:
        return False


def half_space_model(indenter: Indenter, name: str | None = None) -> Reported:
    """One of the half-space formulas for a tip, the first that fits it if no name is given.

    Names are "hertz", "sneddon", "flat", and for pyramids "bilodeau" (0.7453 E* tan(alpha) d^2, alpha the face's half opening
    angle) or "rico" (1/sqrt(2) instead of 0.7453).
    """
    found = half_space_models(indenter)
    if name is None:
        return next(iter(found.values()))
    return found[one_of("model", name, found, wrong=f"does not belong to a {type(indenter).__name__}")]


@dataclass(frozen=True, slots=True)
class Formula:
    """A published formula for one sample and tip.

    Parameters
    ----------
    name : str
        By its authors.
    force : callable
        (depths [m], Young's modulus of the layer [Pa]) -> forces [N].
    linear : bool
        Whether the force is proportional to that modulus.
    remark : str
        What the formula was made for, where the sample differs.
    """

    name: str
    force: Callable[[Array, float], Array]
    linear: bool = True
    remark: str = ""


def layer_on_top(medium: Body) -> tuple[Medium, Layer]:
    """Return the sample and the homogeneous layer at its surface, whose modulus formulas give; ValueError without one."""
    if not isinstance(medium, Medium) or not medium.layers or not isinstance(medium.layers[0], Layer):
        raise BadValue("layers[0]", "", "must be a homogeneous layer on top of a Medium: its modulus is looked for.")
    return medium, medium.layers[0]


def formulas(medium: Medium, indenter: Indenter) -> list[Formula]:
    """Return the published formulas for one layer on a base and a tip with a half-space model; none for more layers."""
    if len(medium.layers) != 1 or isinstance(medium.layers[0].bonded, Interface):
        return []
    found = list(_thin_layer(medium, indenter))
    return [*found, *_substrate(medium, indenter)] if isinstance(medium.base, HalfSpace) else found


def _thin_layer(medium: Medium, indenter: Indenter) -> Iterator[Formula]:
    """Factors on the half-space force of layers on rigid bases."""
    top = layer_on_top(medium)[1]
    nu, h, tip, bonded = top.poisson, top.thickness, half_space_model(indenter), bool(top.bonded)
    star = 1 / (1 - nu**2)
    rigid = "" if isinstance(medium.base, RigidBase) else "for a rigid base"
    half = "" if nu == 0.5 else "for nu = 0.5"

    def factor(name: str, of: Callable[[Array], Array], *remarks: str) -> Formula:
        said = "; ".join(remark for remark in (*remarks, rigid) if remark)
        return Formula(name, lambda d, young: young * star * tip.force(d) * of(d), remark=said)

    if isinstance(indenter, (Sphere, Paraboloid)):
        radius = indenter.radius

        def x(d: Array) -> Array:
            return np.sqrt(radius * d) / h

        yield factor("Dimitriadis", lambda d: published.dimitriadis(x(d), nu, bonded))
        if bonded:
            yield factor("Garcia", lambda d: published.garcia(x(d), "paraboloid"), half)
            if published.LONG[0] <= radius / h < published.LONG[1]:
                yield factor("Long", lambda d: published.long(x(d), radius / h), "for large strains", half)
            yield Formula(
                "Chadwick",
                lambda d, young: published.chadwick(radius, d, young, h),
                remark="for bonded incompressible layers much thinner than the contact",
            )
    elif isinstance(indenter, Cylinder) and bonded:
        yield factor("Garcia", lambda d: published.garcia(np.full_like(d, indenter.radius / h), "flat"), half)
    elif isinstance(indenter, (Cone, Pyramid)):
        slope = 1 / math.tan(indenter.inclination)
        if bonded:
            made_for = "" if isinstance(indenter, Cone) else "for cones"
            yield factor("Garcia", lambda d: published.garcia(slope * d / h, "cone"), made_for, half)
        if isinstance(indenter, Pyramid):
            ours = published.PYRAMID_FORCE[4] * slope / tip.factor
            yield factor(
                "flatpunch", lambda d: ours * published.pyramid(slope * d / h, 4, bonded), "of this project", half
            )


def _substrate(medium: Medium, indenter: Indenter) -> Iterator[Formula]:
    """Equivalent moduli E(a/t): the contact radius is the half-space's, as these formulas are used."""
    top, base, tip = layer_on_top(medium)[1], medium.base, half_space_model(indenter)
    assert isinstance(base, HalfSpace)
    nu, t, substrate = top.poisson, top.thickness, base.surface_modulus

    def radius(d: Array) -> Array:
        if isinstance(indenter, (Sphere, Paraboloid)):
            return np.asarray(np.sqrt(indenter.radius * d))
        if isinstance(indenter, Cylinder):
            return np.full_like(d, indenter.radius)
        assert isinstance(indenter, (Cone, Pyramid))
        return np.asarray(2 / math.pi * d / math.tan(indenter.inclination))

    laws: dict[str, Callable[[Array, float], Array]] = {
        "Gao": lambda d, film: published.gao(radius(d) / t, film, substrate, nu),
        "Perriot-Barthel": lambda d, film: published.perriot_barthel(radius(d) / t, film, substrate),
        "Bec": lambda d, film: published.bec(radius(d), film, substrate, t),
    }
    if isinstance(indenter, (Sphere, Paraboloid)):
        laws["Clifford"] = lambda d, film: published.clifford(indenter.radius, d, film, nu, substrate, base.poisson, t)
    made_for = {
        "Gao": "for bodies of similar stiffness",
        "Perriot-Barthel": "for moduli that differ by up to 100 times",
    }
    for name, law in laws.items():

        def force(d: Array, young: float, law: Callable[[Array, float], Array] = law) -> Array:
            return tip.force(d) * law(d, young / (1 - nu**2))

        yield Formula(name, force, linear=False, remark=made_for.get(name, ""))
