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
from functools import lru_cache

import numpy as np

from flatpunch._validation import Array, Indices
from flatpunch.compliance import Kernel
from flatpunch.contact.axisymmetric import RoundContact, SampledProfile, edge_strength, round_contact
from flatpunch.contact.expansion import PathPoint, PerturbedContact, radius_of_stiffness
from flatpunch.contact.log_table import LogTable
from flatpunch.contact.perturbation import PowerLawEdges, edges_of
from flatpunch.indenters.angular_mean import GeometricMean, angular_mean
from flatpunch.indenters.profile import Indenter, height_and_slope
from flatpunch.indenters.symmetry import rotational_symmetry, sample_radii
from flatpunch.punch.basis import projection, regular_part
from flatpunch.punch.family import SMALLEST
from flatpunch.punch.harmonics import Edges, harmonic_size
from flatpunch.punch.power_law import power_law_punch

_POINTS = 256
"""Angles on one period of the outline: harmonics up to 128 times the symmetry."""
_CHUNK = 4_000_000
_POWER_LAW_NODES = 256
_SINGULAR = 4.0
"""|ln(f/f_b)| from which on the logarithm is no good variable: f comes close to zero away from the axis."""

_LARGEST_WAVE = 3.0
"""|w| at which outlines are cut, far beyond what the series can say."""
_LARGEST_TERM = 2.0
"""|ln(F/F_base)| at which the force term is cut."""
_TINY = 1e-300

_DEPTH, _SLOPE, _SHIFT, _FORCE, _X2, _STIFFENING, _LOG_MEAN, _LOG_SQUARE, _SKEW, _SWING = range(10)


class GeneralExpansion:
    """Second-order series of one indenter on one medium.

    Parameters
    ----------
    kernel, indenter
        Medium and indenter, of any shape f(r, phi).
    """

    def __init__(self, kernel: Kernel, indenter: Indenter) -> None:
        self.kernel, self.indenter = kernel, indenter
        fold = rotational_symmetry(indenter)
        start = indenter.corners[0] if indenter.corners else 0.0
        self._phi = start + 2 * np.pi / fold * np.arange(_POINTS) / _POINTS
        self._orders: Indices = fold * np.arange(1, _POINTS // 2 + 1)
        self._weights, self._jump, self._aliased = np.ones(_POINTS) / _POINTS, np.zeros(_POINTS), np.zeros(_POINTS // 2)
        if len(indenter.corners) == fold:
            self._weights, self._jump, self._aliased = _one_kink()
        self._logarithmic = self._is_regular()
        mean = GeometricMean(indenter, self._phi, self._weights) if self._logarithmic else angular_mean(indenter)
        self.base = SampledProfile(mean.height, mean.slope, indenter.rings)
        self._table = LogTable(self._columns, indenter.reach, kinks=indenter.rings)

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
        size = radius_of_stiffness(self.kernel, path.stiffness, values[:, _STIFFENING], radius)
        zero = np.zeros_like(radius)
        return PerturbedContact(
            radius=radius,
            depth=path.depth,
            force=path.force,
            stiffness=path.stiffness,
            depth_slope=path.depth_slope,
            shape_radius=radius,
            size=size,
            mean_radius=size * np.exp(values[:, _LOG_MEAN]),
            area=np.pi * size**2 * np.exp(values[:, _LOG_SQUARE]),
            swing=values[:, _SWING],
            terms=np.column_stack([values[:, _X2], values[:, _SKEW], zero]),
            sound=np.ones(radius.size, dtype=bool),
        )

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Contact outline a(phi), shape (n, p) [m]."""
        values, _ = self._at(contact.radius)
        count = self._orders.size
        waves = np.exp(1j * np.outer(self._orders, phi - self._phi[0]))
        harmonics = values[:, _SWING + 1 : -1]
        w = harmonics[:, :count] @ waves.real - harmonics[:, count:] @ waves.imag
        return np.asarray(contact.size[:, None] * np.exp(w))

    def _path(self, radius: Array, values: Array, slopes: Array) -> PathPoint:
        depth = radius * (values[:, _DEPTH] - values[:, _SHIFT])
        force = self.kernel.modulus * radius**2 * values[:, _FORCE]
        base_slope = radius * values[:, _SLOPE]
        slope = base_slope - radius * (values[:, _SHIFT] + slopes[:, _SHIFT])
        flat = self.kernel.modulus * radius * values[:, -1]
        factor = np.exp(values[:, _X2])
        # dF/dd = exp(X) (K a d_b' + F_b dX/dln a)/(a d')
        moving = slope > 0
        stretch = np.where(moving, base_slope / np.where(moving, slope, 1.0), 1.0)
        growth = np.where(moving, slopes[:, _X2] / np.where(moving, slope, 1.0), 0.0)
        return PathPoint(radius, depth, factor * force, factor * (flat * stretch + force * growth), slope)

    def _at(self, radius: Array) -> tuple[Array, Array]:
        live = radius > 0
        outputs = _SWING + 2 + 2 * self._orders.size
        values, slopes = np.zeros((radius.size, outputs)), np.zeros((radius.size, outputs))
        if live.any():
            values[live], slopes[live] = self._table.at(radius[live])
        return values, slopes

    def _columns(self, radius: Array) -> Array:
        """Scaled base contact, force term, outline measures, harmonics of w (real, imaginary) and K, shape (n, outputs)."""
        base = round_contact(self.kernel, self.base, radius)
        size = max(1, _CHUNK // (_POINTS * (2 * harmonic_size(self.kernel, self._beta(radius).max()) + 48)))
        parts = [
            self._chunk(radius[i : i + size], _rows(base, slice(i, i + size))) for i in range(0, radius.size, size)
        ]
        return np.vstack(parts)

    def _chunk(self, radius: Array, base: RoundContact) -> Array:
        beta = self._beta(radius)
        edges = edges_of(self.kernel, np.where(beta > SMALLEST, beta, 0.0), self._orders)
        value, growth, curvature, rho, weight = self._harmonics(radius, base)
        e = edge_strength(base.answers)
        strength = self._edge(edges, e, value, growth, rho, weight)
        h, w = _waves(-strength, e * base.depth_slope)
        k = edges.stiffening(self._orders)
        mean_square = np.mean(w * w, axis=1)
        stiffened = mean_square + np.sum(k[:, :-1] * np.abs(h[:, :-1]) ** 2, axis=1) / 2
        rise = np.pi * e**2 / base.answers.flat[:, 0]
        # X2 = (a K' D1 <w^2>/2 - int p* f_b <g^2>/2)/F_b, both over E* a
        rate = np.pi**2 * e**2 * base.depth_slope
        pull = rate * mean_square - curvature
        shift = np.zeros_like(radius)
        if not self._logarithmic and self._orders[0] == 1:
            first = rate * np.abs(h[:, 0]) ** 2 / 2
            pull, shift = pull - first, first / (2 * np.pi * base.answers.flat[:, 0])
        force = base.force / (self.kernel.modulus * radius)
        columns = [
            base.depth / radius,
            base.depth_slope / radius,
            shift / radius,
            force / radius,
            np.clip(pull / np.maximum(force, _TINY), -_LARGEST_TERM, _LARGEST_TERM),
            rise * stiffened,
            np.log(np.mean(np.exp(w), axis=1)),
            np.log(np.mean(np.exp(2 * w), axis=1)),
            # of the size of x3, which is not known here; zero of an ellipse as x3 is
            pull / np.maximum(force, _TINY) * np.mean(w**3, axis=1) / np.maximum(mean_square, _TINY),
            np.abs(w).max(axis=1),
        ]
        flat = 2 * np.pi * base.answers.flat[:, :1]
        return np.hstack([np.column_stack(columns), h.real, h.imag, flat])

    def _harmonics(self, radius: Array, base: RoundContact) -> tuple[Array, Array, Array, Array, Array]:
        """Harmonics of f - f_b and of its growth r d/dr on the nodes, shape (n, nodes, orders), and the mean's part."""
        nodes = 2 * harmonic_size(self.kernel, float(self._beta(radius).max())) + 48
        rho, weight = self._rule(radius, nodes)
        r = (radius[:, None] * rho)[..., None]
        f, slope = height_and_slope(self.indenter, r, self._phi)
        q = r * slope
        if self._logarithmic:
            g = np.log(f)
            mean = self._mean(g)[..., None]
            g, rate, f_b = g - mean, q / f, np.exp(mean)
            growth_mean = self._mean(rate)[..., None]
            value, growth = f_b * g, f_b * (growth_mean * g + rate - growth_mean)
            excess = f_b[..., 0] * self._mean(g * g) / 2
        else:
            value, growth = f - self._mean(f)[..., None], q - self._mean(q)[..., None]
            excess = np.zeros(r.shape[:-1])
        flat = base.answers.flat
        if self.kernel.exponent:
            pressure = flat * (1 + self.kernel.exponent) * weight
        else:
            pressure = _pressure(flat, 0, rho, weight)
        curvature = 2 * np.pi * np.sum(pressure * excess, axis=1)
        return self._spectrum(value), self._spectrum(growth), curvature, rho, weight

    def _rule(self, radius: Array, nodes: int) -> tuple[Array, Array]:
        """Nodes rho of the discs and weights in theta; on a power-law half-space weights of (1 - r^2)^alpha r dr."""
        if not self.kernel.exponent:
            return self.base.disc_rule(radius, nodes)
        rho, weight = power_law_punch(self.kernel).rule(_POWER_LAW_NODES)
        return rho[None, :], weight[None, :]

    def _edge(
        self, edges: Edges | PowerLawEdges, e: Array, value: Array, growth: Array, rho: Array, weight: Array
    ) -> Array:
        """S[c_m] for all orders, shape (n, orders), complex."""
        m = self._orders
        if isinstance(edges, PowerLawEdges):
            # S is (m + 1 + k) b_0[f] + b_0[r f'] over that of the flat punch, whose strength is e
            first = rho[..., None] ** m * weight[..., None]
            grown = (m + 1 + self.kernel.exponent) * value + growth
            return np.asarray(np.sum(first * grown, axis=1) * e[:, None])
        first = rho[..., None] ** (m + 1.0) * weight[..., None]
        strength = np.einsum("njm,njm->nm", np.broadcast_to(first, value.shape), (m + 1) * value + growth) / np.pi
        for column, order in enumerate(m):
            vector = edges.vectors.get(int(order))
            if vector is not None:
                pressure = _pressure(vector, int(order), rho, weight)
                strength[:, column] += np.sum(pressure * value[..., column], axis=1)
        return np.asarray(strength)

    def _mean(self, field: Array) -> Array:
        """Mean over the angle, the last axis."""
        return np.asarray(field @ self._weights)

    def _spectrum(self, field: Array) -> Array:
        """Complex amplitudes c_m of sum Re(c_m exp(i m phi)) without the mean, shape (..., orders)."""
        sampled = np.fft.rfft(field, axis=-1)[..., 1:] * (2 / _POINTS)
        return np.asarray(sampled + (field @ self._jump)[..., None] * self._aliased)

    def _is_regular(self) -> bool:
        # within the border of a flat f is zero, however far the shape reaches
        r = np.append(sample_radii(self.indenter, 61), 0.5 * np.array(self.indenter.rings))[:, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            g = np.log(np.asarray(self.indenter.height(r, self._phi)))
            return bool(np.all(np.abs(g - g.mean(axis=1, keepdims=True)) < _SINGULAR))

    def _beta(self, radius: Array) -> Array:
        return np.asarray(radius / self.kernel.length)


def _one_kink() -> tuple[Array, Array, Array]:
    """For one kink in each period, on its first point: what means and amplitudes of its samples need, shape (points,) and half.

    Weights of the mean are those of Gregory's rule on either side. Amplitudes: a slope that jumps by J, seen by one-sided
    differences of sixth order, holds J times the function -B_2/2 of Bernoulli, whose amplitudes -1/(2 pi^2 k^2) are known
    and need not be sampled.
    """
    weights = np.ones(_POINTS) / _POINTS
    weights[[0, 1, -1, 2, -2]] *= (3 / 4, 7 / 6, 7 / 6, 23 / 24, 23 / 24)
    jump = np.zeros(_POINTS)
    for j, c in enumerate((-49 / 20, 6, -15 / 2, 20 / 3, -15 / 4, 6 / 5, -1 / 6)):
        jump[j] += c * _POINTS
        jump[-j] += c * _POINTS
    x = np.arange(_POINTS) / _POINTS
    k = np.arange(1, _POINTS // 2 + 1)
    sampled = np.fft.rfft(-(x * x - x + 1 / 6) / 2)[1:].real * (2 / _POINTS)
    return weights, jump, -1 / (2 * np.pi**2 * k**2) - sampled


def _waves(strength: Array, rate: Array) -> tuple[Array, Array]:
    """Harmonics h = strength/rate of w, shape (n, orders), and w on one period, cut where |w| exceeds `_LARGEST_WAVE`.

    The rate e a d' vanishes within the flat of a truncated tip and where the depth turns back under a stiff film.
    """
    w = np.fft.irfft(np.hstack([np.zeros((rate.size, 1)), strength * _POINTS / 2]), n=_POINTS, axis=1)
    largest = np.abs(w).max(axis=1)
    sign = np.where(rate < 0, -1.0, 1.0)
    bound = np.maximum(np.abs(rate), np.maximum(largest, _TINY) / _LARGEST_WAVE) * sign
    return strength / bound[:, None], w / bound[:, None]


def _pressure(coefficients: Array, m: int, rho: Array, weight: Array) -> Array:
    """Weights of the pressure sum c_l p_l on the nodes of each disc, int p f r dr = sum of weights times f; shape (n, nodes)."""
    terms = coefficients.shape[1]
    if rho.shape[0] == 1 and coefficients.shape[0] != 1:
        return coefficients @ projection(m, terms, rho.shape[1])[1]
    return np.asarray(np.einsum("nl,lnj->nj", coefficients, regular_part(m, terms, rho)) * rho * weight)


def _rows(base: RoundContact, rows: slice) -> RoundContact:
    answers = replace(
        base.answers, flat=base.answers.flat[rows], edge=base.answers.edge[rows], slope=base.answers.slope[rows]
    )
    shape = {name: getattr(base, name)[rows] for name in ("radius", "depth", "force", "stiffness", "depth_slope")}
    return replace(base, answers=answers, **shape)


@lru_cache(maxsize=32)
def general_expansion(kernel: Kernel, indenter: Indenter) -> GeneralExpansion:
    """The series of a medium and an indenter; what is already computed is shared."""
    return GeneralExpansion(kernel, indenter)
