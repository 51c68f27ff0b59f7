"""Second-order perturbation series of any profile f(r, phi) on any medium (T8.1)-(T8.3).

With ln f = <ln f> + g, the base is f_b = exp<ln f> and g_m(r) are the harmonics of g at each radius. The displacement
f_b g_m cos m phi on the disc needs the pressure with c_m = A_m^-1 b[f_b g_m]; its edge strength moves the outline,
h_m = -S[c_m]/(e a d'). Half-space parts are closed: S0_m = ((m + 1) b_0 + a db_0/da)/pi.

Where f touches zero away from the axis (truncated tips) ln f is singular; there the arithmetic mean is the base and f - f_b
takes the place of f_b g, which is the same to second order. There the harmonic m = 1 is a shift of the tip: what it does to the
force enters as a lower depth instead of a factor, which is exact for a paraboloid.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import AT_ONCE, Array
from flatpunch.compliances import Kernel
from flatpunch.contact.perturbation.perturbed_contact import PathPoint, PerturbedContact
from flatpunch.contact.perturbation.power_law_series import LARGEST_TERM, radius_of_stiffness
from flatpunch.contact.round.profile import NODES, TINY, SampledProfile
from flatpunch.contact.round.round_contact import RoundContact, round_contact
from flatpunch.indenters.geometry.angles import angular_harmonics, angular_mean, geometric_mean
from flatpunch.indenters.geometry.features import sample_radii
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.piecewise import log_table
from flatpunch.punch.basis import node_count, projection, regular_part
from flatpunch.punch.family import SMALLEST
from flatpunch.punch.harmonics import Edges, PowerLawEdges, edges_of, harmonic_size
from flatpunch.punch.matrix import edge_strength
from flatpunch.punch.power_law import power_law_punch

_POINTS = 256
"""Angles on one period of the outline, harmonics up to 128 times the symmetry: half as many change outlines of pyramids by 2e-3
and take 0.7 of the time, twice as many by 2e-4 and 1.3 of it."""


LARGEST_WAVE = 3.0
"""|w| at which outlines are cut, far beyond where the series is of use."""


class Terms(NamedTuple):
    """Scaled base contact, force term and outline at n base radii, or their derivatives by ln a; shape (n,) each.

    Attributes
    ----------
    depth, depth_slope, shift : ndarray
        d, a d' and the depth that a shift of the tip takes away, over a.
    force, stiffness : ndarray
        F over E* a^2 and K over E* a of the base.
    x2 : ndarray
        Second-order term of ln F.
    stiffening, log_mean, log_square, skew, swing : ndarray
        Measures of the outline abar exp(w): sum_m eta_m h_m^2, ln<e^w>, ln<e^2w>, x2 <w^3>/<w^2>, largest |w|.
    waves : ndarray, shape (n, 2 orders)
        Harmonics of w, real parts before imaginary ones.
    """

    depth: Array
    depth_slope: Array
    shift: Array
    force: Array
    stiffness: Array
    x2: Array
    stiffening: Array
    log_mean: Array
    log_square: Array
    skew: Array
    swing: Array
    waves: Array

    @classmethod
    def of(cls, columns: Array) -> Terms:
        """The terms from an array of shape (n, outputs)."""
        count = len(cls._fields) - 1
        return cls._make([*columns[:, :count].T, columns[:, count:]])

    @property
    def columns(self) -> Array:
        """All of them side by side, shape (n, outputs)."""
        return np.column_stack(self)


class GeneralExpansion:
    """Second-order series of one indenter on one medium.

    Parameters
    ----------
    kernel, indenter
        Medium and indenter, of any shape f(r, phi).
    """

    def __init__(self, kernel: Kernel, indenter: Indenter) -> None:
        self.kernel = kernel
        self._geometric = geometric_mean(indenter) if _is_regular(indenter) else None
        self._shape = angular_harmonics(indenter, _POINTS // 2, logarithmic=self._geometric is not None)
        self._orders = self._shape.orders
        mean = self._geometric or angular_mean(indenter)
        self.base = SampledProfile(mean.height, mean.slope, indenter.rings)
        self._reach = indenter.reach
        self._table = log_table(self._columns, indenter.reach, kinks=indenter.rings)

    def descent(self, radius: Array) -> PathPoint:
        """Depth and its derivative at base radii of shape (n,); here no cheaper than `loading`."""
        return self.loading(radius)

    def loading(self, radius: Array) -> PathPoint:
        """Depth, force and their derivatives at base radii of shape (n,), >= 0 [m]."""
        values, slopes = self._at(radius)
        return self._path(radius, values, slopes)

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at base radii, shape (n,), >= 0 [m]."""
        values, slopes = self._at(radius)
        path = self._path(radius, values, slopes)
        size = radius_of_stiffness(self.kernel, path.stiffness, values.stiffening, radius)
        zero = np.zeros_like(radius)
        return PerturbedContact(
            radius=radius,
            depth=path.depth,
            force=path.force,
            stiffness=path.stiffness,
            depth_slope=path.depth_slope,
            shape_radius=radius,
            size=size,
            mean_radius=size * np.exp(values.log_mean),
            area=np.pi * size**2 * np.exp(values.log_square),
            swing=values.swing,
            terms=np.column_stack([values.x2, values.skew, zero]),
        )

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Contact outline a(phi), shape (n, p) [m]."""
        values, _ = self._at(contact.radius)
        count = self._orders.size
        waves = np.exp(1j * np.outer(self._orders, phi - self._shape.start))
        w = values.waves[:, :count] @ waves.real - values.waves[:, count:] @ waves.imag
        return np.asarray(contact.size[:, None] * np.exp(w))

    def _path(self, radius: Array, values: Terms, slopes: Terms) -> PathPoint:
        depth = radius * (values.depth - values.shift)
        force = self.kernel.modulus * radius**2 * values.force
        base_slope = radius * values.depth_slope
        slope = base_slope - radius * (values.shift + slopes.shift)
        flat = self.kernel.modulus * radius * values.stiffness
        factor = np.exp(values.x2)
        # dF/dd = exp(X) (K a d_b' + F_b dX/dln a)/(a d')
        moving = slope > 0
        stretch = np.where(moving, base_slope / np.where(moving, slope, 1.0), 1.0)
        growth = np.where(moving, slopes.x2 / np.where(moving, slope, 1.0), 0.0)
        return PathPoint(radius, depth, factor * force, factor * (flat * stretch + force * growth), slope)

    def _at(self, radius: Array) -> tuple[Terms, Terms]:
        live = radius > 0
        outputs = len(Terms._fields) - 1 + 2 * self._orders.size
        values, slopes = np.zeros((radius.size, outputs)), np.zeros((radius.size, outputs))
        if live.any():
            values[live], slopes[live] = self._table.with_slope(np.log(np.minimum(radius[live], self._reach)))
        return Terms.of(values), Terms.of(slopes)

    def _columns(self, radius: Array) -> Array:
        """All of `Terms` side by side, shape (n, outputs)."""
        base = round_contact(self.kernel, self.base, radius)
        size = max(1, AT_ONCE // (_POINTS * node_count(harmonic_size(self.kernel, self._beta(radius).max()))))
        parts = [
            self._chunk(radius[i : i + size], _rows(base, slice(i, i + size))) for i in range(0, radius.size, size)
        ]
        return np.vstack(parts)

    def _chunk(self, radius: Array, base: RoundContact) -> Array:
        beta = self._beta(radius)
        edges = edges_of(self.kernel, np.where(beta > SMALLEST, beta, 0.0), self._orders)
        value, growth, curvature, rho, weight = self._harmonics(radius, base)
        e = edge_strength(base.responses)
        strength = self._edge(edges, e, value, growth, rho, weight)
        h, w = _waves(-strength, e * base.depth_slope)
        k = edges.stiffening(self._orders)
        mean_square = np.mean(w * w, axis=1)
        stiffened = mean_square + np.sum(k[:, :-1] * np.abs(h[:, :-1]) ** 2, axis=1) / 2
        rise = np.pi * e**2 / base.responses.flat[:, 0]
        # X2 = (a K' D1 <w^2>/2 - int p* f_b <g^2>/2)/F_b, both over E* a
        rate = np.pi**2 * e**2 * base.depth_slope
        pull = rate * mean_square - curvature
        shift = np.zeros_like(radius)
        if self._geometric is None and self._orders[0] == 1:
            first = rate * np.abs(h[:, 0]) ** 2 / 2
            pull, shift = pull - first, first / (2 * np.pi * base.responses.flat[:, 0])
        force = base.force / (self.kernel.modulus * radius)
        x2 = pull / np.maximum(force, TINY)
        return Terms(
            depth=base.depth / radius,
            depth_slope=base.depth_slope / radius,
            shift=shift / radius,
            force=force / radius,
            stiffness=2 * np.pi * base.responses.flat[:, 0],
            x2=np.clip(x2, -LARGEST_TERM, LARGEST_TERM),
            stiffening=rise * stiffened,
            log_mean=np.log(np.mean(np.exp(w), axis=1)),
            log_square=np.log(np.mean(np.exp(2 * w), axis=1)),
            # of the size of x3, which is not known here; zero of an ellipse as x3 is
            skew=x2 * np.mean(w**3, axis=1) / np.maximum(mean_square, TINY),
            swing=np.abs(w).max(axis=1),
            waves=np.hstack([h.real, h.imag]),
        ).columns

    def _harmonics(self, radius: Array, base: RoundContact) -> tuple[Array, Array, Array, Array, Array]:
        """Harmonics of f - f_b and of its growth r d/dr on the nodes, shape (n, nodes, 2 orders), and the mean's part."""
        nodes = node_count(harmonic_size(self.kernel, float(self._beta(radius).max())))
        rho, weight = self._rule(radius, nodes)
        r = radius[:, None] * rho
        value, growth = self._shape.harmonics(r)
        growth *= r[..., None]
        excess = np.zeros(r.shape)
        if self._geometric is not None:
            mean, rate, square = np.moveaxis(self._geometric.at(r), -1, 0)
            f_b = np.exp(mean)
            growth *= f_b[..., None]
            value *= f_b[..., None]
            growth += (r * rate)[..., None] * value
            excess = f_b * square / 2
        flat = base.responses.flat
        if self.kernel.exponent:
            pressure = flat * (1 + self.kernel.exponent) * weight
        else:
            pressure = _pressure(flat, 0, rho, weight)
        curvature = 2 * np.pi * np.sum(pressure * excess, axis=1)
        return value, growth, curvature, rho, weight

    def _rule(self, radius: Array, nodes: int) -> tuple[Array, Array]:
        """Nodes rho of the discs and weights in theta; on a power-law half-space weights of (1 - r^2)^alpha r dr."""
        if not self.kernel.exponent:
            return self.base.disc_rule(radius, nodes)
        rho, weight = power_law_punch(self.kernel).rule(NODES)
        return rho[None, :], weight[None, :]

    def _edge(
        self, edges: Edges | PowerLawEdges, e: Array, value: Array, growth: Array, rho: Array, weight: Array
    ) -> Array:
        """S[c_m] for all orders, shape (n, orders), complex."""
        m, power, extra = self._orders, rho[..., None] ** self._orders, self.kernel.exponent
        # int rho^m weight (...), real and imaginary parts alike
        first = power * (weight if extra else rho * weight)[..., None]
        moment, grown = (self._summed(first, field) for field in (value, growth))
        # half-space: S is ((m + 1) b_0[f] + b_0[r f'])/pi; power law: with m + 1 + k, over that of the flat punch, of strength e
        strength = (m + 1 + extra)[:, None] * moment + grown
        if isinstance(edges, PowerLawEdges):
            return np.asarray(strength * e[:, None, None]).view(complex)[..., 0]
        strength /= np.pi
        for column, vector in edges.felt(m):
            pressure = _pressure(vector, int(m[column]), rho, weight)[..., None]
            strength[:, [column]] += self._summed(pressure, value[..., 2 * column : 2 * column + 2])
        return np.asarray(strength).view(complex)[..., 0]

    @staticmethod
    def _summed(factor: Array, field: Array) -> Array:
        """Sums over the nodes, shape (n, orders, 2), of a factor (n or 1, nodes, orders) times a field (n, nodes, 2 orders)."""
        n, nodes = field.shape[:2]
        orders = factor.shape[-1]
        factors = np.broadcast_to(factor, (n, nodes, orders))
        return np.asarray(np.einsum("njm,njmc->nmc", factors, field.reshape(n, nodes, orders, 2)))

    def _beta(self, radius: Array) -> Array:
        return np.asarray(radius / self.kernel.length)


def _is_regular(indenter: Indenter) -> bool:
    """Whether ln f is a good variable: within the border of a flat f is zero, however far the shape reaches."""
    r = np.append(sample_radii(indenter), 0.5 * np.array(indenter.rings))[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        g = np.log(np.asarray(indenter.height(r, 2 * np.pi * np.arange(_POINTS) / _POINTS)))
        # |ln(f/f_b)| above which the logarithm is no good variable: f comes close to zero away from the axis
        return bool(np.all(np.abs(g - g.mean(axis=1, keepdims=True)) < 4.0))


def _waves(strength: Array, rate: Array) -> tuple[Array, Array]:
    """Harmonics h = strength/rate of w, shape (n, orders), and w on one period, cut at `LARGEST_WAVE`."""
    w = np.fft.irfft(np.hstack([np.zeros((rate.size, 1)), strength * _POINTS / 2]), n=_POINTS, axis=1)
    largest = np.abs(w).max(axis=1)
    sign = np.where(rate < 0, -1.0, 1.0)
    bound = np.maximum(np.abs(rate), np.maximum(largest, TINY) / LARGEST_WAVE) * sign
    return strength / bound[:, None], w / bound[:, None]


def _pressure(coefficients: Array, m: int, rho: Array, weight: Array) -> Array:
    """Weights of the pressure sum c_l p_l on the nodes of each disc, int p f r dr = sum of weights times f; shape (n, nodes)."""
    terms = coefficients.shape[1]
    if rho.shape[0] == 1 and coefficients.shape[0] != 1:
        return coefficients @ projection(m, terms, rho.shape[1])[1]
    return np.asarray(np.einsum("nl,lnj->nj", coefficients, regular_part(m, terms, rho)) * rho * weight)


def _rows(base: RoundContact, rows: slice) -> RoundContact:
    responses = replace(
        base.responses, flat=base.responses.flat[rows], edge=base.responses.edge[rows], slope=base.responses.slope[rows]
    )
    shape = {name: getattr(base, name)[rows] for name in ("radius", "depth", "force", "stiffness", "depth_slope")}
    return replace(base, responses=responses, **shape)


@byte_cached
def general_expansion(kernel: Kernel, indenter: Indenter) -> GeneralExpansion:
    """The series of a medium and an indenter; what is already computed is shared."""
    return GeneralExpansion(kernel, indenter)
