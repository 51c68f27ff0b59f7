"""Free parameters of a forward model: by name in SI outside, as a vector theta of their internal form inside."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fits.parameters.sample import Sample
from flatpunch.fits.parameters.scaling import external, internal, slope
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body


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

    @abstractmethod
    def value(self, name: str) -> float:
        """Value of a parameter in the case, free or not, SI."""

    @abstractmethod
    def case(self, values: Mapping[str, float]) -> tuple[Body, Indenter]:
        """Medium and indenter with these values."""

    def sample_at(self, values: Mapping[str, float]) -> Sample:
        """The whole case with these values."""
        return Sample(*self.case(values))

    def start(self) -> Array:
        """Internal values of the free parameters in the case."""
        return np.array([internal(name, self.value(name)) for name in self.free])

    def internals(self, values: Mapping[str, float] | None = None) -> Array:
        """Internal values of the free parameters by name, SI; missing ones as in the case."""
        theta = self.start()
        for name, value in (values or {}).items():
            theta[self.free.index(name)] = internal(name, value)
        return theta

    def externals(self, theta: Array) -> dict[str, float]:
        """Free parameters by name, SI."""
        return {name: external(name, float(t)) for name, t in zip(self.free, theta, strict=True)}

    def slopes(self, theta: Array) -> Array:
        """Derivatives of the external over the internal values."""
        return np.array([slope(name, value) for name, value in self.externals(theta).items()])

    def linear(self, weights: Mapping[str, float]) -> tuple[float, Array]:
        """Constant part of a linear form, from the fixed parameters, and its coefficients of the free ones."""
        fixed = sum(f * internal(name, self.value(name)) for name, f in weights.items() if name not in self.free)
        return fixed, np.array([weights.get(name, 0.0) for name in self.free])


class SampleParameters(FreeParameters):
    """Free parameters of a model whose case is a `Sample`.

    Attributes
    ----------
    sample : Sample
        The case; free parameters have their starting values in it.
    """

    sample: Sample

    @property
    def medium(self) -> Body:
        """Medium with the starting values."""
        return self.sample.medium

    @property
    def indenter(self) -> Indenter:
        """Tip with the starting values."""
        return self.sample.indenter

    def value(self, name: str) -> float:
        """Value of a parameter in the case, free or not, SI."""
        return self.sample.value(name)

    def case(self, values: Mapping[str, float]) -> tuple[Body, Indenter]:
        """Medium and indenter with these values."""
        sample = self.sample_at(values)
        return sample.medium, sample.indenter

    def sample_at(self, values: Mapping[str, float]) -> Sample:
        """The whole case with these values."""
        return self.sample.replaced(values)
