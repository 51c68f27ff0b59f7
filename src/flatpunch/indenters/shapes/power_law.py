"""Power-law indenters f = r^n psi(phi): every level line has the same shape; superellipses among them.

psi may be a number, a function, or a table of one turn. Numbers and tables become small callables of their
own, so that `indenter.angular(phi)` works for all three and the indenter stays hashable.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated, Any, ClassVar

import numpy as np
import scipy

from flatpunch._support.checks import Array, BadValue, Values
from flatpunch._support.declared import Checked, Number, a_length, a_ratio, an_angle, checked, in_case_files
from flatpunch._support.readable import readable
from flatpunch.indenters._common import FULL_TURN, SCATTERED, Exponent, check_slender, corner_angles
from flatpunch.indenters.profile import PowerLawShape

Psi = Annotated[float, Number("angular factor", None, above=0.0)]


@readable
@dataclass(frozen=True, slots=True)
class AngularConstant(Checked):
    """psi(phi) = value: a body of revolution.

    Parameters
    ----------
    value : float
        psi [m^(1-n)], > 0.
    """

    value: Psi
    _called_: ClassVar = {"value": "PowerLaw.angular"}

    def __call__(self, phi: Array) -> Array:
        """Values psi in the shape of phi [rad]."""
        return np.full(np.shape(phi), self.value)


@readable
@dataclass(frozen=True, slots=True)
class AngularTable(Checked):
    """psi(phi) through the points of a table, as a cubic spline that closes after one turn.

    At `corners` the spline is cut: it keeps its value there but not its slope.

    Parameters
    ----------
    phi : sequence of float
        Polar angles [rad], strictly increasing, within less than one turn (the first point is not repeated).
    psi : sequence of float
        Values [m^(1-n)], > 0, and so that the spline stays positive in between.
    corners : sequence of float
        Angles of the table at which the outline has an edge.
    """

    phi: tuple[Annotated[float, an_angle("angle", least=-np.inf)], ...]
    psi: tuple[Psi, ...]
    corners: tuple[float, ...] = ()
    _spline: scipy.interpolate.PPoly = field(init=False, repr=False, compare=False)
    _called_: ClassVar = {"phi": "PowerLaw.angular phi", "psi": "PowerLaw.angular psi"}

    def _together_(self) -> None:
        phi, psi = np.array(self.phi), np.array(self.psi)
        if phi.size != psi.size or phi.size < 3:
            raise BadValue(
                "PowerLaw.angular",
                "",
                f"has {phi.size} angles and {psi.size} values; a table needs 3 or more of each, equally many.",
            )
        if (np.diff(phi) <= 0).any() or phi[-1] - phi[0] >= FULL_TURN:
            raise BadValue(
                "PowerLaw.angular",
                "",
                "phi must increase strictly and stay below one turn (2 pi): the table closes by itself, leave out "
                "the repeated first point.",
            )
        object.__setattr__(self, "corners", corner_angles("PowerLaw.corners", self.corners))
        object.__setattr__(self, "_spline", _closed_spline(phi, psi, self.corners))

    def __call__(self, phi: Array) -> Array:
        """Values psi in the shape of phi [rad]."""
        start = self._spline.x[0]
        return np.asarray(self._spline(start + np.mod(np.asarray(phi) - start, FULL_TURN)))


def _closed_spline(phi: Array, psi: Array, corners: tuple[float, ...]) -> scipy.interpolate.PPoly:
    """One turn of piecewise cubics, starting at the first corner if there is one."""
    cuts = []
    for corner in corners:
        off = np.abs(np.mod(phi - corner + np.pi, FULL_TURN) - np.pi)
        if off.min() > 1e-9:
            raise BadValue(
                "PowerLaw.corners",
                "",
                f"contains {float(corner)!r}, which is no angle of the table. Add the corner's own value to the table.",
            )
        cuts.append(int(np.argmin(off)))
        if cuts[-1] in cuts[:-1]:
            raise BadValue("PowerLaw.corners", "", f"contains {float(corner)!r} twice. Give each corner once.")
    first = min(cuts, default=0)
    x = np.concatenate([phi[first:], phi[:first] + FULL_TURN, [phi[first] + FULL_TURN]])
    y = np.concatenate([psi[first:], psi[:first], [psi[first]]])
    if not cuts:
        return scipy.interpolate.CubicSpline(x, y, bc_type="periodic")
    ends = [*sorted(cut - first for cut in cuts), phi.size]
    pieces = [scipy.interpolate.CubicSpline(x[i : j + 1], y[i : j + 1]) for i, j in pairwise(ends)]
    joints = np.concatenate([pieces[0].x, *(piece.x[1:] for piece in pieces[1:])])
    return scipy.interpolate.PPoly(np.hstack([piece.c for piece in pieces]), joints)


@in_case_files("indenter", None, "through")
@readable
@dataclass(frozen=True, slots=True)
class PowerLaw(PowerLawShape):
    """Indenter f = r^n psi(phi).

    Parameters
    ----------
    exponent : float
        n [-], > 0. The theory wants n >= 1; smaller ones have an infinite slope at the apex.
    angular : float, callable, or pair (phi, psi)
        psi(phi) [m^(1-n)], > 0 and periodic over one turn: a number (body of revolution), a function of an
        array of angles [rad], or a table of one turn through which a cubic spline is laid.
    corners : sequence of float
        Polar angles [rad] at which psi has an edge; for a table they must be angles of the table. Quadrature
        over the angle is split there, so a corner that is not named costs accuracy.

    Raises
    ------
    ValueError, TypeError
        If psi is not positive, finite and periodic, or does not accept arrays.

    See Also
    --------
    Superellipse : Rounded rectangles as level lines.
    HeightMap : Shapes of any kind.

    Examples
    --------
    >>> tip = fp.PowerLaw(exponent=2.0, angular=1e5)
    >>> tip.exponent
    2.0
    """

    exponent: Exponent = field()
    angular: Callable[[Array], Array]
    corners: tuple[float, ...] = ()
    _round: bool = field(init=False, repr=False, compare=False)

    @checked
    def __init__(
        self,
        exponent: Exponent,
        angular: float | Callable[[Array], Array] | tuple[Values, Values],
        corners: Sequence[float] = (),
    ) -> None:
        object.__setattr__(self, "exponent", exponent)
        object.__setattr__(self, "corners", corner_angles("PowerLaw.corners", corners))
        object.__setattr__(self, "angular", _as_angular(angular, self.corners))
        object.__setattr__(self, "_round", bool(np.ptp(_tried(self.angular)) == 0))

    @classmethod
    @checked
    def through(
        cls,
        exponent: Exponent,
        radius: Annotated[float, a_length("radius", example="5 um")],
        height: Annotated[float, a_length("height", example="1 um")],
        angles: tuple[Annotated[float, an_angle("angles", least=-np.inf)], ...] | None = None,
        factors: tuple[Annotated[float, a_ratio("factors", example="[1.0, 1.2, 1.1]")], ...] | None = None,
        corners: tuple[Annotated[float, an_angle("corners", least=-np.inf)], ...] = (),
    ) -> PowerLaw:
        """Power law by its height at a radius, f = height (r/radius)^exponent, times factors over the polar angle.

        Parameters
        ----------
        exponent : float
            n [-], > 0.
        radius, height : float
            A radius and the height there [m], > 0.
        angles, factors : sequence of float, optional
            Polar angles [rad] of one turn, and the factor on the height at each, > 0; a cubic spline is laid through them.
        corners : sequence of float
            Angles of the table at which the outline has an edge [rad].

        Raises
        ------
        ValueError
            If only one of angles and factors is given.
        """
        if (angles is None) != (factors is None):
            raise ValueError("angles and factors belong together: one factor for each polar angle of one turn.")
        psi = height / radius**exponent
        if angles is None or factors is None:
            return cls(exponent, psi)
        return cls(exponent, (angles, [psi * factor for factor in factors]), corners)

    @property
    def round(self) -> bool:
        """Whether psi is constant."""
        return self._round

    @property
    def seams(self) -> tuple[float, ...]:
        """Angles between which psi is analytic though it has no edge there: the points of a table."""
        table = self.angular
        return tuple(sorted(p % FULL_TURN for p in table.phi)) if isinstance(table, AngularTable) else ()


def _as_angular(angular: Any, corners: tuple[float, ...]) -> Callable[[Array], Array]:
    if isinstance(angular, AngularTable) and angular.corners != corners:
        return AngularTable(angular.phi, angular.psi, corners)
    if callable(angular):
        function: Callable[[Array], Array] = angular
        return function
    if isinstance(angular, (tuple, list)) or (isinstance(angular, np.ndarray) and angular.ndim):
        if len(angular) != 2:
            raise BadValue(
                "PowerLaw.angular", "", f"has {len(angular)} entries; a table is a pair (phi, psi) of two sequences."
            )
        return AngularTable(angular[0], angular[1], corners)
    return AngularConstant(angular)


def _tried(angular: Callable[[Array], Array]) -> Array:
    """Values at `SCATTERED`, after the checks that psi is usable at all."""
    try:
        psi = np.asarray(angular(SCATTERED), dtype=float)
    except (TypeError, ValueError) as error:
        raise TypeError(
            f"PowerLaw.angular fails on an array of angles ({error}). Write it with NumPy functions, e.g. "
            "lambda phi: 1 + 0.1 * np.cos(phi)."
        ) from error
    if psi.shape != SCATTERED.shape:
        raise BadValue(
            "PowerLaw.angular",
            "",
            f"gave shape {psi.shape} for {SCATTERED.shape} angles. Return one value per angle; a constant is given "
            "as a number.",
        )
    bad = ~(np.isfinite(psi) & (psi > 0))
    if bad.any():
        i = int(np.argmax(bad))
        raise BadValue(
            f"PowerLaw.angular({SCATTERED[i]:.4g})",
            f"{psi[i]:.6g}",
            "must be finite and > 0: f must rise from the apex in every direction.",
        )
    # a turn shifts the angle by rounding of 2 pi only, which a psi of ordinary smoothness does not see at
    # 1e-9
    if np.abs(np.asarray(angular(SCATTERED - FULL_TURN)) - psi).max() > 1e-9 * psi.max():
        raise BadValue("PowerLaw.angular", "", "is not periodic: psi(phi - 2 pi) differs from psi(phi).")
    return psi


@in_case_files("indenter")
@readable
@dataclass(frozen=True, slots=True)
class Superellipse(PowerLawShape):
    """Power law with superelliptic level lines, ``f = height_at_axes (|x/half_x|^p + |y/half_y|^p)^(n/p)``.

    Parameters
    ----------
    half_x, half_y : float
        Half-axes of the level line f = height_at_axes along x and y [m], > 0.
    height_at_axes : float
        Height of that level line above the apex [m], > 0.
    power : float
        p [-], >= 1: 1 is a rhombus, 2 an ellipse, larger ones approach a rectangle.
    exponent : float
        n of f ~ r^n [-], > 0: 1 for pointed tips, 2 for rounded ones.

    See Also
    --------
    PowerLaw : Angular factors of any form.
    EllipticParaboloid : Ellipses as level lines.

    Examples
    --------
    >>> tip = fp.Superellipse(half_x=1e-6, half_y=1.5e-6, height_at_axes=0.2e-6)
    >>> curve = fp.indent(fp.HalfSpace(young=1e9, poisson=0.3), tip, depth=50e-9, method="second-order")
    >>> print(f"{float(curve.force[0]) * 1e6:.1f} uN, within {100 * float(curve.force_error[0]):.1f} %")
    35.3 uN, within 0.5 %
    """

    half_x: Annotated[float, a_length("half-axis x", example="10 um")]
    half_y: Annotated[float, a_length("half-axis y", example="6 um")]
    height_at_axes: Annotated[float, a_length("height at the axes", example="1 um")]
    power: Annotated[
        float,
        a_ratio(
            "power",
            least=1.0,
            most=1000.0,
            outside="must lie between 1 and 1000: below, the level lines are hollow between the axes, and the contact would "
            "not be convex; beyond, they are rectangles.",
        ),
    ] = 4.0
    exponent: Exponent = 2.0

    def _together_(self) -> None:
        check_slender("Superellipse", self.half_x, self.half_y)

    @property
    def corners(self) -> tuple[float, ...]:
        """The axes, for a rhombus (power 1); otherwise none."""
        return _AXES if self.power == 1 else ()

    @property
    def seams(self) -> tuple[float, ...]:
        """The axes, where ``|x|^p`` is not analytic unless p is even, and the corners that a large p nearly has."""
        if self.power <= 2:
            return () if self.power in (1, 2) else _AXES
        diagonal = math.atan2(self.half_y, self.half_x)
        return tuple(sorted({*_AXES, diagonal, math.pi - diagonal, math.pi + diagonal, 2 * math.pi - diagonal}))

    @property
    def round(self) -> bool:
        """Whether the level lines are circles: power 2 and equal half-axes."""
        return self.power == 2 and self.half_x == self.half_y

    def angular(self, phi: Array) -> Array:
        """psi(phi) [m^(1-n)], in the shape of phi [rad]."""
        if self.round:
            return np.full(np.shape(phi), self.height_at_axes * self.half_x**-self.exponent)
        x, y = np.abs(np.cos(phi)) / self.half_x, np.abs(np.sin(phi)) / self.half_y
        larger = np.maximum(x, y)
        # the larger one in front, so that no power overflows
        norm = larger * (1 + (np.minimum(x, y) / larger) ** self.power) ** (1 / self.power)
        return np.asarray(self.height_at_axes * norm**self.exponent)


_AXES = (0.0, math.pi / 2, math.pi, 3 * math.pi / 2)
