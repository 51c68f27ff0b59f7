"""Power-law half-spaces E(z) = E_l (z/l)^e: surface compliance in closed form, and fields at depth under a load wave.

The response at wavenumber q is C(q) = (2 c/E*) (q l)^k/q with k = e and E* = E_l/(1 - nu^2). The constant
follows from the flat punch, F = 2 h_N E* a^(1+k) d/((1 + k) l^k) (Booker, Balaam and Davis 1985; Giannakopoulos and
Suresh 1997; Popov, Hess and Willert, Handbook of Contact Mechanics, chapter 9):

    h_N = 2 (1 + k) cos(k pi/2) Gamma(1 + k/2) / (sqrt(pi) D b sin(b pi/2) Gamma((1 + k)/2)),
    D = 2^(1+k) Gamma((3 + k + b)/2) Gamma((3 + k - b)/2) / (pi Gamma(2 + k)),    b^2 = (1 + k)(1 - k nu/(1 - nu))
    c = pi / (2^k Gamma((1 + k)/2)^2 h_N)

Such a body has no length of its own: with x = kz, mu(z) = m x^e, m = mu_l (kl)^-e, and displacements in units of 1/(m k), the
system of `depth` reads, with no constant left but e and nu,

    u_l' = u_z + s_lz x^-e,                  u_z' = -nu/(1 - nu) u_l + c s_zz x^-e,    c = (1 - 2 nu)/(2 (1 - nu)),
    s_lz' = 2/(1 - nu) x^e u_l + nu/(1 - nu) s_zz,     s_zz' = -s_lz,         u_t' = s_tz x^-e,    s_tz' = x^e u_t.

The fields that decay are integrated once from large x, where they are those of a homogeneous half-space, to small x, where
tractions are constant and displacements differ from constants by s x^(1-e)/(1 - e). They are kept as splines in ln x.
"""

from __future__ import annotations

from math import gamma

import numpy as np
import scipy

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.compliances.depth import Waves, named_waves
from flatpunch.compliances.graded import TOLERANCE
from flatpunch.compliances.layered import SATURATION, sagittal_system
from flatpunch.media.material import PowerLaw
from flatpunch.media.plane import isotropic_plane


def stiffness_factor(exponent: float, poisson: float) -> float:
    """h_N of the flat punch [-]: 1 at exponent 0, pi/2 for the Gibson soil (exponent 1, Poisson ratio 1/2)."""
    k, nu = exponent, poisson
    # notation: cos(k pi/2)/(b sin(b pi/2)) with both zeros of the Gibson soil divided out; at nu = 1/2 they cancel
    quotient = 1.0 if nu == 0.5 else (1 - nu) * (1 - k) / (1 - nu - k * nu)
    b = np.sqrt((1 + k) * (1 - k * nu / (1 - nu)))
    quotient *= np.sinc((1 - k) / 2) / np.sinc(b / 2)
    d = 2 ** (1 + k) * gamma((3 + k + b) / 2) * gamma((3 + k - b) / 2) / (np.pi * gamma(2 + k))
    return float(2 * gamma(1 + k / 2) * quotient / (np.sqrt(np.pi) * d * gamma((1 + k) / 2)))


def power_law_constant(exponent: float, poisson: float) -> float:
    """c of the response L(kappa) = c kappa^exponent [-]."""
    k = exponent
    return float(np.pi / (2**k * gamma((1 + k) / 2) ** 2 * stiffness_factor(k, poisson)))


_DEEPEST, _SHALLOWEST = 4 * SATURATION, 1e-14
"""x between which the system is integrated: at the start the grading is taken as none, whose error decays like exp(-2x)."""

_NODES = 24000
"""Nodes of the splines in ln x: 1e-12 of the largest value between them."""


def power_law_waves(body: PowerLaw, k: Array, z: Array) -> Waves:
    """Fields at depths z, shape (nz,), under unit load waves of wavenumbers k > 0, shape (nk,).

    Depths are >= 0 [m], but > 0 where the exponent is negative, for the stresses along the surface are infinite there.
    """
    e, nu = body.exponent, body.poisson
    spline = _universal(e, nu)
    x = np.multiply.outer(k, z)
    inside = np.clip(x, _SHALLOWEST, _DEEPEST / 2)
    found = np.moveaxis(spline(np.log(inside)), -1, 0) * np.exp(-x)
    fields, across = found[:8].reshape(4, 2, *x.shape), found[8:]
    growth = _growth(x, e)
    modulus = x**e
    fields[0] += growth * fields[2]
    fields[1] += _vertical(nu) * growth * fields[3]
    across[0] += growth * across[1]
    shear = body.modulus / (2 * (1 + nu)) * (k * body.depth) ** -e
    with np.errstate(
        divide="ignore", invalid="ignore"
    ):  # the compliances, which may be infinite at the surface, are not needed
        plane = isotropic_plane(2 * (1 + nu) * modulus, np.full(z.size, nu))
    waves = named_waves(fields, across, plane, 1.0)
    # displacements are in units of 1/(m k)
    waves.normal[:2] /= shear[:, None]
    waves.shear[:2] /= shear[:, None]
    waves.transverse[0] /= shear[:, None]
    return waves


def _vertical(nu: float) -> float:
    return (1 - 2 * nu) / (2 * (1 - nu))


def _growth(x: Array, e: float) -> Array:
    """Antiderivative of x^-e from 0; for e = 1 (the Gibson soil) tractions vanish where it would be needed."""
    return np.asarray(x ** (1 - e) / (1 - e)) if e < 1 else np.zeros_like(x)


@byte_cached
def _universal(e: float, nu: float) -> scipy.interpolate.CubicSpline:
    """Spline in ln x of the four sagittal fields under two loads and the two transverse ones, times exp(x); shape (10,).

    Loads are s_zz = -1 and s_lz = 1, and s_tz = 1. Of displacements the part s x^(1-e)/(1 - e) is left out.
    """
    decaying = np.array([[nu - 1, 0.5 - nu], [0.5 - nu, nu - 1]]) / _DEEPEST**e
    start = np.concatenate([decaying, np.eye(2)]).ravel()
    start = np.concatenate([start, [-1 / _DEEPEST**e, 1.0]])

    def slope(t: float, y: Array) -> Array:
        x = np.exp(t)
        mu = x**e
        sagittal = (sagittal_system(mu, nu) + np.eye(4)) @ y[:8].reshape(4, 2)
        u, s = y[8:]
        return np.concatenate([x * sagittal.ravel(), [x * (u + s / mu), x * (s + mu * u)]])

    ends = np.log(_DEEPEST), np.log(_SHALLOWEST)
    t = np.linspace(*ends, _NODES)
    solved = scipy.integrate.solve_ivp(
        slope, ends, start, method="DOP853", t_eval=t, rtol=TOLERANCE, atol=TOLERANCE / 100
    )
    x = np.exp(solved.t)
    sagittal, across = solved.y[:8].reshape(4, 2, x.size), solved.y[8:]
    # amplitudes with which the tractions at the surface are those of the loads
    loads = np.array([[0.0, 1.0], [-1.0, 0.0]])
    sagittal = np.einsum("ijn,jk->ikn", sagittal, np.linalg.solve(sagittal[2:, :, -1], loads))
    across /= across[1, -1]
    growth = _growth(x, e)
    sagittal[0] -= growth * sagittal[2]
    sagittal[1] -= _vertical(nu) * growth * sagittal[3]
    across[0] -= growth * across[1]
    values = np.concatenate([sagittal.reshape(-1, x.size), across])
    return scipy.interpolate.CubicSpline(solved.t[::-1], values[:, ::-1].T)
