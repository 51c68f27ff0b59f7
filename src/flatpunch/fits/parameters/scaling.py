"""What a free parameter does to the force curve: scaling as far as it goes, tables for the rest.

Every elastic contact obeys F = F0 phi(d/d0; q) with a reference force F0, a reference depth d0 and numbers q without
dimension. With one of its moduli, E, one of its lengths, l (a thickness, else the tip's own), and a power-law tip
f = c r^n psi(phi):

    d0 = c l^n,    F0 = E c l^(n+1);      other tips: d0 = l,  F0 = E l^2 and their own radius over l is one of the q.

In the logarithms of moduli, lengths and slopes ln F0, ln d0 and q are linear: a modulus, a thickness, a tip radius or an angle
costs nothing but an exponent. Only ratios of moduli, ratios of lengths and Poisson ratios are left for a table. E and l are
fixed ones where there are any, so that there are no more q than free parameters.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from flatpunch._support.checks import shown
from flatpunch.indenters import Cone, Cylinder, Paraboloid, Pyramid, Sphere
from flatpunch.indenters.profile import Indenter
from flatpunch.media import (
    Body,
    Stack,
    paths,
)

M = TypeVar("M", bound=Body)
T = TypeVar("T", bound=Indenter | None)

MODULUS_STEP, LENGTH_STEP, POISSON_STEP = 0.25, 0.125, 0.01
"""Knot spacing of the logarithms of ratios and of Poisson ratios; six knots at a time leave about 1e-7 in force."""


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One of the numbers q: linear in the internal parameters, tabulated at offset + step * integer.

    Parameters
    ----------
    name : str
        For messages.
    weights : mapping
        Internal parameter -> coefficient.
    step, offset : float
        Knots.
    lowest, highest : int or None
        Smallest and largest knot, where the coordinate ends.
    """

    name: str
    weights: Mapping[str, float]
    step: float
    offset: float = 0.0
    highest: int | None = None
    lowest: int | None = None


def parameter_names(medium: Body, indenter: Indenter | None) -> list[str]:
    """Names of all parameters of a medium and an indenter that can be fitted.

    See Also
    --------
    flatpunch.Free : Start and limits of one of them.
    flatpunch.fit : Fits them.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> from flatpunch.fits import parameter_names
    >>> print(parameter_names(gel, fp.Sphere(radius=5e-6)))
    ['layers[0].young', 'layers[0].poisson', 'layers[0].thickness', 'indenter.radius']
    """
    names = []
    for prefix, body in _bodies(medium).items():
        for i, layer in enumerate(body.layers):
            if layer.isotropic and "young" in layer.numbers:
                names += [f"{prefix}layers[{i}].{attribute}" for attribute in (*layer.numbers, "thickness")]
            elif not layer.varies:
                # all moduli at their ratios: more is not in a curve
                names += [f"{prefix}layers[{i}].{attribute}" for attribute in ("young", "thickness")]
            else:
                # the law of depth keeps its shape
                names.append(f"{prefix}layers[{i}].surface_modulus")
            springs = (("normal", layer.face.normal), ("shear", layer.face.shear))
            names += [f"{prefix}layers[{i}].bonded.{kind}" for kind, value in springs if value]
        if body.base.isotropic and "young" in body.base.numbers:
            names += [f"{prefix}base.{attribute}" for attribute in body.base.numbers]
        elif body.base.isotropic or body.base.anisotropic:
            names.append(f"{prefix}base.young")
    if isinstance(indenter, (Paraboloid, Sphere, Cylinder)):
        names.append("indenter.radius")
    if isinstance(indenter, (Cone, Pyramid)):
        names.append("indenter.inclination")
    return names


def _bodies(medium: Body) -> dict[str, Stack]:
    """The bodies of a medium by what their names begin with."""
    if not (medium.single or medium.pair):
        return {}
    return {f"{name}." if name else "": body for name, body in medium.sides}


def value_of(medium: Body, indenter: Indenter | None, name: str) -> float:
    """Value of a named parameter, SI."""
    _check(medium, indenter, (name,))
    return paths.value_of(medium, indenter, name)


def replaced(medium: M, indenter: T, values: Mapping[str, float]) -> tuple[M, T]:
    """Medium and indenter with some parameters replaced."""
    _check(medium, indenter, values)
    return paths.with_values(medium, indenter, values)


def _check(medium: Body, indenter: Indenter | None, names: Iterable[str]) -> None:
    """Refuse names that are no parameters of this case."""
    known = parameter_names(medium, indenter)
    for name in names:
        if name not in known:
            raise ValueError(f"free parameter {shown(name)} is not part of this case; it has {', '.join(known)}.")


_PLAIN = {
    "poisson": (-0.99, 0.5),
    "equilibrium": (0.0, 1 - 1e-6),
    "exponent": (1e-3, 1 - 1e-3),
    "weights": (1e-6, 1e3),
}
"""Parameters that are fitted as they are, and between which limits; of all others the logarithm is."""


MODULI = ("young", "surface_modulus")
"""Ends of the names of moduli."""

_SPRINGS = (".normal", ".shear")
"""Ends of the names of interface stiffnesses."""

OF = " @ "
"""Between the name of a parameter and that of the one curve that it belongs to."""


def kind(name: str) -> str:
    """What sort of parameter a name is: "young", "radius", "weights", ..."""
    return name.partition(OF)[0].split(".")[-1].split("[")[0]


def plain_limits(name: str) -> tuple[float, float] | None:
    """Limits of a parameter that is fitted as it is; None for those of which the logarithm is."""
    return _PLAIN.get(kind(name))


def internal(name: str, value: float) -> float:
    """Value in which scaling is linear: logarithm, logarithm of the slope for angles, numbers without unit as they are."""
    if kind(name) in _PLAIN:
        return value
    return math.log(math.tan(value)) if kind(name) == "inclination" else math.log(value)


def external(name: str, value: float) -> float:
    """Inverse of `internal`."""
    if kind(name) in _PLAIN:
        return value
    return math.atan(math.exp(value)) if kind(name) == "inclination" else math.exp(value)


def slope(name: str, value: float) -> float:
    """Derivative of the external over the internal value, at the external `value`."""
    if kind(name) in _PLAIN:
        return 1.0
    return math.sin(2 * value) / 2 if kind(name) == "inclination" else value


@dataclass(frozen=True)
class Scaling:
    """Reference force and depth, coordinates q, and how to build the problem at given q.

    Attributes
    ----------
    force, depth : mapping
        ln F0 and ln d0 as linear forms in internal parameters.
    coordinates : tuple of Coordinate
        The numbers q that change with the free parameters.
    modulus, length : str or None
        Parameters that serve as units.
    tip : str or None
        Slope or curvature of the tip, if it serves as a unit.
    """

    medium: Body
    indenter: Indenter
    force: Mapping[str, float]
    depth: Mapping[str, float]
    coordinates: tuple[Coordinate, ...]
    modulus: str | None
    length: str | None
    tip: str | None

    def problem(self, q: Sequence[float]) -> tuple[Body, Indenter]:
        """Medium and indenter of unit modulus, unit length and unit slope (as far as they scale) at coordinates q."""
        u = {name: internal(name, value_of(self.medium, self.indenter, name)) for name in self._all()}
        # the reference quantities keep their values here; q fixes the others relative to them
        for coordinate, value in zip(self.coordinates, q, strict=True):
            target = next(iter(coordinate.weights))
            rest = sum(f * u[name] for name, f in coordinate.weights.items() if name != target)
            u[target] = (value - rest) / coordinate.weights[target]
        shift = self._units(u)
        values = {name: external(name, u[name] - shift[name]) for name in self._all()}
        return replaced(self.medium, self.indenter, values)

    def _all(self) -> list[str]:
        return parameter_names(self.medium, self.indenter)

    def _units(self, u: Mapping[str, float]) -> dict[str, float]:
        """Internal value of the unit in which each parameter is measured."""
        shift = dict.fromkeys(self._all(), 0.0)
        for name in shift:
            if name.endswith(MODULI) and self.modulus:
                shift[name] = u[self.modulus]
            elif name.endswith(_SPRINGS):
                shift[name] = (u[self.modulus] if self.modulus else 0.0) - (u[self.length] if self.length else 0.0)
            elif name == self.tip:
                # slope and curvature are units of their own
                shift[name] = u[name]
            elif name.endswith(("thickness", "radius")) and self.length:
                shift[name] = u[self.length]
        return shift


def scaling(medium: Body, indenter: Indenter, free: Sequence[str], *, large: bool = False) -> Scaling:
    """Work out how the force depends on the free parameters; at large strains it is not in proportion to a cone's slope.

    Media that are not made of homogeneous layers and tips without a size of their own do not scale; then the free parameters
    are coordinates themselves.
    """
    _check(medium, indenter, free)
    names = parameter_names(medium, indenter)
    moduli_scale, homogeneous = not medium.power_law, not medium.varies
    power = indenter.exponent is not None
    lengths_scale = homogeneous and (power or indenter.flat or isinstance(indenter, Sphere))
    moduli = [name for name in names if name.endswith(MODULI)]
    lengths = [name for name in names if name.endswith("thickness")]
    tip = next((name for name in names if name.startswith("indenter")), None)
    if tip and not power:
        lengths.append(tip)
    unit_tip = tip if power and not large else None
    modulus = _unit(moduli, free) if moduli_scale else None
    length = _unit(lengths, free) if lengths_scale else None
    force: dict[str, float] = {}
    depth: dict[str, float] = {}
    if modulus:
        force[modulus] = 1.0
    if length:
        n = indenter.exponent or 1.0
        depth[length], force[length] = n, n + 1.0
    if unit_tip:
        # curvature 1/R of a paraboloid, tan of an inclination
        depth[unit_tip] = force[unit_tip] = -1.0 if unit_tip.endswith("radius") else 1.0
    coordinates = [*_ratios(moduli, modulus, MODULUS_STEP), *_ratios(lengths, length, LENGTH_STEP)]
    # knot of the Poisson ratio -0.99, below which no isotropic body is stable
    coordinates += [
        Coordinate(name, {name: 1.0}, POISSON_STEP, 0.5, 0, -149) for name in names if name.endswith("poisson")
    ]
    # springs scale like a modulus over a length
    units = {**({modulus: -1.0} if modulus else {}), **({length: 1.0} if length else {})}
    coordinates += [Coordinate(name, {name: 1.0, **units}, MODULUS_STEP) for name in names if name.endswith(_SPRINGS)]
    moving = tuple(c for c in coordinates if any(name in free for name in c.weights))
    return Scaling(medium, indenter, force, depth, moving, modulus, length, unit_tip)


def _unit(names: Sequence[str], free: Sequence[str]) -> str | None:
    """The quantity that the others are measured in: a fixed one if there is one."""
    return next((name for name in names if name not in free), names[0] if names else None)


def _ratios(names: Sequence[str], unit: str | None, step: float) -> list[Coordinate]:
    """Logarithms of quantities over their unit, or by themselves where there is none."""
    return [
        Coordinate(name, {name: 1.0} if unit is None else {name: 1.0, unit: -1.0}, step)
        for name in names
        if name != unit
    ]
