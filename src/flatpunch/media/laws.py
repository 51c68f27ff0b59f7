"""Material constants as functions of depth: named laws and tables.

Each law is a small frozen object, called with depths z [m] from the layer's own top, shape (n,), and equal to another
one with the same parameters, so that media made of them can be cached and written to a case file.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import scipy

from flatpunch._support.checks import Array, BadValue
from flatpunch._support.declared import Checked, Number, a_length, a_pressure, a_ratio
from flatpunch._support.readable import readable

Law = Callable[[Array], Array]
"""Depths z [m], shape (n,) -> values, shape (n,)."""


@dataclass(frozen=True, slots=True)
class _Transition(Checked, ABC):
    """What the laws from one modulus to another share: both, and the depth between them."""

    top: Annotated[float, a_pressure("at the top", held=True)]
    bottom: Annotated[float, a_pressure("at the bottom", held=True)]
    thickness: Annotated[float, a_length("thickness of the law")]

    @abstractmethod
    def __call__(self, z: Array) -> Array:
        """Young's modulus [Pa] at depths z [m]."""


@readable
@dataclass(frozen=True, slots=True)
class LinearModulus(_Transition):
    """E(z) = top + (bottom - top) z/thickness.

    Parameters
    ----------
    top, bottom : float
        Young's modulus at z = 0 and at z = thickness [Pa], > 0.
    thickness : float
        Depth at which `bottom` is reached [m], > 0.

    See Also
    --------
    ExponentialModulus, PowerModulus, DepthTable, Formula : Other laws.
    GradedLayer : The layer that takes it.

    Examples
    --------
    >>> fp.LinearModulus(1e9, 2e9, 1e-6)
    LinearModulus(top=1e+09, bottom=2e+09, thickness=1e-06)
    """

    def __call__(self, z: Array) -> Array:
        """Young's modulus [Pa] at depths z [m]."""
        return self.top + (self.bottom - self.top) * (np.asarray(z) / self.thickness)


@readable
@dataclass(frozen=True, slots=True)
class ExponentialModulus(_Transition):
    """E(z) = top (bottom/top)^(z/thickness).

    Parameters
    ----------
    top, bottom : float
        Young's modulus at z = 0 and at z = thickness [Pa], > 0.
    thickness : float
        Depth at which `bottom` is reached [m], > 0.

    See Also
    --------
    LinearModulus, PowerModulus, DepthTable, Formula : Other laws.
    GradedLayer : The layer that takes it.

    Examples
    --------
    >>> fp.ExponentialModulus(1e9, 2e9, 1e-6)
    ExponentialModulus(top=1e+09, bottom=2e+09, thickness=1e-06)
    """

    def __call__(self, z: Array) -> Array:
        """Young's modulus [Pa] at depths z [m]."""
        return np.asarray(self.top * np.exp(np.log(self.bottom / self.top) * (np.asarray(z) / self.thickness)))


@readable
@dataclass(frozen=True, slots=True)
class PowerModulus(_Transition):
    """E(z) = top + (bottom - top) (z/thickness)^exponent, the usual law of metal-ceramic coatings.

    Parameters
    ----------
    top, bottom : float
        Young's modulus at z = 0 and at z = thickness [Pa], > 0.
    thickness : float
        Depth at which `bottom` is reached [m], > 0.
    exponent : float
        > 0; 1 is the linear law.

    See Also
    --------
    LinearModulus, ExponentialModulus, DepthTable, Formula : Other laws.
    PowerLawHalfSpace : The law from the surface down to any depth.

    Examples
    --------
    >>> fp.PowerModulus(1e9, 2e9, 1e-6, exponent=2.0)
    PowerModulus(top=1e+09, bottom=2e+09, thickness=1e-06, exponent=2)
    """

    exponent: Annotated[float, a_ratio("exponent", above=0.0)]

    def __call__(self, z: Array) -> Array:
        """Young's modulus [Pa] at depths z [m]."""
        return self.top + (self.bottom - self.top) * (np.asarray(z) / self.thickness) ** self.exponent


@readable
@dataclass(frozen=True, slots=True)
class DepthTable(Checked):
    """Values at depths, joined by the monotone cubic of Fritsch and Butland (PCHIP): no overshoot.

    Parameters
    ----------
    depths : sequence of float
        Depths z [m] from the layer's own top, ascending from 0; at least two.
    entries : sequence of float
        The value at each depth.

    See Also
    --------
    Formula : The law as text.
    LinearModulus, ExponentialModulus, PowerModulus : Laws in closed form.

    Examples
    --------
    >>> fp.DepthTable([0.0, 0.5e-6, 1e-6], [1e9, 1.2e9, 2e9])
    DepthTable(depths=(0, 5e-07, 1e-06), entries=(1e+09, 1.2e+09, 2e+09))
    """

    depths: tuple[Annotated[float, a_length("depth", above=-np.inf, least=0.0, varies=False)], ...]
    entries: tuple[Annotated[float, Number("at a depth", None, held=True)], ...]
    _curve: scipy.interpolate.PchipInterpolator = field(init=False, repr=False, compare=False, default=None)

    def _together_(self) -> None:
        z, v = np.array(self.depths), np.array(self.entries)
        if z.size != v.size or z.size < 2:
            raise ValueError(
                f"DepthTable has {z.size} depths and {v.size} entries; it needs as many of one as of the other, "
                "at least two."
            )
        steps = np.diff(z)
        if (steps <= 0).any():
            i = int(np.argmax(steps <= 0)) + 1
            raise BadValue(f"DepthTable.depths[{i}]", f"{z[i]:g}", f"must lie below {z[i - 1]:g}: depths ascend.")
        object.__setattr__(self, "_curve", scipy.interpolate.PchipInterpolator(z, v))

    def __call__(self, z: Array) -> Array:
        """Values at depths z [m]; beyond the table its last cubic goes on."""
        return np.asarray(self._curve(z))

    @property
    def breaks(self) -> tuple[float, ...]:
        """Depths at which the second derivative jumps [m]."""
        return self.depths[1:-1]


@readable
@dataclass(frozen=True, slots=True)
class Multiple:
    """A law times a number.

    Parameters
    ----------
    law : callable
    factor : float
    """

    law: Law
    factor: Annotated[float, a_ratio("factor")]

    def __call__(self, z: Array) -> Array:
        """Values at depths z [m]."""
        return np.asarray(self.factor * self.law(z))

    @property
    def breaks(self) -> tuple[float, ...]:
        """Depths at which the second derivative jumps [m]."""
        return tuple(getattr(self.law, "breaks", ()))


@readable
@dataclass(frozen=True, slots=True)
class Constant(Checked):
    """One value at every depth.

    Parameters
    ----------
    value : float
    """

    value: Annotated[float, Number("", None, held=True)]

    def __call__(self, z: Array) -> Array:
        """The value at depths z [m]."""
        return np.full(np.shape(z), self.value)


LAWS: dict[str, Callable[..., Law]] = {
    "linear": LinearModulus,
    "exponential": ExponentialModulus,
    "power": PowerModulus,
}
"""Laws from one modulus to another by their names in case files."""


def times(law: Law, factor: float) -> Law:
    """The law times a number, of its own kind where that has a number to multiply."""
    named: object = law
    if isinstance(named, _Transition):
        return replace(named, top=factor * named.top, bottom=factor * named.bottom)
    if isinstance(named, DepthTable):
        return DepthTable(named.depths, tuple(factor * entry for entry in named.entries))
    if isinstance(named, Constant):
        return Constant(factor * named.value)
    return Multiple(law, factor)
