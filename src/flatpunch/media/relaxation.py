"""Relaxation of linear viscoelastic materials with a constant Poisson ratio: E(t) = E psi(t), E the modulus of the medium.

psi is the share of the modulus that is left at time t after a sudden strain. With psi(0) = 1 the medium is given by its
instantaneous modulus; any other normalisation is allowed. Under a strain that oscillates as exp(i omega t) the modulus is
E psi*(omega), psi* = i omega int_0^inf psi(t) exp(-i omega t) dt, its real part the storage, its imaginary part the loss modulus.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from flatpunch._support.checks import ROUNDING, Array, BadValue, Values, real, values
from flatpunch._support.declared import Checked, a_ratio, a_time, in_case_files
from flatpunch._support.readable import readable

ComplexArray = NDArray[np.complex128]


@runtime_checkable
class Relaxation(Protocol):
    """What a viscoelastic contact asks of a material."""

    def __call__(self, t: Array) -> Array:
        """psi(t) at times t >= 0 [s]."""

    def integral(self, t: Array) -> Array:
        """int_0^t psi [s]."""

    def dynamic(self, omega: Array) -> ComplexArray:
        """psi*(omega) at angular frequencies [rad/s]: storage + i loss, over the modulus of the medium."""


@in_case_files("relaxation", "prony")
@readable
@dataclass(frozen=True, slots=True)
class Prony:
    """psi(t) = equilibrium + sum_j weights_j exp(-t/times_j).

    Parameters
    ----------
    weights : sequence of float
        g_j [-], > 0.
    times : sequence of float
        Relaxation times [s], > 0, as many as weights.
    equilibrium : float, optional
        psi after infinite time [-], >= 0. By default 1 - sum(weights): the modulus of the medium is the instantaneous one.

    See Also
    --------
    StandardLinearSolid : One time only.
    PowerLawRelaxation : Soft tissue and cells.
    indent : Takes it as `relaxation`.

    Examples
    --------
    >>> fp.Prony([0.5], [1.0])
    Prony(weights=(0.5,), times=(1,), equilibrium=0.5)
    """

    weights: tuple[Annotated[float, a_ratio("weights", above=0.0, example="[0.5, 0.2]")], ...]
    times: tuple[Annotated[float, a_time("times", example='["1 s", "10 s"]')], ...]
    equilibrium: Annotated[float, a_ratio("equilibrium", least=0.0, varies=False)]

    def __init__(self, weights: Values, times: Values, equilibrium: float | None = None) -> None:
        g = values("Prony.weights", weights, strict=True, unit="1")
        tau = values("Prony.times", times, strict=True, unit="s")
        if g.size != tau.size:
            raise BadValue("Prony.times", "", f"are {tau.size} for {g.size} weights: one time per weight is needed.")
        rest = 1 - float(g.sum()) if equilibrium is None else real("Prony.equilibrium", equilibrium, "1")
        # decimal weights that add up to one do so to rounding only
        if rest < (-ROUNDING if equilibrium is None else 0.0):
            raise BadValue(
                "Prony.equilibrium",
                f"{rest:.6g}",
                f"must be >= 0. The weights add up to {g.sum():.6g}; give equilibrium if the modulus of the medium is "
                "not the instantaneous one.",
            )
        object.__setattr__(self, "weights", tuple(map(float, g)))
        object.__setattr__(self, "times", tuple(map(float, tau)))
        object.__setattr__(self, "equilibrium", max(rest, 0.0))

    def __call__(self, t: Array) -> Array:
        """psi(t) at times t >= 0 [s]."""
        g, tau = np.array(self.weights), np.array(self.times)
        return np.asarray(self.equilibrium + np.exp(-np.asarray(t, dtype=float)[..., None] / tau) @ g)

    def integral(self, t: Array) -> Array:
        """int_0^t psi [s]."""
        g, tau = np.array(self.weights), np.array(self.times)
        t = np.asarray(t, dtype=float)
        return np.asarray(self.equilibrium * t - np.expm1(-t[..., None] / tau) @ (g * tau))

    def dynamic(self, omega: Array) -> ComplexArray:
        """psi*(omega): storage + i loss over the modulus of the medium."""
        g, tau = np.array(self.weights), np.array(self.times)
        turn = 1j * np.asarray(omega, dtype=float)[..., None] * tau
        return np.asarray(self.equilibrium + (turn / (1 + turn)) @ g)


@in_case_files("relaxation", "standard-linear-solid")
@readable
@dataclass(frozen=True, slots=True)
class StandardLinearSolid(Checked):
    """psi(t) = equilibrium + (1 - equilibrium) exp(-t/time): one spring beside a spring and a dashpot in series.

    Parameters
    ----------
    equilibrium : float
        Long-time modulus over the instantaneous one [-], between 0 and 1; 0 is a Maxwell fluid.
    time : float
        Relaxation time [s], > 0.

    See Also
    --------
    Prony : Several times.
    PowerLawRelaxation : Soft tissue and cells.
    indent : Takes it as `relaxation`.

    Examples
    --------
    >>> fp.StandardLinearSolid(equilibrium=0.4, time=1.0)
    StandardLinearSolid(equilibrium=0.4, time=1)
    """

    equilibrium: Annotated[
        float,
        a_ratio(
            "equilibrium",
            least=0.0,
            below=1.0,
            outside="must be below 1 and not negative: it is the long-time modulus over the instantaneous one.",
        ),
    ]
    time: Annotated[float, a_time("relaxation time")]

    @property
    def prony(self) -> Prony:
        """Prony series of one term with this relaxation."""
        return Prony((1 - self.equilibrium,), (self.time,), self.equilibrium)

    def __call__(self, t: Array) -> Array:
        """psi(t) at times t >= 0 [s]."""
        return self.prony(t)

    def integral(self, t: Array) -> Array:
        """int_0^t psi [s]."""
        return self.prony.integral(t)

    def dynamic(self, omega: Array) -> ComplexArray:
        """psi*(omega): storage + i loss over the modulus of the medium."""
        return self.prony.dynamic(omega)


@in_case_files("relaxation", "power-law")
@readable
@dataclass(frozen=True, slots=True)
class PowerLawRelaxation(Checked):
    """psi(t) = (t/time)^-exponent: no instantaneous modulus, that of the medium is reached at t = time.

    Parameters
    ----------
    exponent : float
        alpha [-], 0 < alpha < 1; cells and soft gels have 0.05 to 0.4.
    time : float
        Time at which the modulus is that of the medium [s], > 0.

    See Also
    --------
    Prony, StandardLinearSolid : Exponential relaxation.
    indent : Takes it as `relaxation`.

    Examples
    --------
    >>> fp.PowerLawRelaxation(exponent=0.2, time=1.0)
    PowerLawRelaxation(exponent=0.2, time=1)
    """

    exponent: Annotated[
        float,
        a_ratio("exponent", above=0.0, below=1.0, outside="must lie between 0 (elastic) and 1 (fluid), both excluded."),
    ]
    time: Annotated[float, a_time("time of the modulus", varies=False)]

    def __call__(self, t: Array) -> Array:
        """psi(t) at times t >= 0 [s]; infinite at t = 0."""
        with np.errstate(divide="ignore"):
            return np.asarray((np.asarray(t, dtype=float) / self.time) ** -self.exponent)

    def integral(self, t: Array) -> Array:
        """int_0^t psi [s]."""
        x = np.asarray(t, dtype=float) / self.time
        return np.asarray(self.time * x ** (1 - self.exponent) / (1 - self.exponent))

    def dynamic(self, omega: Array) -> ComplexArray:
        """psi*(omega) = Gamma(1 - alpha) (i omega time)^alpha: storage + i loss over the modulus of the medium."""
        turn = 1j * np.asarray(omega, dtype=float) * self.time
        return np.asarray(math.gamma(1 - self.exponent) * turn**self.exponent)
