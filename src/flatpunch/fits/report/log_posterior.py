"""The posterior density of a fit: likelihood of the curves, noise integrated out, times the priors.

With independent normal noise of unknown standard deviation s, prior 1/s, the integral over s is in closed form:

    p(x | F) ~ prod over curves S_i(x)^(-n_i/2) p(x),

S_i the sum of squares of curve i and n_i the number of its readings, of independent ones where neighbours are correlated. On
block means S falls by what the readings scatter within the blocks, which does not depend on x and is added back.

Residuals of many vectors at once come from the same tables as those of one. Two numbers of the calibration may differ between
vectors as well. With kappa the true over the assumed spring constant and sigma the same of the sensitivity, true forces are
kappa sigma times and true deflections sigma times those of the curve: the force of the model counts by 1/(kappa sigma), and a
force bends the cantilever by sigma/k.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeGuard

import numpy as np

from flatpunch._support.checks import TINY, Array, Indices
from flatpunch._support.declared import Place
from flatpunch._support.paths import Plain
from flatpunch.fits.elastic.model import ForwardModel
from flatpunch.fits.least_squares.objective import Objective, blocked
from flatpunch.fits.least_squares.problem import Problem
from flatpunch.fits.measured.signal import independent
from flatpunch.fits.parameters.sample import CALIBRATION, Scale
from flatpunch.fits.parameters.unknowns import Unknowns
from flatpunch.fits.report.posterior import Prior

_NEWTON = 8
"""Newton steps at most for the force behind a cantilever."""


def at_once(objective: object) -> TypeGuard[Objective]:
    """Whether residuals can be had at once: elastic contacts without adhesion or memory, from a table."""
    if not isinstance(objective, Objective) or not isinstance(objective.model, ForwardModel):
        return False
    return objective.loaded is None and objective.model.tabulated


def residuals_of_many(objective: Objective, x: Array, spring_constant: Array, sensitivity: Array) -> Array:
    """Residuals over the force range, shape (vectors, n), as `Objective.evaluate` has them; see `at_once`.

    For each vector x of internal parameters the calibration has factors, true over assumed, shape (vectors,).
    """
    count = len(objective.model.free)
    rest: Plain = dict(objective.held)
    for name, column in zip(objective.nuisance, x[:, count:].T, strict=True):
        offset, unit = objective.units[name]
        rest[name] = (offset + unit * column)[:, None]
    moving = objective.background(rest, objective.position, objective.speed)
    gain = (spring_constant * sensitivity)[:, None]
    give = np.zeros_like(gain) if objective.spring is None else sensitivity[:, None] / objective.spring
    depth = objective.position - give * (objective.force - moving) - rest["contact"]
    straight = np.broadcast_to(rest["baseline"] + moving - objective.force, depth.shape)
    found = _solved(objective, depth, straight, x[:, :count], gain, give)
    for weight in (objective.weight, None if objective.counts is None else np.sqrt(objective.counts)):
        if weight is not None:
            found *= weight
    return np.asarray(found / objective.frame.span)


def _solved(objective: Objective, depth: Array, straight: Array, theta: Array, gain: Array, give: Array) -> Array:
    """Residuals [N]: behind a cantilever the roots of r = straight + M(depth - give r)/gain, by Newton's method."""
    force, stiffness = forces(objective.model, depth, theta)
    found = np.asarray(straight + force / gain)
    if objective.spring is None:
        return found
    residual = found / (1 + stiffness * give / gain)
    for _ in range(_NEWTON):
        force, stiffness = forces(objective.model, depth - give * residual, theta)
        step = (straight + force / gain - residual) / (1 + stiffness * give / gain)
        residual = residual + step
        # Newton's method behind a cantilever ends with a step this small against the residuals
        if (np.abs(step).max(axis=1) < 1e-3 * np.sqrt(np.mean(residual**2, axis=1))).all():
            break
    return np.asarray(residual)


def forces(model: ForwardModel, depth: Array, theta: Array) -> tuple[Array, Array]:
    """Force [N] and stiffness [N/m] at depths of any sign, shape (vectors, n), for parameters of shape (vectors, free)."""
    force, stiffness = np.zeros_like(depth), np.zeros_like(depth)
    touching = np.flatnonzero((depth > 0).any(axis=0))
    if not touching.size:
        return force, stiffness
    some = slice(touching[0], touching[-1] + 1)
    inside = depth[:, some] > 0
    at = np.where(inside, depth[:, some], depth[:, some].max())
    value, slope = model.logarithms(np.log(at), theta)
    found = np.where(inside, np.exp(value), 0.0)
    force[:, some] = found
    stiffness[:, some] = found * slope / at
    return force, stiffness


BROAD = 3.0
"""Standard deviation of an internal parameter of which nothing is known: a factor 20 of a logarithmic one."""


@dataclass(frozen=True, eq=False)
class Quadratic:
    """Residuals as polynomials of second degree about the minimum: a surrogate for models that are slow.

    Attributes
    ----------
    origin : ndarray, shape (p,)
        Middle x.
    root : ndarray, shape (p, p)
        x = origin + root u with u of order one.
    terms : ndarray, shape (1 + p + p (p + 1)/2, n)
        Coefficients of 1, u_i and u_i u_j, i <= j.
    """

    origin: Array
    root: Array
    terms: Array

    @classmethod
    def of(cls, objective: Unknowns, origin: Array, root: Array, reach: float) -> Quadratic:
        """The polynomial through residuals at u_i = 0, +-reach and at both of two equal to reach."""
        axes = reach * np.eye(origin.size)

        def at(u: Array) -> Array:
            return np.asarray(objective.residuals(origin + root @ u))

        middle, ahead, behind = at(0 * origin), [at(u) for u in axes], [at(-u) for u in axes]
        linear = [(a - b) / (2 * reach) for a, b in zip(ahead, behind, strict=True)]
        square = [
            (ahead[i] + behind[i] - 2 * middle) / (2 * reach**2)
            if i == j
            else (at(axes[i] + axes[j]) - ahead[i] - ahead[j] + middle) / reach**2
            for i, j in zip(*np.triu_indices(origin.size), strict=True)
        ]
        return cls(origin, root, np.array([middle, *linear, *square]))

    def residuals(self, x: Array) -> Array:
        """Residuals at many vectors, shape (vectors, n)."""
        u = np.linalg.solve(self.root, (x - self.origin).T).T
        first, second = np.triu_indices(self.origin.size)
        return np.asarray(np.hstack([np.ones((len(x), 1)), u, u[:, first] * u[:, second]]) @ self.terms)


class Part(NamedTuple):
    """One curve.

    Attributes
    ----------
    objective : object
        Its residuals, on all readings or on block means.
    places : ndarray of int
        Where in x its parameters are.
    worth : float
        Independent readings that would be as certain as its own.
    within : float
        Sum of squares within the blocks.
    """

    objective: Unknowns | Quadratic
    places: Indices
    worth: float
    within: float = 0.0

    @property
    def fast(self) -> bool:
        """Whether many vectors are evaluated at once."""
        return isinstance(self.objective, Quadratic) or at_once(self.objective)

    def on_blocks(self, x: Array) -> Part:
        """The curve on block means, which are chosen at x; as it is where there are none."""
        own = self.objective
        if not at_once(own) or own.counts is not None:
            return self
        at = x[self.places]
        rest = own.split(at)[1]
        coarse = blocked(own, rest["contact"] + (rest["baseline"] / own.spring if own.spring else 0.0))
        within = [float(np.sum(each.residuals(at) ** 2)) for each in (own, coarse)]
        return self._replace(objective=coarse, within=max(within[0] - within[1], 0.0)) if coarse is not own else self

    def quadratic(self, middle: Array, root: Array, reach: float) -> Part:
        """The curve with residuals of second degree; as it is where many vectors are evaluated at once."""
        if isinstance(self.objective, Quadratic) or self.fast:
            return self
        own, spread = self.places, (root @ root.T)[np.ix_(self.places, self.places)]
        near = np.asarray(np.linalg.cholesky(spread), dtype=float)
        return self._replace(objective=Quadratic.of(self.objective, middle[own], near, reach))


@dataclass(frozen=True, eq=False)
class LogPosterior:
    """ln of the posterior density over the internal parameters; the last ones are ln of the calibration over the assumed one.

    Attributes
    ----------
    parts : tuple of Part
    numbers : mapping of str to Place
        Declarations of the parameters.
    scales : dict of str to Scale
        By the name of each parameter, in order.
    lower, upper : ndarray, shape (parameters,)
        Where the density is not zero.
    priors : mapping of str to Prior
    """

    parts: tuple[Part, ...]
    numbers: Mapping[str, Place]
    scales: dict[str, Scale]
    lower: Array
    upper: Array
    priors: Mapping[str, Prior]

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters in the order of x."""
        return tuple(self.scales)

    def __call__(self, x: Array) -> Array:
        """Values at many vectors, shape (vectors, parameters)."""
        result = np.full(len(x), -np.inf)
        inside = ((x >= self.lower) & (x <= self.upper)).all(axis=1)
        if inside.any():
            result[inside] = self.likelihood(x[inside]) + self.prior(x[inside])
        return np.where(np.isfinite(result), result, -np.inf)

    def likelihood(self, x: Array) -> Array:
        """ln of the likelihood, noise integrated out."""
        result = np.zeros(len(x))
        for part in self.parts:
            r = self.residuals(part, x)
            result -= part.worth / 2 * np.log(np.einsum("ij,ij->i", r, r) + part.within)
        return result

    def residuals(self, part: Part, x: Array) -> Array:
        """Residuals of a curve at many vectors, shape (vectors, n)."""
        own, objective = x[:, part.places], part.objective
        if at_once(objective):
            names = self.names
            factors = [np.exp(x[:, names.index(n)]) if n in names else np.ones(len(x)) for n in CALIBRATION]
            return residuals_of_many(objective, own, *factors)
        if isinstance(objective, Quadratic):
            return objective.residuals(own)
        return np.array([objective.residuals(row) for row in own])

    def prior(self, x: Array) -> Array:
        """ln of the prior density over the internal parameters."""
        result = np.zeros(len(x))
        for name, prior in self.priors.items():
            column, scale = x[:, self.names.index(name)], self.scales[name]
            result += prior.logarithm(scale.external(column)) + np.log(np.abs(scale.slope(column)))
        return result

    def parabola(self, x: Array) -> tuple[Array, Array]:
        """Most probable parameters and a root of their covariance, from the slopes of the residuals at x and the priors."""
        step = 1e-4 * np.eye(x.size)  # internal parameters are of order one
        information, shift = np.eye(x.size) / BROAD**2, np.zeros(x.size)
        for part in self.parts:
            r = self.residuals(part, np.vstack([x, x + step, x - step]))
            slopes = (r[1 : x.size + 1] - r[x.size + 1 :]) / (2 * step[0, 0])
            variance = (float(r[0] @ r[0]) + part.within) / max(part.worth - x.size, 1)
            information += slopes @ slopes.T / max(variance, TINY)
        for name, prior in self.priors.items():
            j, scale = self.names.index(name), self.scales[name]
            place = float(np.clip(scale.internal(prior.centre), self.lower[j], self.upper[j]))
            weight = float(scale.slope(np.array([place]))[0] / prior.spread) ** 2
            information[j, j] += weight
            shift[j] = weight * (place - x[j])
        unit = 1 / np.sqrt(np.diag(information))
        root = np.linalg.inv(np.linalg.cholesky(information * unit[:, None] * unit)).T * unit[:, None]
        return x + root @ root.T @ shift, root

    def quick(self, x: Array, middle: Array, root: Array, reach: float = 1.5) -> LogPosterior:
        """The density on block means chosen at x, with residuals of second degree about the middle where models are slow.

        Itself where these polynomials would go beyond a limit.
        """
        parts = [part.on_blocks(x) for part in self.parts]
        far = reach * np.abs(root).sum(axis=1)
        if not all(part.fast for part in parts) and (
            (middle - far <= self.lower).any() or (middle + far >= self.upper).any()
        ):
            return self
        return replace(self, parts=tuple(part.quadratic(middle, root, reach) for part in parts))


def parts_of(problem: Problem, x: Array) -> tuple[Part, ...]:
    """The curves of a problem, whose residuals at x show how many of their readings are independent."""
    pairs = zip(problem.parts, problem.places, strict=True)
    return tuple(Part(part, places, max(independent(part.evaluate(x[places])[0]), 1.0)) for part, places in pairs)
