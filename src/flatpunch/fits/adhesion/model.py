"""Forward model of an adhesive fit (JKR): force over depth along the stable branch, with all derivatives.

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
from flatpunch.contact.adhesion.case import adhesive_case, check_range
from flatpunch.contact.adhesion.pull_off import pull_off
from flatpunch.contact.curve import FEW_ANGLES, NOTABLE_FORCE
from flatpunch.contact.indentation import indent
from flatpunch.fits.adhesion.branch import (
    BranchFamily,
    BranchTables,
    StableBranch,
    branch_tables,
    retreats_over_flat_end,
)
from flatpunch.fits.parameters.sample import WORK, Sample
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
        if self.sample.physics.range_of_action is not None:
            check_range(compliance(medium), tip, self.sample.physics.range_of_action)
        object.__setattr__(self, "method", adhesive_method(tip, self.method))
        free = [name for name in self.free if name != WORK]
        found = scaling(medium, tip, free, numbers=self.numbers)
        object.__setattr__(self, "knots", found.knots)
        work = None if tip.round or self.approximate else _work_coordinate(found)
        coordinates = (*found.coordinates, *([work] if work else []))
        half = _half_powers(found)
        weights = [found.depth, found.force, half[0], half[1], *(c.weights for c in coordinates)]
        linear = [self.linear(w) for w in weights]
        object.__setattr__(self, "_forms", (np.array([c for c, _ in linear]), np.array([w for _, w in linear])))
        start = found.problem([c.offset for c in found.coordinates])
        family = BranchFamily(*start, found, coordinates, work is not None)
        object.__setattr__(self, "_tables", branch_tables(family))

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
        return StableBranch(forms, weights, self._tables).up_to(deepest, softest)

    def pull_off(self, theta: Array) -> tuple[float, float]:
        """Depth and force at which the tip lets go under prescribed depth [m], [N]."""
        branch = self.branch(theta, 0.0)
        state = branch.at(np.array([branch.fold]))
        return float(state.depth[0]), float(state.force[0])

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
                **replace(sample.physics, range_of_action=None).given,
                angles=FEW_ANGLES,
            )
        notes = [str(curve.attrs["notes"])]
        if retreats_over_flat_end(sample.medium, sample.indenter):
            notes.append(
                "On this layer the contact goes on shrinking over the flat end of the tip before it lets go; the fit follows "
                "it to the border of the flat only. Cut the retract where the force has fallen that far."
            )
        if sample.physics.range_of_action is not None:
            notes += _of_finite_range(sample)
        return ExactForce.of(curve, notes)


def _of_finite_range(sample: Sample) -> list[str]:
    """A note where the range of action changes the pull-off force of the JKR theory that is fitted."""
    case = sample.medium, sample.indenter
    within, work = sample.physics.range_of_action, sample.value(WORK)
    by_jkr = pull_off(*case, work_of_adhesion=work).force
    force = pull_off(*case, work_of_adhesion=work, range_of_action=within).force
    if abs(force - by_jkr) < NOTABLE_FORCE * abs(by_jkr):
        return []
    return [
        f"With this range of action the pull-off force is {text(force, 'N')}, by the JKR theory that is fitted "
        f"{text(by_jkr, 'N')}: the work of adhesion is uncertain by about as much."
    ]


def _half_powers(found: Scaling) -> tuple[dict[str, float], dict[str, float]]:
    """ln (w l/E)^(1/2) and ln (w E l^3)^(1/2) as linear forms."""
    back, tension = {WORK: 0.5}, {WORK: 0.5}
    if found.modulus:
        back[found.modulus], tension[found.modulus] = -0.5, 0.5
    if found.length:
        back[found.length], tension[found.length] = 1 / 2, 3 / 2
    return back, tension


def _work_coordinate(found: Scaling) -> Coordinate:
    """ln of w over E c^2 l^(2n - 1), on which non-round tips depend; (d0/l)^2 contains c as far as it is a unit."""
    weights = {WORK: 1.0}
    for name, factor in found.depth.items():
        weights[name] = weights.get(name, 0.0) - 2 * factor
    for unit, factor in ((found.modulus, -1.0), (found.length, 1.0)):
        if unit:
            weights[unit] = weights.get(unit, 0.0) + factor
    return Coordinate(WORK, weights, MODULUS_STEP)
