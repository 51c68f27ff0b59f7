"""A family's tabulated solutions: values for many media at once, or flat punches of all radii on one medium.

Everything is in units of the punch: unit disc, modulus 1, depth 1. `Table.at` puts the parameters in and leaves a `Solution`,
which is what contact calculations use.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

import numpy as np
import scipy

from flatpunch._support.checks import (
    ANGLES,
    ROUNDING,
    Array,
    BadValue,
    Flags,
    Indices,
    numbers,
    positive,
    real,
    values,
    whole,
)
from flatpunch._support.readable import readable
from flatpunch.atlas.panel import Coordinates, Panel, Parameter, PowerLawPanel
from flatpunch.numerics.shapes import common_shape
from flatpunch.punch.basis import power_edge, power_moments, regular_part, round_functionals
from flatpunch.punch.harmonics import half_space_power_edge

AnyPanel = Panel | PowerLawPanel
P = TypeVar("P", Panel, AnyPanel)

Outside = Literal["solve", "refuse"]

_TOGETHER = 10_000
"""Radii of a panel that are evaluated together: their Chebyshev polynomials stay in the cache of a core."""

_MEDIA = 100
"""Media of a table whose series are kept for the next call."""


@readable
@dataclass(frozen=True, eq=False)
class Table:
    """Flat-punch solutions of a family.

    Attributes
    ----------
    name, title : str
        The family.
    parameters : tuple of Parameter
        What it depends on beside beta = a/l: each has `name`, `meaning`, `low`, `high` and `unit`.
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
    panels: tuple[AnyPanel, ...] = field(repr=False)
    bound: float
    attributes: Mapping[str, object] = field(default_factory=dict)
    _solutions: dict[tuple[float, ...], Solution] = field(default_factory=dict, init=False, repr=False)

    def _line_(self) -> str:
        """Name, parameters and error; the series are thousands of numbers."""
        return f"Table({self.name!r}, {', '.join(p.name for p in self.parameters) or 'no'} parameter, error {self.bound:.0e})"

    @property
    def beta_range(self) -> tuple[float, float]:
        """Punch radii over the medium's length that the table holds."""
        return self.panels[0].low, self.panels[-1].high

    def at(self, **parameters: float) -> Solution:
        """All flat punches on the medium with these parameters, a number for each.

        ValueError or TypeError if one is outside its range, missing or unknown, or the solutions are closed forms.
        """
        coordinates = self._coordinates(parameters)
        given = {p.name: real(p.name, numbers(p.name, parameters[p.name], p.si), p.si) for p in self.parameters}
        x = tuple(float(v) for v in coordinates)
        if x not in self._solutions:
            if len(self._solutions) >= _MEDIA:
                self._solutions.pop(next(iter(self._solutions)))
            panels = tuple(panel.at(coordinates) for panel in self.panels)
            self._solutions[x] = Solution(self.name, given, panels, self.bound)
        return self._solutions[x]

    def stiffness_and_moments(
        self, beta: float | Array, exponents: Sequence[float] = (), **parameters: Any
    ) -> tuple[Array, ...]:
        """Kbar and moments kappa_n [-] for many radii and media at once.

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
            Kbar and one kappa_n for each exponent, of the common shape.
        """
        wanted = values("exponents", exponents, strict=True, empty=True).tolist()
        shape, places = self._points(beta, parameters)
        result = np.empty((1 + len(wanted), *shape)).reshape(1 + len(wanted), -1)
        for panel, chosen, radii, x in places:
            result[:, chosen] = panel.stiffness_and_moments(radii, x, wanted)
        return tuple(result.reshape(-1, *shape))

    def edge_coefficients(self, beta: float | Array, **parameters: float | Array) -> Array:
        """Edge strength [-], whose square is d(a Kbar)/da = Kbar (1 + dln Kbar/dln beta), for many radii and media at once."""
        shape, places = self._points(beta, parameters)
        result = np.empty(shape).ravel()
        for panel, chosen, radii, x in places:
            result[chosen] = panel.edge_coefficients(radii, x)
        return result.reshape(shape)

    def _points(
        self, beta: float | Array, parameters: Mapping[str, float | Array]
    ) -> tuple[tuple[int, ...], Iterator[tuple[AnyPanel, Indices, Array, Coordinates]]]:
        """Common shape of radii and parameters; panels with the points that each holds, their radii and coordinates."""
        given = numbers("beta", beta, "1")
        x, radii = self._coordinates(parameters), values("beta", given, strict=True)
        _check_range(self.panels, radii)
        shape = common_shape(beta=given, **dict(zip(parameters, x, strict=True)))
        if any(y.ndim for y in x):
            radii, x = np.broadcast_to(radii, shape).ravel(), tuple(np.broadcast_to(y, shape).ravel() for y in x)
        return shape, (
            (panel, chosen, radii[chosen], tuple(y[chosen] if y.ndim else y for y in x))
            for panel, chosen in _places(self.panels, radii)
        )

    def _coordinates(self, given: Mapping[str, float | Array]) -> Coordinates:
        names = [p.name for p in self.parameters]
        if set(given) != set(names):
            raise TypeError(
                f"The table {self.name!r} takes {', '.join(names) or 'no parameters'} beside beta, "
                f"not {', '.join(given) or 'nothing'}."
            )
        return tuple(p.unit_coordinate(p.check(given[p.name])) for p in self.parameters)


@readable
@dataclass(frozen=True)
class Solution:
    """Flat punches on one medium; made by `Table.at`.

    Attributes
    ----------
    family : str
        Name of the table.
    parameters : mapping
        Their values.
    panels : tuple of Panel
        Series over ln beta.
    error : float
        Bound of the relative error of Kbar and the moments.
    outside : "solve" or "refuse"
        Whether radii that the table does not hold are solved directly, or refused.

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
    parameters: Mapping[str, float] = field(compare=False)
    panels: tuple[Panel, ...] = field(repr=False)
    error: float
    outside: Outside = "solve"

    def _line_(self) -> str:
        """Family and parameters; the series are thousands of numbers."""
        chosen = "".join(f", {name}={value:.6g}" for name, value in self.parameters.items())
        return f"Solution({self.family!r}{chosen}, error={self.error:.0e})"

    @property
    def beta_range(self) -> tuple[float, float]:
        """Radii over the medium's length that the table holds."""
        return self.panels[0].low, self.panels[-1].high

    def covers(self, beta: Array) -> bool:
        """Whether all radii are in the table; raises ValueError where others are refused."""
        beta = numbers("beta", beta)
        inside = not _outside(self.panels, beta).any()
        if not inside and self.outside == "refuse":
            low, high = self.beta_range
            raise ValueError(
                f"beta = {beta.min():.3g} ... {beta.max():.3g}, radii over the length of the medium, is needed; the table "
                f"{self.family!r} holds {low:g} ... {high:g}. outside='solve' solves the others directly."
            )
        return inside and bool(beta.size)

    def summary(self, beta: Array) -> str:
        """Which table it was, and how many of these radii it does not hold."""
        beta, (low, high) = numbers("beta", beta), self.beta_range
        outside = int(np.count_nonzero((beta > 0) & _outside(self.panels, beta)))
        others = f"; {outside} of {beta.size} contacts are outside it and were solved directly" if outside else ""
        return f"table {self.family!r}, relative error below {self.error:.0e}, a/l = {low:g} ... {high:g}{others}"

    def normalized_stiffness(self, beta: float | Array) -> Array:
        """Kbar = F/(2 E* a d) [-]; shape of `beta`."""
        beta = numbers("beta", beta)
        return np.pi * self.coefficients(beta.ravel())[0][:, 0].reshape(beta.shape)

    def moment(self, beta: float | Array, exponent: float) -> Array:
        """kappa_n = (n + 1) int_0^1 pbar rho^(n + 1) drho [-], n > 0; shape of `beta`."""
        beta, n = numbers("beta", beta), positive("exponent", exponent)
        flat = self.coefficients(beta.ravel())[0]
        return ((n + 1) * np.pi * flat @ power_moments(n, 0, flat.shape[1])).reshape(beta.shape)

    def edge_coefficient(self, beta: float | Array) -> Array:
        """Edge strength [-], whose square is d(a Kbar)/da; shape of `beta`."""
        beta = numbers("beta", beta)
        flat, first, _ = self.coefficients(beta.ravel())
        return np.sqrt(np.pi * (flat[:, 0] + first[:, 0])).reshape(beta.shape)

    def pressure(self, beta: float, rho: Array) -> Array:
        """Pressure of unit depth on the unit disc, modulus 1, at 0 <= rho < 1."""
        flat, rho = self.coefficients(np.array([real("beta", beta)]))[0][0], numbers("rho", rho)
        if not ((rho >= 0) & (rho < 1)).all():
            raise BadValue(
                "rho", "", "must be 0 or more and below 1: it is the distance from the axis over the radius."
            )
        return np.tensordot(flat, regular_part(0, flat.size, rho), axes=1) / np.sqrt((1 - rho) * (1 + rho))

    def coefficients(self, beta: Array) -> tuple[Array, Array, Array]:
        """c_n of the flat punch at radii inside the table and their first two derivatives by ln beta, shape (n, terms) each."""
        _check_range(self.panels, beta)
        parts = list(_places(self.panels, beta))
        terms = max((panel.series["flat"].outputs for panel, _ in parts), default=1)
        c, first, second = (np.zeros((beta.size, terms)) for _ in range(3))
        for panel, chosen in parts:
            # the first column is ln Kbar, the others c_n/c_0
            y, dy, ddy = panel.derivatives("flat", beta[chosen], 2)
            size, growth, change = np.exp(y[:, :1]) / np.pi, dy[:, :1].copy(), ddy[:, :1].copy()
            y[:, 0], dy[:, 0], ddy[:, 0] = 1.0, 0.0, 0.0
            n = y.shape[1]
            c[chosen, :n] = size * y
            first[chosen, :n] = size * (dy + growth * y)
            second[chosen, :n] = size * (ddy + 2 * growth * dy + (change + growth**2) * y)
        return c, first, second

    def round(self, beta: Array) -> tuple[Array, Array, Array]:
        """Flat punch, edge and slope functionals of harmonic 0 (`flatpunch.punch.matrix.Responses`)."""
        c, first, second = self.coefficients(beta)
        return c, *round_functionals(c, first, second)

    def responds_to(self, exponent: float) -> bool:
        """Whether the responses to the harmonics of r^n psi(phi) are tabulated."""
        return bool(self.panels[0].orders.size) and exponent in (1, 2)

    def edges(self, beta: Array, orders: Indices, exponent: float) -> tuple[Array, Array]:
        """k_m and S[A_m^-1 b[r^n]] of harmonics m > 0, for indenters r^n psi(phi), n = 1 or 2; shape (radii, orders) each."""
        stiffening, edge = (np.empty((beta.size, orders.size)) for _ in range(2))
        strength, closed = self.edge_coefficient(beta), half_space_power_edge(exponent, orders)
        for panel, chosen in _places(self.panels, beta):
            # responses are smooth functions of ln m
            known, inside = np.log(panel.orders), np.log(np.minimum(orders, panel.orders[-1]))
            added, ratio = (
                scipy.interpolate.make_interp_spline(known, panel.derivatives(name, beta[chosen], 0)[0], 5, axis=1)(
                    inside
                )
                for name in ("stiffening", f"edge_{exponent:g}")
            )
            stiffening[chosen] = (orders - 1) / 2 + added
            # on harmonics beyond the last only the half-space of the surface acts
            edge[chosen] = closed * np.where(orders > panel.orders[-1], 1.0, ratio * strength[chosen, None])
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
        exponent = positive("exponent", exponent)
        if not self.responds_to(exponent):
            raise ValueError(
                f"exponent = {exponent!r}: the table {self.family!r} holds responses "
                + ("for n = 1 and 2." if self.panels[0].orders.size else "of no indenter.")
            )
        order = whole("order", order, 1, "It is the harmonic m of the angle.", most=ANGLES)
        beta = values("beta", beta, strict=True)
        flat, edge, slope = self.round(beta)
        k, power = (found[:, 0] for found in self.edges(beta, np.array([order]), exponent))
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


def _outside(panels: Sequence[AnyPanel], beta: Array) -> Flags:
    return ~np.asarray((beta >= panels[0].low * (1 - ROUNDING)) & (beta <= panels[-1].high * (1 + ROUNDING)))


def _check_range(panels: Sequence[AnyPanel], beta: Array) -> None:
    outside = _outside(panels, beta)
    if outside.any():
        raise ValueError(
            f"beta = {beta[outside][0]:.6g} lies outside the table, which holds {panels[0].low:g} ... {panels[-1].high:g} "
            "(punch radius over the length of the medium)."
        )


def _places(panels: Sequence[P], beta: Array) -> Iterator[tuple[P, Indices]]:
    """Panels with the radii that each holds, by their indices: few enough that polynomials stay in the cache of a core."""
    index = np.searchsorted(np.log([panel.high for panel in panels[:-1]]), np.log(beta))
    for i in np.unique(index):
        chosen = np.flatnonzero(index == i)
        for start in range(0, chosen.size, _TOGETHER):
            yield panels[int(i)], chosen[start : start + _TOGETHER]
