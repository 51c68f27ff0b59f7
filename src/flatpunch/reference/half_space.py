"""Round contact on a homogeneous half-space: closed forms, and Sneddon's integrals for any profile.

Every solution is parametrised by the contact radius a. Sneddon (1965), in the notation of the method of
dimensionality reduction:

    g(x) = x int_0^x f'(r) dr / sqrt(x^2 - r^2),      d = g(a),      F = 2 E* int_0^a (d - g(x)) dx,
    dF/dd = 2 E* a

See Also
--------
flatpunch.reference.power_law : Graded half-spaces.
flatpunch.reference.elliptic : Elliptic contact.

Examples
--------
>>> from flatpunch.reference import half_space
>>> hertz = half_space.paraboloid(radius=1e-6, curvature_radius=5e-6, modulus=1e9)
>>> print(f"{float(hertz.depth) * 1e9:.0f} nm, {float(hertz.force) * 1e6:.1f} uN")
200 nm, 266.7 uN
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.special import beta as beta_function

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RoundContact:
    """Depth [m], force [N] and stiffness dF/dd [N/m] of a contact of given radius; arrays of one shape."""

    radius: Array
    depth: Array
    force: Array
    stiffness: Array


def _contact(a: Array, depth: Array, force: Array, modulus: float) -> RoundContact:
    return RoundContact(a, np.asarray(depth), np.asarray(force), 2 * modulus * a)


def flat_punch(radius: float | Array, depth: float | Array, modulus: float) -> RoundContact:
    """Cylindrical flat punch: F = 2 E* a d (Boussinesq).

    Parameters
    ----------
    radius, depth : float or array
        Punch radius a and depth d [m].
    modulus : float
        Plane-strain modulus E* [Pa].
    """
    a, d = np.broadcast_arrays(np.asarray(radius, float), np.asarray(depth, float))
    return _contact(a, d, 2 * modulus * a * d, modulus)


def flat_punch_pressure(r: Array, radius: float, depth: float, modulus: float) -> Array:
    """Pressure under the flat punch, p = E* d / (pi sqrt(a^2 - r^2)) [Pa], at r < a."""
    return np.asarray(modulus * depth / (np.pi * np.sqrt(radius**2 - np.square(r))))


def paraboloid(radius: float | Array, curvature_radius: float, modulus: float) -> RoundContact:
    """Paraboloid f = r^2/(2 R): d = a^2/R, F = 4 E* a^3/(3 R) (Hertz 1881).

    Parameters
    ----------
    radius : float or array
        Contact radius a [m].
    curvature_radius : float
        R [m].
    modulus : float
        E* [Pa].
    """
    a = np.asarray(radius, float)
    return _contact(a, a**2 / curvature_radius, 4 / 3 * modulus * a**3 / curvature_radius, modulus)


def paraboloid_pressure(r: Array, radius: float, curvature_radius: float, modulus: float) -> Array:
    """Hertz pressure p = 2 E* sqrt(a^2 - r^2)/(pi R) [Pa] at r <= a."""
    return np.asarray(2 * modulus * np.sqrt(radius**2 - np.square(r)) / (np.pi * curvature_radius))


def cone(radius: float | Array, inclination: float, modulus: float) -> RoundContact:
    """Cone f = r tan(inclination): d = (pi/2) a tan, F = (pi/2) E* a^2 tan (Love 1939, Sneddon 1948)."""
    a, slope = np.asarray(radius, float), np.tan(inclination)
    return _contact(a, np.pi / 2 * a * slope, np.pi / 2 * modulus * a**2 * slope, modulus)


def cone_pressure(r: Array, radius: float, inclination: float, modulus: float) -> Array:
    """Pressure under a cone, p = (E*/2) tan(inclination) arcosh(a/r) [Pa], at 0 < r <= a."""
    return np.asarray(modulus / 2 * np.tan(inclination) * np.arccosh(radius / np.asarray(r)))


def power_law(radius: float | Array, exponent: float, coefficient: float, modulus: float) -> RoundContact:
    """Profile f = c r^n: d = (n/2) B(n/2, 1/2) c a^n, F = 2 E* a d n/(n + 1) (Galin 1946)."""
    a = np.asarray(radius, float)
    depth = exponent / 2 * beta_function(exponent / 2, 0.5) * coefficient * a**exponent
    return _contact(a, depth, 2 * modulus * exponent / (exponent + 1) * depth * a, modulus)


def sphere(radius: float | Array, ball_radius: float, modulus: float) -> RoundContact:
    """Ball with its true shape R - sqrt(R^2 - r^2), a < R (Segedin 1957).

    d = (a/2) ln((R + a)/(R - a)),      F = (E*/2) [(R^2 + a^2) ln((R + a)/(R - a)) - 2 a R]

    The force loses about (R/a)^3 in relative rounding; below a = R/10 its series in a/R is summed instead.
    """
    a = np.asarray(radius, float)
    t = a / ball_radius
    log = 2 * np.arctanh(t)
    # F/(E* R^2) = sum_j [1/(2j + 1) + 1/(2j - 1)] t^(2j + 1): ten terms leave t^22, below rounding at t = 0.1
    j = np.arange(1, 11)
    terms = (1 / (2 * j + 1) + 1 / (2 * j - 1)) * t[..., None] ** (2 * j + 1)
    force = np.where(t < 0.1, terms.sum(axis=-1), ((1 + t**2) * log - 2 * t) / 2)
    return _contact(a, a / 2 * log, modulus * ball_radius**2 * force, modulus)


def sneddon(
    slope: Callable[[float], float], radius: float, modulus: float, kinks: Sequence[float] = ()
) -> RoundContact:
    """Any round profile by quadrature of Sneddon's integrals.

    With r = a sin t both integrals have smooth integrands, and the double one of the force is done:

        d = a int f'(a sin t) dt,      F = 2 E* a^2 int f'(a sin t) sin^2 t dt,      0 <= t <= pi/2

    Parameters
    ----------
    slope : callable
        f'(r) [-] at one radius [m].
    radius : float
        Contact radius a [m].
    modulus : float
        E* [Pa].
    kinks : sequence of float
        Radii at which the slope jumps [m].
    """
    cuts = [float(np.arcsin(kink / radius)) for kink in sorted(kinks) if 0 < kink < radius]
    edges = [0.0, *cuts, np.pi / 2]
    depth = force = 0.0
    for low, high in pairwise(edges):
        depth += _integral(lambda t: slope(radius * np.sin(t)), low, high)
        force += _integral(lambda t: slope(radius * np.sin(t)) * np.sin(t) ** 2, low, high)
    a = np.asarray(float(radius))
    return _contact(a, radius * np.asarray(depth), 2 * modulus * radius**2 * np.asarray(force), modulus)


def westergaard_stresses(
    x: float | Array,
    z: float | Array,
    *,
    wavelength: float,
    half_width: float,
    mean: float,
    poisson: float,
    friction: float = 0.0,
) -> Array:
    """Stresses inside under a wavy surface that touches along strips, p = 2 p_m cos(v) sqrt(sin^2 v_a - sin^2 v)/sin^2 v_a.

    v = pi x/wavelength, v_a = pi half_width/wavelength (Westergaard 1939). With f(x + iz) analytic inside and p its real part
    at the surface, s_zz and s_xx are -Re f - z Im f' and -Re f + z Im f', s_xz is z Re f'; under a traction p along x they
    are z Re f', -2 Im f - z Re f' and z Im f' - Re f. The mean pressure is in uniaxial strain.

    Parameters
    ----------
    x, z : float or array
        Points [m], broadcast together, not the rims of the strips; x = 0 is the middle of a strip, z >= 0 points inwards.
    wavelength, half_width : float
        Period and half the width of a strip [m], half_width <= wavelength/2: then contact is full, p = p_m (1 + cos 2v).
    mean : float
        Mean pressure p_m [Pa].
    poisson, friction : float
        Poisson ratio and coefficient of friction.

    Returns
    -------
    ndarray, shape (6, ...)
        s_xx, s_yy, s_zz, s_yz, s_xz, s_xy [Pa], positive in tension.
    """
    rate, edge = np.pi / wavelength, np.sin(np.pi * half_width / wavelength) ** 2
    x, z = np.broadcast_arrays(np.asarray(x, float), np.asarray(z, float))
    v = rate * (x - wavelength * np.round(x / wavelength) + 1j * z)
    sine, cosine = np.sin(v), np.cos(v)
    root = np.sqrt(edge - sine**2)
    # of both roots the one that leaves f finite at large depths
    root = np.where((root * np.conj(-1j * sine)).real < 0, -root, root)
    f = 2 * mean * cosine / (root - 1j * sine)
    slope = 2 * mean * rate * (1j * cosine**2 / root - sine) / (root - 1j * sine)
    uniform = mean * poisson / (1 - poisson)
    xx = -f.real + z * slope.imag - friction * (2 * f.imag + z * slope.real)
    zz = -f.real - z * slope.imag + friction * z * slope.real
    xz = z * slope.real - friction * (f.real - z * slope.imag)
    yy = poisson * (xx + zz + 2 * mean) - uniform
    none = np.zeros_like(xx)
    return np.stack([xx + mean - uniform, yy, zz, none, xz, none])


def _integral(integrand: Callable[[float], float], low: float, high: float) -> float:
    # 1e-13: the quadrature's own rounding on a smooth integrand; the absolute bound lets a vanishing one pass
    return float(quad(integrand, low, high, epsabs=1e-300, epsrel=1e-13, limit=400)[0])
