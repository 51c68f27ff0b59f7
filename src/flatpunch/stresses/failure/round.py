"""First event under a growing round contact: polar grids that follow the contact."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from flatpunch._support.checks import ROUNDING, Array
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import Control
from flatpunch.contact.exact import punch_stiffness
from flatpunch.contact.round.mean_profile import mean_contact, mean_profile, resolved_radius
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters._common import SCATTERED
from flatpunch.indenters.profile import Indenter
from flatpunch.media import HalfSpace, Stack
from flatpunch.stresses.axisymmetric.contact_load import contact_load
from flatpunch.stresses.axisymmetric.panels import REACH, SECOND_REACH, missing
from flatpunch.stresses.axisymmetric.ring_sources import RingSources
from flatpunch.stresses.axisymmetric.round_load import round_fields
from flatpunch.stresses.axisymmetric.section import Section
from flatpunch.stresses.bodies import Located
from flatpunch.stresses.failure.events import (
    BEYOND,
    FINER,
    ROUNDS,
    STEPS,
    SURE,
    Event,
    Judged,
    body_of,
    of_kind,
    outwards,
)
from flatpunch.stresses.failure.tips import infinite

_RADII = np.array([0.0, 0.2, 0.4, 0.6, 0.75, 0.86, 0.94, 1.0, 1.06, 1.16, 1.35, 1.7, 2.2, 3.0])
"""Radii of the grid over the contact radius; between them the largest value is refined."""

_RINGS = 5
"""Radii of the grid beyond these, as far as films bend, and in each octave where stresses still rise."""

_COARSE = 14.0
"""Where integrals over the layers' response end on the grid, to a per cent; at refined places they are exact."""

_ANGLES = np.linspace(0, np.pi, 5)
"""Polar angles of the grid on one side of the plane of sliding; without friction the first is enough."""

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
    sections: dict[tuple[object, ...], Section] = field(default_factory=dict, init=False)
    loads: dict[tuple[float, bool], RingSources] = field(default_factory=dict)
    known: dict[float, list[Event]] = field(default_factory=dict, init=False)

    def contact(self, size: float) -> tuple[float, float, float]:
        """Force [N], depth [m] and radius [m] at a size."""
        if self.indenter.flat:
            radius = self.indenter.reach
            return float(punch_stiffness(self.kernel, np.array([radius]))[0]) * size, size, radius
        found = round_contact(self.kernel, mean_profile(self.indenter), np.array([size]))
        return float(found.force[0]), float(found.depth[0]), size

    def limits(self) -> tuple[float, float, float]:
        """Smallest size, start and largest size [m]."""
        if self.indenter.flat:
            force, _, radius = self.contact(1.0)
            each = _expected(self.bodies, np.array([radius]), np.array([force / (np.pi * radius**2)]))
            start = float(1 / each.max())
            start = min(start, self.deepest)
            return start / RANGE, start, min(start * RANGE, self.deepest)
        return radius_limits(self.bodies, self.kernel, self.indenter, self.deepest)

    def turns(self, low: float, high: float) -> list[float]:
        """Sizes just beyond the rings of the tip, and between them."""
        rings = np.array(sorted(ring for ring in self.indenter.rings if low < ring < high)) * (1 + BEYOND)
        return sorted([*rings.tolist(), *((rings[1:] + rings[:-1]) / 2).tolist()])

    def _load(self, size: float, *, again: bool = False) -> RingSources:
        if (size, again) not in self.loads:
            _, depth, radius = self.contact(size) if self.indenter.flat else (0.0, 0.0, size)
            made = contact_load(self.kernel, self.indenter, radius, depth, edge=self.indenter.flat, again=again)
            self.loads[size, again] = made
        return self.loads[size, again]

    def singular(self, size: float) -> list[Event]:
        """Infinite stresses at a size."""
        return infinite(self.bodies, self.indenter, size, self.friction)

    def events(self, size: float) -> list[Event]:
        """Largest utilisation of every kind in every layer, on the grid."""
        if size not in self.known:
            self.known[size] = self._on_grids(size, Judged.largest)
        return self.known[size] + self.singular(size)

    def maxima(self, size: float) -> list[Event]:
        """Local maxima of every kind in every layer, on the grid; the infinite ones among them."""
        # ahead of the load, beside and behind it, which a coarse grid may not tell apart
        last = _ANGLES.size - 1
        parts = (slice(0, 1), slice(1, last), slice(last, last + 1)) if self.friction else (slice(None),)
        return self._on_grids(size, partial(Judged.maxima, parts=parts)) + self.singular(size)

    def _on_grids(self, size: float, chosen: Callable[..., list[Event]]) -> list[Event]:
        """Events on the grid, and in rings outside it of twice the radius each."""
        edge = self._radii(self._load(size))[-1]

        def on_grid(n: int) -> list[Event]:
            return [event for each, *found in self._grid(size, n) for event in chosen(each, *found)]

        return outwards(on_grid, lambda n, event: event.polar[0] >= 2**n * edge * (1 - ROUNDING))

    def _grid(self, size: float, ring: int) -> Iterator[tuple[Judged, int, Array, Array]]:
        """Bodies, layers, stresses (6, nr, ntheta, nz), and their places (3, nr, ntheta, nz), with depths for z."""
        load = self._load(size)
        radius = load.radius
        r, theta = self._radii(load), _ANGLES if self.friction else _ANGLES[:1]
        if ring:
            r = r[-1] * np.geomspace(2 ** (ring - 1), 2**ring, _RINGS)
        for n, each in enumerate(self.bodies):
            if not each.watched:
                continue
            largest = 2.0 ** np.ceil(np.log2(radius) - 1e-9)
            extent = 4 * largest + (float(r.max()) - 3 * radius) * largest / radius
            for group in _octaves(each):
                depths = [each.depths(i, largest) for i in group]
                layer = np.repeat(group, [z.size for z in depths])
                key = n, largest, group[0], ring
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
                section = self.sections[key]
                stress = section.stress(load, r, theta, self._traction(each))
                for i in group:
                    mine = layer == i
                    yield each, i, stress[..., mine], _places(r, theta, section.depth[mine])

    def _traction(self, judged: Judged) -> float:
        # on the upper body the friction of the lower one acts backwards
        return -self.friction if judged.upper else self.friction

    def _radii(self, load: RingSources) -> Array:
        """Radii in units of the contact's, at corners of the tip, and out to where stiff films bend and deep interfaces shear."""
        radius = load.radius
        # shear below a point is largest at half the depth away from its axis
        far = max(max(bending(each.body), each.deepest) for each in self.bodies)
        outer = np.geomspace(3 * radius, 3 * radius + far, _RINGS + 1)[1:] if far > 0 else np.zeros(0)
        # beside the rim stresses of thin layers change over their thickness
        thin = min(float(np.diff(each.tops).min(initial=np.inf)) for each in self.bodies) / 4
        beside = (
            thin * 2.0 ** np.arange(np.log2(np.diff(_RADII).min() * radius / thin)) if thin < np.inf else np.zeros(0)
        )
        corners = [edge.radius for edge in load.edges if edge.sharp]
        return np.concatenate(
            [np.unique([*(_RADII * radius), *(radius - beside), *(radius + beside), *corners]), outer]
        )

    def refined(self, events: Sequence[Event], size: float) -> list[Event]:
        """Return events with their places refined, one by one."""
        return [self._refined(event, size) for event in events]

    def _refined(self, event: Event, size: float) -> Event:
        """Return an event with its place refined on grids of five places along each direction, and by parabolas.

        Along each direction grids become finer once the largest value is inside, not at an end from which it may grow further.
        """
        load, judged = self._load(size), body_of(self.bodies, event)
        top, bottom = np.append(judged.tops, np.inf)[event.layer : event.layer + 2]
        # what falls off towards zero from below has its largest value at infinity: it is searched as far as the grid
        radii = self._radii(load)
        farthest, deepest = radii[-1], judged.depths(event.layer, load.radius)[-1]
        if event.utilisation > 0:
            farthest, deepest = np.inf, np.inf
        ends = np.array([[0, 0, top], [farthest, np.pi, min(bottom, deepest)]])
        at = np.array(event.polar)
        # as far as the grid is wide there, on either side
        beside = np.searchsorted(radii, at[0])
        broad = np.diff(radii)[max(beside - 1, 0) : beside + 1].max() if beside < radii.size else 0.3 * at[0]
        wide = np.array([broad, np.pi / 4, judged.interval(event, load.radius)])
        finer, highest, rising = np.zeros(3), -np.inf, True

        def tried(place: Sequence[Array]) -> tuple[Event, Array]:
            stress = self._stress(event, load, place)
            return of_kind(event.kind, judged.largest(event.layer, stress, _places(*place))), _ratio(
                judged, event, stress
            )

        while finer.min() < ROUNDS or (rising and FINER ** finer.max() * ROUNDING < 1):
            lines = at[:, None] + (wide / FINER**finer)[:, None] * STEPS
            place = [np.unique(np.clip(line, *each)) for line, each in zip(lines, ends.T, strict=True)]
            if not self.friction or at[0] == 0:
                place[1] = _ANGLES if self.friction else _ANGLES[:1]
            _, ratios = tried(place)
            index = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
            at = np.array([axis[n] for axis, n in zip(place, index, strict=True)])
            outwards = [axis.size > 1 and n in (0, axis.size - 1) for axis, n in zip(place, index, strict=True)]
            finer += ~(np.array(outwards) & (at != ends).all(axis=0) & (ratios.max() > highest))
            rising = ratios.max() > highest + SURE * abs(highest)
            highest = max(highest, ratios.max())
        along = [ratios.max(axis=tuple({0, 1, 2} - {n})) for n in range(3)]
        vertex = [np.array([_vertex(*each)]) for each in zip(place, along, strict=True)]
        return max((tried(each)[0] for each in (list(at[:, None]), vertex)), key=lambda each: each.utilisation)

    def _stress(self, event: Event, load: RingSources, place: Sequence[Array], reach: float = REACH) -> Array:
        """Stresses (6, nr, ntheta, nz) in the layer of an event on the polar grid of r, theta and z."""
        judged = body_of(self.bodies, event)
        x, y, z = (each.ravel() for each in _places(*place))
        at = Located(judged.body, np.arange(z.size), z, np.full(z.size, event.layer))
        found = round_fields(load, at, x, y, traction=self._traction(judged), reach=reach)
        return found[:6].reshape(-1, *(each.size for each in place))

    def error(self, event: Event, size: float) -> float:
        """Estimated relative error of the stress: what other panels and rules change."""
        judged, place = body_of(self.bodies, event), [np.array([each]) for each in event.polar]
        first, second = (
            _ratio(judged, event, self._stress(event, self._load(size, again=again), place, reach)).item()
            for again, reach in ((False, REACH), (True, SECOND_REACH))
        )
        more = missing(judged.body, self._load(size), place[0], place[2])
        return float(abs(second / first - 1) * more[0])

    def follower(self, event: Event, size: float) -> Callable[[float], Event]:
        """Follow an event at the place that it has moved to in a contact of another size."""
        judged, radius = body_of(self.bodies, event), self._load(size).radius
        r, theta, z = event.polar
        layered = bool(judged.body.layers)
        corner = any(abs(edge.radius / r - 1) < ROUNDING for edge in self._load(size).edges[:-1]) if r > 0 else False

        def followed(other: float) -> Event:
            load = self._load(other)
            # far below the contact places depend on the depth alone, and a corner of the tip stays where it is
            growth = load.radius / radius if not layered or z < radius else 1.0
            place = np.array([r if corner else r * growth]), np.array([theta]), np.array([z if layered else z * growth])
            stress = self._stress(event, load, place)
            return of_kind(event.kind, judged.largest(event.layer, stress, _places(*place)))

        return followed


def radius_limits(
    bodies: tuple[Judged, ...], kernel: Kernel, indenter: Indenter, deepest: float
) -> tuple[float, float, float]:
    """Smallest radius, one at which a strength may be reached, from the mean pressure on a half-space, and the largest [m]."""
    reach = indenter.reach * 0.98
    high = float(min(reach, resolved_radius(kernel)))
    if deepest < np.inf:
        try:
            (radius,) = mean_contact(kernel, indenter, Control("depth", np.array([deepest])))[1].radius
            high = min(high, float(radius))
        except ValueError:
            # the tip ends, or the layers are no longer resolved, before the contact is that deep
            pass
    half_space = compliance(HalfSpace(kernel.modulus, 0.0))
    flat = _flat_radius(indenter)
    radius = np.geomspace(max(ROUNDING, flat), min(1e3, reach), 200)
    contact = round_contact(half_space, mean_profile(indenter), radius)
    mean = contact.force / (np.pi * radius**2)
    reached = _expected(bodies, radius, mean) >= 1
    # of each criterion; sharp tips exceed some at any size
    starts = np.clip(radius[np.where(reached.any(axis=1), np.argmax(reached, axis=1), -1)], flat, high)
    # what lies deep feels nothing of contacts that are small against its depth
    last = max(float(starts.max()), *(each.deepest for each in bodies))
    lowest = float(starts.min()) / RANGE if reached.any(axis=1).all() else float(radius[0])
    return max(lowest, flat), float(starts.min()), min(high, last * RANGE)


def _expected(bodies: Sequence[Judged], radius: Array, pressure: Array) -> Array:
    """Rough largest stress over strength under mean pressures [Pa] on discs of given radii [m], shape (criteria, n).

    Where a search may start.
    """
    found = []
    for each in bodies:
        faces = np.append(each.tops[1:], np.inf)
        for strength, top, face in zip(each.strengths, each.tops, faces, strict=True):
            # notation: shares of the mean pressure, falling off with depth as on the axis of a half-space
            for value, share, depth in (
                (strength.yield_stress, 0.6, top),
                (strength.shear, 0.3, top),
                (strength.tensile, 0.2, top),
                (strength.interface_tension, 0.1, face),
                (strength.interface_shear, 0.3, face),
            ):
                if value is not None:
                    found.append(share * pressure / (1 + (depth / radius) ** 2) / value)
    return np.array(found)


def _octaves(judged: Judged) -> list[list[int]]:
    """Watched layers that share wavenumbers: the topmost, and those whose upper faces lie within an octave of depth."""
    groups: dict[int | None, list[int]] = {}
    for i in judged.watched:
        octave = int(np.frexp(judged.tops[i])[1]) if i > 0 else None
        groups.setdefault(octave, []).append(i)
    return list(groups.values())


def _flat_radius(indenter: Indenter) -> float:
    """Radius at which the contact begins [m]: just beyond the largest disc in a flat end, which is in contact as a whole."""
    rings = np.array(indenter.rings)
    height, beyond = (indenter.height(rings[:, None] * factor, SCATTERED) for factor in (1.0, 2.0))
    # zero but for rounding
    flat = rings[(height <= ROUNDING * beyond).all(axis=1)]
    return float(max(flat, default=0.0)) * (1 + 1e-6)


def bending(body: Stack) -> float:
    """Distance over which layers and membranes bend on a softer body, or on springs, about four times the length of decay [m]."""
    if not body.layers:
        return 0.0
    moduli = [layer.surface_modulus for layer in body.layers]
    above = np.cumsum([layer.thickness for layer in body.layers])
    plates = np.maximum.accumulate(moduli) * above**3 / 12
    softness = [layer.face.softness[1] for layer in body.layers]
    if not body.base.rigid:
        moduli.append(body.base.surface_modulus)
    on_body = body.thickness * ((max(moduli) / min(moduli)) ** (1 / 3) - 1)
    membranes = (layer.face.membrane.reach(min(moduli)) for layer in body.layers if layer.face.membrane)
    return 4 * max(float(on_body), float(np.max(plates * softness) ** (1 / 4)), *membranes)


def _places(r: Array, theta: Array, z: Array) -> Array:
    """Cartesian places of a polar grid, shape (3, nr, ntheta, nz)."""
    r, theta, z = np.meshgrid(r, theta, z, indexing="ij")
    return np.stack([r * np.cos(theta), r * np.sin(theta), z])


def _ratio(judged: Judged, event: Event, stress: Array) -> Array:
    """Stress over strength of one kind, shape (nr, ntheta, nz)."""
    strength = judged.strengths[event.layer]
    whole = stress.copy()
    whole[:2] += judged.residual[event.layer]
    kinds = dict(strength.interface_utilisation(whole) if event.of_face else strength.utilisation(whole))
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
