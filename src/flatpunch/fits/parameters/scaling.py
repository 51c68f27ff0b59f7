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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from flatpunch._support.declared import Number, Place, numbers_of
from flatpunch.fits.parameters.sample import Numbers, Scale, numbers_in, smooth
from flatpunch.indenters import Cone, Paraboloid, Pyramid
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body, paths

MODULUS_STEP, POISSON_STEP = 0.25, 0.01
LENGTH_STEP = MODULUS_STEP / 2
"""Knot spacing of the logarithms of ratios and of Poisson ratios; six knots at a time leave about 1e-7 in force."""
_NEAR = 0.05
"""Largest change of the internal value of an untabulated number for which its derivatives are used again."""


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
    tabulated : bool
        Whether the force is smooth over it; otherwise each value is solved.
    """

    name: str
    weights: Mapping[str, float]
    step: float
    offset: float = 0.0
    highest: int | None = None
    lowest: int | None = None
    tabulated: bool = True


def parameter_names(medium: Body, indenter: Indenter | None) -> list[str]:
    """Names of all parameters of a medium and an indenter that can be fitted.

    They are those of `flatpunch.sensitivity`, and the moduli of a material at their ratios as one number: "layers[0].young" of a
    layer that is transversely isotropic, "layers[0].surface_modulus" of a graded one.

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
    return list(numbers_in(medium, indenter))


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
    numbers : mapping
        Records of all parameters.
    units : mapping
        For each number that scales, the unit in which it is measured: a product of powers of parameters.
    """

    medium: Body
    indenter: Indenter
    numbers: Mapping[str, Place]
    force: Mapping[str, float]
    depth: Mapping[str, float]
    coordinates: tuple[Coordinate, ...]
    modulus: str | None
    length: str | None
    units: Mapping[str, Mapping[str, float]]

    @property
    def knots(self) -> dict[str, tuple[float, float]]:
        """Internal values of numbers between which there are knots, where these end."""
        return {
            c.name: (c.offset + c.step * c.lowest, c.offset + c.step * c.highest)
            for c in self.coordinates
            if c.lowest is not None and c.highest is not None
        }

    def problem(self, q: Sequence[float]) -> tuple[Body, Indenter]:
        """Medium and indenter of unit modulus, unit length and unit slope (as far as they scale) at coordinates q."""
        names = {*self.units, *(next(iter(c.weights)) for c in self.coordinates)}
        scales = {name: Scale.of(self.numbers[name]) for name in names}
        u = {name: scale.internal(self.numbers[name].value) for name, scale in scales.items()}
        # the reference quantities keep their values here; q fixes the others relative to them
        for coordinate, value in zip(self.coordinates, q, strict=True):
            target = next(iter(coordinate.weights))
            rest = sum(f * u[name] for name, f in coordinate.weights.items() if name != target)
            u[target] = (value - rest) / coordinate.weights[target]
        values = {
            name: scale.external(u[name] - sum(f * u[unit] for unit, f in self.units.get(name, {}).items()))
            for name, scale in scales.items()
        }
        return paths.with_values(self.medium, self.indenter, values)


_OF_FACES = {"Pa/m": -1.0, "N/m": 1.0, "J": 3.0}
"""Springs and membranes by their units: they scale like a modulus times this power of a length."""


def scaling(
    medium: Body,
    indenter: Indenter,
    free: Sequence[str],
    *,
    large: bool = False,
    numbers: Numbers | None = None,
) -> Scaling:
    """Work out how the force depends on the free parameters; at large strains it is not in proportion to a cone's slope.

    Media that are not made of homogeneous layers and tips without a size of their own do not scale; then the free parameters
    are coordinates themselves.
    """
    numbers = numbers_in(medium, indenter) if numbers is None else numbers
    kept = _one_modulus_each(numbers, free)
    moduli, lengths, ratios = ([name for name in kept if numbers[name].number.unit == unit] for unit in ("Pa", "m", ""))
    faces = {name: _OF_FACES[unit] for name in kept if (unit := numbers[name].number.unit) in _OF_FACES}
    tip = _only_number(numbers, indenter)
    # heights are in proportion to the curvature or the slope that is the tip's number
    in_proportion = indenter.exponent is not None and isinstance(indenter, (Paraboloid, Cone, Pyramid))
    unit_tip = tip if in_proportion and not large else None
    if tip and indenter.exponent is None and numbers[tip].number.unit == "m":
        lengths.append(tip)
    known = {*moduli, *lengths, *ratios, *faces, unit_tip}
    exact = [numbers[name] for name in free if name not in known]
    sized = indenter.exponent is not None or tip in lengths
    of_tip = [each for each in exact if each.path.startswith("indenter.")]
    lengths_scale = sized and not medium.varies and not of_tip
    # a number of a material with several moduli moves them against each other
    moduli_scale = not medium.power_law and len(of_tip) == len(exact)
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
        depth[unit_tip] = force[unit_tip] = -1.0 if numbers[unit_tip].number.unit == "m" else 1.0
    stiff = {
        name: {**({modulus: 1.0} if modulus else {}), **({length: power} if length else {})}
        for name, power in faces.items()
    }
    coordinates = [*_ratios(moduli, modulus, MODULUS_STEP), *_ratios(lengths, length, LENGTH_STEP)]
    coordinates += [_poisson(name, numbers[name].number) for name in ratios]
    coordinates += [
        Coordinate(name, {name: 1.0, **{u: -f for u, f in own.items()}}, MODULUS_STEP) for name, own in stiff.items()
    ]
    moving = [c for c in coordinates if any(name in free for name in c.weights)]
    moving += [Coordinate(n.path, {n.path: 1.0}, _NEAR, Scale.of(n).internal(n.value), tabulated=False) for n in exact]
    units: dict[str, dict[str, float]] = {name: {modulus: 1.0} for name in moduli if modulus}
    units |= {name: {length: 1.0} for name in lengths if length} | stiff
    units |= {unit_tip: {unit_tip: 1.0}} if unit_tip else {}
    return Scaling(medium, indenter, numbers, force, depth, tuple(moving), modulus, length, units)


def _one_modulus_each(numbers: Numbers, free: Sequence[str]) -> list[str]:
    """Numbers of the medium in which the force is smooth, with one modulus for each material: the group where it is free."""
    found = [name for name, each in numbers.items() if name not in numbers.members and smooth(each)]
    for group, inside in numbers.members.items():
        if group in free or not any(member in found for member in inside):
            found = [group, *(name for name in found if name not in inside)]
    return found


def _only_number(numbers: Mapping[str, Place], indenter: Indenter) -> str | None:
    """The number of a tip that has one alone."""
    found = [each.path for each in numbers_of(indenter, "indenter")]
    return found[0] if len(found) == 1 and found[0] in numbers else None


def _poisson(name: str, number: Number) -> Coordinate:
    """A Poisson ratio between knots at its upper end and one above its lower, at which no isotropic body is stable."""
    lowest = 1 - round((number.high - number.low) / POISSON_STEP)
    return Coordinate(name, {name: 1.0}, POISSON_STEP, number.high, 0, lowest)


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
