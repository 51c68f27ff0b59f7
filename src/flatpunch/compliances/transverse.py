"""Waves in transversely isotropic layers and half-spaces, one propagator for real, equal and complex rates of decay.

Along a wave the state y = (k u_l, k u_z, s_lz, s_zz) obeys dy/d(kz) = A y with the coefficients of `media.plane.Plane`. A^2
has two eigenvalues, the squares of the rates p, p^2 - s p + d = 0. Fields that decay with depth are y = [H; 1] exp(-N x) t, t the
tractions (s_lz, s_zz), and those that grow are their mirror images, with

    H = [[-s, d - q], [d - q, -s d]]/M,    N = [[s, -d], [1, 0]],    exp(-N x) = exp(-s x/2) [cosh ex - (sinh ex/e) (N - s/2)],

e^2 = s^2/4 - d of either sign, M the plane-strain stiffness and q the coupling. In a layer the lower face sends back R exp(-N x)
of what arrives, so that only decaying exponentials occur. Where k h is small both kinds of fields are nearly alike and exp(-A x)
is taken instead, a power series in A^2, whose powers all are u A^2 + v. Across the wave (k u_t, s_tz) decays like
exp(-k z sqrt(C66/C44)). Stresses and stiffnesses are in units of a scale.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np

from flatpunch._support.checks import Array, Flags
from flatpunch.media import Material
from flatpunch.media.plane import N, Plane, exponents, over

REACH = 25.0
"""Rate of decay times k h from which a layer hides what lies below it."""

_SERIES, _TERMS = 2.0, 14
"""Largest rate times k h for which the power series is taken, and its terms: the next one is 2^28/28! = 1e-21."""


@dataclass(frozen=True)
class Solid:
    """A transversely isotropic material with stresses in units of a scale.

    Attributes
    ----------
    plane : Plane
        Its coefficients.
    """

    plane: Plane[float]

    @classmethod
    def of(cls, body: Material, scale: float) -> Solid:
        """Material of a layer or half-space."""
        return cls(over(scale, body.plane))

    @cached_property
    def rates(self) -> tuple[float, float]:
        """Sum s and product d of the rates of decay."""
        return exponents(self.plane)[:2]

    @cached_property
    def square(self) -> float:
        """e^2: the square of half the difference of the rates, negative for a complex pair."""
        return exponents(self.plane)[3]

    @cached_property
    def slowest(self) -> float:
        """Rate at which sagittal fields decay with k z at least."""
        s, d = self.rates
        return d / (s / 2 + sqrt(self.square)) if self.square > 0 else s / 2

    @cached_property
    def fastest(self) -> float:
        """Magnitude of the larger rate."""
        s, d = self.rates
        return s / 2 + sqrt(self.square) if self.square > 0 else sqrt(d)

    @cached_property
    def system(self) -> Array:
        """A."""
        return system_of(self.plane)

    @cached_property
    def flexibility(self) -> Array:
        """H of a half-space, shape (2, 2)."""
        return flexibility_of(self.plane)

    @cached_property
    def generator(self) -> Array:
        """N."""
        s, d = self.rates
        return np.array([[s, -d], [1.0, 0.0]])

    @cached_property
    def sideways(self) -> tuple[float, float]:
        """Rate of decay across the wave, and the impedance of such waves."""
        return sqrt(self.plane.across * self.plane.shear), sqrt(self.plane.across / self.plane.shear)

    def fading(self, x: Array) -> Array:
        """exp(-N x), shape (2, 2, *x.shape)."""
        s, _ = self.rates
        slow = np.exp(-self.slowest * x)
        if self.square > 0:
            e = sqrt(self.square)
            ratio = -np.expm1(-2 * e * x)
            mean, slope = slow * (1 - ratio / 2), slow * ratio / (2 * e)
        elif self.square < 0:
            e = sqrt(-self.square)
            mean, slope = slow * np.cos(e * x), slow * np.sin(e * x) / e
        else:
            mean, slope = slow, slow * x
        turned = self.generator - s / 2 * np.eye(2)
        return np.asarray(np.multiply.outer(np.eye(2), mean) - np.multiply.outer(turned, slope))

    def decaying(self, x: Array) -> Array:
        """Fields [H; 1] exp(-N x), shape (4, 2, *x.shape)."""
        basis = np.concatenate([self.flexibility, np.eye(2)])
        return np.tensordot(basis, self.fading(x), axes=1)

    def growing(self, x: Array) -> Array:
        """Their mirror images at the distance x above a face on which they have unit tractions, shape (4, 2, *x.shape)."""
        return np.asarray(_MIRROR.reshape(4, 2, *[1] * x.ndim) * self.decaying(x))

    def raised(self, states: Array, x: Array) -> Array:
        """exp(-A x) times states (4, c, n) by its power series, for x of shape (n,) or (n, nz)."""
        s, d = self.rates
        trace, product = s * s - 2 * d, d * d
        # notation: A^(2j) = u A^2 + v
        u, v, even, odd = 0.0, 1.0, [], []
        factorial = 1.0
        for j in range(_TERMS):
            even.append((v / factorial, u / factorial))
            factorial *= 2 * j + 1
            odd.append((v / factorial, u / factorial))
            factorial *= 2 * j + 2
            u, v = trace * u + v, -product * u
        y = x * x
        c0, c2 = (np.polynomial.polynomial.polyval(y, each) for each in zip(*even, strict=True))
        c1, c3 = (x * np.polynomial.polynomial.polyval(y, each) for each in zip(*odd, strict=True))
        powers = [states]
        for _ in range(3):
            powers.append(np.tensordot(self.system, powers[-1], axes=1))
        if x.ndim == 2:
            powers = [each[..., None] for each in powers]
        return np.asarray(c0 * powers[0] - c1 * powers[1] + c2 * powers[2] - c3 * powers[3])


def system_of(plane: Plane[N]) -> Array:
    """A, shape (4, 4, ...)."""
    q, shear, soft, stiff, _ = plane
    none, one = 0 * q, 0 * q + 1
    return np.array(
        [[none, one, shear, none], [-q, none, none, soft], [stiff, none, none, q], [none, none, -one, none]]
    )


def flexibility_of(plane: Plane[N]) -> Array:
    """H of a half-space, shape (2, 2, ...)."""
    s, d, mixed, _ = exponents(plane)
    return np.array([[-s, mixed], [mixed, -s * d]]) / plane.stiffness


_MIRROR = np.outer([1.0, -1.0, -1.0, 1.0], [-1.0, 1.0])
"""Signs under z -> -z of a state, and of the tractions that name it."""


class Sheet:
    """A layer on what lies below it, for wavenumbers k: carries flexibilities up and tractions down.

    Parameters
    ----------
    solid : Solid
        Its material.
    thickness : float
        [m].
    k : ndarray, shape (nk,)
        Wavenumbers [1/m].
    states : ndarray, shape (4, 2, nk)
        What the lower face admits.
    across : ndarray, shape (2, nk), optional
        (k u_t, s_tz) that it admits, for waves of traction across the wave vector.
    """

    def __init__(self, solid: Solid, thickness: float, k: Array, states: Array, across: Array | None = None) -> None:
        self._solid, self._thickness, self._k, self._states = solid, thickness, k, states
        x = k * thickness
        if across is not None:
            self._across, self._lifted = across, _across_above(solid, x, across)
        self._thin: Flags = x * solid.fastest <= _SERIES
        thick = ~self._thin
        self._top = np.empty((4, 2, k.size))
        if self._thin.any():
            self._top[..., self._thin] = solid.raised(states[..., self._thin], x[self._thin])
        if thick.any():
            self._back = self._reflected(x[thick], states[..., thick])
            down = np.concatenate([solid.flexibility, np.eye(2)])
            up = solid.growing(x[thick])
            self._top[..., thick] = down[..., None] + np.einsum("ijn,jkn->ikn", up, self._back)

    def _reflected(self, x: Array, states: Array) -> Array:
        """R exp(-N x): growing fields at the lower face for unit tractions of decaying ones at the upper face, (2, 2, n)."""
        solid = self._solid
        hidden = x * solid.slowest > REACH
        back = np.zeros((2, 2, x.size))
        shown = ~hidden
        if shown.any():
            arriving = solid.decaying(x[shown])
            mirror = solid.growing(np.zeros(int(shown.sum())))
            unknown = np.concatenate([mirror, -_scaled(states[..., shown])], axis=1)
            solved = np.linalg.solve(np.moveaxis(unknown, 2, 0), -np.moveaxis(arriving, 2, 0))
            back[..., shown] = np.moveaxis(solved[:, :2], 0, 2)
        return back

    @property
    def flexibility(self) -> Array:
        """Flexibility at the upper face, shape (2, 2, nk)."""
        return divided(self._top[:2], self._top[2:])

    @property
    def flexibility_across(self) -> Array:
        """k u_t/s_tz at the upper face, shape (nk,)."""
        return np.asarray(self._lifted[0] / self._lifted[1])

    def _amplitude(self, traction: Array) -> Array:
        return np.asarray(np.einsum("ijn,jkn->ikn", inverse(self._top[2:]), traction))

    def at(self, down: Array, traction: Array) -> Array:
        """States (4, loads, nk, nz) at depths (nz,) below the upper face [m] under tractions (2, loads, nk) on it."""
        amplitude = self._amplitude(traction)
        found = np.empty((4, amplitude.shape[1], self._k.size, down.size))
        solid, thin, thick = self._solid, self._thin, ~self._thin
        height = np.maximum(self._thickness - down, 0.0)
        if thin.any():
            raised = solid.raised(self._states[..., thin], np.multiply.outer(self._k[thin], height))
            found[..., thin, :] = np.einsum("ijnz,jkn->iknz", raised, amplitude[..., thin])
        if thick.any():
            k = self._k[thick]
            fields = solid.decaying(np.multiply.outer(k, down))
            fields += np.einsum("ijnz,jkn->iknz", solid.growing(np.multiply.outer(k, height)), self._back)
            found[..., thick, :] = np.einsum("ijnz,jkn->iknz", fields, amplitude[..., thick])
        return found

    def at_across(self, down: Array, traction: Array) -> Array:
        """(k u_t, s_tz), shape (2, nk, nz), at depths (nz,) under a traction (nk,) across the wave on the upper face."""
        height = np.multiply.outer(self._k, np.maximum(self._thickness - down, 0.0))
        above = _across_above(self._solid, height, self._across[..., None])
        fade = np.exp(
            -self._solid.sideways[0] * (np.multiply.outer(self._k, np.full(down.shape, self._thickness)) - height)
        )
        return np.asarray(above * (traction / self._lifted[1])[:, None] * fade)


def _scaled(states: Array) -> Array:
    """States whose columns have the size 1: a loose spring below makes one of them very long."""
    return np.asarray(states / np.abs(states).max(axis=0, keepdims=True))


def _across_above(solid: Solid, x: Array, lower: Array) -> Array:
    """(k u_t, s_tz) at heights x = k h above a face where it is `lower`, times exp(-rate x)."""
    rate, impedance = solid.sideways
    fade = np.exp(-2 * rate * x)
    cosh, sinh = (1 + fade) / 2, -np.expm1(-2 * rate * x) / 2
    u, s = lower
    return np.stack([cosh * u - sinh * s / impedance, cosh * s - sinh * impedance * u])


def divided(upper: Array, lower: Array) -> Array:
    """`upper` times the inverse of `lower`, both (2, 2, nk)."""
    (a, b), (c, d) = lower
    product = np.empty(upper.shape)
    product[:, 0], product[:, 1] = upper[:, 0] * d - upper[:, 1] * c, upper[:, 1] * a - upper[:, 0] * b
    product /= a * d - b * c
    return product


def inverse(lower: Array) -> Array:
    """Inverse of matrices (2, 2, nk)."""
    determinant = lower[0, 0] * lower[1, 1] - lower[0, 1] * lower[1, 0]
    return np.asarray(np.array([[lower[1, 1], -lower[0, 1]], [-lower[1, 0], lower[0, 0]]]) / determinant)
