"""First event under a contact that is no disc: its pressure on cells, by boundary elements."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import ROUNDING, Array
from flatpunch.compliances import Kernel
from flatpunch.contact import exact
from flatpunch.contact.curve import Control, Curve
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter
from flatpunch.punch import UnresolvedLayer
from flatpunch.stresses.axisymmetric.radial import SurfacePart
from flatpunch.stresses.bodies import Located
from flatpunch.stresses.cells import Cells, fields_of_cells
from flatpunch.stresses.failure.equal_area import counted_by
from flatpunch.stresses.failure.events import DEEPEST, Event, Judged, outwards
from flatpunch.stresses.failure.rim import Rim, rim_of
from flatpunch.stresses.failure.round import bending, radius_limits

_COARSE, _FINE, _RIM = 48, 128, 256
"""Cells along each side: while the load is searched, at the place that is found, and where that is at the rim."""

_RAYS = 720
"""Points of the rim; an eighth of them cost 6 % of the tension at the ends of contacts four times as long as wide."""

_CLOSED = 1e-8
"""Relative error of the closed form at the ends of an ellipse: digits lost where the contact is nearly round."""

_NEARLY_ROUND = 1e-2
"""Eccentricity below which the tension at the ends is a series: its next term is 1e-13."""

_PLACES = np.linspace(-1, 1, 27)
"""Places of the grid along x and y over its half-widths."""

_WIDER = 4
"""Width of a grid over that of the one inside it: stresses at a distance vary over that distance."""


_ROUNDS, _FINER = 3, 3.0
"""Rounds of refinement of a place, each finer by this factor."""


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
        """The depth of a size [m], shape (1,)."""
        return round_contact(self.kernel, mean_profile(counted_by(self.indenter)), np.array([size])).depth

    def _ellipse(self, size: float) -> Curve | None:
        """The contact in closed form, with its half-axes along x and y; None where it has none."""
        if not exact.has_ellipse(self.kernel, self.indenter):
            return None
        control = Control("depth", self._depth(size))
        return exact.solve_ellipse(self.kernel, self.indenter, control, np.array([0.0, np.pi / 2]))

    def _ends(self, judged: Judged, size: float) -> list[Event] | None:
        """Largest stresses over strength at the ends of the contact ellipse, where a half-space has its largest tension.

        None for other bodies and tips, and under friction. Along the long axis, of half-axis a, the stress is
        p0 (1 - 2 nu) b/(a e^2) (artanh(e)/e - 1), and minus that across it (K. L. Johnson, Contact Mechanics, 1985, ch. 4).
        """
        exact, body = self._ellipse(size), judged.body
        if exact is None or self.friction or self.kernel.exponent or body.layers or not body.base.isotropic:
            return None
        half_axes = exact.contour[0]
        long = int(np.argmax(half_axes))
        a, b = half_axes[long], half_axes[1 - long]
        squared = max(1 - (b / a) ** 2, ROUNDING)
        # artanh(e)/e - 1 by its series where the contact is nearly round
        e = np.sqrt(squared)
        excess = squared / 3 + squared**2 / 5 if e < _NEARLY_ROUND else np.arctanh(e) / e - 1
        peak = 1.5 * exact.force[0] / (np.pi * a * b)
        stress, place = np.zeros((6, 1, 1, 1)), np.zeros((3, 1, 1, 1))
        stress[long] = peak * (1 - 2 * SurfacePart.of(body).constants[1]) * b / (a * squared) * excess
        stress[1 - long], place[long] = -stress[long], a
        return [replace(each, rim=True) for each in judged.largest(0, stress, place)]

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
        return [
            event for each in self.bodies for event in each.singular(self.indenter, size, sliding=self.friction > 0)
        ]

    def events(self, size: float, only: int | None = None) -> list[Event]:
        """Largest utilisation of every kind in every layer, or in `only` one, on the grid."""
        sharp = self.singular(size)
        if sharp and only is None:
            return sharp
        return _largest_of_each(self._found(size, only, Judged.largest)) + sharp

    def maxima(self, size: float, only: int | None = None) -> list[Event]:
        """Local maxima of every kind in every layer, on the grid; the infinite ones among them."""
        return self._found(size, only, Judged.maxima) + self.singular(size)

    def _found(self, size: float, only: int | None, chosen: Callable[..., list[Event]]) -> list[Event]:
        """Events of all layers, or of `only` one, on the grid."""
        cells = self._cells(size, _COARSE)
        found = []
        for each in self.bodies:
            for i in each.watched if only is None else {only}.intersection(each.watched):
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
        ends = self._ends(judged, size) if i == 0 and kinds else None
        if ends is not None:
            # nowhere else is the tension as large
            kept = [each for each in found if each.kind != "tensile"]
            return kept + [each for each in ends if each.kind == "tensile"]
        rim = self._rim(size, _COARSE) if i == 0 and kinds else None
        if rim is None:
            return found
        order = [each.kind for each in found]
        kept = [each for each in found if each.kind != "tensile"]
        kept += [each for each in chosen(i, _away(rim, stress, place), place) if each.kind == "tensile"]
        kept += [each for each in self._at_rim(judged, size, _COARSE, rim) if each.kind in kinds]
        return sorted(kept, key=lambda each: order.index(each.kind))

    def _rim(self, size: float, count: int, phi: float | None = None) -> Rim | None:
        """The rim of a contact, or its point at a polar angle; none on bodies whose surface has no modulus."""
        solution = self._solved(size, count)
        chosen = slice(None) if phi is None else np.array([round(phi / (2 * np.pi) * _RAYS) % _RAYS])
        return (
            rim_of(solution, self.kernel.surface_length, self.friction > 0, chosen)
            if not self.kernel.exponent
            else None
        )

    def _at_rim(self, judged: Judged, size: float, count: int, rim: Rim) -> list[Event]:
        """Largest stresses over strength of each kind at the surface along the rim."""
        x, y = rim.outside.reshape(2, -1)
        at = Located(judged.body, np.arange(x.size), np.zeros(x.size), np.zeros(x.size, dtype=int), judged.upper)
        outside = fields_of_cells(self._cells(size, count), at, x, y, 0.0)[:6].reshape(6, -1, rim.weights.size)
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
            return chosen(*self._at(judged, i, cells, x, y, z))

        def at_edge(n: int, event: Event) -> bool:
            return bool((np.abs(event.place[:2] - center) >= _WIDER**n * halves * (1 - ROUNDING)).any())

        return outwards(on_grid, at_edge, math.ceil(math.log(1 + bending(judged.body) / halves.min(), _WIDER)) + 1)

    def _at(self, judged: Judged, i: int, cells: Cells, x: Array, y: Array, z: Array) -> tuple[Array, Array]:
        """Stresses in a layer on the product of x, y and depths z, shape (6, nx, ny, nz), and the places, (3, nx, ny, nz)."""
        place = np.stack(np.meshgrid(x, y, z, indexing="ij"))
        flat = place.reshape(3, -1)
        at = Located(judged.body, np.arange(flat.shape[1]), flat[2], np.full(flat.shape[1], i), judged.upper)
        return fields_of_cells(cells, at, flat[0], flat[1], 0.0)[:6].reshape(6, *place.shape[1:]), place

    def _largest(self, judged: Judged, i: int, cells: Cells, x: Array, y: Array, z: Array) -> list[Event]:
        """Largest utilisation of each kind in a layer on the product of x, y and depths z."""
        return judged.largest(i, *self._at(judged, i, cells, x, y, z))

    def _judged(self, event: Event) -> Judged:
        return next(each for each in self.bodies if each.name == event.body)

    def refined(self, event: Event, size: float) -> Event:
        """Return an event with its place refined on finer cells and grids of five places along each axis."""
        if event.rim and (ends := self._ends(self._judged(event), size)):
            return _of_kind(event.kind, ends)
        if event.rim and (rim := self._rim(size, _RIM)):
            return _of_kind(event.kind, self._at_rim(self._judged(event), size, _RIM, rim))
        cells, judged = self._cells(size, _FINE), self._judged(event)
        i, face = event.layer, event.kind.startswith("interface")
        top, bottom = np.append(judged.tops, np.inf)[i : i + 2]
        x, y, z = event.place[0], event.place[1], abs(event.place[2])
        deep = 0.0 if face else 0.15 * min(float(bottom - top), DEEPEST * max(size, float(top) / 2))
        # one interval of the grid
        halves = _half_widths(cells, float(bottom if face else top))
        wide = np.append(2 * halves / (_PLACES.size - 1), deep)
        rim = self._rim(size, _FINE) if event.kind == "tensile" and i == 0 else None
        steps, best, finer = np.linspace(-1, 1, 5), None, np.zeros(3)
        for _ in range(2 * _ROUNDS):
            (dx, dy, dz), middle = wide / _FINER**finer, (x, y, z)
            zs = np.unique(np.clip(z + dz * steps, top, bottom))
            stress, place = self._at(judged, i, cells, x + dx * steps, y + dy * steps, zs)
            found = judged.largest(i, stress if rim is None else _away(rim, stress, place), place)
            here = _of_kind(event.kind, found)
            best = here if best is None else max(best, here, key=lambda each: each.utilisation)
            x, y, z = best.place[0], best.place[1], abs(best.place[2])
            # grids become finer once the largest value is inside, not at an end from which it may grow further
            finer += np.abs(np.subtract((x, y, z), middle)) <= 0.9 * np.array([dx, dy, dz])
            if finer.min() >= _ROUNDS:
                break
        assert best is not None
        return best

    def follower(self, event: Event, size: float) -> Callable[[float], Event]:
        """Follow an event at the place that it has moved to in a contact of another size."""
        judged = self._judged(event)
        layered = bool(judged.body.layers)

        def followed(other: float) -> Event:
            if event.rim and (ends := self._ends(judged, other)):
                return _of_kind(event.kind, ends)
            if event.rim and (rim := self._rim(other, _RIM, _angle(event))):
                return _of_kind(event.kind, self._at_rim(judged, other, _RIM, rim))
            # far below the contact places depend on the depth alone
            growth = other / size if not layered or abs(event.place[2]) < size else 1.0
            x, y, z = event.place[0] * growth, event.place[1] * growth, abs(event.place[2])
            place = (np.array([each]) for each in (x, y, z if layered else z * growth))
            found = self._largest(judged, event.layer, self._cells(other, _FINE), *place)
            return _of_kind(event.kind, found)

        return followed

    def error(self, event: Event, size: float) -> float:
        """Estimated relative error of the stress: twice what cells twice as wide change, and what joining cells costs."""
        judged = self._judged(event)
        if event.rim and self._ends(judged, size):
            return _CLOSED
        if event.rim and (rim := self._rim(size, _RIM // 2, _angle(event))):
            coarse = _of_kind(event.kind, self._at_rim(judged, size, _RIM // 2, rim))
        else:
            place = (np.array([each]) for each in (event.place[0], event.place[1], abs(event.place[2])))
            found = self._largest(judged, event.layer, self._cells(size, _FINE // 2), *place)
            coarse = _of_kind(event.kind, found)
        # relative error of stresses from cells that are joined and taken as discs away from the points
        return 2 * abs(coarse.utilisation / event.utilisation - 1) + 1e-3


def _half_widths(cells: Cells, depth: float) -> Array:
    """Half the grid along x and y [m]: a third beyond the load, or far below it as wide as the fields of a point are there."""
    return np.maximum(1.3 * np.array(cells.pressure.shape[::-1]) * cells.spacing / 2, 2 * depth)


def _away(rim: Rim, stress: Array, place: Array) -> Array:
    """Stresses without those that cells do not resolve beside the rim."""
    return np.where(rim.beside(place), 0.0, stress)


def _angle(event: Event) -> float:
    """Polar angle of a place [rad], from 0 to a full turn."""
    return float(np.arctan2(event.place[1], event.place[0]) % (2 * np.pi))


def _of_kind(kind: str, events: list[Event]) -> Event:
    """The one event of a kind."""
    (found,) = [each for each in events if each.kind == kind]
    return found


def _largest_of_each(events: list[Event]) -> list[Event]:
    """The largest of each kind in each layer."""
    best: dict[tuple[str, int, str], Event] = {}
    for each in events:
        if each.what not in best or each.utilisation > best[each.what].utilisation:
            best[each.what] = each
    return list(best.values())
