"""Tables of the functions that the branch of an adhesive contact is made of, shared by all models of the same family.

The functions f_0 to f_3 of `flatpunch.fit.adhesion.branch` are those of the scaled problem: over x = ln(a/l) and the numbers q.
For round tips they do not depend on the work of adhesion w; for others w/(E c^2 l^(2n-1)) is one more q.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.compliance import compliance
from flatpunch.contact.adhesion.branch import Branch, Equilibria
from flatpunch.contact.adhesion.non_round import PerturbedBranch
from flatpunch.contact.adhesion.stability import largest_radius
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.fit.elastic.table import Table
from flatpunch.fit.parameters.scaling import Coordinate, Scaling
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body

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
    by_work : bool
        Whether the last of them is the work of adhesion.
    """

    medium: Body
    indenter: Indenter
    scaling: Scaling = field(compare=False)
    coordinates: tuple[Coordinate, ...] = field(compare=False)
    by_work: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return tuple(c.name for c in self.coordinates)

    def branch(self, q: tuple[float, ...]) -> tuple[Equilibria, Indenter, float]:
        """Branch of the scaled problem, its tip, and w."""
        count = len(self.scaling.coordinates)
        medium, indenter = self.scaling.problem(q[:count])
        kernel = compliance(medium)
        if self.by_work:
            work = float(np.exp(q[count]))
            return PerturbedBranch(kernel, indenter, work), indenter, work
        profile = mean_profile(indenter)
        return Branch(kernel, lambda radius: round_contact(kernel, profile, radius), 1.0), indenter, 1.0

    def limit(self, q: tuple[float, ...]) -> float:
        """ln of the largest radius."""
        branch, indenter, _ = self.branch(q)
        return float(np.log(largest_radius(branch.kernel, indenter.reach)))


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
    """

    family: BranchFamily
    functions: tuple[Table, ...] = field(init=False)
    _solved: dict[tuple[tuple[float, ...], bytes], Array] = field(default_factory=dict)
    _coarse: tuple[Array, Array, Array] | None = None

    def __post_init__(self) -> None:
        def function(i: int) -> Callable[[tuple[float, ...], Array], Array]:
            return lambda q, radius: np.asarray(self._solve(q, radius)[i])

        family = self.family
        # decades of radius below the largest; pull-off is nearly always within, and what is below goes on as a power law
        self.functions = tuple(
            Table(function(i), family.coordinates, family.limit, decades=2) for i in range(FUNCTIONS)
        )

    def _solve(self, q: tuple[float, ...], radius: Array) -> Array:
        """All four functions, shape (4, n); nan beyond the largest radius. What the tables have in common is solved once."""
        key = (q, radius.tobytes())
        if key not in self._solved:
            if len(self._solved) > 64:
                self._solved.clear()
            branch, indenter, work = self.family.branch(q)
            inside = radius < largest_radius(branch.kernel, indenter.reach)
            found = np.full((FUNCTIONS, radius.size), np.nan)
            contact = branch.at(radius[inside])
            back, tension = contact.plain.depth - contact.depth, contact.plain.force - contact.force
            half = np.sqrt(work)
            found[:, inside] = contact.plain.depth, contact.plain.force, back / half, tension / half
            self._solved[key] = found
        return self._solved[key]

    def begin(self, q: tuple[float, ...], forms: Array, deepest: float) -> float:
        """About the x at which a depth is reached above pull-off; at the first q that was asked for, near enough to begin."""
        if self._coarse is None:
            branch, indenter, _ = self.family.branch(q)
            base = branch.base if isinstance(branch, PerturbedBranch) else branch
            length = 1.0 if base.kernel.homogeneous or base.kernel.exponent else base.kernel.length
            most = largest_radius(base.kernel, indenter.reach)
            radius = np.geomspace(1e-12 * min(length, most), min(1e3 * length, most) / 2, 200)
            contact = base.at(radius)
            work = branch.work
            self._coarse = np.log(radius), np.log(contact.plain.depth), np.log(contact.retraction) - np.log(work) / 2
        x, plain, back = self._coarse
        plain, back = np.exp(plain + forms[0]), np.exp(back + forms[2])
        enough = (plain - back >= max(deepest, 0.0)) & (plain > back)
        return float(x[int(np.argmax(enough)) if enough.any() else x.size - 1])


def branch_tables(family: BranchFamily) -> BranchTables:
    """Tables of a family, the same for all models that belong to it."""
    try:
        return _shared(family, family.names)
    except TypeError:
        # an unhashable part (a user's own indenter): tables of its own
        return BranchTables(family)


def forget_tables() -> None:
    """Forget the tables that models share."""
    _shared.cache_clear()


@byte_cached
def _shared(family: BranchFamily, names: tuple[str, ...]) -> BranchTables:
    return BranchTables(family)
