"""Fields under a pressure on square cells: any contact solved by boundary elements, measured footprints.

On planes of constant depth the fields are convolutions of the cells with the fields of one of them (FFT on a doubled grid, so no
periodic images): its half-space part in closed form (`one_cell`; of a disc of the same area where the surface is transversely
isotropic), what layers add from such a disc, since that part is smooth. Fields at a distance s, in depth or sideways, are smooth
over lengths like s; so points are sorted by octaves of s, cells are joined until they are as wide as s/12, and where there are
many depths, planes are taken at Chebyshev nodes. More than twelve widths away, nine discs with the moments of the load
take its place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch.compliances.stack import interfaces
from flatpunch.stresses.axisymmetric.panels import at_nodes, nodes_or_points
from flatpunch.stresses.axisymmetric.radial import COMPONENTS, SurfacePart, surface_part
from flatpunch.stresses.axisymmetric.round_load import round_fields
from flatpunch.stresses.axisymmetric.uniform_disc import UniformDisc
from flatpunch.stresses.bodies import Located
from flatpunch.stresses.one_cell import kernels
from flatpunch.stresses.uniform_cells import Rule, convolved, fields_of_squares

_FINE = Rule(cells=12, cut=1, window=6, across=4, down=8)
"""How finely fields are evaluated, which leaves about 1e-6 of the pressure."""

_COARSE, _CHECK = replace(_FINE, cells=6), Rule(cells=20, cut=2, window=80, across=5, down=10)
"""The rule for cells twice as wide, and a finer one, whose difference to the first is the error under uniform squares."""

_EXACT = 64
"""Points at which that is found: squares up to a window of 80 are summed one by one."""

_TRIED = 1500
"""Points at which fields are calculated again on cells twice as wide, at most."""

_RIM = 16
"""Cells around the points on a plane: the end of a spline of order five changes it by .43 to this power inside."""

_FINEST, _MOST = 64**2, 512**2
"""Cells into which those of a prescribed pressure are cut, at most: where the surface has no closed form for squares, and for
what layers add."""


def _moments(low: float, high: float) -> list[float]:
    """Moments 0 to 4 of a uniform load of unit force on an interval."""
    return [(high ** (n + 1) - low ** (n + 1)) / ((n + 1) * (high - low)) for n in range(5)]


_SHARED = np.linalg.solve(
    np.transpose([_moments(offset - 0.5, offset + 0.5) for offset in (-2, -1, 0, 1, 2)]),
    np.transpose([_moments(-0.5, 0.0), _moments(0.0, 0.5)]),
)
"""Shares of the left and the right half of a cell in its own load and in those of its two neighbours on each side."""


def _halved(load: Array) -> Array:
    """Mean loads [Pa] on cells twice as long in the first direction, two more at each end."""
    even = np.concatenate([load, np.zeros((len(load) % 2, load.shape[1]))])
    result = np.zeros((len(even) // 2 + 4, load.shape[1]))
    for i, shares in enumerate(_SHARED / 2):
        result[i : i + len(even) // 2] += shares[0] * even[::2] + shares[1] * even[1::2]
    return result


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Pressure and traction [Pa] of square cells, shape (ny, nx), their side and the centre of the grid [m].

    They are `uniform` squares, or values of a smooth pressure at their centres.
    """

    pressure: Array
    traction: Array
    spacing: float
    center: tuple[float, float]
    uniform: bool = False

    @property
    def x(self) -> Array:
        """Centres along x [m]."""
        n = self.pressure.shape[1]
        return np.asarray(self.center[0] + (np.arange(n) - (n - 1) / 2) * self.spacing)

    @property
    def y(self) -> Array:
        """Centres along y [m]."""
        n = self.pressure.shape[0]
        return np.asarray(self.center[1] + (np.arange(n) - (n - 1) / 2) * self.spacing)

    @property
    def force(self) -> float:
        """Total load [N]."""
        return float(self.pressure.sum()) * self.spacing**2

    def acting(self, direction: float, upper: bool) -> list[tuple[Array, float | None, float]]:
        """Loads that are not zero [Pa], their directions, None for the pressure, and their signs."""
        # the friction of the lower body acts backwards on the upper one
        both = (self.pressure, None, 1.0), (self.traction, direction, -1.0 if upper else 1.0)
        return [each for each in both if np.any(each[0])]

    def split(self, count: int) -> Cells:
        """Each cell cut into `count` times `count` squares, to be taken as values of a pressure."""
        pressure, traction = (
            values.repeat(count, axis=0).repeat(count, axis=1) for values in (self.pressure, self.traction)
        )
        return Cells(pressure, traction, self.spacing / count, self.center)

    def joined(self) -> Cells:
        """Cells twice as wide. Each load is shared among neighbours, which keeps its moments up to the fourth."""
        pressure, traction = (_halved(_halved(values).T).T for values in (self.pressure, self.traction))
        # an odd number of cells gets one more at its end, so the centre of the grid moves
        place = (c + n % 2 * self.spacing / 2 for c, n in zip(self.center, self.pressure.shape[::-1], strict=True))
        return Cells(pressure, traction, 2 * self.spacing, tuple(place))

    @property
    def cropped(self) -> Cells:
        """Without empty rows and columns around."""
        loaded = (self.pressure != 0) | (self.traction != 0)
        if not loaded.any():
            return replace(self, pressure=np.zeros((1, 1)), traction=np.zeros((1, 1)))
        rows, columns = np.flatnonzero(loaded.any(axis=1)), np.flatnonzero(loaded.any(axis=0))
        top, bottom, left, right = rows[0], rows[-1] + 1, columns[0], columns[-1] + 1
        place = float(self.x[left] + self.x[right - 1]) / 2, float(self.y[top] + self.y[bottom - 1]) / 2
        part = slice(top, bottom), slice(left, right)
        return replace(self, pressure=self.pressure[part], traction=self.traction[part], center=place)


@dataclass(frozen=True, slots=True)
class KeptPlanes:
    """Fields of one load in one body on planes, kept for a search that evaluates them at many points in turn."""

    planes: dict[tuple[float, ...], tuple[Indices, list[Array]]] = field(default_factory=dict)

    def of(
        self, key: tuple[float, ...], box: Indices, make: Callable[[Indices], Iterable[Array]]
    ) -> tuple[Indices, list[Array]]:
        """Planes that extend over a box at least, and their box: first and last row and column."""
        if key in self.planes:
            known, _ = self.planes[key]
            box = np.stack([np.minimum(known[0], box[0]), np.maximum(known[1], box[1])])
        if key not in self.planes or (box != known).any():
            self.planes[key] = box, list(make(box))
        return self.planes[key]


def cell_fields(
    cells: Cells, at: Located, x: Array, y: Array, direction: float, coarser: Cells | None = None
) -> tuple[Array, Array, float]:
    """Stress (6, n), displacement (3, n) and the estimated error of stress over the largest pressure.

    The estimate for uniform squares is twice what a finer rule changes at some of the points. Otherwise it is twice what cells
    twice as wide change: beside the rim of a contact, at the surface, the error falls only like the root of their width. Where
    the rim is within a cell is chance, so points close to the surface are moved by a cell as well. `coarser` is the load solved
    on such cells; without it pairs of cells are joined.
    """
    cells = cells.cropped
    largest = max(float(np.abs(cells.pressure).max()), float(np.abs(cells.traction).max()))
    if cells.uniform and _squares_at(at):
        some = _spread(x.size, _EXACT)
        found = fields_of_cells(cells, at, x, y, direction)
        part = Located(at.body, some, at.depth[some], at.layer[some], at.upper)
        apart = np.abs(found[:6, some] - fields_of_cells(cells, part, x[some], y[some], direction, _CHECK)[:6])
        error = 2 * np.nanmax(apart, initial=0.0) / largest if largest > 0 else 0.0
        return found[:6], found[6:], ROUNDING + float(error)
    if cells.uniform:
        cells = cells.split(max(1, int(np.sqrt(_FINEST / cells.pressure.size))))
    found = fields_of_cells(cells, at, x, y, direction)
    some = _spread(x.size, _TRIED)
    wide = cells.joined() if coarser is None else coarser.cropped
    shallow = some[at.depth[some] < wide.spacing]
    shift = wide.spacing * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    tried = np.concatenate([some, *(shallow for _ in shift[1:])])
    moved = np.concatenate([np.zeros((some.size, 2)), *(np.tile(each, (shallow.size, 1)) for each in shift[1:])])
    part = Located(at.body, tried, at.depth[tried], at.layer[tried], at.upper)
    place = x[tried] + moved[:, 0], y[tried] + moved[:, 1]
    fine = found[:6, some]
    if shallow.size:
        fine = fields_of_cells(cells, part, *place, direction)[:6]
    coarse = fields_of_cells(wide, part, *place, direction, _COARSE)[:6]
    error = 2 * float(np.abs(coarse - fine).max()) / largest if largest > 0 else 0.0
    return found[:6], found[6:], error


def _spread(size: int, count: int) -> Indices:
    """Some of `size` points, at most `count`."""
    return np.unique(np.linspace(0, size - 1, min(size, count)).round().astype(int))


def fields_of_cells(
    cells: Cells,
    at: Located,
    x: Array,
    y: Array,
    direction: float,
    rule: Rule = _FINE,
    kept: KeptPlanes | None = None,
) -> Array:
    """The nine components at the points, shape (9, n)."""
    result = np.empty((COMPONENTS, x.size))
    half_x, half_y = (n * cells.spacing / 2 for n in cells.pressure.shape[::-1])
    beside = np.maximum(np.abs(x - cells.center[0]) - half_x, np.abs(y - cells.center[1]) - half_y)
    distance = np.maximum(at.depth, beside)
    octave = np.floor(np.log2(np.maximum(distance / (rule.cells * cells.spacing), 0.5))).astype(int) + 1
    # from this octave on, the load is one cell wide
    one = max(cells.pressure.shape).bit_length() + 1
    far = np.flatnonzero(octave >= one)
    if far.size:
        part = Located(at.body, far, at.depth[far], at.layer[far], at.upper)
        result[:, far] = _as_nine_discs(cells, part, x[far], y[far], direction)
    wide, times = cells, 0
    for m in np.unique(octave[octave < one]).tolist():
        while times < m - 1:
            wide, times = wide.joined(), times + 1
        for layer in np.unique(at.layer[octave == m]):
            here = np.flatnonzero((octave == m) & (at.layer == layer))
            part = Located(at.body, here, at.depth[here], np.full(here.size, layer), at.upper)
            if m == 0 and cells.uniform and _squares_at(at):
                result[:, here] = _close(cells, part, x[here], y[here], direction, rule)
            else:
                first = (rule.cells if m > 0 else 0.5) * wide.spacing
                result[:, here] = _in_slabs(wide, part, first, x[here], y[here], direction, rule, kept=kept)
    return result


def _squares_at(at: Located) -> bool:
    """Whether the surface of a body has a closed form for squares."""
    return not at.body.power_law and isinstance(surface_part(at.body), SurfacePart)


def _close(cells: Cells, at: Located, x: Array, y: Array, direction: float, rule: Rule) -> Array:
    """Components at points of one layer close to uniform squares: in the half-space of the surface, and what layers add."""
    result = np.zeros((COMPONENTS, x.size))
    if at.layer[0] == 0:
        part = surface_part(at.body)
        assert isinstance(part, SurfacePart)
        place = x - cells.x[0], y - cells.y[0], at.depth
        for load, along, sign in cells.acting(direction, at.upper):
            result += sign * fields_of_squares(load, part, cells.spacing, along, place, rule)
    if at.body.layers:
        # what layers add in the first one comes from its lower face and looks like a source above the surface
        top = float(interfaces(at.body)[0])
        vary = float((2 * top - at.depth if at.layer[0] == 0 else at.depth).min())
        most = int(np.sqrt(_MOST / cells.pressure.size))
        parts = rule.cut * (1 + min(int(_FINE.cells * cells.spacing / vary), most))
        result += _in_slabs(cells.split(parts), at, top, x, y, direction, rule, layered=True)
    return result


def _in_slabs(
    cells: Cells,
    at: Located,
    first: float,
    x: Array,
    y: Array,
    direction: float,
    rule: Rule,
    *,
    kept: KeptPlanes | None = None,
    layered: bool = False,
) -> Array:
    """Components at points of one layer from planes at Chebyshev nodes of octaves of depth, the first one down to `first`."""
    result = np.zeros((COMPONENTS, x.size))
    layer = int(at.layer[0])
    place = np.stack([y - cells.y[0], x - cells.x[0]]) / cells.spacing
    for points, low, high in _slabs(at, layer, at.depth, cells.spacing, first):
        here = place[:, points]
        box = np.stack([np.floor(here.min(axis=1)) - _RIM, np.ceil(here.max(axis=1)) + _RIM]).astype(int)
        rule_in_depth = nodes_or_points if kept is None else at_nodes
        depths, weights = rule_in_depth(at.depth[points], low, high, rule.down)
        make = partial(_on_planes, cells, at, depths, layer, direction, layered)
        box, planes = (box, make(box)) if kept is None else kept.of((cells.spacing, layer, low, high), box, make)
        own, which = np.unique(here[0] + 1j * here[1], return_inverse=True)
        where = np.stack([own.real, own.imag]) - box[0][:, None]
        for plane, weight in zip(planes, weights.T, strict=True):
            result[:, points] += weight * _between(plane, where)[:, which]
    return result


def _between(splines: Array, where: Array) -> Array:
    """Values of splines, shape (components, ny, nx), at rows and columns, shape (2, n)."""
    return np.stack(
        [scipy.ndimage.map_coordinates(each, where, order=5, mode="mirror", prefilter=False) for each in splines]
    )


def _as_nine_discs(cells: Cells, at: Located, x: Array, y: Array, direction: float) -> Array:
    """All nine components at points so far away that only moments up to the second matter, however far from each other."""
    count = max(cells.pressure.shape)
    width = count * cells.spacing
    offsets = np.array([-1.0, 0.0, 1.0])
    # variances of a disc along one axis, whose area is the square of its width, and of one cell
    of_disc, of_cell = 1 / (4 * np.pi), 1 / (12 * count**2)
    moments = np.stack([np.ones(3), offsets, offsets**2 + of_disc])
    along, across = (
        np.linalg.solve(moments, np.stack([np.ones(n), place, place**2 + of_cell]))
        for n in cells.pressure.shape
        for place in [(np.arange(n) - (n - 1) / 2) / count]
    )
    dx, dy = (c + width * each.ravel() for c, each in zip(cells.center, np.meshgrid(offsets, offsets), strict=True))
    nine = Located(
        at.body, np.tile(at.chosen, dx.size), np.tile(at.depth, dx.size), np.tile(at.layer, dx.size), at.upper
    )
    place = (x - dx[:, None]).ravel(), (y - dy[:, None]).ravel()
    result = np.zeros((COMPONENTS, x.size))
    disc = UniformDisc(width / np.sqrt(np.pi))
    for load, along_x, sign in cells.acting(direction, at.upper):
        pressure, traction = (1.0, 0.0) if along_x is None else (0.0, sign)
        found = round_fields(disc, nine, *place, pressure=pressure, traction=traction, direction=direction)
        shares = (along @ load @ across.T).ravel() / count**2
        result += np.einsum("j,ijn->in", shares, found.reshape(len(found), shares.size, -1))
    return result


def _slabs(at: Located, layer: int, z: Array, spacing: float, first: float) -> Iterator[tuple[Indices, float, float]]:
    """Points by octaves of depth within their layer, the first of which ends at the depth `first`."""
    faces = np.concatenate([[0.0], interfaces(at.body), [np.inf]])
    start, limit = float(faces[layer]), float(faces[layer + 1])
    z = np.clip(z, start, limit)
    end = max(2 * start, first)
    if at.body.power_law and (z > 0).any():
        # stresses along the surface go like a power of depth, however far from the load
        # cell widths below the surface of a power-law half-space down from which depths are divided into octaves
        end = min(max(float(z[z > 0].min()), 1e-3 * spacing), end)
    while True:
        end = min(end, limit)
        last = end >= min(limit, float(z.max()))
        chosen = np.flatnonzero((z >= start) & ((z <= end) if last else (z < end)))
        if chosen.size:
            yield chosen, start, end
        if last:
            return
        start, end = end, 2 * end


def _on_planes(
    cells: Cells, at: Located, depths: Array, layer: int, direction: float, layered: bool, box: Indices
) -> Iterator[Array]:
    """Splines of the components on the planes of several depths, shape (9, ny, nx); `layered`: only what layers add.

    `box` holds the first and the last row and column of their lattice, which continues that of the cells.
    """
    # offsets between the centres of targets and sources
    along, across = (
        np.arange(low - n + 1, high + 1) for low, high, n in zip(*box.tolist(), cells.pressure.shape, strict=True)
    )
    rows, columns = (box[1] - box[0] + 1).tolist()
    acting = cells.acting(direction, at.upper)
    each_load = [kernels(at, depths, layer, across, along, cells.spacing, along_x, layered) for _, along_x, _ in acting]
    for _ in depths:
        planes = np.zeros((COMPONENTS, rows, columns))
        for (load, _, sign), kernel in zip(acting, each_load, strict=True):
            planes += sign * convolved(load, next(kernel), (rows, columns))
        for axis in (1, 2):
            planes = scipy.ndimage.spline_filter1d(planes, order=5, axis=axis, mode="mirror")
        yield planes
