"""First event under a contact that is no disc: its pressure on cells, by boundary elements; at the rim see `rim`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import ROUNDING, Array
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, Curve
from flatpunch.contact.exact import has_ellipse, solve_ellipse
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.punch import UnresolvedLayer
from flatpunch.stresses.axisymmetric.radial import SurfacePart
from flatpunch.stresses.bodies import Located
from flatpunch.stresses.cells import Cells, KeptPlanes, fields_of_cells
from flatpunch.stresses.failure.events import (
    FINER,
    ROUNDS,
    STEPS,
    Event,
    Judged,
    body_of,
    largest_of_each,
    of_kind,
    outwards,
)
from flatpunch.stresses.failure.rim import Rim, at_ellipse
from flatpunch.stresses.failure.round import bending, radius_limits
from flatpunch.stresses.failure.tips import counted_by, infinite

_COARSE, _FINE = 48, 128
_RIM = 2 * _FINE
"""Cells along each side: while the load is searched, at the place that is found, and where that is at the rim."""

_RAYS = 720
"""Points of the rim; an eighth of them cost 6 % of the tension at the ends of contacts four times as long as wide."""

_PLACES = np.linspace(-1, 1, 27)
"""Places of the grid along x and y over its half-widths."""

_WIDER = 4
"""Width of a grid over that of the one inside it: stresses at a distance vary over that distance."""

Lines = tuple[Array, Array, Array]
"""Values of x, y and the depth whose product is a grid [m]."""


@dataclass(slots=True)
class _Place:
    """An event whose place is refined, and over which intervals and between which depths [m] that begins."""

    event: Event
    wide: Array
    limits: tuple[float, float]
    rim: Rim | None
    finer: Array = field(default_factory=lambda: np.zeros(3))

    @property
    def open(self) -> bool:
        """Whether grids are not as fine as they get."""
        return bool(self.finer.min() < ROUNDS)

    @property
    def middle(self) -> Array:
        """Place of the largest value, with its depth for z [m]."""
        x, y, z = self.event.place
        return np.array([x, y, abs(z)])

    @property
    def steps(self) -> Array:
        """Half the grid along each axis [m]."""
        return np.asarray(self.wide / FINER**self.finer)

    @property
    def lines(self) -> Lines:
        """The grid around that place."""
        x, y, z = self.middle[:, None] + self.steps[:, None] * STEPS
        return x, y, np.unique(np.clip(z, *self.limits))

    def resolved(self, stress: Array, place: Array) -> Array:
        """Stresses without those beside the rim where that is fitted."""
        return stress if self.rim is None else self.rim.away(stress, place)

    def take(self, found: list[Event]) -> None:
        """Go to the largest value of a grid."""
        middle, steps = self.middle, self.steps
        self.event = max(self.event, of_kind(self.event.kind, found), key=lambda each: each.utilisation)
        # grids become finer once the largest value is inside, not at an end from which it may grow further
        self.finer += np.abs(self.middle - middle) <= (1 - ROUNDING) * steps


@dataclass(frozen=True, slots=True)
class CellSearch:
    """Contacts by the radius that a round contact has at their depth (`equal_area`); attributes as of `RoundSearch`."""

    bodies: tuple[Judged, ...]
    kernel: Kernel
    indenter: Indenter
    friction: float
    deepest: float
    solutions: dict[tuple[float, int], bem.Solution] = field(default_factory=dict)

    def limits(self) -> tuple[float, float, float]:
        """Smallest radius, start and largest radius [m]."""
        return radius_limits(self.bodies, self.kernel, counted_by(self.indenter), self.deepest)

    def turns(self, low: float, high: float) -> list[float]:
        """None: these tips rise evenly, or have no rings about one axis."""
        return []

    def contact(self, size: float) -> tuple[float, float, float]:
        """Force [N], depth [m] and mean radius [m]."""
        if (exact := self._ellipse(size)) is not None:
            return float(exact.force[0]), float(exact.depth[0]), float(exact.radius[0])
        solution = self._solved(size, _FINE)
        return solution.force, solution.depth, solution.radius

    def _depth(self, size: float) -> Array:
        return round_contact(self.kernel, mean_profile(counted_by(self.indenter)), np.array([size])).depth

    def _ellipse(self, size: float) -> Curve | None:
        """The contact in closed form, with its half-axes along x and y; None where it has none."""
        if not has_ellipse(self.kernel, self.indenter):
            return None
        control = Control("depth", self._depth(size))
        return solve_ellipse(self.kernel, self.indenter, control, np.array([0.0, np.pi / 2]))

    def _in_closed_form(self, judged: Judged, size: float, turned: float = 0.0) -> list[Event] | None:
        """Largest stresses over strength at the rim of a contact ellipse, where a half-space has its largest tension.

        None for other bodies and tips. The points of the rim may be `turned` by a share of their distance.
        """
        exact, body = self._ellipse(size), judged.body
        if exact is None or self.kernel.exponent or body.layers or not body.base.isotropic:
            return None
        half_axes = exact.contour[0]
        peak = 3 * exact.force[0] / (2 * np.pi * half_axes.prod())
        friction = -self.friction if judged.upper else self.friction
        phi = 2 * np.pi * (np.arange(_RAYS) + turned) / _RAYS
        stress, place = at_ellipse(half_axes, friction, SurfacePart.of(body).constants[1], phi)
        found = judged.largest(0, peak * stress[..., None, None], place[..., None, None])
        return [replace(each, rim=True) for each in found]

    def _solved(self, size: float, count: int) -> bem.Solution:
        key = size, count
        if key not in self.solutions:
            depth = self._depth(size)
            try:
                (self.solutions[key],) = bem.solve(
                    self.kernel, self.indenter, grid=count, depths=depth, tolerance=1e-5, angles=_RAYS
                )
            except bem.ContactTouchesEdge as error:
                # narrow contacts along the edge of a tilted flat end
                raise UnresolvedLayer(str(error)) from None
        return self.solutions[key]

    def _cells(self, size: float, count: int) -> Cells:
        solution = self._solved(size, count)
        grid = solution.grid
        return Cells(solution.pressure, self.friction * solution.pressure, grid.spacing, grid.center).cropped

    def singular(self, size: float) -> list[Event]:
        """Infinite stresses at a size."""
        return infinite(self.bodies, self.indenter, size, self.friction)

    def events(self, size: float) -> list[Event]:
        """Largest utilisation of every kind in every layer, on the grid; the infinite ones alone where there are any."""
        return self.singular(size) or [*largest_of_each(self._found(size, Judged.largest)).values()]

    def maxima(self, size: float) -> list[Event]:
        """Local maxima of every kind in every layer, on the grid; the infinite ones among them."""
        return self._found(size, Judged.maxima) + self.singular(size)

    def _found(self, size: float, chosen: Callable[..., list[Event]]) -> list[Event]:
        cells = self._cells(size, _COARSE)
        found = []
        for each in self.bodies:
            for i in each.watched:
                inside = partial(self._with_rim, each, i, size, partial(chosen, each))
                found += self._on_grids(each, i, cells, each.tops[i], each.depths(i, size), inside)
                face = float(np.append(each.tops, 0.0)[i + 1])
                if each.strengths[i].of_interface and face > size:
                    found += self._on_grids(each, i, cells, face, np.array([face]), partial(chosen, each, i))
        return found

    def _with_rim(
        self, judged: Judged, i: int, size: float, chosen: Callable[..., list[Event]], stress: Array, place: Array
    ) -> list[Event]:
        """Events of a grid, and those at the rim, which cells do not resolve; of tension they replace what is beside it.

        Friction stretches the surface behind the rim, so that shear and von Mises stresses too may be largest there.
        """
        found = chosen(i, stress, place)
        kinds = {each.kind for each in found} & {"tensile", *(("yield", "shear") if self.friction else ())}
        if i > 0 or not kinds:
            return found
        order = [each.kind for each in found]
        kept = [each for each in found if each.kind != "tensile"]
        at_rim = self._in_closed_form(judged, size)
        if at_rim is None:
            rim = self._rim(size, _COARSE)
            if rim is None:
                return found
            kept += [each for each in chosen(i, rim.away(stress, place), place) if each.kind == "tensile"]
            at_rim = self._at_rim(judged, size, _COARSE, rim)
        kept += [each for each in at_rim if each.kind in kinds]
        return sorted(kept, key=lambda each: order.index(each.kind))

    def _rim(self, size: float, count: int, phi: float | None = None) -> Rim | None:
        """The rim of a contact, or its point at a polar angle; none on bodies whose surface has no modulus."""
        if self.kernel.exponent:
            return None
        chosen = slice(None) if phi is None else np.array([round(phi / (2 * np.pi) * _RAYS) % _RAYS])
        return Rim.of(self._solved(size, count), self.kernel.surface_length, self.friction > 0, chosen)

    def _at_rim(self, judged: Judged, size: float, count: int, rim: Rim) -> list[Event]:
        """Largest stresses over strength of each kind at the surface along the rim."""
        x, y = rim.outside.reshape(2, -1)
        at = Located(judged.body, np.arange(x.size), np.zeros(x.size), np.zeros(x.size, dtype=int), judged.upper)
        outside = fields_of_cells(self._cells(size, count), at, x, y, 0.0)[:6].reshape(
            -1, rim.place.shape[1], rim.weights.size
        )
        place = np.vstack([rim.place, np.zeros(rim.place.shape[1])])
        found = judged.largest(0, (outside @ rim.weights)[..., None, None], place[..., None, None])
        return [replace(each, rim=True) for each in found]

    def _on_grids(
        self,
        judged: Judged,
        i: int,
        cells: Cells,
        depth: float,
        z: Array,
        chosen: Callable[[Array, Array], list[Event]],
    ) -> list[Event]:
        """Events at depths z of a layer, on grids that are each `_WIDER` than the one before."""
        halves, center = _half_widths(cells, depth), np.array(cells.center)

        def on_grid(n: int) -> list[Event]:
            x, y = (middle + _PLACES * _WIDER**n * half for middle, half in zip(center, halves, strict=True))
            return chosen(*self._at(judged, i, cells, [(x, y, z)])[0])

        def at_edge(n: int, event: Event) -> bool:
            return bool((np.abs(event.place[:2] - center) >= _WIDER**n * halves * (1 - ROUNDING)).any())

        return outwards(on_grid, at_edge, math.ceil(math.log(1 + bending(judged.body) / halves.min(), _WIDER)) + 1)

    def _at(
        self, judged: Judged, i: int, cells: Cells, grids: Sequence[Lines], kept: KeptPlanes | None = None
    ) -> list[tuple[Array, Array]]:
        """Stresses in a layer on products of x, y and depths z, shape (6, nx, ny, nz) each, and places, (3, nx, ny, nz)."""
        places = [np.stack(np.meshgrid(*each, indexing="ij")) for each in grids]
        x, y, z = np.concatenate([each.reshape(3, -1) for each in places], axis=1)
        at = Located(judged.body, np.arange(z.size), z, np.full(z.size, i), judged.upper)
        stress = fields_of_cells(cells, at, x, y, 0.0, kept=kept)[:6]
        ends = np.cumsum([each[0].size for each in places])[:-1]
        parts = np.split(stress, ends, axis=1)
        return [(part.reshape(-1, *each.shape[1:]), each) for part, each in zip(parts, places, strict=True)]

    def _at_event(self, event: Event, size: float, count: int, place: Sequence[float]) -> Event:
        """The utilisation of an event's kind at a place, from `count` cells along a side."""
        judged, (x, y, z) = body_of(self.bodies, event), np.array(place)[:, None]
        (found,) = self._at(judged, event.layer, self._cells(size, count), [(x, y, z)])
        return of_kind(event.kind, judged.largest(event.layer, *found))

    def _of_rim(self, judged: Judged, size: float, phi: float | None = None) -> list[Event]:
        """Largest stresses over strength at the rim, or at its point at a polar angle; none if it has none."""
        if exact := self._in_closed_form(judged, size):
            return exact
        rim = self._rim(size, _RIM, phi)
        return self._at_rim(judged, size, _RIM, rim) if rim else []

    def refined(self, events: Sequence[Event], size: float) -> list[Event]:
        """Return events with their places refined on finer cells and grids of five places along each axis.

        All places of a layer are evaluated together, round by round, on planes that are kept.
        """
        found, places = [], []
        rims = {each.name: self._of_rim(each, size) for each in self.bodies if _any_at_rim(events, each)}
        for event in events:
            if event.rim and rims[event.body]:
                found.append(of_kind(event.kind, rims[event.body]))
            else:
                places.append(self._start(event, size))
        kept: dict[str, KeptPlanes] = {each.name: KeptPlanes() for each in self.bodies}
        for _ in range(2 * ROUNDS):
            for judged in self.bodies:
                for i in judged.watched:
                    here = [each for each in places if each.open and each.event.what[1:] == (i, judged.name)]
                    grids = [each.lines for each in here]
                    if here:
                        fields = self._at(judged, i, self._cells(size, _FINE), grids, kept[judged.name])
                        for each, (stress, place) in zip(here, fields, strict=True):
                            each.take(judged.largest(i, each.resolved(stress, place), place))
        return found + [each.event for each in places]

    def _start(self, event: Event, size: float) -> _Place:
        """Where an event is refined first: over one interval of the grid."""
        judged, i = body_of(self.bodies, event), event.layer
        top, bottom = np.append(judged.tops, np.inf)[i : i + 2]
        halves = _half_widths(self._cells(size, _FINE), float(bottom if event.of_face else top))
        wide = np.append(2 * halves / (_PLACES.size - 1), judged.interval(event, size))
        rim = self._rim(size, _FINE) if event.kind == "tensile" and i == 0 else None
        return _Place(replace(event, utilisation=-np.inf), wide, (float(top), float(bottom)), rim)

    def follower(self, event: Event, size: float) -> Callable[[float], Event]:
        """Follow an event at the place that it has moved to in a contact of another size."""
        judged = body_of(self.bodies, event)
        layered = bool(judged.body.layers)

        def followed(other: float) -> Event:
            if event.rim and (rim := self._of_rim(judged, other, _angle(event))):
                return of_kind(event.kind, rim)
            # far below the contact places depend on the depth alone
            growth = other / size if not layered or abs(event.place[2]) < size else 1.0
            x, y, z = event.place[0] * growth, event.place[1] * growth, abs(event.place[2])
            return self._at_event(event, other, _FINE, (x, y, z if layered else z * growth))

        return followed

    def error(self, event: Event, size: float) -> float:
        """Estimated relative error of the stress: twice what cells twice as wide change, and what joining cells costs."""
        judged = body_of(self.bodies, event)
        if event.rim and (between := self._in_closed_form(judged, size, turned=0.5)):
            return abs(of_kind(event.kind, between).utilisation / event.utilisation - 1)
        if event.rim and (rim := self._rim(size, _RIM // 2, _angle(event))):
            coarse = of_kind(event.kind, self._at_rim(judged, size, _RIM // 2, rim))
        else:
            coarse = self._at_event(event, size, _FINE // 2, (*event.place[:2], abs(event.place[2])))
        # relative error of stresses from cells that are joined and taken as discs away from the points
        return 2 * abs(coarse.utilisation / event.utilisation - 1) + 1e-3


def _any_at_rim(events: Sequence[Event], judged: Judged) -> bool:
    return any(each.rim and each.body == judged.name for each in events)


def _half_widths(cells: Cells, depth: float) -> Array:
    """Half the grid along x and y [m]: a third beyond the load, or far below it as wide as the fields of a point are there."""
    return np.maximum(1.3 * np.array(cells.pressure.shape[::-1]) * cells.spacing / 2, 2 * depth)


def _angle(event: Event) -> float:
    """Polar angle of a place [rad], from 0 to a full turn."""
    return float(np.arctan2(event.place[1], event.place[0]) % (2 * np.pi))
