"""Forward model of an adhesive fit: force over depth along the stable branch, with all derivatives.

`contact.adhesion.branch` has depth and force over x = ln(a/l). The depth is inverted for x by Newton's method, and at given
depth dF/dtheta = F_theta - (F_x/d_x) d_theta.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from flatpunch._support.checks import Array, BadValue, FlatpunchWarning, shown
from flatpunch._support.prefixes import text
from flatpunch.compliances import compliance
from flatpunch.contact import MethodName
from flatpunch.contact.adhesion.case import adhesive_case
from flatpunch.contact.curve import FEW_ANGLES
from flatpunch.contact.indentation import indent
from flatpunch.contact.physics import Physics
from flatpunch.fits.adhesion.branch import StableBranch
from flatpunch.fits.adhesion.tables import BranchFamily, BranchTables, branch_tables, retreats_over_flat_end
from flatpunch.fits.parameters.sample import ADHESION, RANGE, STRENGTH, WORK, Sample
from flatpunch.fits.parameters.scaling import MODULUS_STEP, Coordinate, Scaling, scaling
from flatpunch.fits.parameters.settings import FitMethod
from flatpunch.fits.parameters.unknowns import ExactForce, FreeParameters
from flatpunch.indenters.profile import Indenter


def adhesive_method(indenter: Indenter, method: FitMethod) -> MethodName:
    """Contact method of an adhesive fit: exact for round tips, second order for others."""
    name = method if isinstance(method, str) else method.name
    if name not in ("auto", "second-order", *(("exact", "first-order") if indenter.round else ())):
        raise BadValue(
            "method",
            shown(name),
            "does not go with work_of_adhesion; leave it out: adhesion is exact for round tips and known to "
            "second order for others.",
        )
    return "exact" if indenter.round else "second-order"


@dataclass(frozen=True)
class AdhesiveModel(FreeParameters):
    """Force over depth of an adhesive contact as a function of the free parameters; see `ForwardModel`.

    Parameters
    ----------
    sample : Sample
        The case with its work of adhesion.
    free : tuple of str
        Names such as "layers[0].young", "work_of_adhesion".
    method : str or method
        "auto", or a method that knows adhesion.
    approximate : bool
        Take the round tip of the same mean profile: to find a start.
    """

    sample: Sample
    free: tuple[str, ...] = ()
    method: FitMethod = "auto"
    approximate: bool = False
    adhesive: ClassVar[bool] = True
    _tables: BranchTables = field(init=False, repr=False, compare=False)
    _forms: tuple[Array, Array] = field(init=False, repr=False, compare=False)
    knots: Mapping[str, tuple[float, float]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        self.sample.check(self.free)
        medium, tip = self.sample.medium, self.sample.indenter
        if not tip.round and tip.exponent is None:
            # says what can be done
            adhesive_case(compliance(medium), tip, self.sample.value(WORK))
        object.__setattr__(self, "method", adhesive_method(tip, self.method))
        free = [name for name in self.free if name not in ADHESION]
        found = scaling(medium, tip, free, numbers=self.numbers)
        object.__setattr__(self, "knots", found.knots)
        reach = None if self.approximate else _range(self.sample.physics)
        beside = reach is not None or not (tip.round or self.approximate)
        alike = beside and compliance(medium).homogeneous and all(c.tabulated for c in found.coordinates)
        found, length = _lengths(found, tip.exponent if alike else None)
        weights, moving = _units(found, length, reach), list(found.coordinates)
        fixed: list[float | None] = []
        for coordinate in _beside(found, length, reach) if beside else []:
            moves = any(name in self.free for name in coordinate.weights)
            fixed.append(None if moves else self.linear(coordinate.weights)[0])
            moving += [coordinate] if moves else []
        weights += [c.weights for c in moving]
        linear = [self.linear(w) for w in weights]
        object.__setattr__(self, "_forms", (np.array([c for c, _ in linear]), np.array([w for _, w in linear])))
        start = found.problem([c.offset for c in found.coordinates])
        family = BranchFamily(*start, found, tuple(moving), tuple(fixed))
        object.__setattr__(self, "_tables", branch_tables(family, family.names))

    @property
    def family(self) -> BranchFamily:
        """What models must have in common to share tables."""
        return self._tables.family

    @property
    def tabulated(self) -> bool:
        """Whether the branch comes from tables; with many free parameters each is solved."""
        return self._tables.functions[0].tabulated

    def evaluate(self, depth: Array, theta: Array, softest: float = -np.inf) -> tuple[Array, Array, Array]:
        """Force F [N], dF/dd [N/m] and dF/dtheta [N], shape (parameters, n), at depths [m] of any sign, on the stable branch.

        Below the stiffness `softest` [N/m] the branch is continued by its tangent.
        """
        with np.errstate(over="ignore"):
            return self._evaluated(depth, theta, softest)

    def _evaluated(self, depth: Array, theta: Array, softest: float) -> tuple[Array, Array, Array]:
        branch = self.branch(theta, float(depth.max(initial=-np.inf)), softest)
        x, beyond = branch.radius_at(depth)
        state = branch.at(x)
        stiffness = state.force_slope / state.depth_slope
        by_theta = state.force_by - stiffness * state.depth_by
        return state.force + stiffness * beyond, stiffness, by_theta

    def branch(self, theta: Array, deepest: float, softest: float = -np.inf) -> StableBranch:
        """The stable branch up to a depth, from a stiffness on."""
        constants, weights = self._forms
        forms = constants + (weights @ theta if theta.size else 0.0)
        try:
            return StableBranch(forms, weights, self._tables).up_to(deepest, softest)
        except BadValue as fault:
            if fault.field != RANGE:
                raise
            raise BadValue(
                RANGE,
                text(float(np.exp(forms[4])), "m"),
                "is too long for fits under this tip: with ranges up to twice as long as those that are tried the surfaces must "
                "touch within its shape. Take a shorter one, limit it where it is free, or give the shape further out.",
            ) from None

    def pull_off(self, theta: Array) -> tuple[float, float]:
        """Depth and force at which the tip lets go under prescribed depth [m], [N]."""
        branch = self.branch(theta, 0.0)
        state = branch.at(np.array([branch.fold]))
        return float(state.depth[0]), float(state.force[0])

    def about_to_snap(self, theta: Array, deepest: float, spring: float) -> tuple[float, float] | None:
        """Largest depth and its force at which dF/dd is below -k/2 behind a cantilever of stiffness k; None if it is nowhere.

        Nearer to its instability, dF/dd = -k, noise moves the tip by more than twice what it shows.
        """
        way = np.linspace(self.pull_off(theta)[0], deepest, 10_000)
        force, stiffness, _ = self.evaluate(way, theta)
        past = np.flatnonzero(stiffness < -0.5 * spring)
        return (float(way[past[-1]]), float(force[past[-1]])) if past.size else None

    def opening(self, theta: Array, deepest: float) -> float:
        """Depth [m] at which a contact that was made without adhesion at `deepest` begins to shrink when it is pulled."""
        return self.branch(theta, deepest).opening(deepest)

    def force(self, depth: Array, values: Mapping[str, float] | None = None) -> Array:
        """Force [N] at any depths [m], zero beyond pull-off; free parameters that `values` lacks are as in the case."""
        depth = np.asarray(depth, dtype=float)
        theta = self.internals(values)
        held = depth >= self.pull_off(theta)[0]
        result = np.zeros_like(depth)
        if held.any():
            result[held] = self.evaluate(depth[held], theta)[0]
        return result

    def exact(self, depth: Array, values: Mapping[str, float]) -> ExactForce:
        """Force without tables, from `indent`, with the notes of the theory."""
        import warnings

        sample = self.sample.replaced(values)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FlatpunchWarning)
            curve = indent(
                sample.medium,
                sample.indenter,
                depth=depth,
                method=adhesive_method(sample.indenter, self.method),
                **sample.physics.given,
                angles=FEW_ANGLES,
            )
        notes = [str(curve.attrs["notes"])]
        if sample.physics.within is None and retreats_over_flat_end(sample.medium, sample.indenter):
            notes.append(
                "On this layer the contact goes on shrinking over the flat end of the tip before it lets go; the fit follows "
                "it to the border of the flat only. Cut the retract where the force has fallen that far."
            )
        return ExactForce.of(curve, notes)


Weights = dict[str, float]


def _sum(*terms: tuple[float, Mapping[str, float]]) -> Weights:
    """Linear forms with factors, added."""
    total: Weights = {}
    for factor, weights in terms:
        for name, weight in weights.items():
            total[name] = total.get(name, 0.0) + factor * weight
    return total


def _range(physics: Physics) -> Weights | None:
    """ln z0."""
    if physics.within is None:
        return None
    return {RANGE: 1.0} if physics.strength is None else {WORK: 1.0, STRENGTH: -1.0}


def _lengths(found: Scaling, exponent: float | None) -> tuple[Scaling, Weights]:
    """ln l, and the forms with it.

    On half-spaces, where there is no other length, tips c r^n of the given exponent n take that of adhesion,
    l^(2n - 1) = w/(E c^2).
    """
    if exponent is None:
        return found, _one(found.length)
    part = 1 / (2 * exponent - 1)
    length = _sum((part, {WORK: 1.0}), (-part, _one(found.modulus)), (-2 * part, found.depth))
    depth, force = _sum((1, found.depth), (exponent, length)), _sum((1, found.force), (exponent + 1, length))
    return replace(found, depth=depth, force=force), length


def _units(found: Scaling, length: Weights, reach: Weights | None) -> list[Mapping[str, float]]:
    """The forms of `StableBranch` before the coordinates."""
    work, modulus = {WORK: 1.0}, _one(found.modulus)
    halves = [(0.5, work), (-0.5, modulus), (0.5, length)], [(0.5, work), (0.5, modulus), (1.5, length)]
    jkr = [found.depth, found.force, *(_sum(*half) for half in halves)]
    if reach is None:
        return jkr
    stress = _sum((1, work), (-1, reach))
    return [*jkr, reach, _sum((1, stress), (1, length), (-1, modulus)), _sum((1, stress), (2, length))]


def _beside(found: Scaling, length: Weights, reach: Weights | None) -> list[Coordinate]:
    """ln of w over E c^2 l^(2n - 1), on which tips depend that are not round, and all with a range of action; and z0 over d0.

    (d0/l)^2 contains c as far as it is a unit.
    """
    work = _sum((1, {WORK: 1.0}), (-2, found.depth), (-1, _one(found.modulus)), (1, length))
    if WORK in length:
        # it is 1
        work = {}
    ranges = [] if reach is None else [Coordinate(RANGE, _sum((1, reach), (-1, found.depth)), MODULUS_STEP)]
    return [Coordinate(WORK, work, MODULUS_STEP), *ranges]


def _one(unit: str | None) -> Weights:
    return {unit: 1.0} if unit else {}
