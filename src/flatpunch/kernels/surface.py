"""Surface displacements under waves of traction and under pressed cells, and tractions under waves of displacement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flatpunch.kernels.arguments import Tuples, at_zero_wave, body_of, wave_vectors
from flatpunch.kernels.radial import at_zero, table

if TYPE_CHECKING:
    from flatpunch._support.checks import Array
    from flatpunch.compliances.tangential import Radial
    from flatpunch.media import Body
    from flatpunch.numerics.chebyshev import Numbers

_DIRECT = 4000
"""Largest number of wave vectors that are all computed; more are interpolated."""

_WIDEST = 1e4
"""Side of a cell over the length of the medium, beyond which the error is above 1e-8; at three times as much it is 6e-8."""

_CHUNK = 2**15
"""Wavenumbers at once: their arrays stay in the cache."""


def surface_compliance(
    medium: Body | Tuples, qx: Numbers, qy: Numbers, *, rtol: float = 1e-10, undetermined: float = 0.0
) -> NDArray[np.complex128]:
    """Displacement of the surface under a wave of traction, for other codes' Fourier solvers.

    Parameters
    ----------
    medium : Body or tuple
        A medium of the package, or ((layer, ...), base) from the surface down: layers (young, poisson, thickness) or
        (young_in_plane, young_axial, poisson_in_plane, poisson_axial, shear, thickness), with or without `bonded` at the end; a
        base (young, poisson), or five constants, or None if it is rigid.
    qx, qy : array
        Wave vector [rad/m], broadcast together.
    rtol : float
        Largest error of the interpolation over the wavenumber that is made for more than some thousand wave vectors, relative to
        each diagonal entry (of the coupling: to the root of two); it is measured between the nodes. 0 computes every one.
    undetermined : float
        Diagonal entries at q = 0 that a uniform traction does not determine [m/Pa].

    Returns
    -------
    ndarray of complex, shape (..., 3, 3)
        u = C t, rows and columns x, y, z [m/Pa]. The conventions are those of the room: z inward, traction on the body.

    Raises
    ------
    ValueError, TypeError
        On bad input, and if rtol cannot be reached.

    See Also
    --------
    flatpunch.kernels.surface_stiffness : The inverse.
    flatpunch.kernels.normal_compliance : C_zz alone.
    flatpunch.kernels.interior : Fields at depth.

    Examples
    --------
    >>> from flatpunch import kernels
    >>> q = 2 * np.pi * np.fft.fftfreq(64, d=50e-9)
    >>> gel = ([(5e3, 0.5, 2e-6)], None)  # a bonded layer on a rigid base
    >>> c = kernels.surface_compliance(gel, q[:, None], q)
    >>> c.shape, bool(np.allclose(c, np.conj(np.swapaxes(c, -1, -2))))
    ((64, 64, 3, 3), True)
    """
    return _matrices(medium, qx, qy, rtol, undetermined, inverse=False)


def surface_stiffness(
    medium: Body | Tuples, qx: Numbers, qy: Numbers, *, rtol: float = 1e-10, undetermined: float = 0.0
) -> NDArray[np.complex128]:
    """Traction on the surface that produces a wave of displacement: the inverse of `surface_compliance`.

    Parameters
    ----------
    medium, qx, qy, rtol
        As for `surface_compliance`.
    undetermined : float
        Diagonal entries at q = 0 that would be infinite [Pa/m]: of incompressible layers on rigid bases. They are zero where
        the compliance is infinite.

    Returns
    -------
    ndarray of complex, shape (..., 3, 3)
        t = S u [Pa/m].

    Raises
    ------
    ValueError, TypeError
        On bad input, and if rtol cannot be reached.

    See Also
    --------
    flatpunch.kernels.surface_compliance : The inverse, with all parameters and an example.

    Examples
    --------
    >>> from flatpunch import kernels
    >>> body = fp.HalfSpace(young=1e9, poisson=0.3)
    >>> s, c = (make(body, 1e6, 2e6) for make in (kernels.surface_stiffness, kernels.surface_compliance))
    >>> bool(np.allclose(s @ c, np.eye(3)))
    True
    """
    return _matrices(medium, qx, qy, rtol, undetermined, inverse=True)


def normal_compliance(medium: Body | Tuples, q: Numbers, *, undetermined: float = 0.0) -> Array:
    """Normal displacement under a wave of pressure without friction, C_zz.

    Parameters
    ----------
    medium : Body or tuple
        As for `surface_compliance`.
    q : array
        Magnitude of the wave vector [rad/m].
    undetermined : float
        Value at q = 0 where a uniform pressure does not determine it [m/Pa].

    Returns
    -------
    ndarray, shape of q
        C_zz [m/Pa].

    Raises
    ------
    ValueError, TypeError
        On bad input.

    See Also
    --------
    flatpunch.kernels.surface_compliance : All components.

    Examples
    --------
    >>> from flatpunch import kernels
    >>> q = np.array([0.0, 1e6])
    >>> kernels.normal_compliance(([(5e3, 0.3, 2e-6)], None), q).shape
    (2,)
    """
    from flatpunch.compliances import compliance

    body, undetermined = body_of(medium), at_zero_wave(undetermined, "m/Pa")
    _, magnitude = wave_vectors(q=q)
    result, zero = np.empty(magnitude.shape), magnitude == 0
    if not zero.all():
        result[~zero] = compliance(body, membrane=True)(magnitude[~zero])
    normal, _ = at_zero(body)
    result[zero] = normal if np.isfinite(normal) else undetermined
    return result


def influence_coefficients(medium: Body | Tuples, spacing: float, shape: Sequence[int]) -> Array:
    """Normal displacement at the centre of a cell per uniform pressure without friction on another one.

    Parameters
    ----------
    medium : Body or tuple
        As for `surface_compliance`.
    spacing : float
        Side of the square cells [m], at most 10 000 lengths of the medium (thicknesses of a layer).
    shape : sequence of two int
        Number of offsets along rows and columns, counted from zero.

    Returns
    -------
    ndarray, shape (rows, columns)
        Coefficients at offsets of (i, j) cells [m/Pa]: even in both, and the same for (j, i). The absolute error is below 1e-8 of
        that at zero offset of a half-space with the modulus of the surface.

    Raises
    ------
    ValueError, TypeError
        On bad input.

    See Also
    --------
    flatpunch.kernels.normal_compliance : Its transform, for surfaces that repeat.

    Examples
    --------
    >>> from flatpunch import kernels
    >>> g = kernels.influence_coefficients(fp.HalfSpace(1e9, 0.3), 1e-6, (128, 128))
    >>> print(g.shape, f"{g[0, 0] * np.pi * 1e9 / 0.91 / 1e-6:.4f}")  # 4 ln(1 + sqrt 2) on a half-space
    (128, 128) 3.5255
    """
    from flatpunch._support.checks import CELLS, BadValue, positive, values, whole
    from flatpunch.bem.operator.influence import influence_coefficients as coefficients
    from flatpunch.compliances import compliance

    sizes = values("shape", shape).tolist()
    if len(sizes) != 2:
        raise BadValue("shape", "", f"has {len(sizes)} entries; it must be the numbers of rows and columns.")
    rows, columns = (whole("shape", n, 1, most=4 * CELLS) for n in sizes)
    kernel, spacing = compliance(body_of(medium), membrane=True), positive("spacing", spacing, unit="m")
    if spacing > _WIDEST * kernel.length:
        most = f"must be at most {_WIDEST * kernel.length:.3g} m, {_WIDEST:g} lengths of the medium. Check the units."
        raise BadValue("spacing", repr(spacing), most)
    return coefficients(kernel, spacing, (rows, columns))


def _matrices(
    medium: Body | Tuples, qx: Numbers, qy: Numbers, rtol: float, undetermined: float, *, inverse: bool
) -> NDArray[np.complex128]:
    from flatpunch._support.checks import non_negative

    body, undetermined = body_of(medium), at_zero_wave(undetermined, "Pa/m" if inverse else "m/Pa")
    rtol = non_negative("rtol", rtol, "0 computes every wave vector.", unit="1")
    components, magnitude = wave_vectors(qx=qx, qy=qy)
    shape = magnitude.shape
    x, y, q = (each.ravel() for each in (*components, magnitude))
    result = np.zeros((x.size, 3, 3), dtype=complex)
    zero = np.flatnonzero(q == 0)
    if zero.size < q.size:
        functions = _functions(body, q, rtol)
        for start in range(0, q.size, _CHUNK):
            part = slice(start, start + _CHUNK)
            _fill(result[part], x[part], y[part], q[part], functions, inverse)
    if zero.size:
        normal, along = at_zero(body)
        diagonal = np.array([along, along, normal])
        if inverse:
            with np.errstate(divide="ignore"):
                diagonal = 1 / diagonal
        result[zero] = np.diag(np.where(np.isfinite(diagonal), diagonal, undetermined))
    return result.reshape(*shape, 3, 3)


def _functions(body: Body, q: Array, rtol: float) -> Callable[[Array], Radial]:
    """Callable: magnitudes of a part of the wave vectors -> Radial."""
    from flatpunch.compliances.tangential import Radial, radial_compliance

    if rtol > 0 and q.size > _DIRECT:
        present = q[q > 0]
        low, high = float(present.min()), float(present.max())
        if high > low:
            spline = table(body, low, high, rtol)

            def tabulated(part: Array) -> Radial:
                return Radial(*(spline(np.log(part)).T / part))

            return tabulated

    def computed(part: Array) -> Radial:
        own, which = np.unique(part, return_inverse=True)
        return Radial(*(each[which.ravel()] for each in radial_compliance(body, own)))

    return computed


def _fill(result: Numbers, x: Array, y: Array, q: Array, functions: Callable[[Array], Radial], inverse: bool) -> None:
    q = np.where(q > 0, q, q.max() or 1.0)  # q = 0 is written afterwards
    n, a, c, d = functions(q)
    if inverse:
        n, a, c, d = 1 / (n - d / a * d), 1 / (a - d / n * d), 1 / c, -d / a / (n - d / a * d)
    real, imaginary = result.real, result.imag
    lx, ly = x / q, y / q
    real[:, 0, 0], real[:, 1, 1] = a * lx * lx + c * ly * ly, a * ly * ly + c * lx * lx
    real[:, 0, 1] = real[:, 1, 0] = (a - c) * lx * ly
    real[:, 2, 2] = n
    lx *= d
    ly *= d
    imaginary[:, 0, 2], imaginary[:, 1, 2], imaginary[:, 2, 0], imaginary[:, 2, 1] = lx, ly, -lx, -ly
