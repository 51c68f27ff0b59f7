"""Adhesive contact of slightly non-round power-law tips, exact to second order in the asymmetry.

f = C r^n exp(g(phi)), <g> = 0. The potential of a contact with outline a exp(h(phi)) at depth d is Pi = U - w area. About the
round contact of C r^n with radius a, retraction D = d_n - d, D1 = a d_n' and S_m = D1 R_m g_m (see `perturbation`) its second
order is

    Pi_2 = E(a) - W(a, d) + (a K'/2) D sum_m [S_m h_m + (D1 + D k_m) h_m^2/2],
    dE/dln a = (a K'/4) sum S_m^2,  dW/dd = V,  dW/dln a = -D a V',  V = (K d_n - F_n) <g^2>/2,  V' = K' d_n <g^2>/2.

Equilibrium, the same energy release all around, is h_m = -S_m/(D1 + D k_m); Y = (a K'/4) D sum S_m^2/(D1 + D k_m) is what it
gains, and the force is the derivative of Pi along the path at constant w. With N = dE/dln a + D a V' - dY/dln a, d_x = dd/dln a
of the round contact and q = a K' D,

    d = d_round + delta,      F = F_round - V + K delta + N K^2 d_x/(q^2 + (K d_x)^2),      delta = N q/(q^2 + (K d_x)^2).

Any delta of second order gives the same curve F(d) to that order; this one stays finite at both instabilities. The area is
-dPi/dw at constant depth,

    area = pi a^2 (1 - 2 X),      X = (F - F_round + V - K delta + dY/dd)/q,
    X -> [a K' d_n <g^2>/2 - dT/dln a + 2 T_k]/(a K' D1),      T = a K' sum S_m^2/(4 D1),  T_k the same with the factors k_m

as D -> 0. Without adhesion all this is the second order of `perturbation`, which sums it differently: as an exponential in ln
F, and with the area from the stiffness. So that it is the limit for w -> 0, the force is larger by F_n (e^x2 - 1 - x2), and the
area is the one without adhesion times exp(-2 (X - X(D = 0))). Both are terms of fourth order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.contact.adhesion.branch import (
    AROUND,
    STEP,
    AdhesiveContact,
    Branch,
    central_derivatives,
    stiffness_growth,
)
from flatpunch.contact.perturbation.error import second_order_error
from flatpunch.contact.perturbation.power_law_series import PowerExpansion, power_expansion
from flatpunch.contact.perturbation.power_law_terms import Angles, expand
from flatpunch.contact.round.profile import PowerProfile
from flatpunch.contact.round.round_contact import RoundContact, round_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.chebyshev import NODES
from flatpunch.numerics.piecewise import PiecewiseChebyshev, log_table
from flatpunch.punch.family import SMALLEST, panels, punch_family
from flatpunch.punch.harmonics import Edges, solve_edges
from flatpunch.punch.matrix import edge_strength
from flatpunch.punch.power_law import power_law_punch


@dataclass(frozen=True)
class PerturbedBranch:
    """Equilibria of one power-law tip over the base radius, with a work of adhesion [J/m^2]; the same interface as `Branch`."""

    kernel: Kernel
    indenter: Indenter
    work: float
    range_of_action: ClassVar[float] = 0.0
    kinks: ClassVar[tuple[float, ...]] = ()

    @cached_property
    def angles(self) -> Angles:
        """g = ln(psi/C) and C."""
        return expand(self.indenter, 0.0)

    @cached_property
    def profile(self) -> PowerProfile:
        """C r^n."""
        assert self.indenter.exponent is not None
        return PowerProfile(self.indenter.exponent, self.angles.mean)

    @cached_property
    def base(self) -> Branch:
        """The round branch of C r^n."""
        return Branch(self.kernel, lambda radius: round_contact(self.kernel, self.profile, radius), self.work)

    @cached_property
    def plain(self) -> PowerExpansion:
        """The contact without adhesion."""
        return power_expansion(self.kernel, self.indenter, "second")

    @cached_property
    def harmonics(self) -> Array:
        """g_m, complex."""
        u = self.angles.u
        return np.asarray(2 * np.fft.rfft(u)[1:-1] / u.size)

    @cached_property
    def orders(self) -> Indices:
        """The harmonics m."""
        return np.asarray(self.angles.orders[: self.harmonics.size])

    @cached_property
    def _table(self) -> PiecewiseChebyshev:
        """Depth, force and logarithm of the area over ln a."""
        return log_table(lambda radius: self._corrected(radius).T, nodes=NODES)

    @cached_property
    def _panels(self) -> PiecewiseChebyshev:
        return panels(self.kernel, self._answers)

    def evaluate(self, radius: Array) -> RoundContact:
        """Round contacts without adhesion of C r^n."""
        return self.base.evaluate(radius)

    def at(self, radius: Array) -> AdhesiveContact:
        """Equilibria at base radii > 0, shape (n,)."""
        values, slopes = self._table.with_slope(np.log(radius))
        round_ = self.base.at(radius)
        return AdhesiveContact(
            radius=radius,
            depth=values[:, 0],
            force=values[:, 1],
            retraction=round_.retraction,
            depth_slope=slopes[:, 0],
            force_slope=slopes[:, 1],
            plain=round_.plain,
        )

    def shape(self, radius: Array, phi: Array) -> tuple[Array, Array, Array]:
        """Outline, shape (n, p), mean radius a0 and area at base radii."""
        area = np.exp(self._table.at(np.log(radius))[:, 2])
        h = self._outline_harmonics(radius)
        # over one period, on the grid of the harmonics
        points = self.angles.u.size
        w = np.fft.irfft(np.pad(h, ((0, 0), (1, 1))), n=points) * points / 2
        size = np.sqrt(area / (np.pi * np.mean(np.exp(2 * w), axis=1)))
        return size[:, None] * np.exp(self._waves(h, phi)), size * np.mean(np.exp(w), axis=1), area

    def size(self, radius: Array) -> tuple[Array, Array]:
        """Mean radius a0 and area at base radii."""
        _, mean_radius, area = self.shape(radius, np.zeros(1))
        return mean_radius, area

    def base_radius(self, mean_radius: Array) -> Array:
        """Base radii of contacts with given mean radii a0, shape (n,); their ratio varies slowly, plain iteration converges."""
        x = np.log(mean_radius)
        for _ in range(60):
            step = np.log(mean_radius / self.shape(np.exp(x), np.zeros(1))[1])
            x = x + step
            if np.abs(step).max() < ROUNDING:
                break
        return np.asarray(np.exp(x))

    def error(self, radius: Array) -> Array:
        """Estimated error of the force [N], shape (n,).

        That of the contact without adhesion, and the square of the second-order change, whichever is larger; infinite where the
        outline is unstable.
        """
        assert self.indenter.exponent is not None
        plain = self.plain.evaluate(radius)
        contact = self.base.at(radius)
        scale = contact.plain.force + contact.plain.stiffness * contact.retraction
        depth, force, _ = self._table.at(np.log(radius)).T
        change = np.abs(force - contact.force) + contact.plain.stiffness * np.abs(depth - contact.depth)
        error = np.maximum(second_order_error(self.indenter, plain)[0], 2.5 * (change / scale) ** 2)
        return np.where(self.weakest(radius) > 0, error * scale, np.inf)

    def weakest(self, radius: Array) -> Array:
        """Smallest of (D1 + D k_m)/D1 over the harmonics: not positive where the outline is unstable."""
        contact = self.base.at(radius)
        _, k = self._responses(radius)
        d1 = contact.plain.depth_slope[:, None]
        return np.asarray(np.min(1 + contact.retraction[:, None] * k / d1, axis=1))

    def _waves(self, h: Array, phi: Array) -> Array:
        return np.asarray(np.real(h @ np.exp(1j * np.outer(self.orders, phi - self.angles.start))))

    def _outline_harmonics(self, radius: Array) -> Array:
        contact = self.base.at(radius)
        response, k = self._responses(radius)
        d1, back = contact.plain.depth_slope[:, None], contact.retraction[:, None]
        return np.asarray(-response * self.harmonics / (1 + back * k / d1))

    def _corrected(self, radius: Array) -> Array:
        """Depth, force and logarithm of the area, which stays positive beside poles; shape (3, n)."""
        samples = radius * np.exp(STEP * AROUND)[:, None]
        around = self._left(samples.ravel()).reshape(4, *samples.shape)
        left_slope, _ = central_derivatives(around[0])
        weak_slope, _ = central_derivatives(around[2])
        slope_by_depth, stiffened = around[1::2, AROUND == 0][:, 0]
        contact = self.base.at(radius)
        plain, back = contact.plain, contact.retraction
        growth, _ = stiffness_growth(self.kernel, plain)
        response, _ = self._responses(radius)
        half_square = np.sum(np.abs(self.harmonics) ** 2) / 4
        squares = plain.depth_slope**2 * (response**2 @ np.abs(self.harmonics) ** 2)
        # notation as in the module's text
        n = growth / 4 * squares + back * growth * plain.depth * half_square - left_slope
        v = (plain.stiffness * plain.depth - plain.force) * half_square
        q, kd = growth * back, plain.stiffness * contact.depth_slope
        delta = n * q / (q**2 + kd**2)
        rest = n * plain.stiffness * kd / (q**2 + kd**2)
        weak = (growth * plain.depth * half_square - weak_slope + 2 * stiffened) / (growth * plain.depth_slope)
        without = self.plain.evaluate(radius)
        x2 = without.terms[:, 0]
        force = contact.force - v + plain.stiffness * delta + rest + plain.force * (np.expm1(x2) - x2)
        # where the outline is unstable, which results are marked for, these terms have poles
        shrinkage = np.clip((rest + slope_by_depth) / q - weak, -1.0, 1.0)
        return np.stack([contact.depth + delta, force, np.log(without.area) - 2 * shrinkage])

    def _left(self, radius: Array) -> Array:
        """Y, its derivative by the depth at constant radius, and T and T_k, shape (4, n)."""
        contact = self.base.at(radius)
        growth, _ = stiffness_growth(self.kernel, contact.plain)
        response, k = self._responses(radius)
        d1, back = contact.plain.depth_slope[:, None], contact.retraction[:, None]
        squares = growth[:, None] / 4 * (d1 * response) ** 2 * np.abs(self.harmonics) ** 2
        lift = d1 + back * k
        # dD/dd = -1
        by_depth = -np.sum(squares * d1 / lift**2, axis=1)
        weak = np.sum(squares / d1, axis=1), np.sum(squares * k / d1, axis=1)
        return np.stack([np.sum(squares * back / lift, axis=1), by_depth, *weak])

    def _responses(self, radius: Array) -> tuple[Array, Array]:
        """R_m and k_m at radii, shape (n, orders) each."""
        beta = radius / self.kernel.length
        # a power-law half-space looks the same at every radius, as a homogeneous one does
        alike = self.kernel.homogeneous or self.kernel.exponent != 0
        live = (beta > SMALLEST) & (not alike)
        values = np.empty((radius.size, 2 * self.orders.size))
        if not live.all():
            values[~live] = self._answers(np.zeros(1))
        if live.any():
            values[live] = self._panels.at(np.log(beta[live]))
        return values[:, : self.orders.size], values[:, self.orders.size :]

    def _answers(self, beta: Array) -> Array:
        """R_m and k_m side by side, sampled on panels of ln(beta); in closed form on power-law half-spaces."""
        if self.kernel.exponent:
            punch = power_law_punch(self.kernel)
            response = [punch.outline_response(self.profile.exponent, int(m)) for m in self.orders]
            return np.array([response + [punch.stiffening(int(m)) for m in self.orders]])
        edges = solve_edges(self.kernel, beta, self.orders) if beta.all() else Edges.half_space(beta.size)
        unit = PowerProfile(self.profile.exponent, 1.0)
        responses = punch_family(self.kernel).at(beta)
        moments = unit.moments(np.ones(beta.size), responses.flat.shape[1])
        strength = edge_strength(responses)
        depth = (moments.edge + np.sum(moments.b * responses.edge, axis=1)) / strength
        tangent = -moments.edge_slope + np.sum(moments.b * responses.slope, axis=1)
        d1 = (depth * responses.slope[:, 0] - tangent) / strength
        response = edges.power_edge(self.profile.exponent, self.orders) / (strength * d1)[:, None]
        return np.hstack([response, edges.stiffening(self.orders)])
