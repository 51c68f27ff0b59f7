"""Parameters of a family, and its solutions on one interval of beta: series in Chebyshev polynomials, or closed forms.

Of the full tensor of coefficients only those above a cutoff are kept, each with its degrees: a list of products
T_i(ln beta) T_j(p1) T_k(p2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.checks import Array, Indices, numbers
from flatpunch.media import PowerLawHalfSpace
from flatpunch.numerics.chebyshev import NODES, polynomials
from flatpunch.punch.basis import power_moments
from flatpunch.punch.power_law import power_law_punch

Coordinates = tuple[Array, ...]
"""Coordinates in [-1, 1] of the parameters: numbers all of them, or arrays, one entry for each radius."""


Scale = Literal["linear", "log", "upper"]


@dataclass(frozen=True, slots=True)
class Parameter:
    """A named parameter with a range [low, high], and what it means in one line with the definition.

    Solutions are series over the coordinate v of its `scale`: the value; its logarithm ("log"); or
    -ln(shift + (high - value)/(high - low)) for what changes fast near the upper end, as everything does near
    incompressibility ("upper"). `unit` is that of SI, "1" for what has none.
    """

    name: str
    meaning: str
    low: float
    high: float
    scale: Scale = "linear"
    shift: float = 0.0
    unit: str = "1"

    @property
    def si(self) -> str:
        """The unit to which quantities are converted."""
        return self.unit.replace("^", "**")

    def check(self, given: Array | float) -> Array:
        """Values as an array, refused outside the range."""
        found = numbers(self.name, given, self.si)
        # a value may be outside the range by rounding
        slack = 1e-9 * (self.high - self.low)
        bad = ~((found >= self.low - slack) & (found <= self.high + slack))
        if bad.any():
            raise ValueError(
                f"{self.name} = {np.ravel(found)[np.ravel(bad)][0]:.6g} lies outside the table, which holds "
                f"{self.low:g} ... {self.high:g}. Outside it the medium is solved directly: flatpunch.flat_punch, or "
                "atlas.tabulated(medium, outside='solve')."
            )
        return np.asarray(np.clip(found, self.low, self.high))

    def unit_coordinate(self, inside: Array | float) -> Array:
        """Coordinate x in [-1, 1] of values inside the range."""
        low, high = self._coordinate(np.array([self.low, self.high]))
        return np.asarray((2 * self._coordinate(np.asarray(inside, dtype=float)) - low - high) / (high - low))

    def at(self, x: Array) -> Array:
        """Values at coordinates x in [-1, 1]; the ends are exact."""
        low, high = self._coordinate(np.array([self.low, self.high]))
        v = (low + high) / 2 + (high - low) / 2 * np.asarray(x)
        if self.scale == "log":
            v = np.exp(v)
        elif self.scale == "upper":
            v = self.high - (np.exp(-v) - self.shift) * (self.high - self.low)
        inside = np.clip(v, self.low, self.high)
        return np.asarray(np.where(x == -1, self.low, np.where(x == 1, self.high, inside)))

    def _coordinate(self, values: Array) -> Array:
        if self.scale == "linear":
            return values
        if self.scale == "log":
            return np.log(values)
        return np.asarray(-np.log(self.shift + (self.high - values) / (self.high - self.low)))


@dataclass(frozen=True, eq=False)
class SparseSeries:
    """Coefficients of `outputs` functions, each with its function and its degrees over ln beta and the parameters."""

    outputs: int
    value: Array
    output: Indices
    beta_degree: Indices
    degrees: tuple[Indices, ...]

    def over_beta(self, x: Coordinates) -> Array:
        """Coefficients of the series over ln beta at coordinates of the parameters, shape (NODES, outputs)."""
        weight = self.value
        for degree, coordinate in zip(self.degrees, x, strict=True):
            weight = weight * polynomials(np.reshape(coordinate, 1), int(degree.max(initial=0)))[degree, 0]
        total = np.bincount(self.output * NODES + self.beta_degree, weight, minlength=self.outputs * NODES)
        return np.ascontiguousarray(total.reshape(self.outputs, NODES).T, dtype=float)

    def combined(self, weights: Array) -> Array:
        """Dense coefficients, shape (NODES, degrees of parameter 1, ...), of a sum of the functions with `weights`."""
        shape = (NODES, *(int(degree.max(initial=0)) + 1 for degree in self.degrees))
        index = np.ravel_multi_index((self.beta_degree, *self.degrees), shape)
        total = np.bincount(index, self.value * weights[self.output], minlength=int(np.prod(shape)))
        return np.asarray(total.reshape(shape), dtype=float)


def evaluate(dense: Array, x: Array, parameters: Coordinates) -> Array:
    """Sum of a dense series at coordinates x of ln beta, shape (n,), and those of the parameters."""
    used = np.flatnonzero(np.abs(dense).reshape(NODES, -1).max(axis=1))
    last = int(used.max(initial=0))
    basis, values = polynomials(x, last), dense[: last + 1]
    if all(y.ndim == 0 for y in parameters):
        for coordinate in reversed(parameters):
            values = values @ polynomials(np.reshape(coordinate, 1), values.shape[-1] - 1)[:, 0]
        return np.asarray(values @ basis)
    # over the last parameter first: a product of matrices, then sums along the columns
    values = values @ polynomials(parameters[-1], values.shape[-1] - 1)
    for coordinate in parameters[-2::-1]:
        values = np.einsum("...kn,kn->...n", values, polynomials(coordinate, values.shape[-2] - 1))
    return np.asarray(np.einsum("in,in->n", values, basis))


@dataclass(frozen=True, eq=False)
class Panel:
    """Functions on the interval low <= beta <= high: "flat", and with responses "stiffening", "edge_1" and "edge_2".

    `orders` are the harmonics m of the responses, none without them; `x` the coordinates of one medium.
    """

    low: float
    high: float
    series: Mapping[str, SparseSeries] = field(repr=False)
    orders: Indices = field(default_factory=lambda: np.zeros(0, dtype=int), repr=False)
    x: Coordinates = ()
    _kept: dict[float | str | None, Array] = field(default_factory=dict, init=False, repr=False)

    def at(self, x: Coordinates) -> Panel:
        """The panel of one medium, whose series are put together when they are needed."""
        return replace(self, x=x)

    def stiffness_and_moments(self, beta: Array, x: Coordinates, exponents: tuple[float, ...]) -> Array:
        """Kbar and kappa_n for each exponent, shape (1 + exponents, n)."""
        place, _ = self._place(beta)
        stiffness = np.exp(evaluate(self._combined(None), place, x))
        return np.stack([stiffness, *(stiffness * evaluate(self._combined(n), place, x) for n in exponents)])

    def edge_coefficients(self, beta: Array, x: Coordinates) -> Array:
        """Square root of Kbar (1 + dln Kbar/dln beta), shape (n,)."""
        place, stretch = self._place(beta)
        dense = self._combined(None)
        slope = np.zeros_like(dense)
        slope[:-1] = chebyshev.chebder(dense) * stretch
        return np.asarray(np.sqrt(np.exp(evaluate(dense, place, x)) * (1 + evaluate(slope, place, x))))

    def derivatives(self, name: str, beta: Array, order: int) -> list[Array]:
        """Functions of one medium and their derivatives by ln beta up to `order`, shape (n, outputs) each."""
        if name not in self._kept:
            self._kept[name] = self.series[name].over_beta(self.x)
        (place, stretch), coefficients = self._place(beta), self._kept[name]
        basis, found = polynomials(place), []
        for _ in range(order + 1):
            found.append(basis[: coefficients.shape[0]].T @ coefficients)
            coefficients = np.asarray(chebyshev.chebder(coefficients) * stretch, dtype=float)
        return found

    def _place(self, beta: Array) -> tuple[Array, float]:
        """Coordinates in [-1, 1] of ln beta, and their derivative."""
        low, high = float(np.log(self.low)), float(np.log(self.high))
        return (2 * np.log(beta) - low - high) / (high - low), 2 / (high - low)

    def _combined(self, exponent: float | None) -> Array:
        """Dense series of ln Kbar, or of kappa_n/Kbar; output 0 of the series is ln Kbar, output n is c_n/c_0."""
        if exponent not in self._kept:
            flat = self.series["flat"]
            if exponent is None:
                dense = flat.combined(np.eye(1, flat.outputs)[0])
            else:
                weights = (exponent + 1) * power_moments(exponent, 0, flat.outputs)
                constant, weights[0] = weights[0], 0.0
                dense = flat.combined(weights)
                dense[(0,) * dense.ndim] += constant
            self._kept[exponent] = dense
        return self._kept[exponent]


@dataclass(frozen=True, eq=False)
class PowerLawPanel:
    """Half-spaces E(z) = E_l (z/l)^k, whose punches are closed forms at all radii beta = a/l."""

    grading: Parameter
    poisson: Parameter
    low: float = 0.0
    high: float = float("inf")
    series: Mapping[str, SparseSeries] = field(default_factory=dict)
    orders: Indices = field(default_factory=lambda: np.zeros(0, dtype=int))

    def at(self, x: Coordinates) -> Panel:
        """Raise: there are no series."""
        raise ValueError("Solutions of power-law half-spaces are closed forms and have no coefficients.")

    def stiffness_and_moments(self, beta: Array, x: Coordinates, exponents: tuple[float, ...]) -> Array:
        """Kbar and kappa_n for each exponent, shape (1 + exponents, n)."""
        found = np.empty((1 + len(exponents), beta.size))
        media = np.broadcast_arrays(beta, self.grading.at(x[0]), self.poisson.at(x[1]))
        for i, (radius, k, poisson) in enumerate(zip(*media, strict=True)):
            punch = power_law_punch(PowerLawHalfSpace(1.0, 1.0, k, poisson))
            found[:, i] = punch.normalized_stiffness(radius), *(punch.moment(n, radius) for n in exponents)
        return found

    def edge_coefficients(self, beta: Array, x: Coordinates) -> Array:
        """Square root of d(a Kbar)/da = (1 + k) Kbar, shape (n,)."""
        return np.asarray(np.sqrt((1 + self.grading.at(x[0])) * self.stiffness_and_moments(beta, x, ())[0]))
