"""First event under a contact that is no disc: its pressure on cells, by boundary elements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from flatpunch import bem
from flatpunch._support.checks import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.fields.bodies import Located
from flatpunch.fields.cells import Cells, fields_of_cells
from flatpunch.fields.failure.equal_area import counted_by
from flatpunch.fields.failure.events import DEEPEST, Event, Judged
from flatpunch.fields.failure.round import radius_limits
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Medium

_COARSE, _FINE = 48, 128
"""Cells along each side: while the load is searched, and at the place that is found."""

_PLACES = np.linspace(-1.3, 1.3, 27)
"""Places of the grid along x and y over half the length of the contact."""


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

    def contact(self, size: float) -> tuple[float, float, float]:
        """Force [N], depth [m] and mean radius [m]."""
        solution = self._solved(size, _FINE)
        return solution.force, solution.depth, solution.radius

    def _solved(self, size: float, count: int) -> bem.Solution:
        key = size, count
        if key not in self.solutions:
            depth = round_contact(self.kernel, mean_profile(counted_by(self.indenter)), np.array([size])).depth
            (self.solutions[key],) = bem.solve(self.kernel, self.indenter, grid=count, depths=depth, tolerance=1e-5)
        return self.solutions[key]

    def _cells(self, size: float, count: int) -> Cells:
        solution = self._solved(size, count)
        grid = solution.grid
        return Cells(solution.pressure, self.friction * solution.pressure, grid.spacing, grid.center).cropped

    def singular(self, size: float) -> list[Event]:
        """Infinite stresses at a size."""
        return [event for each in self.bodies for event in each.singular(self.indenter, size)]

    def events(self, size: float, only: int | None = None) -> list[Event]:
        """Largest utilisation of every kind in every layer, or in `only` one, on the grid."""
        sharp = self.singular(size)
        if sharp and only is None:
            return sharp
        cells = self._cells(size, _COARSE)
        x, y = self._across(cells)
        found = []
        for each in self.bodies:
            for i in each.watched if only is None else {only}.intersection(each.watched):
                found += self._largest(each, i, cells, x, y, each.depths(i, size))
        return found + sharp

    def maxima(self, size: float) -> list[Event]:
        """Local maxima of every kind in every layer, on the grid; the infinite ones among them."""
        cells = self._cells(size, _COARSE)
        x, y = self._across(cells)
        found = []
        for each in self.bodies:
            for i in each.watched:
                found += each.maxima(i, *self._stress(each, i, cells, x, y, each.depths(i, size)))
        return found + self.singular(size)

    def _across(self, cells: Cells) -> tuple[Array, Array]:
        """Places of the grid along x and y."""
        along = [_PLACES * n * cells.spacing / 2 for n in cells.pressure.shape[::-1]]
        return cells.center[0] + along[0], cells.center[1] + along[1]

    def _stress(self, judged: Judged, i: int, cells: Cells, x: Array, y: Array, z: Array) -> tuple[Array, Array]:
        """Stresses in a layer on the product of x, y and depths z, shape (6, nx, ny, nz), and the places, (3, nx, ny, nz)."""
        place = np.stack(np.meshgrid(x, y, z, indexing="ij"))
        flat = place.reshape(3, -1)
        at = Located(judged.body, np.arange(flat.shape[1]), flat[2], np.full(flat.shape[1], i), judged.upper)
        return fields_of_cells(cells, at, flat[0], flat[1], 0.0)[:6].reshape(6, *place.shape[1:]), place

    def _largest(self, judged: Judged, i: int, cells: Cells, x: Array, y: Array, z: Array) -> list[Event]:
        """Largest utilisation of each kind in a layer on the product of x, y and depths z."""
        return judged.largest(i, *self._stress(judged, i, cells, x, y, z))

    def _judged(self, event: Event) -> Judged:
        return next(each for each in self.bodies if each.name == event.body)

    def refined(self, event: Event, size: float) -> Event:
        """The same event, its place refined on finer cells and grids of five places along each axis."""
        cells, judged = self._cells(size, _FINE), self._judged(event)
        i, face = event.layer, event.kind.startswith("interface")
        top, bottom = np.append(judged.tops, np.inf)[i : i + 2]
        x, y, z = event.place[0], event.place[1], abs(event.place[2])
        wide = [n * cells.spacing / 12 for n in cells.pressure.shape[::-1]]
        deep = 0.0 if face else 0.15 * min(float(bottom - top), DEEPEST * max(size, float(top) / 2))
        steps, best = np.linspace(-1, 1, 5), None
        for _ in range(_ROUNDS):
            zs = np.unique(np.clip(z + deep * steps, top, bottom))
            found = self._largest(judged, i, cells, x + wide[0] * steps, y + wide[1] * steps, zs)
            (here,) = [each for each in found if each.kind == event.kind]
            best = here if best is None else max(best, here, key=lambda each: each.utilisation)
            x, y, z = best.place[0], best.place[1], abs(best.place[2])
            wide, deep = [each / _FINER for each in wide], deep / _FINER
        assert best is not None
        return best

    def follower(self, event: Event, size: float) -> Callable[[float], Event]:
        """The same event at the place that it has moved to in a contact of another size."""
        judged = self._judged(event)
        layered = isinstance(judged.body, Medium) and bool(judged.body.layers)

        def followed(other: float, count: int = _FINE) -> Event:
            growth = other / size
            x, y, z = event.place[0] * growth, event.place[1] * growth, abs(event.place[2])
            place = (np.array([each]) for each in (x, y, z if layered else z * growth))
            found = self._largest(judged, event.layer, self._cells(other, count), *place)
            (here,) = [each for each in found if each.kind == event.kind]
            return here

        return followed

    def error(self, event: Event, size: float) -> float:
        """Estimated relative error of the stress: twice what cells twice as wide change, and what joining cells costs."""
        judged = self._judged(event)
        place = (np.array([each]) for each in (event.place[0], event.place[1], abs(event.place[2])))
        found = self._largest(judged, event.layer, self._cells(size, _FINE // 2), *place)
        (coarse,) = [each for each in found if each.kind == event.kind]
        # relative error of stresses from cells that are joined and taken as discs away from the points
        return 2 * abs(coarse.utilisation / event.utilisation - 1) + 1e-3
