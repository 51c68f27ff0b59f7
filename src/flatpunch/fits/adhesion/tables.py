"""What the stable branches of adhesive contacts have in common: depth and force over the contact radius, scaled and tabulated.

Along the branch of contact radii a of (T11.1), as `flatpunch.contact.adhesion.branch` has it, or with a range of action (T11.4),

    d = d_n - D,    F = F_n - T;    d_n = d0 exp f_0,  F_n = F0 exp f_1,  D = (w l/E)^(1/2) exp f_2,  T = (w E l^3)^(1/2) exp f_3

with f smooth functions of x = ln(s/l), s^2 = a^2 - b^2 with the radius b of a flat end (none: s = a), and of the numbers q of
`flatpunch.fits.parameters.scaling`, tabulated like the force without adhesion and shared by all models of the same family. For
round tips they do not depend on the work of adhesion w; for others w/(E c^2 l^(2n-1)) is one more q. Beside a flat end d_n
begins like s, where its slope jumps, and the branch ends at a = b, which no power of a/l shows.

A range of action z0, with the stress s0 = w/z0, is one more q, z0/d0. Surfaces that attract one another across a disc of radius c
and do not touch go on, for tips without a flat end, with

    d = f(c) - s0 U(c) - z0,    F = -pi c^2 s0,    f = d0 exp f_4,  U = (l/E) exp f_5

with f the height of the tip, U what a unit tension on the disc lifts its rim, and f_4, f_5 functions of ln(c/l). Tips with a flat
end always retreat over it, down to where adhesion acts no further than its border, c = b. There the branch has kinks that move
with q: it is solved at each q, from c = b to where the contact is the flat, as series over c.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array
from flatpunch.compliances import compliance
from flatpunch.contact.adhesion.branch import Branch
from flatpunch.contact.adhesion.cohesive_zone import rim_lift
from flatpunch.contact.adhesion.maugis import MaugisBranch
from flatpunch.contact.adhesion.non_round import PerturbedBranch
from flatpunch.contact.adhesion.stability import largest_radius
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.fits.elastic.table import Table, shift
from flatpunch.fits.parameters.scaling import Coordinate, Scaling
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.numerics.chebyshev import NODES, nodal_transform, unit_nodes

FUNCTIONS = 4
"""f_0 to f_3."""


@dataclass(frozen=True)
class BranchFamily:
    """What models must have in common to share tables.

    Parameters
    ----------
    medium, indenter : object
        The scaled problem at the offsets of the coordinates.
    scaling : Scaling
        Follows from the problem up to units.
    coordinates : tuple of Coordinate
        The numbers q.
    fixed : tuple of float or None
        ln of w for tips that are not round, of w and z0 with a range of action; None for those that are coordinates, after those
        of the problem.
    """

    medium: Body
    indenter: Indenter
    scaling: Scaling = field(compare=False)
    coordinates: tuple[Coordinate, ...] = field(compare=False)
    fixed: tuple[float | None, ...] = ()

    @property
    def by_range(self) -> bool:
        """Whether adhesion has a range of action."""
        return len(self.fixed) == 2

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return tuple(c.name for c in self.coordinates)

    def branch(self, q: tuple[float, ...]) -> tuple[Branch | PerturbedBranch | MaugisBranch, Indenter]:
        """Branch of the scaled problem, and its tip."""
        count = len(self.scaling.coordinates)
        medium, indenter = self.scaling.problem(q[:count])
        kernel = compliance(medium)
        others = iter(q[count:])
        beside = [float(np.exp(next(others) if value is None else value)) for value in self.fixed]
        if self.by_range:
            work, within = beside
            return MaugisBranch(kernel, mean_profile(indenter), indenter.reach, work, within), indenter
        if beside:
            return PerturbedBranch(kernel, indenter, beside[0]), indenter
        profile = mean_profile(indenter)
        return Branch(kernel, lambda radius: round_contact(kernel, profile, radius), 1.0), indenter

    def limit(self, q: tuple[float, ...]) -> float:
        """ln of the largest s, by the coordinates of the problem alone."""
        medium, indenter = self.scaling.problem(q[: len(self.scaling.coordinates)])
        end = flat_end(indenter)
        most = largest_radius(compliance(medium), indenter.reach)
        return float(np.log((most - end) * (most + end)) / 2)


def flat_end(indenter: Indenter) -> float:
    """Radius of the flat end of a tip that rises beyond it, else 0."""
    heights = [(ring, *indenter.height(np.array([ring, 2 * ring]), np.zeros(2))) for ring in indenter.rings]
    return max((ring for ring, at, beyond in heights if at <= ROUNDING * beyond), default=0.0)


def retreats_over_flat_end(medium: Body, indenter: Indenter) -> bool:
    """Whether in JKR theory the contact goes on shrinking, stably, over the flat end of a tip; over s it ends at the border."""
    end = flat_end(indenter)
    if end == 0:
        return False
    kernel, profile = compliance(medium), mean_profile(indenter)
    contact = Branch(kernel, lambda radius: round_contact(kernel, profile, radius), 1.0).at(
        end * np.linspace(0.1, 1, 10)
    )
    return bool(contact.retraction.max() > contact.retraction[-1])


@dataclass(eq=False)
class BranchTables:
    """f_0 to f_3 of one family.

    Parameters
    ----------
    family : BranchFamily
        Whose branch it is.

    Attributes
    ----------
    functions : tuple of Table
        The four of them.
    apart : tuple of Table
        f_4 and f_5, with a range of action and without a flat end.
    """

    family: BranchFamily
    functions: tuple[Table, ...] = field(init=False)
    apart: tuple[Table, ...] = field(init=False)
    _flat: dict[tuple[float, ...], Array] = field(default_factory=dict)
    _solved: dict[tuple[tuple[float, ...], bytes], Array] = field(default_factory=dict)
    _coarse: tuple[Array, Array, Array] | None = None

    def __post_init__(self) -> None:
        def function(i: int) -> Callable[[tuple[float, ...], Array], Array]:
            return lambda q, radius: np.asarray(self._solve(q, radius)[i])

        family = self.family
        # decades below the largest s; pull-off is nearly always within, and what is below goes on as a power law, as D over s
        # does beside a flat end only where s << b, and with a range of action where a << c
        end = flat_end(family.indenter)
        decades = (5 if end else 6) if family.by_range else 4 if end else 2
        self.functions = tuple(Table(function(i), family.coordinates, family.limit, decades) for i in range(FUNCTIONS))
        others = family.scaling.coordinates
        lone = family.by_range and not end
        self.apart = tuple(Table(each, others, family.limit, 2) for each in (self._height, self._lift)) if lone else ()

    def over_flat(self, q: tuple[float, ...]) -> Array:
        """Series of `_over_flat` of the scaled problem, and their derivatives by q, shape (1 + coordinates, 2, 2, terms)."""
        if q not in self._flat:
            if len(self._flat) > 100:
                self._flat.clear()
            here, rows = _over_flat(*self.family.branch(q)), []
            for j, coordinate in enumerate(self.family.coordinates):
                step = shift(coordinate, q[j])
                moved = (*q[:j], q[j] + step, *q[j + 1 :])
                rows.append((_over_flat(*self.family.branch(moved)) - here) / step)
            self._flat[q] = np.array([here, *rows])
        return self._flat[q]

    def _height(self, q: tuple[float, ...], radius: Array) -> Array:
        """f of the scaled problem."""
        _, indenter = self.family.scaling.problem(q)
        return indenter.height(radius, np.zeros_like(radius))

    def _lift(self, q: tuple[float, ...], radius: Array) -> Array:
        """U of the scaled problem."""
        return rim_lift(compliance(self.family.scaling.problem(q)[0]), radius)

    def _solve(self, q: tuple[float, ...], distance: Array) -> Array:
        """All four functions of s, shape (4, n); nan beyond the largest. What the tables have in common is solved once."""
        key = (q, distance.tobytes())
        if key not in self._solved:
            if len(self._solved) > 100:
                self._solved.clear()
            branch, indenter = self.family.branch(q)
            end = flat_end(indenter)
            radius = np.hypot(distance, end)
            # beside the border of a flat end rounding hides the distance from it
            inside = (radius < largest_radius(branch.kernel, indenter.reach)) & (radius * (1 - ROUNDING) > end)
            found = np.full((FUNCTIONS, radius.size), np.nan)
            if inside.any():
                found[:, inside] = _parts(branch, radius[inside])
            self._solved[key] = found
        return self._solved[key]

    def begin(self, q: tuple[float, ...], forms: Array, deepest: float) -> float:
        """About the x at which a depth is reached above pull-off; at the first q that was asked for, near enough to begin."""
        if self._coarse is None:
            branch, indenter = self.family.branch(q)
            base = _round(branch)
            length = 1.0 if base.kernel.homogeneous or base.kernel.exponent else base.kernel.length
            most = largest_radius(base.kernel, indenter.reach)
            end = flat_end(indenter)
            # s of which a - b is known to some digits
            least = max(ROUNDING * min(length, most), 2 * np.sqrt(ROUNDING) * end)
            distance = np.geomspace(least, min(1e3 * length, most) / 2, 100)
            contact = base.at(np.hypot(distance, end))
            back = np.log(contact.retraction) - np.log(base.work) / 2
            self._coarse = np.log(distance), np.log(contact.plain.depth), back
        x, plain, back = self._coarse
        plain, back = np.exp(plain + forms[0]), np.exp(back + forms[2])
        enough = (plain - back >= max(deepest, 0.0)) & (plain > back)
        return float(x[int(np.argmax(enough)) if enough.any() else x.size - 1])


def _parts(branch: Branch | PerturbedBranch | MaugisBranch, radius: Array) -> Array:
    """d_n, F_n, D and T of the scaled problem over the square root of w, shape (4, n)."""
    if isinstance(branch, MaugisBranch):
        pressed, lessened = branch.evaluate(radius), branch.lessened(radius) / np.sqrt(branch.work)
        return np.array([pressed.depth, pressed.force, *lessened])
    contact, round_, found = branch.at(radius), _round(branch).at(radius), np.empty((FUNCTIONS, radius.size))
    # what a tip that is not round changes is shared out, so that both parts stay positive however weak the adhesion is
    for i, name in enumerate(("depth", "force")):
        plain, sum_ = getattr(round_.plain, name), getattr(round_, name)
        share = (getattr(contact, name) - sum_) / (2 * plain - sum_)
        found[i] = plain * (1 + share)
        found[i + 2] = (plain - sum_) * (1 - share) / np.sqrt(branch.work)
    return found


def _over_flat(branch: Branch | PerturbedBranch | MaugisBranch, indenter: Indenter) -> Array:
    """Chebyshev series of depth and force from where adhesion ends at the border of a flat end to where the contact does.

    Shape (2, 2, terms): before the surfaces touch, over c, and after, over the root of its distance.
    """
    assert isinstance(branch, MaugisBranch)
    end, v = flat_end(indenter), (1 + unit_nodes(NODES)) / 2
    touch, last = max(branch.opening, end), branch.passed(np.array([end]))[0]
    outer = np.concatenate([end + (touch - end) * v, touch + (last - touch) * v**2])
    depth, force, _ = branch.solved(outer).T
    return np.stack([depth - branch.range_of_action, force]).reshape(2, 2, NODES).swapaxes(0, 1) @ nodal_transform().T


def _round(branch: Branch | PerturbedBranch | MaugisBranch) -> Branch:
    """The branch of JKR theory of the mean profile."""
    return branch if isinstance(branch, Branch) else branch.base


@byte_cached
def branch_tables(family: BranchFamily, names: tuple[str, ...]) -> BranchTables:
    """Tables of a family, the same for all models that belong to it and have coordinates of the same names."""
    return BranchTables(family)
