"""First event under a growing round contact: grids in the plane of sliding that follow the contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel, compliance
from flatpunch.contact.curve import Control
from flatpunch.contact.round.cylinder import punch_stiffness
from flatpunch.contact.round.mean_profile import mean_contact, mean_profile, resolved_radius
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.fields.axisymmetric.contact_load import contact_load
from flatpunch.fields.axisymmetric.layered import REACH
from flatpunch.fields.axisymmetric.ring_sources import RingSources
from flatpunch.fields.axisymmetric.section import Section
from flatpunch.fields.failure.events import DEEPEST, Event, Judged, expected_utilisation
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace, Medium

_RADII = np.array([0.0, 0.2, 0.4, 0.6, 0.75, 0.86, 0.94, 1.0, 1.06, 1.16, 1.35, 1.7, 2.2, 3.0])
"""Radii of the grid over the contact radius; between them the largest value is refined."""

_COARSE = 14.0
"""Where integrals over the layers' response end during the search: 1e-4. The load at the place found is exact."""

_ROUNDS, _FINER = 3, 3.0
"""Rounds of refinement of a place, each finer by this factor; a parabola follows."""

RANGE = 1e6
"""Ratio of sizes over which the first event is searched, on either side of the start."""


@dataclass(frozen=True, slots=True)
class RoundSearch:
    """Round contacts by their radius, and flat ends, whose radius is given, by their depth.

    Attributes
    ----------
    bodies : tuple of Judged
        The bodies.
    kernel : Kernel
        Compliance of both.
    indenter : Indenter
        Round.
    friction : float
        Coefficient of friction.
    deepest : float
        Depth that no tip can reach [m]: the thickness of layers on rigid bases, infinite for all other bodies.
    """

    bodies: tuple[Judged, ...]
    kernel: Kernel
    indenter: Indenter
    friction: float
    deepest: float
    sections: dict[tuple[object, ...], Section] = field(default_factory=dict)

    @property
    def flat(self) -> bool:
        """Whether the tip has a flat end, so that the contact does not grow."""
        return isinstance(self.indenter, Cylinder)

    def contact(self, size: float) -> tuple[float, float, float]:
        """Force [N], depth [m] and radius [m] at a size."""
        if isinstance(self.indenter, Cylinder):
            radius = self.indenter.radius
            return float(punch_stiffness(self.kernel, np.array([radius]))[0]) * size, size, radius
        found = round_contact(self.kernel, mean_profile(self.indenter), np.array([size]))
        return float(found.force[0]), float(found.depth[0]), size

    def limits(self) -> tuple[float, float, float]:
        """Smallest size, start and largest size [m]."""
        if self.flat:
            force, _, radius = self.contact(1.0)
            each = expected_utilisation(self.bodies, np.array([radius]), np.array([force / (np.pi * radius**2)]))
            start = float(1 / each[0])
            start = min(start, self.deepest)
            return start / RANGE, start, min(start * RANGE, self.deepest)
        return radius_limits(self.bodies, self.kernel, self.indenter, self.deepest)

    def _load(self, size: float) -> RingSources:
        _, depth, radius = self.contact(size) if self.flat else (0.0, 0.0, size)
        return contact_load(self.kernel, self.indenter, radius, depth, edge=self.flat)

    def events(self, size: float) -> list[Event]:
        """Largest utilisation of every kind in every layer, on the grid."""
        load = self._load(size)
        radius = load.radius
        x = self._radii(radius)
        found = []
        for n, each in enumerate(self.bodies):
            if not each.watched:
                continue
            largest = 2.0 ** np.ceil(np.log2(radius) - 1e-9)
            depths = [each.depths(i, largest) for i in each.watched]
            layer = np.repeat(each.watched, [z.size for z in depths])
            extent = 4 * largest + (float(np.abs(x).max()) - 3 * radius) * largest / radius
            key = n, largest
            if key not in self.sections:
                self.sections[key] = Section.of(
                    each.body,
                    np.concatenate(depths),
                    layer,
                    (largest / 2, largest),
                    extent,
                    shear=self.friction > 0,
                    reach=_COARSE,
                )
            stress = self.sections[key].stress(load, x, self._traction(each))
            for i in each.watched:
                here = layer == i
                found += _largest(each, i, stress[..., here], x, self.sections[key].depth[here])
            found += each.singular(self.indenter, radius)
        return found

    def _traction(self, judged: Judged) -> float:
        # on the upper body the friction of the lower one acts backwards
        return -self.friction if judged.upper else self.friction

    def _radii(self, radius: float) -> Array:
        """Places along the plane of sliding: in units of the radius, and out to where stiff films bend."""
        far = max(_bending(each.body) for each in self.bodies)
        outer = np.geomspace(3 * radius, 3 * radius + 4 * far, 6)[1:] if far > 0 else np.zeros(0)
        right = np.concatenate([_RADII * radius, outer])
        return np.concatenate([-right[:0:-1], right]) if self.friction else right

    def _judged(self, event: Event) -> Judged:
        return next(each for each in self.bodies if each.name == event.body)

    def refined(self, event: Event, size: float) -> Event:
        """The same event, its place refined on ever finer grids of five by five, and by parabolas."""
        load, judged = self._load(size), self._judged(event)
        radius, i = load.radius, event.layer
        top, bottom = np.append(judged.tops, np.inf)[i : i + 2]
        x, _, z = event.place
        z = abs(z)
        wide = max(0.2 * radius, 0.3 * abs(x))
        face = event.kind.startswith("interface")
        deep = 0.0 if face else 0.15 * min(float(bottom - top), DEEPEST * max(radius, float(top) / 2))

        def tried(xs: Array, zs: Array) -> tuple[Event, Array]:
            section = self._section_at(judged, i, zs, radius, float(np.abs(xs).max()), _COARSE)
            stress = section.stress(load, xs, self._traction(judged))
            (found,) = [e for e in _largest(judged, i, stress, xs, zs) if e.kind == event.kind]
            return found, _ratio(judged, event, stress)

        best = event
        for _ in range(_ROUNDS):
            xs = x + wide * np.linspace(-1, 1, 5)
            xs = xs if self.friction else np.unique(np.abs(xs))
            zs = np.unique(np.clip(z + deep * np.linspace(-1, 1, 5), top, bottom))
            found, ratios = tried(xs, zs)
            best = max(best, found, key=lambda each: each.utilisation)
            x, z = best.place[0], abs(best.place[2])
            peak = _vertex(xs, ratios.max(axis=1)), _vertex(zs, ratios.max(axis=0))
            wide, deep = wide / _FINER, deep / _FINER
        found, _ = tried(np.array([peak[0]]), np.array([peak[1]]))
        return max(best, found, key=lambda each: each.utilisation)

    def _section_at(self, judged: Judged, i: int, z: Array, radius: float, farthest: float, reach: float) -> Section:
        return Section.of(
            judged.body,
            z,
            np.full(z.size, i),
            (radius / 2, 2 * radius),
            2 * (radius + farthest),
            shear=self.friction > 0,
            reach=reach,
        )

    def error(self, event: Event, size: float) -> float:
        """Estimated relative error of the stress."""
        graded = self.kernel.graded or self.kernel.exponent
        return 1e-4 if graded else 1e-8

    def follower(self, event: Event, size: float) -> Callable[[float], Event]:
        """The same event at the place that it has moved to in a contact of another size."""
        judged, i = self._judged(event), event.layer
        radius = self._load(size).radius
        x, _, z = event.place
        layered = isinstance(judged.body, Medium) and bool(judged.body.layers)
        fixed = self._section_at(judged, i, np.array([abs(z)]), radius, abs(x), REACH) if layered else None

        def followed(other: float) -> Event:
            load = self._load(other)
            growth = load.radius / radius
            place = np.array([x * growth]), np.array([abs(z) if layered else abs(z) * growth])
            section = fixed or self._section_at(judged, i, place[1], load.radius, abs(float(place[0][0])), REACH)
            stress = section.stress(load, place[0], self._traction(judged))
            (found,) = [e for e in _largest(judged, i, stress, *place) if e.kind == event.kind]
            return found

        return followed


def radius_limits(
    bodies: tuple[Judged, ...], kernel: Kernel, indenter: Indenter, deepest: float
) -> tuple[float, float, float]:
    """Smallest radius, one at which a strength may be reached, from the mean pressure on a half-space, and the largest [m]."""
    high = float(min(indenter.reach * 0.98, resolved_radius(kernel)))
    if deepest < np.inf:
        try:
            (radius,) = mean_contact(kernel, indenter, Control("depth", np.array([deepest])))[1].radius
            high = min(high, float(radius))
        except ValueError:
            # the tip ends, or the layers are no longer resolved, before the contact is that deep
            pass
    half_space = compliance(HalfSpace(kernel.modulus, 0.0))
    radius = np.geomspace(1e-12, min(1e3, indenter.reach * 0.98), 200)
    contact = round_contact(half_space, mean_profile(indenter), radius)
    mean = contact.force / (np.pi * radius**2)
    reached = expected_utilisation(bodies, radius, mean) >= 1
    start = float(radius[np.argmax(reached) if reached.any() else -1])
    start = float(np.clip(start, 0.0, high))
    return start / RANGE, start, min(high, start * RANGE)


def _bending(body: object) -> float:
    """Distance over which the layers bend on what is below [m]: the thickness times the cube root of the contrast."""
    if not isinstance(body, Medium) or not body.layers:
        return 0.0
    moduli = [layer.surface_modulus for layer in body.layers]
    if isinstance(body.base, HalfSpace):
        moduli.append(body.base.surface_modulus)
    return float(body.thickness * ((max(moduli) / min(moduli)) ** (1 / 3) - 1))


def _largest(judged: Judged, i: int, stress: Array, x: Array, z: Array) -> list[Event]:
    """Largest utilisation of each kind in a layer; stress of shape (6, nx, nz)."""
    across, down = np.meshgrid(x, z, indexing="ij")
    return judged.largest(i, stress.reshape(6, -1), np.stack([across, np.zeros_like(across), down]).reshape(3, -1))


def _ratio(judged: Judged, event: Event, stress: Array) -> Array:
    """Stress over strength of one kind, shape (nx, nz)."""
    strength = judged.strengths[event.layer]
    whole = stress.copy()
    whole[:2] += judged.residual[event.layer]
    kinds = dict(
        strength.interface_utilisation(whole) if event.kind.startswith("interface") else strength.utilisation(whole)
    )
    return kinds[event.kind]


def _vertex(x: Array, y: Array) -> float:
    """Place of the largest value: of the parabola through it and its neighbours, where it has two."""
    i = int(np.argmax(y))
    if not 0 < i < x.size - 1:
        return float(x[i])
    left, right = x[i - 1] - x[i], x[i + 1] - x[i]
    down, up = y[i - 1] - y[i], y[i + 1] - y[i]
    curvature = down * right - up * left
    if curvature == 0:
        return float(x[i])
    return float(x[i] + np.clip((down * right**2 - up * left**2) / (2 * curvature), left, right))
