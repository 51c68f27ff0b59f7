"""Fields under a pressure on square cells: any contact solved by boundary elements, measured footprints.

On planes of constant depth the fields are convolutions of the cells with the fields of one of them (FFT on a doubled grid, so no
periodic images): its half-space part in closed form (`rectangle`; of a disc of the same area where the surface is transversely
isotropic), what layers add from such a disc, since that part is smooth. Fields at a distance s, in depth or sideways, are smooth
over lengths like s; so points are sorted by octaves of s, cells are joined until they are as wide as s/12, and where there are
many depths, planes are taken at Chebyshev nodes. More than twelve widths away, nine discs with the moments of the load
take its place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances.stack import interfaces
from flatpunch.stresses.axisymmetric.panels import nodes_or_points
from flatpunch.stresses.axisymmetric.radial import (
    NORMAL_ORDERS,
    AnisotropicPart,
    surface_part,
    turned,
    under_pressure,
    under_traction,
)
from flatpunch.stresses.axisymmetric.round_load import layered_part, round_fields, split_off
from flatpunch.stresses.axisymmetric.uniform_disc import UniformDisc
from flatpunch.stresses.bodies import Located
from flatpunch.stresses.rectangle import normal_corner, shear_corner, summed

_CELLS, _NODES = 12, 7
"""Cells to the distance of a point, half as many for the estimate of the error, and Chebyshev nodes in an octave of depth; they
leave about 1e-5 of the local stress."""

_RIM = 8
"""Cells around the points on a plane: the end of a cubic spline changes it by .27 to this power inside."""


_SWAP = np.array([1, 0, 2, 4, 3, 5, 7, 6, 8])
"""Components after exchanging x and y."""


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
    """Pressure and traction [Pa] of square cells, shape (ny, nx), their side and the centre of the grid [m]."""

    pressure: Array
    traction: Array
    spacing: float
    center: tuple[float, float]

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

    def split(self, most: int) -> Cells:
        """Each cell cut into squares, so that there are at most `most` in all."""
        count = max(1, int(np.sqrt(most / self.pressure.size)))
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
            return Cells(np.zeros((1, 1)), np.zeros((1, 1)), self.spacing, self.center)
        rows, columns = np.flatnonzero(loaded.any(axis=1)), np.flatnonzero(loaded.any(axis=0))
        top, bottom, left, right = rows[0], rows[-1] + 1, columns[0], columns[-1] + 1
        place = float(self.x[left] + self.x[right - 1]) / 2, float(self.y[top] + self.y[bottom - 1]) / 2
        part = slice(top, bottom), slice(left, right)
        return Cells(self.pressure[part], self.traction[part], self.spacing, place)


def cell_fields(
    cells: Cells, at: Located, x: Array, y: Array, direction: float, coarser: Cells | None = None
) -> tuple[Array, Array, float]:
    """Stress (6, n), displacement (3, n) and the estimated error of stress over the largest pressure.

    The estimate is twice what cells twice as wide change, at up to 1500 of the points: beside the rim of a contact, at the
    surface, the error falls only like the root of their width. Where the rim is within a cell is chance, so points close to
    the surface are moved by a cell as well. `coarser` is the load solved on such cells; without it pairs of cells are joined.
    """
    cells = cells.cropped
    found = fields_of_cells(cells, at, x, y, direction)
    wide = cells.joined() if coarser is None else coarser.cropped
    # points at which cells twice as wide are tried for the estimate of the error
    some = np.unique(np.linspace(0, x.size - 1, min(x.size, 1500)).round().astype(int))
    shallow = some[at.depth[some] < wide.spacing]
    shift = wide.spacing * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    tried = np.concatenate([some, *(shallow for _ in shift[1:])])
    moved = np.concatenate([np.zeros((some.size, 2)), *(np.tile(each, (shallow.size, 1)) for each in shift[1:])])
    part = Located(at.body, tried, at.depth[tried], at.layer[tried], at.upper)
    place = x[tried] + moved[:, 0], y[tried] + moved[:, 1]
    fine = found[:6, some]
    if shallow.size:
        fine = fields_of_cells(cells, part, *place, direction)[:6]
    coarse = fields_of_cells(wide, part, *place, direction, _CELLS // 2)[:6]
    largest = max(float(np.abs(cells.pressure).max()), float(np.abs(cells.traction).max()))
    error = 2 * float(np.abs(coarse - fine).max()) / largest if largest > 0 else 0.0
    return found[:6], found[6:], error


def fields_of_cells(cells: Cells, at: Located, x: Array, y: Array, direction: float, fineness: int = _CELLS) -> Array:
    """All nine components at the points, shape (9, n)."""
    result = np.empty((9, x.size))
    half_x, half_y = (n * cells.spacing / 2 for n in cells.pressure.shape[::-1])
    beside = np.maximum(np.abs(x - cells.center[0]) - half_x, np.abs(y - cells.center[1]) - half_y)
    distance = np.maximum(at.depth, beside)
    octave = np.floor(np.log2(np.maximum(distance / (fineness * cells.spacing), 0.5))).astype(int) + 1
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
            for chosen, low, high in _slabs(at, int(layer), at.depth[here], wide.spacing, fineness if m > 0 else 0):
                points = here[chosen]
                depths, weights = nodes_or_points(at.depth[points], low, high, _NODES)
                planes = _on_planes(wide, at, depths, int(layer), x[points], y[points], direction)
                result[:, points] = sum(plane * weights[:, i] for i, plane in enumerate(planes))
    return result


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
    result = np.zeros((9, x.size))
    # the friction of the lower body acts backwards on the upper one
    for load, unit in ((cells.pressure, (1.0, 0.0)), (cells.traction, (0.0, -1.0 if at.upper else 1.0))):
        if load.any():
            disc = UniformDisc(width / np.sqrt(np.pi))
            found = round_fields(disc, nine, *place, pressure=unit[0], traction=unit[1], direction=direction)
            shares = (along @ load @ across.T).ravel() / count**2
            result += np.einsum("j,ijn->in", shares, found.reshape(len(found), shares.size, -1))
    return result


def _slabs(at: Located, layer: int, z: Array, spacing: float, count: int) -> Iterator[tuple[Indices, float, float]]:
    """Points by octaves of depth within their layer, from half a cell on, or from `count` cells at points that far away."""
    faces = np.concatenate([[0.0], interfaces(at.body), [np.inf]])
    start, limit = float(faces[layer]), float(faces[layer + 1])
    z = np.clip(z, start, limit)
    end = max(2 * start, (count or 0.5) * spacing)
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
    cells: Cells, at: Located, depths: Array, layer: int, x: Array, y: Array, direction: float
) -> Iterator[Array]:
    """Components at points of the planes of several depths, one after the other, shape (9, n)."""
    h = cells.spacing
    # the plane's grid in units of the cells: first and last centres around the points
    column, row = (x - cells.x[0]) / h, (y - cells.y[0]) / h
    first_x, last_x = int(np.floor(column.min())) - _RIM, int(np.ceil(column.max())) + _RIM
    first_y, last_y = int(np.floor(row.min())) - _RIM, int(np.ceil(row.max())) + _RIM
    ny, nx = cells.pressure.shape
    # offsets between the centres of targets and sources
    across = np.arange(first_x - nx + 1, last_x + 1)
    along = np.arange(first_y - ny + 1, last_y + 1)
    shape = last_y - first_y + 1, last_x - first_x + 1
    acting = [(load, shear) for load, shear in ((cells.pressure, False), (cells.traction, True)) if np.any(load)]
    kernels = [_kernels(at, depths, layer, across, along, h, direction if shear else None) for _, shear in acting]
    where = np.stack([row - first_y, column - first_x])
    for _ in depths:
        planes = np.zeros((9, *shape))
        for (load, shear), kernel in zip(acting, kernels, strict=True):
            sign = -1 if shear and at.upper else 1
            planes += sign * _convolved(load, next(kernel), shape)
        yield np.stack([scipy.ndimage.map_coordinates(each, where, order=3, mode="nearest") for each in planes])


def _convolved(load: Array, kernel: Array, shape: tuple[int, int]) -> Array:
    size = tuple(scipy.fft.next_fast_len(n, real=True) for n in kernel.shape[1:])
    spectrum = scipy.fft.rfft2(load, size)
    full = scipy.fft.irfft2(scipy.fft.rfft2(kernel, size) * spectrum, size)
    ny, nx = load.shape
    return np.asarray(full[:, ny - 1 : ny - 1 + shape[0], nx - 1 : nx - 1 + shape[1]])


def _kernels(
    at: Located, depths: Array, layer: int, across: Array, along: Array, h: float, direction: float | None
) -> Iterator[Array]:
    """Fields of one loaded cell at offsets (in cells), shape (9, ny, nx), depth by depth.

    What layers add is found for all depths at once: most of its time goes into the waves below them, which is the same for all.
    """
    disc, shear = UniformDisc(h / np.sqrt(np.pi)), direction is not None
    r, which, angles = _polar(across, along, h)
    places = np.tile(r, depths.size), np.repeat(depths, r.size), np.full(r.size * depths.size, layer)
    added = layered_part(at.body, disc, *places, shear)
    shape = along.size, across.size
    for i, z in enumerate(depths.tolist()):
        mine = i * r.size + which
        found = _components(added[:, mine], angles, direction).reshape(-1, *shape)
        if split_off(at.body, disc, np.full(1, z), np.full(1, layer))[0]:
            found += _split_off_part(at, z, across, along, h, direction)
        yield found


def _polar(across: Array, along: Array, h: float) -> tuple[Array, Indices, Array]:
    """Different distances [m] of offsets (in cells) from the origin, which of them each offset has, and its polar angle."""
    gx, gy = np.meshgrid(across, along)
    squares, which = np.unique(gx * gx + gy * gy, return_inverse=True)
    return h * np.sqrt(squares), which.ravel(), np.arctan2(gy, gx).ravel()


def _components(functions: Array, angles: Array, direction: float | None) -> Array:
    """Nine components of the functions of a pressure, or of those of a traction in a direction, which follow them."""
    if direction is None:
        return under_pressure(functions, angles)
    return turned(under_traction(functions[len(NORMAL_ORDERS) :], angles - direction), direction)


def _split_off_part(at: Located, z: float, across: Array, along: Array, h: float, direction: float | None) -> Array:
    part = surface_part(at.body)
    if isinstance(part, AnisotropicPart):
        # a disc of the same area takes the place of the square
        r, which, angles = _polar(across, along, h)
        functions = part.of_load(UniformDisc(h / np.sqrt(np.pi)), r, np.full(r.size, z), direction is not None)
        return _components(functions[:, which], angles, direction).reshape(-1, along.size, across.size)
    mu, nu = part.constants
    x = (np.append(across, across[-1] + 1) - 0.5) * h
    y = (np.append(along, along[-1] + 1) - 0.5) * h
    gx, gy = np.meshgrid(x, y)
    if direction is None:
        return part.kept_of_components(summed(normal_corner(gx, gy, z, mu, nu)))
    found = np.cos(direction) * summed(shear_corner(gx, gy, z, mu, nu))
    if np.sin(direction):
        found += np.sin(direction) * summed(shear_corner(gy, gx, z, mu, nu)[_SWAP])
    return part.kept_of_components(found)
