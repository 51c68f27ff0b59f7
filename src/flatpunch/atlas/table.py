"""A family's tabulated solutions: values for many media at once, or one medium at a time.

Everything is in units of the punch: unit disc, modulus 1, depth 1. `Table.at` puts the parameters in and leaves a `Solution`,
which knows flat punches of all radii on one medium, and is what contact calculations use.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.checks import Array, Flags, Indices, positive
from flatpunch._support.readable import readable
from flatpunch.atlas.parameter import Parameter, check_beta
from flatpunch.atlas.series import SparseSeries, evaluate
from flatpunch.atlas.solution import Interval, Solution
from flatpunch.punch.basis import power_moments

_CHUNK = 10_000
"""Points evaluated together: their Chebyshev polynomials stay in the cache of a core."""


@readable
@dataclass(frozen=True, eq=False)
class Panel:
    """All functions on one interval of beta: "flat", and with responses "stiffening", "edge_1" and "edge_2".

    Attributes
    ----------
    low, high : float
        Interval of beta.
    series : mapping
        Name -> coefficients.
    orders : ndarray of int
        Harmonics m of the responses; empty without them.
    """

    low: float
    high: float
    series: Mapping[str, SparseSeries]
    orders: Indices = field(default_factory=lambda: np.zeros(0, dtype=int))

    def _line_(self) -> str:
        """The interval; the series are thousands of numbers."""
        return f"Panel(low={self.low:.6g}, high={self.high:.6g})"


@readable
@dataclass(frozen=True, eq=False)
class Table:
    """Flat-punch solutions of a family.

    Attributes
    ----------
    name, title : str
        The family.
    parameters : tuple of Parameter
        What it depends on beside beta = a/l.
    panels : tuple of Panel
        Intervals of beta, ascending and without gaps.
    bound : float
        Largest relative error of Kbar, kappa_1 and kappa_2 against direct solutions at random points.
    attributes : mapping
        What else the file says: provenance, licence, conventions.

    See Also
    --------
    flatpunch.atlas.table : A shipped one, or one of your own from its file.

    Examples
    --------
    >>> from flatpunch import atlas
    >>> layer = atlas.table("bonded-layer")
    >>> print(layer.title, [p.name for p in layer.parameters])
    Homogeneous layer bonded to a rigid base ['poisson']
    """

    name: str
    title: str
    parameters: tuple[Parameter, ...]
    panels: tuple[Panel, ...]
    bound: float
    attributes: Mapping[str, object] = field(default_factory=dict)
    _kept: dict[Any, Any] = field(default_factory=dict, repr=False)

    def _line_(self) -> str:
        """Name, parameters and error; the series are thousands of numbers."""
        return f"Table({self.name!r}, {', '.join(p.name for p in self.parameters) or 'no'} parameter, error {self.bound:.0e})"

    @property
    def beta_range(self) -> tuple[float, float]:
        """Punch radii over the medium's length that the table holds."""
        return self.panels[0].low, self.panels[-1].high

    def at(self, **parameters: float) -> Solution:
        """All flat punches on the medium with these parameters.

        Parameters
        ----------
        **parameters : float
            One value for each parameter of the family.

        Returns
        -------
        Solution

        Raises
        ------
        ValueError, TypeError
            If a parameter is outside its range, missing or unknown.
        """
        x = tuple(float(v) for v in self._coordinates(parameters))
        if x not in self._kept:
            if len(self._kept) >= 100:
                self._kept.pop(next(iter(self._kept)))
            self._kept[x] = Solution(
                self.name, {k: float(v) for k, v in parameters.items()}, self._intervals(x), self.bound
            )
        found: Solution = self._kept[x]
        return found

    def stiffness_and_moments(
        self, beta: float | Array, exponents: Sequence[float] = (), **parameters: Any
    ) -> tuple[Array, ...]:
        """Kbar and moments kappa_n for many radii and media at once.

        Parameters
        ----------
        beta : float or array
            Punch radius over the medium's length.
        exponents : sequence of float
            n > 0 of the moments wanted.
        **parameters : float or array
            Values of the parameters; arrays are broadcast against `beta`.

        Returns
        -------
        tuple of ndarray
            Kbar and one kappa_n [-] for each exponent, of the common shape.
        """
        given = self._coordinates(parameters)
        beta = check_beta(beta, *self.beta_range)
        if all(x.ndim == 0 for x in given):
            solution = self.at(**parameters)
            return solution.stiffness_and_moments(beta, exponents)
        beta, *given = np.broadcast_arrays(beta, *given)
        flat = [np.ravel(x) for x in (np.log(beta), *given)]
        result = np.empty((1 + len(exponents), flat[0].size))
        for start in range(0, flat[0].size, _CHUNK):
            part = slice(start, start + _CHUNK)
            result[:, part] = self._many(flat[0][part], tuple(x[part] for x in flat[1:]), tuple(exponents))
        return tuple(row.reshape(beta.shape) for row in result)

    def edge_coefficients(self, beta: float | Array, **parameters: float | Array) -> Array:
        """Edge strength [-], whose square is d(a Kbar)/da = Kbar (1 + dln Kbar/dln beta), for many radii and media at once."""
        given = self._coordinates(parameters)
        beta, *given = np.broadcast_arrays(check_beta(beta, *self.beta_range), *given)
        logs, others = np.log(np.ravel(beta)), [np.ravel(x) for x in given]
        result = np.empty(logs.size)
        for i, chosen in self._places(logs):
            panel = self.panels[i]
            low, high = np.log(panel.low), np.log(panel.high)
            x, y = (2 * logs[chosen] - low - high) / (high - low), tuple(p[chosen] for p in others)
            dense = self._combined(i, None)
            slope = np.zeros_like(dense)
            slope[:-1] = chebyshev.chebder(dense) * (2 / (high - low))
            result[chosen] = np.sqrt(np.exp(evaluate(dense, x, y)) * (1 + evaluate(slope, x, y)))
        return result.reshape(np.shape(beta))

    def _many(self, logs: Array, given: tuple[Array, ...], exponents: tuple[float, ...]) -> Array:
        result = np.empty((1 + len(exponents), logs.size))
        for i, chosen in self._places(logs):
            panel = self.panels[i]
            low, high = np.log(panel.low), np.log(panel.high)
            x, others = (2 * logs[chosen] - low - high) / (high - low), tuple(p[chosen] for p in given)
            result[0, chosen] = np.exp(evaluate(self._combined(i, None), x, others))
            for row, exponent in enumerate(exponents, 1):
                result[row, chosen] = result[0, chosen] * evaluate(self._combined(i, exponent), x, others)
        return result

    def _combined(self, panel: int, exponent: float | None) -> Array:
        """Dense series of ln Kbar, or of kappa_n/Kbar without the constant that belongs to c_0."""
        key = (panel, exponent)
        if key not in self._kept:
            flat = self.panels[panel].series["flat"]
            weights = np.eye(1, flat.outputs)[0]
            if exponent is not None:
                weights = (exponent + 1) * power_moments(positive("exponent", exponent), 0, flat.outputs)
                constant, weights[0] = weights[0], 0.0
            dense = flat.combined(weights)
            if exponent is not None:
                dense[(0,) * dense.ndim] += constant
            self._kept[key] = dense
        found: Array = self._kept[key]
        return found

    def _places(self, logs: Array) -> list[tuple[int, Flags]]:
        edges = np.log([panel.high for panel in self.panels[:-1]])
        index = np.searchsorted(edges, logs)
        return [(int(i), index == i) for i in np.unique(index)]

    def _coordinates(self, given: Mapping[str, float | Array]) -> list[Array]:
        names = [p.name for p in self.parameters]
        if set(given) != set(names):
            raise TypeError(
                f"The table {self.name!r} takes {', '.join(names) or 'no parameters'} beside beta, "
                f"not {', '.join(given) or 'nothing'}."
            )
        return [p.unit_coordinate(p.check(given[p.name])) for p in self.parameters]

    def _intervals(self, x: tuple[float, ...]) -> tuple[Interval, ...]:
        return tuple(
            Interval(
                float(np.log(panel.low)),
                float(np.log(panel.high)),
                # a series is assembled on first use
                lru_cache(maxsize=None)(lambda name, panel=panel: panel.series[name].at(x)),
                panel.orders,
            )
            for panel in self.panels
        )
