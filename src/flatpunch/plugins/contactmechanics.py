"""Layered, graded and anisotropic media as substrates of ContactMechanics 1.8.

The classes take a medium of flatpunch in the place of a modulus and are used like the half-spaces that they derive from:
`make_system(substrate=PeriodicMedium((256, 256), medium, (1e-5, 1e-5)), surface=topography)`.
"""

from collections.abc import Sequence
from typing import Self

import numpy as np
from ContactMechanics import (
    FreeFFTElasticHalfSpace,
    PeriodicFFTElasticHalfSpace,
    SemiPeriodicFFTElasticHalfSpace,
)
from numpy.typing import NDArray

from flatpunch import kernels
from flatpunch._support.checks import Array
from flatpunch.media import Body, underlying


class _OfMedium:
    """What the three substrates share: a medium instead of a modulus, and influence coefficients of its cells."""

    _steps: tuple[float, ...]
    dim: int
    Error: type[Exception]

    def __init__(
        self,
        nb_grid_pts: Sequence[int],
        medium: Body,
        physical_sizes: float | Sequence[float] = 2 * np.pi,
        **options: object,
    ) -> None:
        if given := {"thickness", "poisson"} & options.keys():
            raise TypeError(f"{min(given)} is a part of the medium; leave it out.")
        self.medium = medium
        # `super` is the class of ContactMechanics that this one is mixed into, which has these arguments
        super().__init__(nb_grid_pts, underlying(medium).surface_modulus, physical_sizes, **options)  # type: ignore[call-arg]

    def spawn_child(self, nb_grid_pts: Sequence[int]) -> Self:
        """Substrate of the same medium on a part of the grid."""
        sizes = tuple(n * step for n, step in zip(nb_grid_pts, self._steps, strict=True))
        return type(self)(nb_grid_pts, self.medium, sizes)

    def _coefficients(self, shape: Sequence[int]) -> Array:
        """Displacement per pressure at offsets of cells, which must be squares."""
        if self.dim != 2 or not np.allclose(self._steps, self._steps[0], rtol=1e-9, atol=0):
            raise self.Error(
                f"Cells of {self._steps} m: substrates that do not repeat need two dimensions and square cells."
            )
        return kernels.influence_coefficients(self.medium, self._steps[0], shape)


class PeriodicMedium(_OfMedium, PeriodicFFTElasticHalfSpace):
    """A medium whose surface repeats, in one dimension (plane strain) or two.

    Parameters
    ----------
    nb_grid_pts : tuple of int
        Number of points.
    medium : Body
        A medium of flatpunch.
    physical_sizes : float or tuple of float
        Sizes of the cell.
    **options
        Of `PeriodicFFTElasticHalfSpace`. `stiffness_q0` is the stiffness of a uniform pressure: if it is left out, that of layers
        on a rigid base, and on others as there.
    """

    name = "periodic_medium"

    def _compute_greens_function(self) -> NDArray[np.inexact]:
        first = tuple(self.fourier_locations)
        axes = zip(first, self.nb_fourier_grid_pts, self.nb_grid_pts, self.physical_sizes, strict=True)
        waves = [np.abs((i + np.arange(m) + n // 2) % n - n // 2) * 2 * np.pi / size for i, m, n, size in axes]
        q = np.sqrt(sum(axis**2 for axis in np.ix_(*waves)))
        green = kernels.normal_compliance(self.medium, q, undetermined=np.nan)
        if not any(first) and green.size:
            zero = (0,) * self.dim
            if self.stiffness_q0 is not None:
                green[zero] = 1 / self.stiffness_q0 if self.stiffness_q0 else 0.0
            elif np.isnan(green[zero]):
                green[zero] = 1 / np.mean([1 / green[tuple(one)] for one in np.eye(self.dim, dtype=int)])
        return green


class FreeMedium(_OfMedium, FreeFFTElasticHalfSpace):
    """A medium whose surface does not repeat; arguments as for `PeriodicMedium`, options of `FreeFFTElasticHalfSpace`."""

    name = "free_medium"

    def __init__(
        self,
        nb_grid_pts: Sequence[int],
        medium: Body,
        physical_sizes: float | Sequence[float] = 2 * np.pi,
        **options: object,
    ) -> None:
        self._comp_nb_grid_pts = tuple(2 * n for n in nb_grid_pts)
        super().__init__(nb_grid_pts, medium, physical_sizes, **options)

    def _compute_greens_function(self) -> NDArray[np.inexact]:
        axes = zip(self.subdomain_locations, self.nb_subdomain_grid_pts, self.nb_grid_pts, strict=True)
        offsets = [n - np.abs(n - (i + np.arange(m))) for i, m, n in axes]
        self.real_buffer.p[...] = self._coefficients([n + 1 for n in self.nb_grid_pts])[np.ix_(*offsets)]
        self.fftengine.fft(self.real_buffer, self.fourier_buffer)
        return np.array(self.fourier_buffer.p)


class SemiPeriodicMedium(_OfMedium, SemiPeriodicFFTElasticHalfSpace):
    """A medium that repeats in some directions; as `PeriodicMedium`, options of `SemiPeriodicFFTElasticHalfSpace`."""

    name = "semi_periodic_medium"

    def _compute_greens_function(self) -> NDArray[np.inexact]:
        axes = list(zip(self.nb_grid_pts, self.nb_domain_grid_pts, self.periodicity, strict=True))
        reach = [n * (self.n_images + 1 if periodic else 1) for n, _, periodic in axes]
        green = self._coefficients([n + 1 for n in reach])
        for n, whole, periodic in axes:
            images = n * np.arange(-self.n_images, self.n_images + 1) if periodic else np.zeros(1, dtype=int)
            own = (np.arange(whole) + whole // 2) % whole - whole // 2
            # sums over the images along the first axis, which then becomes the last one
            green = sum(green[np.abs(own + image)] for image in images).T
        self.G_real = green
        self.real_buffer.p[...] = green
        self.fftengine.fft(self.real_buffer, self.fourier_buffer)
        return np.array(self.fourier_buffer.p)


class MediumGreensFunction:
    """Surface response as `ContactMechanics.GreensFunctions` gives that of half-spaces.

    Parameters
    ----------
    medium : Body
        A medium of flatpunch.
    """

    def __init__(self, medium: Body) -> None:
        self.medium = medium

    def greens_function(self, qx: Array, qy: Array) -> NDArray[np.inexact]:
        """Displacement under traction, shape (n, 3, 3) [m/Pa]."""
        return kernels.surface_compliance(self.medium, qx, qy)

    def stiffness(self, qx: Array, qy: Array) -> NDArray[np.inexact]:
        """Traction under displacement, shape (n, 3, 3) [Pa/m]."""
        return kernels.surface_stiffness(self.medium, qx, qy)

    __call__ = stiffness
