"""Forward model of a fit: force over depth at given parameters, with all derivatives.

    F(d) = F0 phi(d/d0; q),    dF/dtheta_j = F (A_j - s B_j + sum_i dln phi/dq_i Q_ij),    s = dln F/dln d

with theta the free parameters in their internal form, ln F0, ln d0 and q linear in them with coefficients A, B, Q
(`flatpunch.fits.parameters.scaling`) and phi from `flatpunch.fits.elastic.table`. 4000 depths take about 0.2 ms.
Tables are made by `indent` and shared by all models of the same family, so that the curves of a batch pay for them once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch._support.readable import readable
from flatpunch.contact import Method, MethodName, indent, method_of
from flatpunch.contact.curve import FEW_ANGLES, percent
from flatpunch.contact.finite_strain.caps import place_of
from flatpunch.contact.physics import FiniteStrain, Physics
from flatpunch.fits.elastic.table import Table, at_pieces
from flatpunch.fits.parameters.sample import Sample
from flatpunch.fits.parameters.scaling import Scaling, scaling
from flatpunch.fits.parameters.settings import FitMethod
from flatpunch.fits.parameters.unknowns import ExactForce, FreeParameters
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.punch import UnresolvedLayer

_THIRD_OF_DECADE = 10 ** (1 / 3)
"""By how much the largest depth of a table is lowered where the layer cannot be resolved."""


def method_for(indenter: Indenter, method: FitMethod = "auto") -> MethodName | Method:
    """Contact method of a fit: the one given, or by "auto" exact for round tips, else the best of the fast ones."""
    if not isinstance(method, str) or method != "auto":
        method_of(method)
        return method
    if indenter.round:
        return "exact"
    return "fourth-order" if indenter.exponent is not None else "second-order"


@readable
@dataclass(frozen=True)
class ForwardModel(FreeParameters):
    """Force over depth of one medium and tip, as a function of the free parameters.

    Parameters
    ----------
    medium, indenter : object
        The case; free parameters have their starting values in it.
    free : tuple of str
        Names such as "layers[0].young", "base.poisson", "indenter.radius".
    method : str or method
        Contact method, or "auto".
    finite_strain : {"neo-hookean"}, optional
        Corrects forces for large strains, as in `indent`.

    See Also
    --------
    flatpunch.fit : Uses it.
    flatpunch.indent : The same contact, with all it returns.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> from flatpunch.fits import ForwardModel
    >>> model = ForwardModel(gel, fp.Sphere(radius=5e-6), ("layers[0].young",))
    >>> print((model.force(np.array([100e-9, 200e-9])) * 1e9).round(3))
    [1.04  3.789]
    """

    medium: Body
    indenter: Indenter
    free: tuple[str, ...] = ()
    method: FitMethod = "auto"
    finite_strain: FiniteStrain | None = None
    _table: Table = field(init=False, repr=False, compare=False)
    _forms: tuple[Array, Array] = field(init=False, repr=False, compare=False)
    knots: Mapping[str, tuple[float, float]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        free = tuple(self.free)
        object.__setattr__(self, "free", free)
        self.sample.check(free)
        method = method_for(self.indenter, self.method)
        object.__setattr__(self, "method", method)
        large = self.finite_strain is not None
        found = scaling(self.medium, self.indenter, free, large=large, numbers=self.numbers)
        if large:
            place_of(self.medium, self.indenter)
            if slanted := [name for name in free if self.numbers[name].number.slanted]:
                raise ValueError(f"{slanted[0]} cannot be fitted with finite_strain, whose factor depends on it.")
        forms = [self.linear(w) for w in (found.force, found.depth, *(c.weights for c in found.coordinates))]
        object.__setattr__(self, "_forms", (np.array([c for c, _ in forms]), np.array([w for _, w in forms])))
        object.__setattr__(self, "knots", found.knots)
        start = found.problem([c.offset for c in found.coordinates])
        names = tuple(c.name for c in found.coordinates)
        object.__setattr__(self, "_table", table_of(Family(*start, names, method, self.finite_strain, found)))

    @property
    def bends(self) -> bool:
        """Whether the free parameters change the shape of the force curve in a double logarithmic plot, or only shift it."""
        return bool(self._forms[0].size > 2)

    @property
    def tabulated(self) -> bool:
        """Whether forces come from a table; with many free parameters each is solved."""
        return self._table.tabulated

    @cached_property
    def sample(self) -> Sample:
        """The case; free parameters have their starting values in it."""
        return Sample(self.medium, self.indenter, Physics(finite_strain=self.finite_strain))

    def evaluate(self, depth: Array, theta: Array) -> tuple[Array, Array, Array]:
        """Force and derivatives at depths > 0.

        Parameters
        ----------
        depth : ndarray, shape (n,)
            Depths [m], all > 0.
        theta : ndarray, shape (parameters,)
            Internal values of the free parameters.

        Returns
        -------
        force, stiffness : ndarray, shape (n,)
            F [N], dF/dd [N/m].
        derivatives : ndarray, shape (parameters, n)
            dF/dtheta [N].
        """
        if not depth.size:
            # a trial beside the curve; without a depth the table would have no end
            return np.zeros(0), np.zeros(0), np.zeros((theta.size, 0))
        constants, weights = self._forms
        forms = constants + (weights @ theta if theta.size else 0.0)
        log_depth = np.log(depth) - forms[1]
        piece = self._table.at(tuple(forms[2:]), float(log_depth.max()))
        value, s, by_q = piece.at(log_depth)
        value += forms[0]
        force = np.exp(value, out=value)
        derivatives = np.empty((theta.size, depth.size))
        for j in range(theta.size):
            row = derivatives[j]
            np.multiply(s, -weights[1, j], out=row)
            row += weights[0, j]
            for i, by in enumerate(by_q):
                if weights[2 + i, j]:
                    row += weights[2 + i, j] * by
            row *= force
        return force, s * force / depth, derivatives

    def logarithms(self, log_depth: Array, theta: Array) -> tuple[Array, Array]:
        """ln F and d ln F/d ln d at ln of depths [m], shape (vectors, n), for many internal parameter vectors at once."""
        constants, weights = self._forms
        forms = constants + theta @ weights.T
        place = log_depth - forms[:, 1:2]
        value, slope = at_pieces(*self._table.at_many(forms[:, 2:], place.max(axis=1)), place)
        return value + forms[:, :1], slope

    def force(self, depth: Array, values: Mapping[str, float] | None = None) -> Array:
        """Force [N] at any depths [m], zero where depth <= 0; free parameters that `values` lacks are as in the case."""
        depth = np.asarray(depth, dtype=float)
        theta = self.internals(values)
        result = np.zeros_like(depth)
        touching = depth > 0
        if touching.any():
            result[touching] = self.evaluate(depth[touching], theta)[0]
        return result

    def exact(self, depth: Array, values: Mapping[str, float]) -> ExactForce:
        """Force without tables, from `indent`, with the notes of the method."""
        medium, indenter = self.case(values)
        method = method_for(indenter, self.method)
        law = self.finite_strain
        curve = indent(medium, indenter, depth=depth, method=method, angles=FEW_ANGLES, finite_strain=law)
        # outlines are no part of a fit
        notes = [note for note in str(curve.attrs["notes"]).splitlines() if "the outline" not in note]
        if not indenter.round:
            error = percent(float(curve["force_error"].max()))
            notes.append(f"Forces are those of the {curve.attrs['method']} method, which expects to be within {error}.")
        return ExactForce.of(curve, notes)


@dataclass(frozen=True)
class Family:
    """What models must have in common to share a table; `scaling` follows from it up to units."""

    medium: Body
    indenter: Indenter
    names: tuple[str, ...]
    method: MethodName | Method
    finite_strain: FiniteStrain | None
    scaling: Scaling = field(compare=False)


@byte_cached
def table_of(family: Family) -> Table:
    """The table of a family, the same for all models that belong to it."""
    solve, limit = _solver(family.scaling, family.method, family.finite_strain is not None)
    return Table(solve, family.scaling.coordinates, limit)


def _solver(found: Scaling, method: MethodName | Method, large: bool) -> tuple[Any, Any]:
    """The exact solution of the scaled problem, and how deep it goes."""

    def limit(q: tuple[float, ...]) -> float:
        """ln of the depth at which a tip of finite extent ends."""
        medium, indenter = found.problem(q)
        if indenter.flat or not np.isfinite(indenter.reach):
            return float("inf")
        for radius in indenter.reach * np.geomspace(1, 0.1, 12):
            try:
                curve = indent(medium, indenter, radius=radius, method=method, angles=FEW_ANGLES)
            except UnresolvedLayer:
                # far deeper than any measured depth: layers of a trial step that are very thin
                return float("inf")
            except ValueError as error:
                # the corrections of a series for the outline may end before the shape does
                refused = error
            else:
                return float(np.log(curve["depth"].values[0]))
        raise refused

    def solve(q: tuple[float, ...], delta: Array) -> Array:
        medium, indenter = found.problem(q)
        inside = np.ones(delta.shape, dtype=bool)
        phi = np.full(delta.shape, np.nan)
        while inside.any():
            try:
                curve = indent(medium, indenter, depth=delta[inside], method=method, angles=FEW_ANGLES)
            except UnresolvedLayer:
                # known only when it is met: depths of trial steps far from the measured ones
                if delta[inside].max() < _THIRD_OF_DECADE * delta[inside].min():
                    raise
                inside &= delta < delta[inside].max() / _THIRD_OF_DECADE
            except ValueError:
                # deeper than the shape of the tip goes
                reached = np.log(delta) < limit(q)
                if reached[inside].all():
                    raise
                inside &= reached
            else:
                phi[inside] = curve["force"].values
                break
        if large:
            # beyond the table its last value
            phi *= place_of(medium, indenter).ratio(delta)[0]
        return phi

    return solve, limit
