"""Flat punches of all radii on one medium of a table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from flatpunch._support.checks import ROUNDING, Array, Flags, Indices, positive, whole
from flatpunch._support.readable import readable
from flatpunch.atlas.parameter import check_beta
from flatpunch.numerics.chebyshev import NODES, polynomials
from flatpunch.punch.basis import power_edge, power_moments, regular_part
from flatpunch.punch.harmonics import half_space_power_edge
from flatpunch.punch.krein import round_functionals


@dataclass(frozen=True, eq=False)
class Interval:
    """Series over ln beta on [low, high] (both ln beta): name -> coefficients, shape (NODES, outputs)."""

    low: float
    high: float
    series: Callable[[str], Array]
    orders: Indices

    def derivatives(self, name: str, logs: Array, order: int, weights: Array | None = None) -> list[Array]:
        """Functions and their derivatives by ln beta up to `order`, shape (n, outputs) each."""
        coefficients = self.series(name)
        if weights is not None:
            coefficients = coefficients @ weights
        x = (2 * logs - self.low - self.high) / (self.high - self.low)
        basis = polynomials(x, NODES - 1)
        found = []
        for _ in range(order + 1):
            found.append(basis[: coefficients.shape[0]].T @ coefficients)
            coefficients = np.asarray(chebyshev.chebder(coefficients) * (2 / (self.high - self.low)), dtype=float)
        return found


@readable
@dataclass(frozen=True, eq=False)
class Solution:
    """Flat punches on one medium; made by `Table.at`.

    Attributes
    ----------
    family : str
        Name of the table.
    parameters : mapping
        Their values.
    intervals : tuple of Interval
        Series over ln beta.
    error : float
        Bound of the relative error of Kbar and the moments.

    See Also
    --------
    flatpunch.atlas.Table.at : Makes it.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> punch = atlas.table("bonded-layer").at(poisson=0.5)
    >>> print(f"{float(punch.normalized_stiffness(1.0)):.5f}")
    3.61874
    """

    family: str
    parameters: Mapping[str, float]
    intervals: tuple[Interval, ...]
    error: float

    def _line_(self) -> str:
        """Family and parameters; the series are thousands of numbers."""
        chosen = "".join(f", {name}={value:.6g}" for name, value in self.parameters.items())
        return f"Solution({self.family!r}{chosen}, error={self.error:.0e})"

    @property
    def beta_range(self) -> tuple[float, float]:
        """Radii over the medium's length that the table holds."""
        return float(np.exp(self.intervals[0].low)), float(np.exp(self.intervals[-1].high))

    def covers(self, beta: Array) -> bool:
        """Whether all radii are inside the table."""
        low, high = self.beta_range
        return (
            bool(beta.size) and bool(beta.min() >= low * (1 - ROUNDING)) and bool(beta.max() <= high * (1 + ROUNDING))
        )

    def stiffness_and_moments(self, beta: float | Array, exponents: Sequence[float] = ()) -> tuple[Array, ...]:
        """Kbar and moments kappa_n [-] at radii beta inside the table; each of the shape of `beta`."""
        beta = check_beta(beta, *self.beta_range)
        terms = max(interval.series("flat").shape[1] for interval in self.intervals)
        weights = np.zeros((terms, 1 + len(exponents)))
        weights[0, 0] = 1.0
        for column, exponent in enumerate(exponents, 1):
            weights[:, column] = (exponent + 1) * power_moments(positive("exponent", exponent), 0, terms)
        constant = weights[0, 1:].copy()
        weights[0, 1:] = 0.0
        result = np.empty((1 + len(exponents), beta.size))
        logs = np.log(np.ravel(beta))
        for interval, chosen in self._places(logs):
            outputs = interval.series("flat").shape[1]
            found = interval.derivatives("flat", logs[chosen], 0, weights[:outputs])[0]
            result[0, chosen] = np.exp(found[:, 0])
            result[1:, chosen] = (result[0, chosen, None] * (constant + found[:, 1:])).T
        return tuple(row.reshape(beta.shape) for row in result)

    def normalized_stiffness(self, beta: float | Array) -> Array:
        """Kbar = F/(2 E* a d) [-]."""
        return self.stiffness_and_moments(beta)[0]

    def moment(self, beta: float | Array, exponent: float) -> Array:
        """kappa_n = (n + 1) int_0^1 pbar rho^(n + 1) drho [-]."""
        return self.stiffness_and_moments(beta, (exponent,))[1]

    def edge_coefficient(self, beta: float | Array) -> Array:
        """Edge strength [-], whose square is d(a Kbar)/da; shape of `beta`."""
        flat, first, _ = self.coefficients(np.ravel(np.asarray(beta, dtype=float)))
        return np.sqrt(np.pi * (flat[:, 0] + first[:, 0])).reshape(np.shape(beta))

    def pressure(self, beta: float, rho: Array) -> Array:
        """Pressure of unit depth on the unit disc, modulus 1, at 0 <= rho < 1."""
        flat = self.coefficients(np.array([beta]))[0][0]
        rho = np.asarray(rho, dtype=float)
        return np.tensordot(flat, regular_part(0, flat.size, rho), axes=1) / np.sqrt((1 - rho) * (1 + rho))

    def coefficients(self, beta: Array) -> tuple[Array, Array, Array]:
        """c_n of the flat punch and their first and second derivatives by ln beta, shape (n, terms) each.

        Parameters
        ----------
        beta : ndarray, shape (n,)
            Radii inside the table.
        """
        logs = np.log(beta)
        parts = list(self._places(logs))
        terms = max((interval.series("flat").shape[1] for interval, _ in parts), default=1)
        c, first, second = (np.zeros((logs.size, terms)) for _ in range(3))
        for interval, chosen in parts:
            y, dy, ddy = interval.derivatives("flat", logs[chosen], 2)
            size, growth, change = np.exp(y[:, :1]) / np.pi, dy[:, :1].copy(), ddy[:, :1].copy()
            # the first column is ln Kbar, the others c_n/c_0
            for column, value in ((y, 1.0), (dy, 0.0), (ddy, 0.0)):
                column[:, 0] = value
            n = y.shape[1]
            c[chosen, :n] = size * y
            first[chosen, :n] = size * (dy + growth * y)
            second[chosen, :n] = size * (ddy + 2 * growth * dy + (change + growth**2) * y)
        return c, first, second

    def flat(self, beta: Array) -> Array:
        """c_n alone, shape (n, terms)."""
        return self.coefficients(beta)[0]

    def round(self, beta: Array) -> tuple[Array, Array, Array]:
        """Flat punch, edge and slope functionals of harmonic 0 (`flatpunch.punch.matrix.Responses`)."""
        c, first, second = self.coefficients(beta)
        return c, *round_functionals(c, first, second)

    def responds_to(self, exponent: float) -> bool:
        """Whether the responses to the harmonics of r^n psi(phi) are tabulated."""
        return bool(self.intervals[0].orders.size) and exponent in (1, 2)

    def edges(self, beta: Array, orders: Indices, exponent: float) -> tuple[Array, Array]:
        """Responses to harmonics of outlines.

        Parameters
        ----------
        beta : ndarray, shape (nb,)
            Radii inside the table.
        orders : ndarray of int
            Harmonics m > 0.
        exponent : float
            n of the indenter r^n psi(phi), 1 or 2.

        Returns
        -------
        stiffening, power_edge : ndarray, shape (nb, len(orders))
            k_m, and S[A_m^-1 b[r^n]].
        """
        stiffening = np.empty((beta.size, orders.size))
        edge = np.empty_like(stiffening)
        c, first, _ = self.coefficients(beta)
        strength = np.sqrt(np.pi * (c[:, 0] + first[:, 0]))
        logs, closed = np.log(beta), half_space_power_edge(exponent, orders)
        for interval, chosen in self._places(logs):
            known, extra = interval.orders, interval.derivatives("stiffening", logs[chosen], 0)[0]
            ratio = interval.derivatives(f"edge_{int(exponent)}", logs[chosen], 0)[0]
            ratio = ratio * strength[chosen, None]
            inside = np.minimum(orders, known[-1])
            added, scaled = (
                scipy.interpolate.make_interp_spline(np.log(known), y, 5, axis=1)(np.log(inside))
                for y in (extra, ratio)
            )
            stiffening[chosen] = (orders - 1) / 2 + added
            # on harmonics beyond the last only the half-space of the surface acts
            edge[chosen] = closed * np.where(orders > known[-1], 1.0, scaled)
        return stiffening, edge

    def responses(self, beta: float | Array, order: int, exponent: float) -> dict[str, Array]:
        """Second-order responses R_m, chi_m and eta_m (T5) to the harmonic m of ln psi, f = r^n psi(phi).

        Parameters
        ----------
        beta : float or ndarray, shape (n,)
            Radius of the round base contact over the medium's length.
        order : int
            m > 0.
        exponent : float
            n, 1 or 2.

        Returns
        -------
        dict of ndarray, shape (n,)
            "outline" R_m: ln a(phi) gains -R_m g_m cos(m phi); "force" chi_m: ln F gains chi_m g_m^2 at given depth;
            "stiffness" eta_m: ln(dF/dd) gains eta_m h_m^2, h_m the harmonic of ln a(phi).
        """
        if not self.responds_to(exponent):
            raise ValueError(
                f"exponent = {exponent!r}: the table {self.family!r} holds responses "
                + ("for n = 1 and 2." if self.intervals[0].orders.size else "of no indenter.")
            )
        order = whole("order", order, 1, "It is the harmonic m of the angle.")
        beta = np.atleast_1d(np.asarray(beta, dtype=float))
        flat, edge, slope = self.round(beta)
        k, power = (values[:, 0] for values in self.edges(beta, np.array([order]), exponent))
        b, closed = power_moments(exponent, 0, flat.shape[1]), power_edge(exponent, 0)
        strength = 1 / np.pi + edge[:, 0]
        depth = (closed + edge @ b) / strength
        growth = (depth * slope[:, 0] + exponent * closed - slope @ b) / strength
        excess = 2 * np.pi * flat @ b
        force = 2 * np.pi * depth * flat[:, 0] - excess
        outline = power / (strength * growth)
        tangent = 2 * np.pi**2 * strength**2 * growth
        return {
            "outline": outline,
            "force": (tangent * outline**2 - excess) / (4 * force),
            "stiffness": np.pi * strength**2 / flat[:, 0] * (1 + k) / 2,
        }

    def _places(self, logs: Array) -> Iterator[tuple[Interval, Flags]]:
        edges = np.array([interval.high for interval in self.intervals[:-1]])
        index = np.searchsorted(edges, logs)
        for i in np.unique(index):
            yield self.intervals[int(i)], index == i
