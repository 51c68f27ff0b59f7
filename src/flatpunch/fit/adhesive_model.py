"""Forward model of an adhesive fit (JKR): force over depth along the stable branch, with all derivatives.

Along the branch of contact radii a of (T11.1), as `flatpunch.contact.adhesion_branch` has it,

    d = d_n - D,    F = F_n - T;    d_n = d0 exp f_0,  F_n = F0 exp f_1,  D = (w l/E)^(1/2) exp f_2,  T = (w E l^3)^(1/2) exp f_3

with f smooth functions of x = ln(a/l) and of the numbers q of `flatpunch.fit.scaling`, tabulated like the force without
adhesion. For round tips f does not depend on the work of adhesion w; for others w/(E c^2 l^(2n-1)) is one more q. The depth is
inverted for x by Newton's method, and at given depth dF/dtheta = F_theta - (F_x/d_x) d_theta.

The branch is followed from the largest contact down to where d_x vanishes: pull-off under prescribed depth. From two per cent
in radius before it the force goes on as a straight line, so that a trial step that lets go too early still has a slope.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from flatpunch._validation import Array, FlatpunchWarning
from flatpunch.compliance import compliance
from flatpunch.contact.adhesion_branch import Branch, Equilibria
from flatpunch.contact.adhesion_case import adhesive_case
from flatpunch.contact.adhesion_limits import largest_radius
from flatpunch.contact.adhesion_perturbed import PerturbedBranch
from flatpunch.contact.axisymmetric import round_contact
from flatpunch.contact.indent import indent
from flatpunch.contact.mean import mean_profile
from flatpunch.fit.sample import WORK, Sample
from flatpunch.fit.scaling import MODULUS_STEP, Coordinate, Scaling, external, internal, scaling, slope
from flatpunch.fit.table import STEP, Piecewise, Table

_FUNCTIONS = 4
_TABULATED = 2
"""Decades of radius below the largest; pull-off is nearly always within, and what is below goes on as a power law."""
_SEARCHED = 6.0
"""Decades of radius over which pull-off is looked for."""
_BEFORE = 0.02
_GRID = 600
_NEWTON = 6
_METHODS = ("auto", "first-order", "second-order")


def adhesive_method(indenter: Any, method: str) -> str:
    """Contact method of an adhesive fit: exact for round tips, second order for others."""
    if method not in _METHODS or (method == "first-order" and not indenter.round):
        raise ValueError(
            f"method = {method!r} does not go with work_of_adhesion; leave it out: adhesion is exact for round tips and known "
            "to second order for others."
        )
    return "first-order" if indenter.round else "second-order"


@dataclass(frozen=True)
class AdhesiveModel:
    """Force over depth of an adhesive contact as a function of the free parameters; see `ForwardModel`.

    Parameters
    ----------
    sample : Sample
        The case with its work of adhesion.
    free : tuple of str
        Names such as "layers[0].young", "work_of_adhesion".
    method : str
        "auto", or a method that knows adhesion.
    approximate : bool
        Take the round tip of the same mean profile: to find a start.
    """

    sample: Sample
    free: tuple[str, ...] = ()
    method: str = "auto"
    approximate: bool = False
    _tables: Any = field(init=False, repr=False, compare=False)
    _forms: Any = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in self.free:
            self.sample.check(name)
        medium, tip = self.sample.medium, self.sample.indenter
        if not tip.round and tip.exponent is None:
            # says what can be done
            adhesive_case(compliance(medium), tip, self.sample.value(WORK))
        object.__setattr__(self, "method", adhesive_method(tip, self.method))
        found = scaling(medium, tip, [name for name in self.free if name != WORK])
        work = None if tip.round or self.approximate else _work_coordinate(found)
        coordinates = (*found.coordinates, *([work] if work else []))
        half = _half_powers(found)
        weights = [found.depth, found.force, half[0], half[1], *(c.weights for c in coordinates)]
        linear = [self._linear(w) for w in weights]
        object.__setattr__(self, "_forms", (np.array([c for c, _ in linear]), np.array([w for _, w in linear])))
        object.__setattr__(self, "_tables", _tables(_Family(*_start(found), found, coordinates, work is not None)))

    @property
    def medium(self) -> Any:
        """Medium with the starting values."""
        return self.sample.medium

    @property
    def indenter(self) -> Any:
        """Tip with the starting values."""
        return self.sample.indenter

    def _linear(self, weights: Mapping[str, float]) -> tuple[float, Array]:
        fixed = sum(f * internal(n, self.sample.value(n)) for n, f in weights.items() if n not in self.free)
        return fixed, np.array([weights.get(name, 0.0) for name in self.free])

    def start(self) -> Array:
        """Internal values of the free parameters in the case."""
        return np.array([internal(name, self.sample.value(name)) for name in self.free])

    def externals(self, theta: Array) -> dict[str, float]:
        """Free parameters by name, SI."""
        return {name: external(name, float(t)) for name, t in zip(self.free, theta, strict=True)}

    def slopes(self, theta: Array) -> Array:
        """Derivatives of the external over the internal values."""
        return np.array([slope(name, value) for name, value in self.externals(theta).items()])

    def case(self, values: Mapping[str, float]) -> tuple[Any, Any]:
        """Medium and indenter with these values."""
        sample = self.sample.replaced(values)
        return sample.medium, sample.indenter

    def evaluate(self, depth: Array, theta: Array) -> tuple[Array, Array, Array]:
        """Force and derivatives at depths of any sign, on the stable branch.

        Parameters
        ----------
        depth : ndarray, shape (n,)
            Depths [m].
        theta : ndarray, shape (parameters,)
            Internal values of the free parameters.

        Returns
        -------
        force, stiffness : ndarray, shape (n,)
            F [N], dF/dd [N/m].
        derivatives : ndarray, shape (parameters, n)
            dF/dtheta [N].
        """
        with np.errstate(over="ignore"):
            return self._evaluated(depth, theta)

    def _evaluated(self, depth: Array, theta: Array) -> tuple[Array, Array, Array]:
        branch = self.branch(theta, float(depth.max(initial=-np.inf)))
        x, beyond = branch.radius_at(depth)
        state = branch.at(x)
        stiffness = state.force_slope / state.depth_slope
        by_theta = state.force_by - stiffness * state.depth_by
        return state.force + stiffness * beyond, stiffness, by_theta

    def branch(self, theta: Array, deepest: float) -> _Branch:
        """The stable branch up to a depth."""
        constants, weights = self._forms
        return _Branch(constants + (weights @ theta if theta.size else 0.0), weights, self._tables).up_to(deepest)

    def pull_off(self, theta: Array) -> tuple[float, float]:
        """Depth and force at which the tip lets go under prescribed depth [m], [N]."""
        branch = self.branch(theta, 0.0)
        state = branch.at(np.array([branch.fold]))
        return float(state.depth[0]), float(state.force[0])

    def force(self, depth: Array, values: Mapping[str, float] | None = None) -> Array:
        """Force at any depths; zero beyond pull-off.

        Parameters
        ----------
        depth : ndarray, shape (n,)
            Depths [m].
        values : mapping, optional
            Free parameters by name, SI; missing ones as in the case.
        """
        depth = np.asarray(depth, dtype=float)
        theta = self.start()
        for name, value in (values or {}).items():
            theta[self.free.index(name)] = internal(name, value)
        held = depth >= self.pull_off(theta)[0]
        result = np.zeros_like(depth)
        if held.any():
            result[held] = self.evaluate(depth[held], theta)[0]
        return result

    def exact(self, depth: Array, values: Mapping[str, float]) -> tuple[Array, str]:
        """The same without tables, from `indent`, and the notes of the theory."""
        import warnings

        sample = self.sample.replaced(values)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FlatpunchWarning)
            curve = indent(
                sample.medium,
                sample.indenter,
                depth=depth,
                method=self.method,
                work_of_adhesion=sample.work_of_adhesion,
                range_of_action=sample.range_of_action,
                angles=8,
            )
        return np.asarray(curve["force"].values), str(curve.attrs["notes"])


@dataclass(frozen=True, slots=True)
class _State:
    """Branch at n values of x: values, slopes over x, derivatives over theta (parameters, n) at constant x."""

    depth: Array
    force: Array
    depth_slope: Array
    force_slope: Array
    depth_by: Array
    force_by: Array


@dataclass(eq=False)
class _Branch:
    """The branch at given parameters. `forms`: ln d0, ln F0, ln (w l/E)^(1/2), ln (w E l^3)^(1/2), q; `weights` by theta."""

    forms: Array
    weights: Array
    family: _Tables
    top: float = 0.0
    fold: float = 0.0
    _pieces: tuple[Piecewise, ...] = ()
    _grid: tuple[Array, Array] | None = None

    def up_to(self, deepest: float) -> _Branch:
        """Choose the largest radius, and find pull-off below it."""
        q = tuple(self.forms[_FUNCTIONS:])
        top = self.family.begin(q, self.forms, deepest)
        most = self.family.tables[0].highest(q) - 3 * STEP
        for _ in range(400):
            top = min(top, most)
            self._pieces = tuple(table.at(q, top) for table in self.family.tables)
            depth, rising = self._depths(np.array([top]))
            if (depth[0] >= deepest and depth[0] > 0 and rising[0] > 0) or top >= most:
                break
            top += 4 * STEP
        self.top = top
        x = np.linspace(top - _SEARCHED * np.log(10), top, 40 * int(_SEARCHED))
        _, rising = self._depths(x)
        below = np.flatnonzero(rising <= 0)
        self.fold = float(x[0])
        if below.size and below[-1] + 1 < x.size:
            low, high = x[below[-1]], x[below[-1] + 1]
            for _ in range(40):
                middle = (low + high) / 2
                if self._depths(np.array([middle]))[1][0] > 0:
                    high = middle
                else:
                    low = middle
            self.fold = float(high)
        # denser towards pull-off, where the depth goes like the square of the distance in x
        start = min(self.fold + _BEFORE, self.top - STEP)
        grid = start + (self.top - start) * np.linspace(0, 1, _GRID) ** 2
        self._grid = (grid, self._depths(grid)[0])
        return self

    def _depths(self, x: Array) -> tuple[Array, Array]:
        """Depth and its slope."""
        (plain, up, _), (back, fall, _) = self._pieces[0].at(x), self._pieces[2].at(x)
        plain, back = np.exp(plain + self.forms[0]), np.exp(back + self.forms[2])
        return plain - back, plain * up - back * fall

    def radius_at(self, depth: Array) -> tuple[Array, Array]:
        """x at depths, and by how much depths lie beyond the ends of the branch [m]."""
        assert self._grid is not None
        grid, depths = self._grid
        inside = np.clip(depth, depths[0], depths[-1])
        cell = np.clip(np.searchsorted(depths, inside), 1, grid.size - 1)
        low, high = grid[cell - 1], grid[cell]
        x = np.interp(inside, depths, grid)
        for _ in range(_NEWTON):
            value, rising = self._depths(x)
            trial = np.clip(x - (value - inside) / rising, low, high)
            moved = float(np.abs(trial - x).max(initial=0.0))
            x = trial
            # quadratic convergence
            if moved < 1e-7:
                break
        return x, depth - inside

    def at(self, x: Array) -> _State:
        """Everything at given x."""
        parts, slopes, by = [], [], []
        for i, piece in enumerate(self._pieces):
            value, rising, others = piece.at(x)
            part = np.exp(value + self.forms[i])
            log_by = np.repeat(self.weights[i][:, None], x.size, axis=1)
            for j, other in enumerate(others):
                log_by += self.weights[_FUNCTIONS + j][:, None] * other
            parts.append(part)
            slopes.append(part * rising)
            by.append(part * log_by)
        return _State(
            parts[0] - parts[2],
            parts[1] - parts[3],
            slopes[0] - slopes[2],
            slopes[1] - slopes[3],
            by[0] - by[2],
            by[1] - by[3],
        )


def _half_powers(found: Scaling) -> tuple[dict[str, float], dict[str, float]]:
    """ln (w l/E)^(1/2) and ln (w E l^3)^(1/2) as linear forms."""
    back, tension = {WORK: 0.5}, {WORK: 0.5}
    if found.modulus:
        back[found.modulus], tension[found.modulus] = -0.5, 0.5
    if found.length:
        back[found.length], tension[found.length] = 0.5, 1.5
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


def _start(found: Scaling) -> tuple[Any, Any]:
    return found.problem([c.offset for c in found.coordinates])


@dataclass(frozen=True)
class _Family:
    """What models must have in common to share tables."""

    medium: Any
    indenter: Any
    scaling: Scaling = field(compare=False)
    coordinates: tuple[Coordinate, ...] = field(compare=False)
    by_work: bool

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(c.name for c in self.coordinates)

    def branch(self, q: tuple[float, ...]) -> tuple[Equilibria, Any, float]:
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
class _Tables:
    """f_0 to f_3 of one family."""

    family: _Family
    tables: tuple[Table, ...] = ()
    _solved: dict[Any, Array] = field(default_factory=dict)
    _coarse: tuple[Array, Array, Array] | None = None

    def __post_init__(self) -> None:
        def function(i: int) -> Callable[[tuple[float, ...], Array], Array]:
            return lambda q, radius: np.asarray(self._solve(q, radius)[i])

        family = self.family
        self.tables = tuple(
            Table(function(i), family.coordinates, family.limit, decades=_TABULATED) for i in range(_FUNCTIONS)
        )

    def _solve(self, q: tuple[float, ...], radius: Array) -> Array:
        """All four functions, shape (4, n); nan beyond the largest radius. What the tables have in common is solved once."""
        key = (q, radius.tobytes())
        if key not in self._solved:
            if len(self._solved) > 64:
                self._solved.clear()
            branch, indenter, work = self.family.branch(q)
            inside = radius < largest_radius(branch.kernel, indenter.reach)
            found = np.full((_FUNCTIONS, radius.size), np.nan)
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


def _tables(family: _Family) -> _Tables:
    try:
        return _shared(family, family.names)
    except TypeError:
        return _Tables(family)


@lru_cache(maxsize=32)
def _shared(family: _Family, names: tuple[str, ...]) -> _Tables:
    return _Tables(family)
