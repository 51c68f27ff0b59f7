"""One function turns a medium into the kernel that punch, contact and boundary elements use.

C(k) = 2 L(k l)/(E* k) with E* the plane-strain modulus at the surface, l the medium's own length and L -> 1 for short waves.
Solvers work with the remainder L - 1, which vanishes at short waves: exponentially under homogeneous layers, like
tail/(k l) where the modulus varies at the surface itself. A power-law half-space is the one exception: L = c (k l)^exponent.

Two bodies pressed together: at every point of the contact the gap is closed by the sum of both surface displacements, and
both carry the same pressure, so the compliances add, C = C_1 + C_2, and nothing that is built on C knows the difference.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, values
from flatpunch._support.readable import readable
from flatpunch.compliances.interpolant import Combined, Interpolant, SmoothResponse, interpolate
from flatpunch.compliances.layered import SATURATION
from flatpunch.compliances.power_law import power_law_constant
from flatpunch.compliances.response import (
    layered_response,
    long_wave_power,
    saturation,
    smallest_and_largest_modulus,
)
from flatpunch.compliances.transverse import flexibility_of
from flatpunch.media import Body, Membrane, PunchSolution, Stack, TabulatedMedium, TwoBodies, underlying
from flatpunch.media.material import PowerLaw


@readable
@dataclass(frozen=True, eq=False)
class Kernel:
    """Surface compliance of one medium (or of two bodies pressed together).

    Parameters
    ----------
    modulus : float
        Plane-strain modulus E* of the surface [Pa].
    length : float
        Own length l [m]; infinite when L = 1 everywhere.
    response : callable
        kappa = k l, shape (n,) -> L, shape (n,) [-].
    tail : float
        L - 1 -> tail/kappa at short waves; zero under homogeneous layers.
    cutoff : float
        kappa above which L - 1 - tail/kappa is below rounding.
    floor : float
        kappa below which L is smooth on the scale of kappa itself.
    exponent : float
        L ~ kappa^exponent at short waves; not 0 only for power-law half-spaces.
    limit : float
        L at short waves: 1, or 0 under a membrane on the surface with tension or bending stiffness, which takes no flat punches.
    series : SmoothResponse or None
        Under a graded surface layer: L - 1 as series, with derivatives, precise at all wavenumbers.
    solution : PunchSolution or None
        Flat punches that need not be computed, over the radii that it covers.

    See Also
    --------
    flatpunch.compliance : Makes it.
    flatpunch.bem.solve : Takes it.

    Examples
    --------
    >>> kernel = fp.compliance(fp.HalfSpace(young=5e3, poisson=0.5))
    >>> print(f"C = {kernel(np.array([1e6]))[0]:.2e} m/Pa, that is 2/(E* k)")
    C = 3.00e-10 m/Pa, that is 2/(E* k)
    """

    modulus: float
    length: float
    response: Callable[[Array], Array]
    tail: float = 0.0
    cutoff: float = SATURATION
    floor: float = 1e-3
    exponent: float = 0.0
    limit: float = 1.0
    series: SmoothResponse | None = None
    solution: PunchSolution | None = None

    def _line_(self) -> str:
        """Modulus and length; the response is a function."""
        return f"Kernel(modulus={self.modulus:.6g}, length={self.length:.6g})"

    @property
    def surface_length(self) -> float:
        """Depth to which the modulus of the surface reaches [m]: the length l, or less where a grading is steep."""
        return self.length / max(1.0, abs(self.tail))

    @property
    def homogeneous(self) -> bool:
        """Whether the medium is a homogeneous half-space, with no length of its own."""
        return not np.isfinite(self.length)

    @property
    def graded(self) -> bool:
        """Whether the modulus varies at the surface itself, so that L - 1 decays like a power of kappa."""
        return self.series is not None

    def remainder(self, kappa: Array) -> Array:
        """L at kappa = k l less its limit at short waves."""
        if self.series is not None:
            return np.asarray(self.series.derivatives(kappa, 0)[0])
        return self.response(kappa) - self.limit

    def __call__(self, k: float | Array) -> Array:
        """Compliance C(k) = u(k)/p(k).

        Parameters
        ----------
        k : float or array, shape (n,)
            Wavenumbers [1/m], > 0.

        Returns
        -------
        ndarray, shape (n,)
            C(k) [m/Pa]: inward displacement per pressure of the same wavenumber.
        """
        k = values("k", k, strict=True, unit="1/m")
        kappa = k * self.length if not self.homogeneous else k
        return np.asarray(2 * self.response(kappa) / (self.modulus * k))


def compliance(medium: Body, *, membrane: bool = False) -> Kernel:
    """Surface compliance of a medium.

    Parameters
    ----------
    medium : HalfSpace, TransverselyIsotropicHalfSpace, Medium, PowerLawHalfSpace, TwoBodies or TabulatedMedium
        The body; equal media share one kernel and with it every solution already computed.
    membrane : bool
        Whether the medium may have a membrane on its surface. C(k) then falls faster than 1/k, and a flat punch has a force along
        its rim: boundary elements and rough contacts alone take such a kernel.

    Returns
    -------
    Kernel
        Callable: C(k) [m/Pa] at wavenumbers k [1/m].

    Raises
    ------
    ValueError, TypeError
        If the medium is none, lifts off, or has a membrane on its surface that is not asked for.

    See Also
    --------
    flat_punch : The first contact made from it.
    compliances.Kernel : What it returns.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> kernel = fp.compliance(gel)
    >>> half_space = fp.compliance(fp.HalfSpace(young=5e3, poisson=0.5))
    >>> k = np.array([1e5, 1e6, 1e7])
    >>> print((kernel(k) / half_space(k)).round(3))  # short waves do not reach the base
    [0.005 0.641 1.   ]
    """
    if underlying(medium).free:
        raise ValueError(
            "medium = FreeLayer(...) lifts off its base, so that it has no compliance: only `indent` takes it, with round "
            "tips and flat punches. A layer that is held down is Medium([Layer(..., bonded=False)], base=...)."
        )
    if not membrane:
        check_no_membrane(medium)
    return _tabulated(medium) if isinstance(medium, TabulatedMedium) else _kernel(medium)


def check_no_membrane(medium: Body) -> None:
    """Refuse a membrane on the surface, where it is not solved."""
    if any(body.membrane for body in underlying(medium).elastic):
        raise ValueError(
            "medium has a membrane on its surface, which only `indent`, `pressure`, `rough_contact`, `kernels` and "
            "compliance(medium, membrane=True) take: under its tension flat punches have a force along their rim. Elsewhere put "
            "it below a layer that is thin against the contact: Layer(..., bonded=Interface(membrane=...))."
        )


@byte_cached
def _tabulated(medium: TabulatedMedium) -> Kernel:
    return replace(_kernel(medium.medium), solution=medium.solution)


@byte_cached
def _kernel(medium: Body) -> Kernel:
    if isinstance(medium, TwoBodies):
        return _pair(medium)
    if medium.power_law:
        return _power_law(medium.power_law)
    ((_, stack),) = medium.sides
    if stack.membrane and stack.membrane.reach(1.0):
        return _held(stack, stack.membrane)
    if not stack.layers:
        return Kernel(modulus=stack.surface_modulus, length=float("inf"), response=np.ones_like)
    return _graded_stack(stack) if stack.varies else _stack(stack)


# Responses are objects, not closures, so that kernels can be handed to other processes.


@dataclass(frozen=True, slots=True)
class _Layered:
    medium: Stack
    length: float

    def __call__(self, kappa: Array) -> Array:
        return layered_response(self.medium, kappa / self.length)


@dataclass(frozen=True, slots=True)
class _Times:
    factor: float
    response: Callable[[Array], Array]

    def __call__(self, kappa: Array) -> Array:
        return self.factor * self.response(kappa)


@dataclass(frozen=True, slots=True)
class _Power:
    constant: float
    exponent: float

    def __call__(self, kappa: Array) -> Array:
        return self.constant * kappa**self.exponent


@dataclass(frozen=True, slots=True)
class _Pair:
    """L of two bodies: a constant from homogeneous ones, share * L(stretch * kappa) from the others."""

    constant: float
    parts: tuple[tuple[float, float, Callable[[Array], Array]], ...]

    def __call__(self, kappa: Array) -> Array:
        varying = sum(share * response(stretch * kappa) for share, stretch, response in self.parts)
        return np.asarray(self.constant + varying)


def _held(medium: Stack, membrane: Membrane) -> Kernel:
    """Kernel under a membrane on the surface: L vanishes at short waves; under in-plane stiffness alone the modulus grows there.

    What does not stretch leaves u_l = 0, so that C is that of H_zz - H_lz^2/H_ll, and comes to it like 1/k.
    """
    modulus = medium.surface_modulus
    length = medium.length if medium.layers else membrane.reach(modulus)
    response = _Layered(medium, length)
    smallest, largest = smallest_and_largest_modulus(medium)
    scales = length / (medium.thickness or length)
    if membrane.tension or membrane.bending:
        floor = 1e-3 * scales * (smallest / largest)
        return Kernel(modulus, length, response, cutoff=float("inf"), floor=floor, limit=0.0)
    (along, mixed), (_, across) = flexibility_of(medium.parts[0].plane)
    stiffer = 1 / (1 - mixed**2 / (along * across))
    start = min(0.1 * scales * float(np.sqrt(smallest / largest)), 1.0)
    series = interpolate(_Times(stiffer, response), start, long_wave_power(medium), vanishing=False)
    return _of_series(modulus * stiffer, length, series)


def _of_series(modulus: float, length: float, series: Interpolant) -> Kernel:
    """Kernel whose L - 1 falls like a power at short waves."""
    return Kernel(
        modulus,
        length,
        series,
        tail=series.tail,
        cutoff=_tail_begins(series),
        floor=series.floor,
        series=series,
    )


def _stack(medium: Stack) -> Kernel:
    # with more layers interpolating a table of the recursion is faster
    if len(medium.layers) > 4:
        return _tabulated_stack(medium)
    length = medium.length
    smallest, largest = smallest_and_largest_modulus(medium)
    # below this kappa even the longest length of the stack, thickness times modulus ratio, is short
    floor = 1e-3 * (length / medium.thickness) * (smallest / largest)
    return Kernel(
        modulus=medium.surface_modulus,
        length=length,
        response=_Layered(medium, length),
        cutoff=saturation(medium.layers[0]),
        floor=floor,
    )


def _tabulated_stack(medium: Stack) -> Kernel:
    series = _interpolated(medium, _Layered(medium, medium.length), vanishing=True)
    cutoff = saturation(medium.layers[0])
    return Kernel(
        modulus=medium.surface_modulus, length=medium.length, response=series, cutoff=cutoff, floor=series.floor
    )


def _interpolated(medium: Stack, response: Callable[[Array], Array], *, vanishing: bool) -> Interpolant:
    smallest, largest = smallest_and_largest_modulus(medium)
    start = 0.1 * (medium.length / medium.thickness) * float(np.sqrt(smallest / largest))
    last = saturation(medium.layers[0])
    return interpolate(response, min(start, last / 2), long_wave_power(medium), vanishing=vanishing, last=last)


def _graded_stack(medium: Stack) -> Kernel:
    if not medium.layers[0].varies:
        return _tabulated_stack(medium)
    series = _interpolated(medium, _Layered(medium, medium.length), vanishing=False)
    return _of_series(medium.surface_modulus, medium.length, series)


def _tail_begins(series: SmoothResponse) -> float:
    """Kappa above which L - 1 is tail/kappa to rounding."""
    kappa = np.geomspace(series.cutoff, 1e10, 100)
    rest = np.abs(series.derivatives(kappa, 0)[0] - series.tail / kappa)
    return float(kappa[min(int(np.flatnonzero(rest > 1e-14).max(initial=-1)) + 1, kappa.size - 1)])


def _power_law(medium: PowerLaw) -> Kernel:
    if medium.exponent == 0:
        return Kernel(modulus=medium.surface_modulus, length=float("inf"), response=np.ones_like)
    constant, exponent = power_law_constant(medium.exponent, medium.poisson), medium.exponent
    return Kernel(
        modulus=medium.surface_modulus,
        length=medium.depth,
        response=_Power(constant, exponent),
        exponent=exponent,
        cutoff=float("inf"),
        floor=0.0,
    )


def _pair(pair: TwoBodies) -> Kernel:
    kernels = [compliance(body, membrane=True) for body in pair.elastic]
    if len(kernels) == 1:
        return kernels[0]
    # half-spaces have no length, the membranes on them have
    modulus, length = pair.surface_modulus, pair.length
    if not np.isfinite(length):
        length = min(kernel.length for kernel in kernels)
    shares = [modulus / kernel.modulus for kernel in kernels]
    if kernels[0].exponent:
        return _power_law_pair(kernels, shares, modulus, length)
    if all(kernel.homogeneous for kernel in kernels):
        return Kernel(modulus=modulus, length=length, response=np.ones_like)
    # notation: kappa_i = k l_i = stretch_i * kappa; a homogeneous body has L = 1 and no length
    parts = [
        (share, kernel.length / length, kernel)
        for share, kernel in zip(shares, kernels, strict=True)
        if not kernel.homogeneous
    ]
    constant = 1.0 - sum(share for share, _, _ in parts)

    series = None
    limit = constant + sum(share * kernel.limit for share, _, kernel in parts)
    if any(kernel.graded for _, _, kernel in parts) and limit == 1:
        series = Combined(tuple((share, stretch, _series(kernel)) for share, stretch, kernel in parts))
    return Kernel(
        modulus=modulus,
        length=length,
        response=_Pair(constant, tuple((share, stretch, kernel.response) for share, stretch, kernel in parts)),
        tail=sum(share * kernel.tail / stretch for share, stretch, kernel in parts),
        cutoff=max(kernel.cutoff / stretch for _, stretch, kernel in parts),
        floor=min(kernel.floor / stretch for _, stretch, kernel in parts),
        limit=limit,
        series=series,
    )


def _power_law_pair(kernels: list[Kernel], shares: list[float], modulus: float, length: float) -> Kernel:
    """Two power-law half-spaces of one exponent: the sum is a third."""
    exponent = kernels[0].exponent
    constant = sum(
        share * float(kernel.response(np.array([kernel.length / length]))[0])
        for share, kernel in zip(shares, kernels, strict=True)
    )
    return Kernel(
        modulus=modulus,
        length=length,
        response=_Power(constant, exponent),
        exponent=exponent,
        cutoff=float("inf"),
        floor=0.0,
    )


def _series(kernel: Kernel) -> SmoothResponse:
    """Response of one body of a pair as series, also under homogeneous layers."""
    if kernel.series is not None:
        return kernel.series
    if isinstance(kernel.response, Interpolant):
        return kernel.response
    lowest = 10 * kernel.floor
    power = round(float(np.diff(np.log(kernel.response(np.array([1.0, 2.0]) * 0.01 * kernel.floor)))[0] / np.log(2)))
    return interpolate(kernel.response, lowest, power, vanishing=True, last=kernel.cutoff)
