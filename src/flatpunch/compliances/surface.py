"""Flexibility of the surface under tractions of all three directions.

Along a wave the 2 x 2 matrix H of `layered` and `graded` at the surface; across it the number w = k u_t/s_tz, which obeys

    w' = k (1/C44 - C66 w^2)     over the depth,

so that a homogeneous layer carries it up as w -> (w - t/Z)/(1 - t Z w), t = tanh(k h sqrt(C66/C44)), Z^2 = C66 C44, and graded
ones by Runge-Kutta steps.
"""

from __future__ import annotations

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch.compliances.graded import TOLERANCE
from flatpunch.compliances.layered import SATURATION, half_space_flexibility
from flatpunch.compliances.response import stack_flexibility
from flatpunch.media import AnyLayer, Material, Stack
from flatpunch.media.plane import Plane


def surface_flexibility(body: Stack, k: Array) -> tuple[Array, Array]:
    """Flexibilities of the surface.

    Parameters
    ----------
    body : HalfSpace, TransverselyIsotropicHalfSpace or Medium
        The body.
    k : ndarray, shape (n,)
        Wavenumbers [1/m], > 0.

    Returns
    -------
    along : ndarray, shape (2, 2, n)
        k (u_l, u_z) per (s_lz, s_zz) [1/Pa].
    across : ndarray, shape (n,)
        k u_t per s_tz [1/Pa].
    """
    if not body.layers:
        return half_space_flexibility(body.base, 1.0, k.shape), _across(body, k)
    scale = body.surface_modulus
    return stack_flexibility(body, k, scale) / scale, _across(body, k)


def _surface_plane(material: Material) -> Plane[Array]:
    """Coefficients at the top of a layer or half-space [Pa], shape (1,)."""
    return material.plane_at(np.zeros(1))


def _across(medium: Stack, k: Array) -> Array:
    """k u_t/s_tz at the surface."""
    base = medium.base
    w = np.zeros_like(k) if base.rigid else np.full(k.size, -1 / _impedance_at(_surface_plane(base))[0])
    for layer in reversed(medium.layers):
        slides = not layer.face
        if not slides:
            w = w - layer.face.softness[0] * k
        w = _through_graded(layer, w, k, slides) if layer.varies else _through(layer, w, k, slides)
    return w


def _through(layer: AnyLayer, w: Array, k: Array, slides: bool) -> Array:
    plane = _surface_plane(layer)
    impedance = _impedance_at(plane)
    t = np.tanh(k * layer.thickness * np.sqrt(plane.across * plane.shear))
    return np.asarray(-1 / (impedance * t) if slides else (w - t / impedance) / (1 - t * impedance * w))


def _through_graded(layer: AnyLayer, w: Array, k: Array, slides: bool) -> Array:
    """From the lower face, or from the depth that a wave reaches, where the layer is its own half-space."""
    samples = layer.plane_at(layer.sampled_depths)
    # waves decay like exp(-k z sqrt(C66/C44))
    slowest = float(np.sqrt(samples.across * samples.shear).min())
    depth = np.minimum(layer.thickness, SATURATION / (k * slowest))
    impedance = _impedance_at(layer.plane_at(depth))
    hidden = depth < layer.thickness
    # where the face slides 1/w is carried, which is zero there; elsewhere w times the impedance below it
    state = np.where(hidden, -1.0, 0.0 if slides else w * impedance)
    inverse = np.full(k.size, slides) & ~hidden

    def slope(share: float, y: Array) -> Array:
        plane = layer.plane_at(share * depth)
        shear, across = plane.shear * impedance, plane.across / impedance
        return np.asarray(k * depth * np.where(inverse, across - shear * y * y, shear - across * y * y))

    solved = scipy.integrate.solve_ivp(slope, (1.0, 0.0), state, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE / 100)
    y = solved.y[:, -1]
    return np.asarray(np.where(inverse, 1 / y, y) / impedance)


def _impedance_at(plane: Plane[Array]) -> Array:
    """Root of C66 C44 [Pa]."""
    return np.sqrt(plane.across / plane.shear)
