"""Equilibria under an adhesive stress of finite range after Maugis (1992) and Dugdale, exact on every medium (T11.4).

The stress s0 = w/z0 acts across gaps up to the range of action z0, outside the contact of radius a and out to the radius c at
which the gap is z0. With d_n, F_n and K of the contact without adhesion and of the flat punch, and `CohesiveZone` for the rest,

    d = d_n(a) - s0 D_c(a),      F = F_n(a) - s0 int_a^c K q_c db,      z0 = int_a^c (d_n' + s0 q_c) (1 - U_b(c)) db.

The last has one root a < c, or none, where c is so small that the surfaces do not touch: then a = 0 and the depth is less by what
z0 exceeds the integral. The branch is thus a function of c, from c = 0 at d = -z0, F = 0. Where the surfaces first touch it has a
kink, beyond which it is a series in the root of the distance. z0 -> 0 is JKR; the rigid limit is Bradley's.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, Array, BadValue, Indices
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.contact.adhesion.branch import AdhesiveContact, Branch, stiffness_growth
from flatpunch.contact.adhesion.cohesive_zone import CohesiveZone, cohesive_zone, tolerance
from flatpunch.contact.adhesion.stability import largest_radius
from flatpunch.contact.round.profile import RoundProfile
from flatpunch.contact.round.round_contact import RoundContact, round_contact
from flatpunch.contact.round.superposition import grown_pressure, punch_pressure
from flatpunch.numerics.chebyshev import NODES, tail
from flatpunch.numerics.gauss import gauss
from flatpunch.numerics.piecewise import PiecewiseChebyshev, log_table

_LEAST = 1e-12
"""Contact radius over c that is taken as none."""

_ANGLE = 0.1
"""Least range of angles of series: rounding leaves 1e-12 of 1 - U_b there, a hundred times as much with a hundredth. On graded
surfaces, where more is left than rounding, it is the whole."""

_NARROWEST = 1e-6
"""Pieces as narrow in ln c are not halved: beside a kink the rounding of the distance from it is left."""


@dataclass(frozen=True)
class MaugisBranch:
    """Equilibria of one medium and one round tip over the radius c within which adhesion acts; the same interface as `Branch`.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    profile : RoundProfile
        The tip.
    reach : float
        Radius at which it ends [m].
    work : float
        Work of adhesion w [J/m^2].
    range_of_action : float
        Range z0 of the adhesive stress w/z0 [m].
    refinement : int
        Terms of series over those that are enough.
    """

    kernel: Kernel
    profile: RoundProfile
    reach: float
    work: float
    range_of_action: float
    refinement: int = 1

    @property
    def stress(self) -> float:
        """s0 [Pa]."""
        return self.work / self.range_of_action

    @property
    def _least(self) -> float:
        """Least range of angles of series."""
        return np.pi / 2 if self.kernel.graded else _ANGLE

    @property
    def _end(self) -> float:
        """Largest radius that is solved [m]."""
        return largest_radius(self.kernel, self.reach)

    @cached_property
    def opening(self) -> float:
        """c at which the surfaces first touch [m]."""
        most = self._end

        def short(x: float) -> float:
            outer = np.exp(np.array([x]))
            zone = cohesive_zone(self.kernel, outer)
            return float(self._integrals(zone, np.zeros(1, int), np.full(1, np.pi / 2))[0, 0]) - self.range_of_action

        # the uniform tension lifts a half-space of the surface material by about as much, and the tip rises by less
        guess = min(self.kernel.modulus * self.range_of_action / self.stress, most)
        while self.profile.height(np.array([guess]))[0] > self.range_of_action:
            guess /= 2
        high = low = np.log(guess)
        while short(high) < 0 and high < np.log(most):
            low, high = high, min(high + np.log(10), np.log(most))
        if short(high) < 0:
            raise BadValue(
                "range_of_action",
                text(self.range_of_action, "m"),
                f"reaches across the gap at the radius {text(most, 'm')}, the largest at which this case is solved, before the "
                "surfaces touch. Take a shorter range, which is a larger strength, or give the shape further out.",
            )
        while short(low) > 0:
            low, high = low - np.log(10), low
        return float(np.exp(scipy.optimize.brentq(short, low, high)))

    @cached_property
    def _pressed(self) -> PiecewiseChebyshev:
        """Depth and force without adhesion over ln a."""

        def sample(radius: Array) -> Array:
            contact = self.evaluate(radius)
            return np.stack([contact.depth, contact.force], axis=1)

        return log_table(sample, self._end, self._rings, NODES)

    @property
    def _rings(self) -> tuple[float, ...]:
        return tuple(ring for ring in getattr(self.profile, "rings", ()) if ring < self.reach)

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """Values of c [m] beyond which the branch is a series in the root of the distance."""
        passed = self.passed(np.array(self._rings)) if self._rings else np.zeros(0)
        return tuple(sorted({self.opening, *self._rings, *passed[passed < self.reach].tolist()}))

    @cached_property
    def _table(self) -> PiecewiseChebyshev:
        """Depth from -z0 on, force and angle over ln c; pieces are halved until their series end."""
        whole = log_table(self.solved, self._end, self.kinks, 16, steepest=1e-6)
        return replace(
            whole,
            judge=lambda series: max(tail(column) for column in series.T),
            rough=lambda piece: piece.error > tolerance(self.kernel) and piece.high - piece.low > _NARROWEST,
            noise=100 * tolerance(self.kernel),
            together=False,
        )

    def evaluate(self, radius: Array) -> RoundContact:
        """Contacts without adhesion of contact radii a."""
        return round_contact(self.kernel, self.profile, radius)

    def at(self, radius: Array) -> AdhesiveContact:
        """Equilibria at c > 0, shape (n,)."""
        values, slopes = self._table.with_slope(np.log(radius))
        plain = self.evaluate(self.size(radius)[0])
        return AdhesiveContact(
            radius=radius,
            depth=values[:, 0] - self.range_of_action,
            force=values[:, 1],
            retraction=plain.depth - values[:, 0] + self.range_of_action,
            depth_slope=slopes[:, 0],
            force_slope=slopes[:, 1],
            plain=plain,
        )

    def size(self, radius: Array) -> tuple[Array, Array]:
        """Contact radius a, 0 where the surfaces do not touch, and area."""
        angle = self._table.at(np.log(radius))[:, 2]
        inner = np.where(radius > self.opening, radius * np.cos(angle), 0.0)
        return inner, np.pi * inner**2

    def passed(self, inner: Array) -> Array:
        """c of contact radii a, shape (n,), without the table, of which they are borders; infinite beyond the largest."""

        def short(x: Array, inner: Array) -> Array:
            outer = np.exp(x)
            angle = np.arccos(np.minimum(inner / outer, 1.0))
            zone = cohesive_zone(self.kernel, outer, max(self._least, float(angle.max())))
            return np.asarray(self._integrals(zone, np.arange(outer.size), angle)[0] - self.range_of_action)

        from scipy.optimize import elementwise

        most, low = np.log(self._end), np.log(inner)
        # from narrow rings on: layers that bulge beside wide ones may close the gap again
        high, width = low, ROUNDING
        while ((more := short(high, inner) < 0) & (high < most)).any():
            low, high = np.where(more, high, low), np.minimum(high + more * width, most)
            # no further than to twice the radius: wide discs cost most
            width = min(10 * width, np.log(2))
        found = np.exp(elementwise.find_root(short, (low, high), args=(inner,)).x)
        return np.asarray(np.where(more, np.inf, found))

    @property
    def base(self) -> Branch:
        """The limit of short ranges."""
        return Branch(self.kernel, self.evaluate, self.work)

    def base_radius(self, mean_radius: Array) -> Array:
        """c of contact radii a, shape (n,); infinite beyond the largest that is solved."""
        from scipy.optimize import elementwise

        def short(x: Array, inner: Array) -> Array:
            return np.asarray(self.size(np.exp(x))[0] - inner)

        most, low = np.log(self._end), np.log(np.maximum(mean_radius, self.opening))
        high = np.minimum(low + np.log(2), most)
        while ((more := short(high, mean_radius) < 0) & (high < most)).any():
            high = np.minimum(high + more * np.log(2), most)
        found = elementwise.find_root(short, (low, high), args=(mean_radius,)).x
        return np.asarray(np.where(more, np.inf, np.exp(found)))

    def lessened(self, radius: Array) -> Array:
        """What adhesion takes off depth [m] and force [N] of contacts of radii a, shape (2, n); nan beyond the largest c."""
        outer = self.base_radius(radius)
        inside = np.isfinite(outer)
        plain, (depth, force, _) = self.evaluate(radius), self._table.at(np.log(outer[inside])).T
        found = np.full((2, radius.size), np.nan)
        found[:, inside] = [plain.depth[inside] - depth + self.range_of_action, plain.force[inside] - force]
        return found

    def error(self, radius: Array) -> Array:
        """Change of the force, with that of the depth times K, by twice as many terms, no less than tails of series [N].

        And the force K D that is drawn times what series miss of the limit of narrow zones, D' K' = 2 pi c (1 - U)' by theta.
        """
        finer, coarse = replace(self, refinement=2).solved(radius), self._table.at(np.log(radius))
        change = np.abs(finer - coarse)
        plain = self.evaluate(self.size(radius)[0])
        drawn = np.abs(plain.depth + self.range_of_action - coarse[:, 0])
        least = tolerance(self.kernel) * (plain.force + plain.stiffness * drawn + np.abs(coarse[:, 1]))
        row = np.arange(radius.size)
        _, _, falling, growth, _ = cohesive_zone(self.kernel, radius, self._least).at(row, np.zeros((radius.size, 1)))
        stiffening, _ = stiffness_growth(self.kernel, self.evaluate(radius))
        missed = np.abs(growth[:, 0] * stiffening / (2 * np.pi * radius**2 * falling[:, 0]) - 1)
        moved = change[:, 0] + missed * drawn
        return np.asarray(np.maximum(change[:, 1] + plain.stiffness * moved, least))

    def pressure(self, radius: float, r: Array) -> tuple[Array, Array]:
        """Pressure at distances r from the axis at one c, and its error, shape (n,) each [Pa].

        In the contact it is that without adhesion less s0 times that of the punches of the radii from a to c; beside it -s0.
        """
        angle = float(self._table.at(np.log(np.array([radius])))[0, 2])
        inner = float(self.size(np.array([radius]))[0][0])
        pressed, error = grown_pressure(self.kernel, self.evaluate, inner, r)
        inside, drawn = r < inner, (r < radius).astype(float)
        places = np.append(r[inside], inner)
        fine, rough = (self._drawn(radius, angle, places, fewer=each) for each in (False, True))
        drawn[inside] = fine[:-1]
        missed = max(abs(float(fine[-1]) - 1), tolerance(self.kernel))
        error[inside] += self.stress * (np.abs(rough - fine) + missed * fine)[:-1]
        return pressed - self.stress * drawn, error

    def _drawn(self, outer: float, angle: float, r: Array, *, fewer: bool) -> Array:
        """int q_c p_b(r) db over the radii b from the contact to c, shape of r; 1 at the edge of the contact.

        With sin(theta) = sqrt(1 - (r/c)^2) sin(phi) the root at the edge of each punch is gone.
        """
        sine = np.sqrt((1 - r / outer) * (1 + r / outer))[:, None]
        zone = cohesive_zone(self.kernel, np.array([outer]), max(self._least, angle))
        end = np.arcsin(np.minimum(np.sin(angle) / sine, 1.0))
        t, weights = gauss(max(zone.series.shape[2], NODES))
        phi = end * (1 + t) / 2
        theta = np.arcsin(sine * np.sin(phi))
        b = outer * np.cos(theta)
        height = np.minimum(outer * sine * np.cos(phi) / b, 1.0)
        growth = zone.at(np.zeros(1, int), theta.reshape(1, -1))[3].reshape(theta.shape)
        pressed = punch_pressure(self.kernel, b.ravel(), height.ravel(), fewer=fewer).reshape(theta.shape)
        return np.asarray(self.kernel.modulus / np.pi * (growth * pressed / b * end / 2) @ weights)

    def solved(self, outer: Array) -> Array:
        """Depth from -z0 on, force and angle at c, shape (n, 3)."""
        from scipy.optimize import elementwise

        row, whole = np.arange(outer.size), np.pi / 2
        # about the angle on a half-space without the tip
        most = max(
            self._least, float(np.sqrt(self.kernel.modulus * self.range_of_action / (self.stress * outer.min())))
        )
        while True:
            angle = np.full(outer.size, min(2 * most, whole))
            zone = cohesive_zone(self.kernel, outer, angle[0], self.refinement)
            gap, most = self._integrals(zone, row, angle)[0], 2 * most
            if angle[0] == whole or (gap > self.range_of_action).all():
                break
        touching = np.flatnonzero(gap > self.range_of_action)
        if touching.size:

            def short(x: Array, at: Array) -> Array:
                return np.asarray(self._integrals(zone, at.astype(int), x)[0] - self.range_of_action)

            bracket = (np.zeros(touching.size), angle[touching])
            angle[touching] = elementwise.find_root(short, bracket, args=(touching,)).x
        _, lost = self._integrals(zone, row, angle)
        depth, force = self._without(outer * np.cos(angle))
        drawn = self.stress * zone.at(row, angle[:, None])[1][:, 0]
        return np.stack([depth - drawn + np.minimum(gap, self.range_of_action), force - lost, angle], axis=1)

    def _without(self, radius: Array) -> tuple[Array, Array]:
        """Depth and force of the contact without adhesion, shape of `radius`."""
        found = self._pressed.at(np.log(radius).ravel())
        return found[:, 0].reshape(radius.shape), found[:, 1].reshape(radius.shape)

    def _integrals(self, zone: CohesiveZone, row: Indices, angle: Array) -> Array:
        """Gap at c [m] and s0 int K q_c db [N] of contacts that end at angles of discs, shape (2, m)."""
        outer = zone.outer[row][:, None]
        rings = np.arccos(np.minimum(np.array(self._rings) / outer, 1.0))
        cuts = np.sort(np.minimum(np.c_[np.zeros_like(angle), rings, angle], angle[:, None]), axis=1)
        # from the end of each panel, beyond which the depth is a series in the root of the distance
        t, weights = gauss(max(zone.series.shape[2], NODES))
        share, width = (1 + t) / 2, np.diff(cuts, axis=1)[..., None]
        places = (cuts[:, 1:, None] - width * share**2).reshape(angle.size, -1)
        steps = (width * share * weights).reshape(angle.size, -1)
        drop, _, falling, growth, stiffness = zone.at(row, places)
        inner = outer * np.c_[np.cos(places), np.cos(angle)]
        depth, _ = self._without(np.maximum(inner, _LEAST * outer))
        bare = (depth[:, :-1] - depth[:, -1:]) * falling
        pulled = self.stress * growth
        return np.stack([np.sum((bare + drop * pulled) * steps, axis=1), np.sum(stiffness * pulled * steps, axis=1)])
