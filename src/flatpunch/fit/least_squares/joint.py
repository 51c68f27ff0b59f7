"""Residuals of several curves that share parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.fit.parameters.unknowns import Unknowns


@dataclass(frozen=True, eq=False)
class JointObjective:
    """Residuals of all curves over their noise, as a function of the joint x = (shared, own and nuisance of each curve).

    Attributes
    ----------
    parts : tuple
        Objective of each curve.
    names : tuple of str
        Of all entries of x; those of one curve end in " @ " and its name.
    places : tuple of ndarray of int
        Where in x the entries of each curve's own x are.
    noise : ndarray, shape (curves,)
        Standard deviation of the residuals of each, over its force range.
    free : tuple of str
        Parameters of the sample, shared and own, which come first among the names.
    starts : ndarray
        Their internal values where the search began.
    """

    parts: tuple[Unknowns, ...]
    names: tuple[str, ...]
    places: tuple[Indices, ...]
    noise: Array
    free: tuple[str, ...]
    starts: Array

    @property
    def model(self) -> JointObjective:
        """Itself, in the place of a forward model: it has `free` and `start`."""
        return self

    def start(self) -> Array:
        """Internal values of the free parameters where the search began."""
        return self.starts

    @property
    def depth(self) -> Array:
        """Depths of all readings, for their number."""
        return np.concatenate([part.depth for part in self.parts])

    def scales(self) -> dict[str, tuple[float, float]]:
        """Offsets and units of contact and background of each curve."""
        found: dict[str, tuple[float, float]] = {}
        for part, places in zip(self.parts, self.places, strict=True):
            found |= {
                self.names[j]: part.scales()[n] for j, n in zip(places, part.names, strict=True) if n in part.scales()
            }
        return found

    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Residuals, shape (n,), and derivatives, shape (parameters, n)."""
        found = [part.evaluate(x[places]) for part, places in zip(self.parts, self.places, strict=True)]
        residual = np.concatenate([r / s for (r, _), s in zip(found, self.noise, strict=True)])
        jacobian = np.zeros((x.size, residual.size))
        begin = 0
        for (r, j), places, s in zip(found, self.places, self.noise, strict=True):
            jacobian[places, begin : begin + r.size] = j / s
            begin += r.size
        return residual, jacobian
