"""Layered, graded and anisotropic media in Tamaas 2.9: an operator from pressures to displacements for its contact solvers.

`ContactSolver(model, surface, 1e-12, medium)` stands in the place of `tamaas.PolonskyKeerRey(model, surface, 1e-12)`;
moduli of the model are not used.
"""

import numpy as np
import tamaas
from numpy.typing import NDArray

from flatpunch import kernels
from flatpunch._support.checks import Array
from flatpunch.media import Body

_DIMENSIONS = {tamaas.model_type.basic_1d: 1, tamaas.model_type.basic_2d: 2}


class MediumOperator(tamaas.IntegralOperator):
    """Normal displacement of the surface of a medium under pressures on the grid of a model.

    Parameters
    ----------
    model : tamaas.Model
        Of type `basic_1d` (plane strain) or `basic_2d`.
    medium : Body
        A medium of flatpunch.
    periodic : bool
        Whether the surface repeats; else cells must be squares.
    """

    def __init__(self, model: tamaas.Model, medium: Body, periodic: bool = True) -> None:
        super().__init__(model)
        if model.type not in _DIMENSIONS:
            raise ValueError(f"model is of type {model.type}; pressures without friction need basic_1d or basic_2d.")
        if tamaas.mpi.size() > 1:
            raise ValueError("the operator knows the whole grid; run without MPI.")
        self._points = tuple(model.shape)
        self._transform: NDArray[np.inexact]
        steps = np.divide(model.boundary_system_size, self._points)
        if periodic:
            self._padded = self._points
            waves = [2 * np.pi * np.fft.fftfreq(n, step) for n, step in zip(self._padded, steps, strict=True)]
            waves[-1] = waves[-1][: self._padded[-1] // 2 + 1]
            self._transform = kernels.normal_compliance(medium, np.sqrt(sum(axis**2 for axis in np.ix_(*waves))))
        else:
            if len(steps) != 2 or not np.allclose(steps, steps[0], rtol=1e-9, atol=0):
                raise ValueError(
                    f"cells of {steps} m: without repetition the operator needs two dimensions and squares."
                )
            self._padded = tuple(2 * n for n in self._points)
            offsets = [n - np.abs(n - np.arange(2 * n)) for n in self._points]
            green = kernels.influence_coefficients(medium, steps[0], [n + 1 for n in self._points])
            self._transform = np.fft.rfftn(green[np.ix_(*offsets)])

    def apply(self, pressure: Array, displacement: Array) -> None:
        """Write the displacement under a pressure."""
        spectrum = np.fft.rfftn(pressure.reshape(self._points), self._padded, axes=range(len(self._points)))
        whole = np.fft.irfftn(spectrum * self._transform, self._padded, axes=range(len(self._points)))
        displacement[...] = whole[tuple(map(slice, self._points))].reshape(displacement.shape)

    def getKind(self) -> object:
        """From pressures to displacements."""
        return tamaas.IntegralOperator.neumann

    def getType(self) -> object:
        """Type of the model."""
        return self.model.type

    def updateFromModel(self) -> None:
        """Keep what the medium says when moduli of the model change."""


class ContactSolver(tamaas.PolonskyKeerRey):
    """Contact solver of Tamaas on a medium: `solve(mean_pressure)`, with the results in the model.

    Parameters
    ----------
    model : tamaas.Model
        Of type `basic_1d` or `basic_2d`.
    surface : ndarray
        Heights of the rigid surface.
    tolerance : float
        Of the solver.
    medium : Body
        A medium of flatpunch.
    periodic : bool
        Whether the surface repeats.
    """

    def __init__(
        self, model: tamaas.Model, surface: Array, tolerance: float, medium: Body, periodic: bool = True
    ) -> None:
        super().__init__(model, surface, tolerance)
        # Tamaas keeps the half of the operator that is its own, and this solver the one that is Python's
        self.operator = MediumOperator(model, medium, periodic)
        model.operators["flatpunch"] = self.operator
        self.setIntegralOperator("flatpunch")
