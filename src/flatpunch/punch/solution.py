"""One rigid cylindrical flat punch on a medium, solved directly (paper equations (P1), (P2), (P21))."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from flatpunch._support.checks import Array, FlatpunchWarning, numbers, positive, refused_overflow, values
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.compliances import Kernel, compliance
from flatpunch.compliances.interpolant import TOLERANCE
from flatpunch.media import Body
from flatpunch.numerics.chebyshev import log_derivative, nodes
from flatpunch.punch.basis import OUTWARDS, RELATIVE, beta, power_moments, regular_part
from flatpunch.punch.family import check_resolution, punch_family
from flatpunch.punch.matrix import RESOLVED, Responses, effective_beta, fewer_terms, solve_with_fewer, sufficient_terms


@readable
@dataclass(frozen=True)
class FlatPunch:
    """Solution for a rigid, frictionless, cylindrical punch with a flat end.

    Attributes
    ----------
    radius : float
        Punch radius a [m].
    modulus : float
        Plane-strain modulus E* of the surface [Pa].
    beta : float
        a/l, l the medium's own length; 0 on a half-space.
    coefficients : ndarray, shape (terms,)
        c_n of the pressure E*/a sum c_n p_n(r/a) per unit depth (basis of `flatpunch.punch.basis`, m = 0).
    error : float
        Estimated relative error of stiffness and moments: change when the last quarter of the terms is left out, or
        three eighths of them where the rim is not resolved, plus rounding and the quadrature over wavenumbers.
    edge_error : float
        The same of the edge coefficient, which depends most on the shortest length of the medium. At radii above about 3000 such
        lengths the pressure within one length of the rim is not resolved.
    alpha : float
        Exponent of (1 - rho^2) at the edge: -1/2, and (k - 1)/2 on a power-law half-space, whose one term is
        p_0 = 2 (1 + alpha)(1 - rho^2)^alpha.

    See Also
    --------
    flatpunch.flat_punch : Makes it.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> punch = fp.flat_punch(gel, radius=1e-6)
    >>> print(f"{punch.stiffness:.4f} N/m, {punch.normalized_stiffness / 2:.2f} times that on a half-space of gel")
    0.0258 N/m, 0.97 times that on a half-space of gel
    """

    radius: float
    modulus: float
    beta: float
    coefficients: Array
    error: float
    _edge: Array = field(repr=False)
    alpha: float = -0.5
    edge_error: float = 0.0

    @property
    def normalized_stiffness(self) -> float:
        """Kbar = F/(2 E* a d) [-] of (P2); 1 on a half-space."""
        return float(np.pi * self.coefficients[0])

    @property
    def stiffness(self) -> float:
        """Contact stiffness K = dF/dd [N/m]."""
        return 2 * self.modulus * self.radius * self.normalized_stiffness

    @property
    def edge_coefficient(self) -> float:
        """Edge strength [-]: its square is d(a Kbar)/da (Krein).

        It is the limit of pbar sqrt(1 - rho^2), except on power-law half-spaces with their other singularity.
        """
        return float(1 + np.pi * self._edge[0])

    @cached_property
    def lowest_pressure(self) -> float:
        """Smallest value of pbar (1 - rho^2)^(-alpha) [-]; negative where the punch would have to pull."""
        return float(np.min(np.pi * self._regular(OUTWARDS)))

    def pressure(self, r: float | Array) -> Array:
        """Pressure per unit depth, p(r)/d.

        Parameters
        ----------
        r : float or array
            Distance from the axis [m], >= 0.

        Returns
        -------
        ndarray, shape of `r`
            [Pa/m]; infinite at r = a, zero outside.
        """
        r = numbers("r", r, "m")
        if not np.all(np.isfinite(r)) or np.any(r < 0):
            raise ValueError("r must be finite and >= 0: it is the distance from the punch's axis in metres.")
        rho = np.minimum(r / self.radius, 1.0)
        with np.errstate(divide="ignore"):
            inside = self.modulus / self.radius * self._regular(rho) * ((1 - rho) * (1 + rho)) ** self.alpha
        return np.where(r <= self.radius, inside, 0.0)

    def _regular(self, rho: Array) -> Array:
        if self.alpha != -0.5:
            return np.full_like(rho, 2 * (1 + self.alpha) * self.coefficients[0])
        return np.tensordot(self.coefficients, regular_part(0, self.coefficients.size, rho), axes=1)

    @refused_overflow()
    def moment(self, exponent: float) -> float:
        """kappa_n = (n + 1) int_0^1 pbar rho^(n+1) drho of (P21) for real n > 0 [-]."""
        exponent = positive("exponent", exponent)
        if self.alpha != -0.5:
            weight = (1 + self.alpha) * beta(exponent / 2 + 1, 1 + self.alpha)
            return float((exponent + 1) * np.pi * weight * self.coefficients[0])
        b = power_moments(exponent, 0, self.coefficients.size)
        return float((exponent + 1) * np.pi * b @ self.coefficients)


@one_blas_thread()
@refused_overflow()
def flat_punch(medium: Body, radius: float) -> FlatPunch:
    """Press a rigid cylindrical punch with a flat end into a medium.

    Parameters
    ----------
    medium : Medium, HalfSpace, PowerLawHalfSpace, TwoBodies or TabulatedMedium
        The elastic body.
    radius : float
        Punch radius a [m], > 0.

    Returns
    -------
    FlatPunch
        Stiffness, pressure, moments and edge coefficient, with an error estimate.

    Warns
    -----
    FlatpunchWarning
        If the pressure is negative somewhere (stiff films): the punch would have to pull.

    Raises
    ------
    ValueError
        If the radius is not positive, or so large that the thinnest layer cannot be resolved.

    See Also
    --------
    compliance : The kernel behind it.
    Cylinder : The same punch as an indenter.
    atlas.table : Tabulated punches.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-6)], base=fp.RigidBase())
    >>> print(f"{fp.flat_punch(gel, radius=1e-6).stiffness:.4g} N/m")
    0.04825 N/m
    """
    punch = solved_punch(medium, positive("radius", radius, unit="m"))
    if punch.lowest_pressure < 0:
        warnings.warn(
            f"The pressure under a flat punch of radius {text(punch.radius, 'm')} (beta = {punch.beta:.3g}) is negative "
            "in part: a "
            "stiff film bends away under it. Stiffness and moments are those of a punch that sticks; a real contact lifts off "
            "there.",
            FlatpunchWarning,
            stacklevel=4,
        )
    return punch


def solved_punch(medium: Body, radius: float) -> FlatPunch:
    """The flat punch, also where it would have to pull: part of round contacts, which press everywhere."""
    kernel = compliance(medium)
    beta = radius / kernel.length
    if kernel.homogeneous:
        return FlatPunch(radius, kernel.modulus, 0.0, np.array([1 / np.pi]), 0.0, np.zeros(1))
    if kernel.exponent:
        responses = punch_family(kernel).at(values("beta", beta))
        alpha = (kernel.exponent - 1) / 2
        return FlatPunch(radius, kernel.modulus, beta, responses.flat[0], RELATIVE, responses.edge[0], alpha, RELATIVE)
    known = kernel.solution
    if known is not None and known.covers(values("beta", beta)):
        flat, edge, _ = known.round(values("beta", beta))
        return FlatPunch(radius, kernel.modulus, beta, flat[0], known.error, edge[0], edge_error=known.error)
    check_resolution(kernel, beta)
    terms = sufficient_terms(kernel, beta)
    responses, fewer = _solve(kernel, beta, terms, fewer_terms(kernel, beta, terms))
    error, edge_error = _errors(kernel, beta, responses, fewer)
    return FlatPunch(radius, kernel.modulus, beta, responses.flat[0], error, responses.edge[0], edge_error=edge_error)


def _solve(kernel: Kernel, beta: float, terms: int, fewer: int) -> tuple[Responses, Responses]:
    """Responses with all terms and with fewer; an unresolved rim follows from (pi e)^2 = d(beta Kbar)/d beta (Krein)."""
    if kernel.graded or effective_beta(kernel, beta) <= RESOLVED:
        many, few = solve_with_fewer(kernel, values("beta", beta), terms, fewer)
        return many, few
    # over this interval of ln(radius) stiffness is differentiated where the rim is not resolved
    half = 0.05
    radii = nodes(np.log(beta) - half, np.log(beta) + half, 7)
    derivative = log_derivative(radii)
    many, few = (_with_rim(around, derivative) for around in solve_with_fewer(kernel, radii, terms, fewer))
    return many, few


def _with_rim(around: Responses, derivative: Array) -> Responses:
    """The answer in the middle of seven radii, with the rim's strength from the growth of the stiffness."""
    kbar = np.pi * around.flat[:, 0]
    strength = np.sqrt((kbar + derivative @ kbar)[3])
    edge = np.append((strength - 1) / np.pi, around.edge[3, 1:])
    return Responses(around.flat[3:4], edge[None], around.slope[3:4], around.rounding[3:4])


def _errors(kernel: Kernel, beta: float, responses: Responses, fewer: Responses) -> tuple[float, float]:
    """Changes of stiffness and moments, and of the edge coefficient, with fewer terms; plus rounding."""
    stiffness = abs(fewer.flat[0, 0] / responses.flat[0, 0] - 1)
    # the first moment is that of a cone, which needs the most terms
    first, second = (
        solution.flat[0] @ power_moments(1.0, 0, solution.flat.shape[1]) for solution in (fewer, responses)
    )
    stiffness = max(stiffness, abs(first / second - 1))
    edge = abs((1 + np.pi * fewer.edge[0, 0]) / (1 + np.pi * responses.edge[0, 0]) - 1)
    floor = float(responses.rounding[0]) + TOLERANCE
    if not kernel.graded and effective_beta(kernel, beta) > RESOLVED:
        # no better than the stiffness it follows from, and 1e-9 from seven nodes; five leave 4e-9 (tests, 300 stacks)
        edge = max(edge, stiffness) + 1e-9
    return float(stiffness) + floor, float(edge) + floor
