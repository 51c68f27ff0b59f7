"""The posterior density of a fit: likelihood of the curves, noise integrated out, times the priors.

With independent normal noise of unknown standard deviation s, prior 1/s, the integral over s is in closed form:

    p(x | F) ~ prod over curves S_i(x)^(-n_i/2) p(x),

S_i the sum of squares of curve i and n_i the number of its readings, of independent ones where neighbours are correlated. On
block means S falls by what the readings scatter within the blocks, which does not depend on x and is added back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.fit.elastic import ensemble
from flatpunch.fit.least_squares.blocks import blocked
from flatpunch.fit.least_squares.joint import JointObjective
from flatpunch.fit.measured.signal import independent
from flatpunch.fit.parameters.priors import Prior
from flatpunch.fit.parameters.scaling import kind, plain_limits
from flatpunch.fit.parameters.unknowns import Unknowns


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
        p = origin.size

        def at(*places: tuple[int, float]) -> Array:
            u = np.zeros(p)
            for i, value in places:
                u[i] += value
            return np.asarray(objective.residuals(origin + root @ u))

        middle = at()
        ahead = [at((i, reach)) for i in range(p)]
        behind = [at((i, -reach)) for i in range(p)]
        linear = [(a - b) / (2 * reach) for a, b in zip(ahead, behind, strict=True)]
        square = [
            (ahead[i] + behind[i] - 2 * middle) / (2 * reach**2)
            if i == j
            else (at((i, reach), (j, reach)) - ahead[i] - ahead[j] + middle) / reach**2
            for i in range(p)
            for j in range(i, p)
        ]
        return cls(origin, root, np.array([middle, *linear, *square]))

    def residuals(self, x: Array) -> Array:
        """Residuals at many vectors, shape (vectors, n)."""
        u = np.linalg.solve(self.root, (x - self.origin).T).T
        first, second = np.triu_indices(self.origin.size)
        features = np.hstack([np.ones((len(x), 1)), u, u[:, first] * u[:, second]])
        return np.asarray(features @ self.terms)


CALIBRATION = ("spring_constant", "sensitivity")
"""Numbers of the calibration that may be drawn; the first is given in N/m, the second relative to the one used."""


@dataclass(frozen=True, eq=False)
class Part:
    """One curve.

    Attributes
    ----------
    objective : object
        Its residuals, on all readings or on block means.
    places : ndarray of int
        Where in x its parameters are.
    count : float
        Independent readings that would be as certain as its own.
    within : float
        Sum of squares within the blocks.
    """

    objective: Unknowns | Quadratic
    places: Indices
    count: float
    within: float = 0.0


@dataclass(frozen=True, eq=False)
class LogPosterior:
    """ln of the posterior density over the internal parameters; the last ones are ln of the calibration over the assumed one.

    Attributes
    ----------
    parts : tuple of Part
    names : tuple of str
    lower, upper : ndarray, shape (parameters,)
        Where the density is not zero.
    scales : mapping of str to (float, float)
        Offset and unit of contact and background.
    assumed : mapping of str to float
        Values of the calibration that was used.
    priors : mapping of str to Prior
    """

    parts: tuple[Part, ...]
    names: tuple[str, ...]
    lower: Array
    upper: Array
    scales: Mapping[str, tuple[float, float]]
    assumed: Mapping[str, float]
    priors: Mapping[str, Prior]

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
            result -= part.count / 2 * np.log(np.einsum("ij,ij->i", r, r) + part.within)
        return result

    def residuals(self, part: Part, x: Array) -> Array:
        """Residuals of a curve at many vectors, shape (vectors, n)."""
        own = x[:, part.places]
        if ensemble.applies(part.objective):
            return ensemble.residuals(part.objective, own, *(self._calibration(name, x) for name in CALIBRATION))
        if isinstance(part.objective, Quadratic):
            return part.objective.residuals(own)
        return np.array([part.objective.residuals(row) for row in own])

    def _calibration(self, name: str, x: Array) -> Array:
        return np.exp(x[:, self.names.index(name)]) if name in self.names else np.ones(len(x))

    def prior(self, x: Array) -> Array:
        """ln of the prior density over the internal parameters."""
        result = np.zeros(len(x))
        for name, prior in self.priors.items():
            column = x[:, self.names.index(name)]
            value, slope = self.external(name, column)
            result += prior.logarithm(value) + np.log(np.abs(slope))
        return result

    def external(self, name: str, x: Array) -> tuple[Array, Array]:
        """Values of a parameter in SI, and their derivative by the internal ones."""
        if name in self.scales:
            offset, unit = self.scales[name]
            return offset + unit * x, np.full_like(x, unit)
        if name in self.assumed:
            value = self.assumed[name] * np.exp(x)
            return value, value
        if plain_limits(name):
            return x, np.ones_like(x)
        if kind(name) == "inclination":
            value = np.arctan(np.exp(x))
            return value, np.sin(2 * value) / 2
        value = np.exp(x)
        return value, value

    @property
    def fast(self) -> bool:
        """Whether many vectors can be evaluated at once."""
        return all(isinstance(part.objective, Quadratic) or ensemble.applies(part.objective) for part in self.parts)

    def quadratic(self, origin: Array, root: Array, reach: float = 1.5) -> LogPosterior:
        """Return the density with residuals of second degree about `origin` in place of slow models; itself beyond a limit."""
        far = reach * np.abs(root).sum(axis=1)
        if (origin - far <= self.lower).any() or (origin + far >= self.upper).any():
            return self
        parts = []
        for part in self.parts:
            if isinstance(part.objective, Quadratic) or ensemble.applies(part.objective):
                parts.append(part)
                continue
            near = np.asarray(np.linalg.cholesky((root @ root.T)[np.ix_(part.places, part.places)]), dtype=float)
            parts.append(replace(part, objective=Quadratic.of(part.objective, origin[part.places], near, reach)))
        return replace(self, parts=tuple(parts))

    def on_blocks(self, x: Array) -> LogPosterior:
        """Return the density of block means, which are chosen at x."""
        parts = []
        for part in self.parts:
            coarse = _on_blocks(part.objective, x[part.places])
            if coarse is part.objective:
                parts.append(part)
                continue
            within = [float(np.sum(o.residuals(x[part.places]) ** 2)) for o in (part.objective, coarse)]
            parts.append(Part(coarse, part.places, part.count, max(within[0] - within[1], 0.0)))
        return replace(self, parts=tuple(parts))


def parts_of(objective: Unknowns | JointObjective, x: Array) -> tuple[Part, ...]:
    """The curves of a problem, whose residuals at x show how many of their readings are independent."""
    if isinstance(objective, JointObjective):
        pairs = list(zip(objective.parts, objective.places, strict=True))
    else:
        pairs = [(objective, np.arange(len(objective.names)))]
    return tuple(Part(part, places, max(independent(part.evaluate(x[places])[0]), 1.0)) for part, places in pairs)


def _on_blocks(objective: Unknowns | Quadratic, x: Array) -> Unknowns | Quadratic:
    """A problem on block means; itself where there is none, or it saves nothing."""
    if not ensemble.applies(objective) or objective.counts is not None:
        return objective
    rest = objective.split(x)[1]
    return blocked(objective, rest["contact"] + (rest["baseline"] / objective.spring if objective.spring else 0.0))
