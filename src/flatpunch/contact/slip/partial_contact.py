"""Partial slip of round contacts after Cattaneo and Mindlin, on any layered or graded body (theory page 18).

Under the force F and then T along x a contact of radius a sticks within r < c and slips outside, where the traction is mu p. It
is tau = mu (p - p'), and p' = 0 beyond c. Where it sticks, the displacement along x is constant. In the mean over the directions
that is a normal contact of radius c, of the compliance C_T/rho (`flatpunch.compliances.tangential`), without a singularity at its
edge, under the tip

    f(r) + V(0) - V(r),      V = H_0[(C_T/rho - C) p^],

so that with its depth d', force F' and stiffness K' at the radius c

    T = mu (F - F'),      delta = mu rho (d + V(0) - d'),      dT/ddelta = K'/rho.

On half-spaces V = 0, and p' is the pressure of the same tip (Ciavarella 1998; Jaeger 1998). What is neglected is the part
u_2(r) cos 2 phi of the displacement, in the stick zone and, on half-spaces too, in the direction of slip.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.checks import ROUNDING, Array, Values
from flatpunch.compliances import Kernel
from flatpunch.compliances.tangential import TangentialResponse
from flatpunch.contact.round.carried import RoundPressure, on_moved_surface, round_pressures
from flatpunch.contact.round.profile import RoundProfile
from flatpunch.contact.round.round_contact import RoundContact, round_contact
from flatpunch.numerics.chebyshev import nodal_transform, unit_nodes
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.family import punch_family

_CHECKED = 64
"""Stick radii at which it is checked that slip spreads inwards."""

_PLACES = 16
"""Radii of a stick zone at which u_2 is computed: it is smooth, and largest at the edge or some way inside."""


@dataclass(frozen=True)
class PartialContact:
    """One normal contact, with all of its stick radii; mu = 1, lengths along the surface over rho.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium under pressure.
    tangential : TangentialResponse
        The same under tractions along the surface.
    profile : RoundProfile
        The tip.
    contact : RoundContact
        The normal contact, one radius > 0.
    raised : RoundProfile, optional
        In the place of the tip on the surface that V moves.
    """

    kernel: Kernel
    tangential: TangentialResponse
    profile: RoundProfile
    contact: RoundContact
    raised: RoundProfile | None = None

    @property
    def radius(self) -> float:
        """Contact radius a [m]."""
        return float(self.contact.radius[0])

    @property
    def force(self) -> float:
        """Normal force F [N]."""
        return float(self.contact.force[0])

    @cached_property
    def _pressure(self) -> RoundPressure | None:
        """The pressure, where C_T is not in proportion to C."""
        return None if self.alike else round_pressures(self.kernel, self.contact)[0]

    @property
    def alike(self) -> bool:
        """Whether the compliances are in proportion at all waves: on half-spaces."""
        return self.kernel.homogeneous or self.kernel.exponent != 0

    def moved(self, r: Array, farthest: float = 1.0) -> Array:
        """V(r) [m], shape (n,)."""
        if self._pressure is None:
            return np.zeros_like(r)
        mean, own = self.tangential.kernel, self.kernel
        wider = RoundPressure(mean if mean.cutoff > own.cutoff else own, self.radius, self._pressure.series)
        return wider.displacement(lambda kappa: mean.remainder(kappa) - own.remainder(kappa), r, farthest=farthest)

    @cached_property
    def sliding(self) -> float:
        """Displacement at which the whole contact slides, delta/(mu rho) [m]."""
        return float(self.contact.depth[0] + self.moved(np.zeros(1))[0])

    @cached_property
    def _tip(self) -> RoundProfile:
        if self.raised is not None:
            return self.raised
        return self.profile if self.alike else on_moved_surface(self.profile, self.moved, self.radius)

    def sticking(self, radius: Array) -> RoundContact:
        """The contacts p' of stick radii 0 <= c <= a, shape (n,)."""
        return round_contact(self.tangential.kernel, self._tip, radius)

    @cached_property
    def turning(self) -> float:
        """Largest stick radius at which less sticks under a smaller displacement [m]; 0 where slip spreads from the rim."""
        radius = self.radius * np.arange(1, _CHECKED + 1) / _CHECKED
        return float(np.max(radius, where=self.sticking(radius).depth_slope < 0, initial=0.0))

    def stick_radius(self, quantity: str, target: Array) -> Array:
        """Stick radii at which T/mu or delta/(mu rho) has values >= 0, shape (n,); 0 where the contact slides."""
        from scipy.optimize import elementwise

        def held(radius: Array) -> Array:
            found = self.sticking(radius)
            return self.force - found.force if quantity == "tangential_force" else self.sliding - found.depth

        ends = held(np.array([0.0, self.radius]))
        # next to an end both values of the bracket could have one sign, by rounding
        near = ROUNDING * ends[0]
        inside = (target < ends[0] - near) & (target > ends[1] + near)
        radius = np.where(target < ends[0] - near, self.radius, 0.0)
        if inside.any():
            bracket = (np.zeros(inside.sum()), np.full(inside.sum(), self.radius))
            solved = elementwise.find_root(lambda c, wanted: held(c) - wanted, bracket, args=(target[inside],))
            radius[inside] = solved.x
        return radius

    def work(self, radius: Array) -> Array:
        """int T ddelta/(mu^2 rho) from stick to the stick radii, shape (n,) [J]."""
        rings = [ring for ring in self.contact.rings if ring < self.radius]
        cuts = np.unique(np.concatenate([radius, rings, [self.radius]]))
        x, weights = gauss(24)
        share = (1 + x) / 2
        # beyond a ring the depth is a series in the root of the distance
        parts = [low + (high - low) * share**2 for low, high in pairwise(cuts)]
        steps = [(high - low) * share * weights for low, high in pairwise(cuts)]
        each = np.zeros(0)
        if parts:
            found = self.sticking(np.concatenate(parts))
            rate = (self.force - found.force) * found.depth_slope / found.radius
            each = (rate * np.concatenate(steps)).reshape(-1, x.size).sum(axis=1)
        above = np.concatenate([np.cumsum(each[::-1])[::-1], [0.0]])
        return np.asarray(above[np.searchsorted(cuts, radius)])

    @cached_property
    def turn(self) -> float:
        """Largest angle between slip and force where the whole contact slides, |u_2| over the slip.

        r^2 u_2 = -int s^2 u_0'(s) ds under every compliance, and u_0 is the sliding displacement less the tip on the moved
        surface, which is the slip.
        """
        x, weights = gauss(_PLACES)
        r = self.radius * np.arange(1, _PLACES + 1) / _PLACES
        s = r[:, None] * (1 + x) / 2
        second = self.tangential.turned * (s**2 * self._tip.slope(s)) @ weights / (2 * r)
        if self._pressure is not None:
            second = second + self._lateral.displacement(self.tangential.doubled, r, 2)
        slip = self._tip.height(r)
        # where slip does not spread from the rim the whole traction may turn
        return float(np.divide(np.abs(second), slip, out=np.full_like(r, 2.0), where=slip > 0).max().clip(max=2.0))

    @property
    def lost(self) -> float:
        """Largest share of the traction lost along the force: the mean of 1 - cos(angle sin 2 phi), at most angle^2/4.

        Next to a stick zone the angle reaches `turned` on half-spaces, its bound.
        """
        return max(self.turn, abs(self.tangential.turned)) ** 2 / 4

    def _ring(self, radius: Values) -> Array:
        """Share of the force that the ring outside carries with little slip, under a traction like that of a flat punch."""
        return np.sqrt(1 - (np.asarray(radius) / self.radius) ** 2)

    @cached_property
    def _lateral(self) -> RoundPressure:
        """The pressure, with the wavenumbers of the tangential kernel."""
        assert self._pressure is not None
        return replace(self._pressure, kernel=self.tangential.kernel)

    def error(self, radius: Array) -> Array:
        """Estimated relative error of force and stiffness at given displacement, at stick radii of shape (n,).

        It is the largest |u_2| in the stick zone over the displacement, with the error of V, and what the ring that slips loses.
        """
        result = self.turn**2 / 4 * self._ring(radius)
        live = np.flatnonzero(radius > 0)
        if self._pressure is None or not live.size:
            return result
        part = 0.5 if self.kernel.graded else 1.0
        unsure = float(np.abs(self.moved(np.zeros(1), part) - self.moved(np.zeros(1)))[0])
        unsure += punch_family(self.tangential.kernel).error(radius[live] / self.kernel.length)[0] * self.sliding
        places = np.arange(1, _PLACES + 1) / _PLACES
        for i in live:
            across, moved = self._across(radius[i])
            result[i] += np.abs(across(radius[i] * places)).max() + unsure / max(
                moved, np.sqrt(ROUNDING) * self.sliding
            )
        return result

    def _across(self, radius: float) -> tuple[Callable[[Array], Array], float]:
        """u_2 in the stick zone over the displacement, r -> (n,), and the displacement, at a stick radius."""
        doubled = self.tangential.doubled
        if radius == 0:
            return lambda r: self._lateral.displacement(doubled, r, 2) / self.sliding, self.sliding
        found = self.sticking(np.array([radius]))
        own, moved = round_pressures(self.tangential.kernel, found)[0], self.sliding - float(found.depth[0])
        if moved < np.sqrt(ROUNDING) * self.sliding:
            # with little slip the traction is that of a flat punch, and the difference below loses digits
            flat = replace(own, series=found.responses.flat[0])
            return lambda r: flat.displacement(doubled, r, 2), moved
        return lambda r: (self._lateral.displacement(doubled, r, 2) - own.displacement(doubled, r, 2)) / moved, moved

    def disturbed(self, radius: float, displacement: float, error: float) -> list[list[tuple[PartialContact, float]]]:
        """Pairs of contacts that bound this one, one way and the other, and their stick radii.

        In the first the displacement delta/(mu rho) is off by the relative `error`, and by the share turned turn/2 by which a
        traction of that angle moves the axis along the force. In the second u_2 cos 2 phi acts as if it were round.
        """
        share = error + abs(self.tangential.turned) * self.turn / 2 * self._ring(radius)
        nearby = displacement * np.array([1 - share, 1 + share])
        pairs = [[(self, float(c)) for c in self.stick_radius("displacement", nearby)]]
        if self.alike:
            return pairs
        across, moved = self._across(radius)
        series = moved * nodal_transform(_PLACES) @ across(self.radius * np.sqrt((1 + unit_nodes(_PLACES)) / 2))

        def other(sign: float) -> tuple[PartialContact, float]:
            def further(r: Array) -> Array:
                return np.asarray(sign * chebyshev.chebval(2 * (r / self.radius) ** 2 - 1, series))

            contact = replace(self, raised=on_moved_surface(self._tip, further, self.radius))
            return contact, float(contact.stick_radius("displacement", np.array([displacement]))[0])

        return [*pairs, [other(-1.0), other(1.0)]]
