"""Free parameters of a forward model: by name in SI outside, as a vector theta of their internal form inside."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Self

import numpy as np
import xarray as xr

from flatpunch._support.checks import Array
from flatpunch.fits.parameters.numbers import Numbers, Scale, ends
from flatpunch.fits.parameters.sample import Sample
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body

_NEAR = 4.0
"""Fits are taken for near each other where rounded internal parameters and ln of the depth, times this, are the same."""


class ExactForce(NamedTuple):
    """Force without tables [N], the notes of the method, and its own relative error."""

    force: Array
    notes: str
    error: float

    @classmethod
    def of(cls, curve: xr.Dataset, notes: Iterable[str]) -> Self:
        """That of a contact; exact methods estimate no error."""
        error = float(curve["force_error"].max()) if "force_error" in curve else 0.0
        return cls(np.asarray(curve["force"].values), "\n".join(notes), error)


class FreeParameters(ABC):
    """What all forward models know of their free parameters.

    Attributes
    ----------
    free : tuple of str
        Their names, in the order of theta.
    adhesive : bool
        Whether the tip holds on below the surface; the model then has `pull_off`.
    over_time : bool
        Whether the force is fitted over time, with the memory of the sample.
    """

    free: tuple[str, ...]
    adhesive: ClassVar[bool] = False
    over_time: ClassVar[bool] = False

    @property
    def tabulated(self) -> bool:
        """Whether forces come from tables, so that an evaluation costs no solution of the contact."""
        return True

    if TYPE_CHECKING:  # properties here would be taken for defaults of fields

        @property
        def sample(self) -> Sample:
            """The case; free parameters have their starting values in it."""

        @property
        def knots(self) -> Mapping[str, tuple[float, float]]:
            """Internal values between which there are knots of a table, where these end."""

    @property
    def numbers(self) -> Numbers:
        """All numbers of the case by name, with their values in it."""
        return self.sample.numbers

    def case(self, values: Mapping[str, float]) -> tuple[Body, Indenter]:
        """Medium and indenter with these values."""
        sample = self.sample.replaced(values)
        return sample.medium, sample.indenter

    @abstractmethod
    def force(self, depth: Array, values: Mapping[str, float] | None = None) -> Array:
        """Force [N] at depths [m] by the tables."""

    @abstractmethod
    def exact(self, depth: Array, values: Mapping[str, float]) -> ExactForce:
        """Force at depths [m] without tables."""

    def off(self, exact: ExactForce, depth: Array, values: Mapping[str, float]) -> tuple[float, float]:
        """Relative difference of the table at the last of depths, and what may be left of it."""
        # interpolation leaves less than 1e-6
        last = float(exact.force[-1])
        return abs(float(self.force(depth[-1:], values)[0]) / last - 1), max(1e-5, exact.error)

    def off_once(self, deepest: float, values: Mapping[str, float]) -> tuple[float, float]:
        """The same at one depth, solved once for fits that are near each other."""
        place = np.append(self.internals(values), np.log(deepest))
        key = tuple(np.rint(_NEAR * place).tolist())
        if key not in self._offs:
            depth = np.array([deepest])
            self._offs[key] = self.off(self.exact(depth, values), depth, values)
        return self._offs[key]

    @cached_property
    def _offs(self) -> dict[tuple[float, ...], tuple[float, float]]:
        return {}

    @cached_property
    def scales(self) -> dict[str, Scale]:
        """How the free parameters follow from their internal values."""
        return {name: Scale.of(self.numbers[name]) for name in self.free}

    @property
    def moduli(self) -> list[int]:
        """Places of the moduli among the free parameters, with which the force grows."""
        return [j for j, name in enumerate(self.free) if self.numbers[name].number.unit == "Pa"]

    def ends(self, name: str) -> tuple[float, float]:
        """Internal values between which a free parameter has a meaning."""
        (low, high), (first, last) = ends(self.numbers[name]), self.knots.get(name, (-np.inf, np.inf))
        return max(low, first), min(high, last)

    def start(self) -> Array:
        """Internal values of the free parameters in the case."""
        return np.array([scale.internal(self.numbers[name].value) for name, scale in self.scales.items()])

    def internals(self, values: Mapping[str, float] | None = None) -> Array:
        """Internal values of the free parameters by name, SI; missing ones as in the case."""
        theta = self.start()
        for name, value in (values or {}).items():
            theta[self.free.index(name)] = self.scales[name].internal(value)
        return theta

    def externals(self, theta: Array) -> dict[str, float]:
        """Free parameters by name, SI."""
        return {name: float(scale.external(t)) for (name, scale), t in zip(self.scales.items(), theta, strict=True)}

    def linear(self, weights: Mapping[str, float]) -> tuple[float, Array]:
        """Constant part of a linear form, from the fixed parameters, and its coefficients of the free ones."""
        known = {name: self.numbers[name] for name in weights if name not in self.free}
        fixed = sum(weights[name] * Scale.of(each).internal(each.value) for name, each in known.items())
        return fixed, np.array([weights.get(name, 0.0) for name in self.free])
