"""Round contacts of a tip with a surface that a known round pressure has moved.

In the basis of the flat punch (T3.1) a round pressure on the radius a is (E*/a) sum c_n p_n(r/a) with the transform
E* a sum c_n j_2n(ka). Under a compliance that differs from another by 2 R(k l)/(E* k) it moves the surface further by

    V(r) = 2 int R(x a/l) sum c_n j_2n(x) J_m(x r/a) dx            (m = 0, or 2 about cos 2 phi).

R vanishes at short waves, so that V is smooth inside the contact, and a tip f on the moved surface is the tip
f(r) + V(0) - V(r) on a flat one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from flatpunch._support.checks import ROUNDING, Array
from flatpunch.compliances import Kernel
from flatpunch.contact.round.profile import NODES, RoundProfile, SampledProfile
from flatpunch.contact.round.round_contact import RoundContact
from flatpunch.numerics.chebyshev import nodal_transform, tail, unit_nodes
from flatpunch.punch.basis import half_space_diagonal
from flatpunch.punch.graded import graded_matrices
from flatpunch.punch.matrix import remainder_rule
from flatpunch.punch.wavenumbers import bessel_table

FARTHEST = 2048.0
"""Wavenumber times radius at which integrals over the response of a graded surface end: 1e-6 of V remains where the radius is its
thickness, and ten times as much with a quarter of it."""

_TAIL = 1e-11
"""Last terms of V over its largest at which a Chebyshev series is long enough: what the responses themselves are good for."""

_LONGEST = 2**9
"""Most terms of it."""


@dataclass(frozen=True, slots=True)
class RoundPressure:
    """A round pressure by its coefficients in the basis of the flat punch.

    Attributes
    ----------
    kernel : Kernel
        Compliance of the medium that it was solved on.
    radius : float
        a [m].
    series : ndarray, shape (terms,)
        c_n [m].
    """

    kernel: Kernel
    radius: float
    series: Array

    def displacement(
        self, response: Callable[[Array], Array], r: Array, order: int = 0, farthest: float = 1.0
    ) -> Array:
        """V [m] at 0 <= r, shape (n,), of R = response(kappa); `farthest` is the share of the wavenumbers that is used."""
        beta = self.radius / self.kernel.length
        first, last = wave_range(self.kernel, beta, beta)
        table = bessel_table(0, self.series.size, first, last)
        used = table.x < farthest * _needed(self.kernel, beta)
        x = table.x[used]
        weights = 2 * response(x / beta) * table.w[used] * (self.series @ table.j[:, used])
        return np.asarray(weights @ scipy.special.jv(order, np.outer(x, r / self.radius)))


def wave_range(kernel: Kernel, smallest: float, largest: float) -> tuple[int, float]:
    """Range of wavenumber times radius that acts on radii a/l in a range: log_4 of its start, and its end."""
    first = min(0, int(np.floor(np.log(kernel.floor * smallest) / np.log(4))))
    return first, 4.0 * 2.0 ** np.ceil(np.log2(_needed(kernel, largest) / 4.0))


def _needed(kernel: Kernel, beta: float) -> float:
    return FARTHEST if kernel.graded else max(kernel.cutoff * beta, 4.0)


def round_pressures(kernel: Kernel, contact: RoundContact) -> list[RoundPressure]:
    """Pressures of contacts without adhesion: c = A^-1 (d b[1] - b[f]). Not on power-law half-spaces, which have no V."""
    right = -contact.moments.b
    right[:, 0] += contact.depth
    beta, terms = contact.radius / kernel.length, right.shape[1]
    if kernel.graded:
        matrix = graded_matrices(kernel, beta, terms)[0] + np.diag(half_space_diagonal(0, terms))
    else:
        matrix = remainder_rule(kernel, beta, terms, 0).matrix()
    found = np.linalg.solve(matrix, right[..., None])[..., 0]
    return [RoundPressure(kernel, float(a), series) for a, series in zip(contact.radius, found, strict=True)]


def on_moved_surface(profile: RoundProfile, moved: Callable[[Array], Array], radius: float) -> SampledProfile:
    """The tip f(r) + V(0) - V(r) within a radius [m]; `moved` is V, shape (n,) -> (n,), smooth in r^2 up to there."""
    terms, series = 8, np.ones(1)
    while tail(series) > _TAIL and terms < _LONGEST:
        terms *= 2
        series = nodal_transform(terms) @ moved(radius * np.sqrt((1 + unit_nodes(terms)) / 2))
    change, slope = series.copy(), chebyshev.chebder(series) * 4 / radius**2
    change[0] -= chebyshev.chebval(-1.0, series)

    def within(r: Array) -> Array:
        return 2 * np.minimum(r / radius, 1.0) ** 2 - 1

    return SampledProfile(
        lambda r: profile.height(r) - chebyshev.chebval(within(r), change),
        # on the axis slopes may be infinite
        lambda r: profile.slope(np.maximum(r, ROUNDING * radius)) - r * chebyshev.chebval(within(r), slope),
        getattr(profile, "rings", ()),
        NODES,
    )
