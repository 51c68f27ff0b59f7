"""Tip area functions A(h) of nanoindentation, used as the axisymmetric indenter of the same area: pi r^2 = A(h).

`AreaFunction` is the usual polynomial fit A = C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) + ...; a measured table goes through
`RadialProfile.from_area`. An equivalent body of revolution is not the tip itself: at equal depth it needs less force, because
a pyramid of the same sections reaches further out with its edges. For sharp tips on a half-space the force of the true shape
exceeds that of the equivalent cone by 2.7 % for four faces and by 7.8 % for three (boundary elements; `second-order` gives 2.4
and 6.5 %).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import scipy

from flatpunch._support.checks import Array, BadValue, refused_overflow
from flatpunch._support.declared import a_length, a_ratio, in_case_files
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch.indenters._common import SAME, spread
from flatpunch.indenters.profile import RoundShape


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class AreaFunction(RoundShape):
    """Body of revolution with the area function A(h) = C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) + ...

    It is a round tip of the same sections, not the tip itself: the force of a real three-sided pyramid is up to 7.8 % higher at
    equal depth, of a four-sided one 2.7 % (sharp tips on a half-space, boundary elements). Results say so in their notes. For
    the real shape take `Berkovich`, `Vickers` or `HeightMap`.

    Parameters
    ----------
    coefficients : sequence of float
        C0, C1, C2, ...; C_k multiplies h^2, h, h^(1/2), h^(1/4), ... and is in units of unit^(2 - power).
    limit : float
        Largest depth h for which the fit was made [m].
    unit : float
        Length unit of the coefficients [m]: 1e-9 for fits with h in nm and A in nm^2.
    start : float
        Depth below which the fit is replaced by the paraboloid that meets it there [m]. Needed where a fit turns
        negative or falls close to the apex; 0 keeps it throughout.

    Raises
    ------
    ValueError
        If A is not positive and rising from `start` to `limit`; the message names the depth.

    See Also
    --------
    Berkovich : The pyramid itself.
    RadialProfile : From measured heights.
    fits.Tip : For Oliver-Pharr evaluations.

    Examples
    --------
    >>> tip = fp.AreaFunction([24.5, 500.0], limit=1000e-9, unit=1e-9)  # A(h) = 24.5 h^2 + 500 nm h
    >>> curve = fp.indent(fp.HalfSpace(young=72e9, poisson=0.17), tip, depth=[50e-9, 100e-9])
    >>> print([f"{force * 1e3:.3f} mN" for force in curve.force.values])
    ['0.448 mN', '1.569 mN']
    """

    coefficients: tuple[Annotated[float, a_ratio("coefficients", example="[24.5, 3.0]")], ...]
    limit: Annotated[float, a_length("limit", varies=False, example="5 um")]
    unit: Annotated[float, a_length("unit", varies=False, needed=True)] = 1.0
    start: Annotated[float, a_length("start", above=-np.inf, least=0.0, varies=False)] = 0.0
    _inverse: scipy.interpolate.PchipInterpolator = field(init=False, repr=False, compare=False)

    @refused_overflow()
    def _together_(self) -> None:
        if not any(self.coefficients):
            raise BadValue("AreaFunction.coefficients", "", "are all zero; C0 of a sharp Berkovich tip is 24.5.")
        if self.start >= self.limit:
            raise BadValue("AreaFunction.start", repr(self.start), f"must be below the limit, {self.limit!r}.")
        object.__setattr__(self, "_inverse", self._table())

    @property
    def reach(self) -> float:
        """Radius sqrt(A(limit)/pi) [m]."""
        return float(np.sqrt(self.area(np.array(self.limit)) / np.pi))

    @property
    def rings(self) -> tuple[float, ...]:
        """The radius at which the paraboloid meets the fit, if there is one [m]."""
        return (float(np.sqrt(self.area(np.array(self.start)) / np.pi)),) if self.start > 0 else ()

    def area(self, depth: Array) -> Array:
        """A(h) of the fit [m^2] at depths h [m]; below `start` that of the paraboloid."""
        depth = np.asarray(depth, dtype=float)
        fitted = self._fit(np.maximum(depth, self.start))[0]
        return np.asarray(fitted * (np.minimum(depth / self.start, 1.0) if self.start > 0 else 1.0))

    def height(self, r: Array, phi: Array) -> Array:
        """Gap f [m] at radii r [m] and polar angles phi [rad], broadcast together."""
        return spread(self._depth(np.asarray(r, dtype=float)), phi)

    def slope(self, r: Array, phi: Array) -> Array:
        """Radial derivative df/dr [-], same broadcasting; where paraboloid and fit meet the value beyond."""
        r = np.asarray(r, dtype=float)
        depth = self._depth(r)
        growth = self._fit(np.maximum(depth, max(self.start, np.finfo(float).tiny)))[1]
        if self.start > 0:
            growth = np.where(r < self.rings[0], self._fit(np.array(self.start))[0] / self.start, growth)
        with np.errstate(divide="ignore", invalid="ignore"):
            return spread(np.where(r > 0, 2 * np.pi * r / growth, self._slope_at_apex()), phi)

    def _slope_at_apex(self) -> float:
        """sqrt(pi/C0) of a cone if only C0 is there, else zero."""
        return 0.0 if self.start > 0 or any(self.coefficients[1:]) else float(np.sqrt(np.pi / self.coefficients[0]))

    def _fit(self, depth: Array) -> tuple[Array, Array]:
        h = depth / self.unit
        powers = np.array([2.0, *(2.0**-k for k in range(len(self.coefficients) - 1))])
        terms = np.array(self.coefficients) * h[..., None] ** powers
        with np.errstate(divide="ignore", invalid="ignore"):
            return terms.sum(axis=-1) * self.unit**2, (powers * terms).sum(axis=-1) / h * self.unit

    def _depth(self, r: Array) -> Array:
        """Depth at which the area is pi r^2: from a table, sharpened by Newton's method in logarithms."""
        with np.errstate(divide="ignore"):
            x = np.log(r)
        low, high = self._inverse.x[[0, -1]]
        # towards the apex like the lowest power of h alone, or the paraboloid
        steepness = 2.0 if self.start > 0 else 2 / self._lowest_power()
        h = np.exp(self._inverse(np.clip(x, low, high)) + steepness * np.minimum(x - low, 0.0))
        fitted = (h > np.finfo(float).tiny) & (x < high) & ((x > low) | (self.start == 0))
        for _ in range(50):
            area, growth = self._fit(np.where(fitted, h, self.limit))
            step = np.where(fitted, (2 * x + np.log(np.pi) - np.log(area)) * area / (growth * h), 0.0)
            h = h * np.exp(np.clip(step, -0.5, 0.5))
            if np.abs(step).max(initial=0.0) < SAME:
                break
        growth, last = self._fit(np.array(self.limit))[1], np.exp(high)
        return np.asarray(np.where(r > last, self.limit + (r - last) * 2 * np.pi * last / growth, h))

    def _lowest_power(self) -> float:
        last = max(i for i, c in enumerate(self.coefficients) if c)
        return 2.0 if last == 0 else 2.0 ** (1 - last)

    def _table(self) -> scipy.interpolate.PchipInterpolator:
        first = self.start if self.start > 0 else self.limit * SAME
        h = np.geomspace(first, self.limit, 1000)
        area, growth = self._fit(h)
        bad = (area <= 0) | (growth <= 0)
        if bad.any():
            i = int(np.flatnonzero(bad)[-1])
            remedy = (
                f"Set start to {text(float(h[min(i + 2, h.size - 1)]), 'm')} or more: below it a paraboloid takes the "
                "place of the fit."
                if i + 1 < h.size
                else "Lower the limit to the range of the fit."
            )
            raise BadValue(
                "AreaFunction.coefficients",
                "",
                f"give an area of {area[i]:.4g} m^2 that rises by {growth[i]:.4g} m^2/m at a depth of "
                f"{text(float(h[i]), 'm')}; both must be > 0. {remedy}",
            )
        return scipy.interpolate.PchipInterpolator(np.log(area / np.pi) / 2, np.log(h))
