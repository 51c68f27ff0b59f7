"""Contact outline beside the edges of a tip, to a fraction of a cell.

An edge draws the contact out into a tongue that ends in a point, narrower than a cell long before its end; the cells lose
the last two to nine of it, or break it up. So the tongue is solved again on finer cells that lie along the edge, two or three
times (zoom.py). Beside its end the tongue is a wedge pressed in, and a wedge's half-width b is proportional to the load
per length q. So b = q (c_0 + c_1 q + c_2 q^2) is fitted where the tongue is wide enough to be measured, each side of the edge by
itself, and q gives the rest. A rounded edge is a cylinder there, and b has a term in the root of q besides. Along needles, which
are a few cells wide over hundreds of them, q tells b by itself (across.py), and only their ends want finer cells. A line load
sinks in by q ln(1/q), while what it has to follow is straight: so the end is where x = x_end + c_1 q + c_2 q ln q says, or
along needles, where this does not hold as far as they are narrow, a parabola through the last of q.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from flatpunch import bem
from flatpunch._support.checks import Array, Flags
from flatpunch.bem.grid import Grid
from flatpunch.compliance import Kernel
from flatpunch.contact.boundary_elements.outlines.core import refine_core
from flatpunch.contact.boundary_elements.outlines.needle_width import Across, across
from flatpunch.contact.boundary_elements.outlines.parts import EXCESS, FILLED, ray_and_area, star_of
from flatpunch.contact.boundary_elements.outlines.zoom import ROOT, Patch, look_closer, turned
from flatpunch.indenters.geometry.edges import place_of, wedges_of
from flatpunch.indenters.geometry.symmetry import mirrored_about, rotational_symmetry
from flatpunch.indenters.profile import Indenter

_WIDTH, _CELLS = 0.28, 8.0
"""Half-width up to which a tongue is looked at: over the mean radius, and at least this many cells."""
_FINE, _FINE_ROUNDED = 1e-3, 5e-4
"""Cells over the mean radius down to which looks are taken, and those along rounded edges, whose needles end bluntly."""
_TONGUES, _NEEDLES, _FINER_NEEDLES, _COUNTED_NEEDLES = (2, np.inf), (4, 0.05), (4, 0.02), (4, 0.01)
"""Cells of the first look per cell, at least, and over the mean radius, at most. Needles are narrow where they leave the core,
the narrower the more they are; of those along rounded edges little is left for closer looks, and counting wants many cells."""
_ROUGHLY = 0.005
"""Cells over the mean radius, islands included, that are small enough where the contact has no outline to be told."""
_CROWDED = 0.6
"""Tangent of half the angle between edges up to which needles are many."""
_CLOSER, _FARTHEST = 4, 6
"""Cells of each look per cell of the one before, at most, and of the first one, unless a coarser one goes before it."""
_NARROW = 8.0
"""Half-width, in cells of the next look, from which on that is taken."""
_COARSE = 0.02
"""Cells over the mean radius from which on a star's core is looked at too."""
_SMOOTHED = 15
"""Cells over which the difference between measured and fitted half-widths is averaged."""
_RIM, _BEYOND, _LONGER = 2.0, 6.0, 0.15
"""What a look takes in beside its root: cells on either side, and beyond the last cell in contact, with a share of the tongue."""
_MEASURED, _MEASURED_BY_MOMENT = 2.0, 1.5
"""Half-widths in cells from which on these tell it: by their number, and along needles by the moment of what they carry."""
_BESIDE_LAW = 4.0
"""Half-width over that up to which the load tells it, up to which what is counted departs smoothly from what the load tells."""
_SPREAD = 0.3
"""Half-width over the distance along the edge up to which the latter holds."""
_TAIL = (0.7, 6.0)
"""Half-widths in cells from which the end is extrapolated."""
_LONGEST = 60
"""Cells of a needle from which its end is extrapolated."""
_BLUNT = 4.0
"""Long cells at an end that are looked at again on square ones in any case."""
_LOST = 10.0
"""How far it may lie beyond the last cell in contact, in cells (2 to 9 found)."""
_FEWEST = 5
_NEAREST, _BESIDE_CORE = 0.3, 0.7
"""Where tongues may begin, over the mean radius, and where they do beside a core that is looked at."""
_SLENDER = 3.0
"""Reach over the mean radius from which on a tongue is a needle."""
_DRAWN_OUT = 1.1
"""Reach along a rounded edge over the mean radius from which on it is followed."""
_STRETCH, _MANY, _SLIM = 3, 240, 8.0
"""Length over width of cells along tongues that more square ones than so many would line, so many times as many as across."""
_ROUNDING = 1e-9

Side = tuple[Array, Array]
"""Points (x, b) [m] of one side of a tongue: along its edge and across, up to the end."""
Polar = tuple[Array, Array]
"""The same as polar angles from the edge [rad], of either sign, and radii [m]."""


@dataclass(frozen=True, slots=True)
class Trace:
    """Outline of one solution.

    Attributes
    ----------
    contour : ndarray, shape (angles,)
        a(phi) [m] at equal angles from 0, the farthest point in contact; NaN where the contact has no outline.
    radius, area : float
        Mean length of rays in contact [m] and area [m^2]; where the contact has no outline those of the cells, but for the
        tongues of a star with islands around it.
    """

    contour: Array
    radius: float
    area: float


@dataclass(frozen=True, slots=True)
class Edge:
    """Where a tongue is looked for.

    Attributes
    ----------
    angle : float
        Polar angle of the edge [rad].
    wedge : float
        Tangent of half the angle to the next edge: beyond that the contact is another tongue's.
    nearest : float
        Distance from the point of first touch at which it may begin [m].
    mean : float
        Mean radius of the contact [m].
    finer : int
        Cells of the first look per cell, at least.
    coarsest : float
        Its cells at most [m].
    rounded : bool
        Whether the edge is rounded.
    told : bool
        Whether the tongue is a needle whose load tells its width.
    """

    angle: float
    wedge: float
    nearest: float
    mean: float
    finer: int
    coarsest: float
    rounded: bool
    told: bool


def traced(kernel: Kernel, indenter: Indenter, solution: bem.Solution, angles: int) -> Trace:
    """Outline of a boundary element solution, its points along the edges of the tip restored."""
    outline, islands = solution.outline, np.zeros_like(solution.contact)
    if not np.isfinite(outline.contour[0]):
        outline, islands = star_of(kernel, indenter, solution, angles)
    contour, gaps = np.array(outline.contour), np.array(outline.gaps)
    between, followed = np.ones(angles, dtype=bool), list[tuple[float, tuple[Polar, Polar]]]()
    if not np.isfinite(contour[0]):
        return Trace(contour, *ray_and_area(solution.grid, solution.contact))
    whole = Patch(solution.grid, 0.0, solution.pressure, solution.displacement)
    star = solution.grid.spacing > _COARSE * outline.radius
    if star:
        refine_core(kernel, indenter, solution.depth, whole, contour, gaps, outline.radius, islands)
    apart = bool(islands.any())
    ray, more = ray_and_area(solution.grid, islands) if apart else (0.0, 0.0)
    if apart:
        # islands are no tongue, however near
        whole = replace(whole, pressure=np.where(islands, 0.0, whole.pressure))
    fold = rotational_symmetry(indenter)
    # cells lie differently in each sector
    rays = np.arange(angles) / angles
    contour = np.mean([np.interp(rays + turn / fold, rays, contour, period=1.0) for turn in range(fold)], axis=0)
    for edge in _edges(kernel, indenter, contour, outline.radius, star, _ROUGHLY * (outline.radius + ray) * apart):
        sides = _tongue(kernel, indenter, solution.depth, whole, edge, closely=not apart)
        if sides is not None:
            for turn in range(fold):
                corner = edge.angle + 2 * np.pi * turn / fold
                between &= ~_restore(contour, sides, corner)
                followed.append((corner, sides))
    radius, area = _radius_and_area(contour, gaps, between, followed)
    if not apart:
        return Trace(contour, radius, area)
    return Trace(np.full_like(contour, np.nan), radius + ray, area + more)


def _edges(kernel: Kernel, indenter: Indenter, contour: Array, mean: float, star: bool, roughly: float) -> list[Edge]:
    """Where tongues are looked for: along every edge, along rounded ones where they draw out the contact beyond the cap.

    Of those that turning the tip carries into each other the one that lies along rows of cells, if there is one. No cells
    smaller than `roughly` [m] are asked for.
    """
    nearest = (_BESIDE_CORE if star else _NEAREST) * mean
    phi, closed = np.linspace(0, 2 * np.pi, contour.size + 1), np.append(contour, contour[0])
    chosen: dict[float, Edge] = {}
    for angle, wedge, rounded in sorted(wedges_of(indenter), key=lambda edge: abs(np.sin(2 * edge[0]))):
        reach = np.interp(np.mod(angle, 2 * np.pi), phi, closed) / mean
        if not rounded or reach > _DRAWN_OUT:
            told = not kernel.exponent and mirrored_about(indenter, angle) and (star or bool(reach > _SLENDER))
            needles = _COUNTED_NEEDLES if not told else _FINER_NEEDLES if rounded or wedge < _CROWDED else _NEEDLES
            finer, coarsest = needles if star else _TONGUES
            coarsest = max(coarsest * mean, roughly)
            chosen.setdefault(
                place_of(indenter, angle), Edge(angle, wedge, nearest, mean, finer, coarsest, rounded, told)
            )
    return list(chosen.values())


def _tongue(
    kernel: Kernel, indenter: Indenter, depth: float, whole: Patch, edge: Edge, *, closely: bool
) -> tuple[Polar, Polar] | None:
    """Left and right side of the tongue along one edge, looked at once or closer and closer; None where there is none."""
    even = mirrored_about(indenter, edge.angle)
    patch, widest = whole, max(_WIDTH * edge.mean, _CELLS * whole.grid.spacing)
    finer = max(edge.finer, int(np.ceil(patch.grid.spacing / edge.coarsest)))
    finest = (_FINE_ROUNDED if edge.rounded else _FINE) * edge.mean
    looks: list[list[Side]] = []
    if finer > _FARTHEST:
        # most of what a single look had to take in beside the tongue, whose cells were so much wider, would lie idle
        approach = _window(patch, edge, widest, -(-finer // _CLOSER), ())
        if approach is not None:
            patch = look_closer(kernel, indenter, depth, patch, approach[0], edge.angle, mirrored=(False, even))
            finer = _CLOSER
    while True:
        # ends want cells as short as wide
        stretch = 1 if looks else _STRETCH
        window = _window(patch, edge, widest, finer, looks[-1] if looks else (), stretch)
        if window is None:
            break
        grid, begins = window
        # beside its beginning the finer cells still feel that the others stand still
        start = grid.x[0] + ROOT * patch.grid.length
        patch = look_closer(kernel, indenter, depth, patch, grid, edge.angle, mirrored=(False, even))
        # the grid may begin beyond the point of first touch
        ends = np.array([start, grid.x[-1]])
        profile = across(kernel, indenter, edge.angle, ends, grid.spacing) if even and not kernel.exponent else None
        each = zip((True, False), begins, strict=True)
        sides = [_side(patch, edge, max(start, begin), left, profile) for left, begin in each if left or not even]
        found = [side for side in sides if side is not None]
        if not patch.converged or (looks and len(found) < len(sides)):
            break
        if len(found) == len(sides):
            # needles may be too narrow for the cells of the first look
            looks.append(found)
        if not closely or grid.spacing <= finest:
            break
        # no finer than the last look has to be
        finer = min(_CLOSER, max(2, int(np.ceil(grid.spacing / finest))))
        widest = _NARROW * grid.spacing / finer
    if not looks:
        return None
    left, right = (_joined([look[side] for look in looks]) for side in (0, -1))
    # both sides end at one point
    end = (left[0][-1] + right[0][-1]) / 2
    for along, _ in (left, right):
        along[-1] = max(end, along[-2] + _ROUNDING * end)
    return _polar(left, 1.0), _polar(right, -1.0)


def _window(
    patch: Patch, edge: Edge, widest: float, finer: int, sides: Sequence[Side], stretch: int = 1
) -> tuple[Grid, tuple[float, float]] | None:
    """Finer cells around the tongue, and from where on its left and right side are as narrow as `widest` [m].

    Along slim tongues cells are `stretch` times as long as wide. None where the contact does not reach so far.
    """
    h, length, turn = patch.grid.spacing, patch.grid.length, edge.angle - patch.angle
    rows, columns = np.nonzero(patch.pressure > 0)
    along, across = turned(patch.grid.x[columns], patch.grid.y[rows], -turn)
    near = (along > 0) & (np.abs(across) < np.minimum(1.5 * widest + 2 * h, edge.wedge * along + h))
    half = np.zeros((2, int(along.max() / length) + 1))
    np.maximum.at(half, ((across[near] < 0).astype(int), (along[near] / length).astype(int)), np.abs(across[near]))
    # as wide as a tongue may be, or nearly filling what lies between two neighbours
    wide = half > np.minimum(widest, FILLED * edge.wedge * length * np.arange(half.shape[1]))
    begins = [length * (np.flatnonzero(side)[-1] + 1) if side.any() else 0.0 for side in wide]
    if sides:
        begin = max(float(along[half > widest].max(initial=0.0)) for along, half in sides)
        if edge.told:
            begin = max(begin, sides[0][0][-1] - _LONGEST * h)
        if patch.grid.stretch > 1:
            # blunt ends are not narrow over as much as a few long cells
            begin = min(begin, sides[0][0][-1] - _BLUNT * length)
        begins = [begin, begin]
    left, right = (max(edge.nearest, begin) for begin in begins)
    start = min(left, right) - ROOT * length
    last = along[near & (np.abs(across) < 1.5 * h)].max(initial=0.0)
    if last <= start + ROOT * length:
        return None
    # the ray leaves the patch
    (x0, x1), (y0, y1) = (
        (v[0] - side / 2, v[-1] + side / 2) for v, side in ((patch.grid.x, length), (patch.grid.y, h))
    )
    with np.errstate(divide="ignore"):
        leaves = min(max(np.array(v) / np.float64(u)) for u, v in ((np.cos(turn), (x0, x1)), (np.sin(turn), (y0, y1))))
    end = min(last + _LONGER * (last - start) + _BEYOND * length, leaves)
    fine = h / finer
    widths = [
        side[max(int((begin - ROOT * length) / length), 0) :].max(initial=0.0)
        for side, begin in zip(half, (left, right), strict=True)
    ]
    ny = 2 * round((max(widths) + _RIM * h) / fine)
    stretch = stretch if (end - start) / fine > max(_MANY, _SLIM * ny) else 1
    nx = max(8, round((end - start) / (stretch * fine)))
    return Grid(nx, ny, fine, (start + nx * stretch * fine / 2, 0.0), stretch=stretch), (left, right)


def _side(patch: Patch, edge: Edge, start: float, left: bool, profile: Across | None) -> Side | None:
    """Points (x, b) of one side of a tongue from x = `start` to its end; None where there is no tongue."""
    h, stretch, middle, columns = patch.grid.spacing, patch.grid.stretch, patch.grid.ny // 2, patch.grid.x > start
    x, y = patch.grid.x[columns], patch.grid.y[middle:]
    pressure = (patch.pressure[middle:] if left else patch.pressure[middle - 1 :: -1])[:, columns]
    # what is apart from the edge is no tongue
    tongue = np.logical_and.accumulate(pressure > 0) & (y[:, None] < edge.wedge * x)
    pressure = np.where(tongue, pressure, 0.0)
    width, load = h * np.count_nonzero(pressure > 0, axis=0), pressure.sum(axis=0)
    if not load.any():
        return None
    q, known, counted, fewest = load / load.max(), np.zeros(x.size), width - EXCESS * h, _MEASURED
    terms = [*([np.sqrt(q)] if edge.rounded else []), q, q**2, q**3]
    if profile is not None:
        by_law = profile.half_widths(x, load, pressure.T @ y**2)
        flat = np.isnan(by_law[0])
        of_load, of_moment = np.where(flat, counted, by_law)
        if of_load.max() < _BESIDE_LAW * profile.widest and (edge.told or not flat.any()):
            # where tongues are narrow they obey it, and depart from it the more the wider they are: corners of flats by too much
            known, terms = of_load, [of_load * q, of_load * q**2]
        if edge.told and of_load.max() < profile.widest:
            # where it spreads towards its root a needle is more than its profile across
            counted, fewest = np.where(of_load < _SPREAD * x, of_moment, counted), _MEASURED_BY_MOMENT
    measured = width > fewest * h
    if measured.sum() < _FEWEST:
        return None
    columns = np.column_stack(terms)
    c = np.linalg.lstsq(columns[measured], (counted - known)[measured], rcond=None)[0]
    half = np.maximum(known + columns @ c, 0.0)
    # what the fit misses where the tongue is wide
    missed = np.where(measured, counted - half, 0.0)
    half = np.where(q > 0, half + uniform_filter1d(missed, _SMOOTHED // stretch, mode="nearest"), 0.0)
    low, high = (limit * h for limit in _TAIL)
    seen, wide = np.flatnonzero(half > low), np.flatnonzero(half > high)
    if not seen.size:
        return None
    # blunt ends are narrow over a few cells only
    first = min(wide[-1] + 1 if wide.size else 0, max(seen[-1] + 1 - 2 * _FEWEST, 0))
    tail = slice(max(first, seen[-1] + 1 - _LONGEST // stretch), seen[-1] + 1)
    far, beside = q[tail][q[tail] > 0], x[tail][q[tail] > 0]
    if far.size < _FEWEST:
        return None
    last = x[np.flatnonzero(width)[-1]] + patch.grid.length / 2
    bend = far**2 if tail.start > first else far * np.log(far)
    end = np.linalg.lstsq(np.column_stack([np.ones_like(far), far, bend]), beside, rcond=None)[0][0]
    end = min(max(end, last), last + _LOST * h)
    keep = (half > low) & (x < end)
    return np.append(x[keep], end), np.append(half[keep], 0.0)


def _joined(looks: list[Side]) -> Side:
    """One side of a tongue from looks closer and closer, each of which has the rest of it."""
    starts = [along[0] for along, _ in looks[1:]] + [np.inf]
    parts = [(along[along < start], half[along < start]) for (along, half), start in zip(looks, starts, strict=True)]
    along, half = (np.concatenate(values) for values in zip(*parts, strict=True))
    return along, half


def _polar(side: Side, sign: float) -> Polar:
    """Points of one side as angles from the edge and radii."""
    along, half = side
    return sign * np.arctan2(half, along), np.hypot(along, half)


def _restore(contour: Array, sides: tuple[Polar, Polar], corner: float) -> Flags:
    """Replace a(phi) on the rays that meet the tongue along one edge, and say which they are.

    Needles may be thinner at their root than farther out, where rays leave the contact and meet it again: then a is their
    farthest point, as everywhere.
    """
    turn = np.mod(2 * np.pi * np.arange(contour.size) / contour.size - corner + np.pi, 2 * np.pi) - np.pi
    met = np.zeros(contour.size, dtype=bool)
    for sign, (angle, radius) in zip((1.0, -1.0), sides, strict=True):
        # from the end on: beside obtuse edges radii grow from there
        widest = np.maximum.accumulate(np.abs(angle[::-1]))
        farthest = np.append(True, widest[1:] > widest[:-1])
        on_side = (sign * turn >= 0) & (np.abs(turn) < widest[-1])
        contour[on_side] = np.interp(np.abs(turn[on_side]), widest[farthest], radius[::-1][farthest])
        met |= on_side
    return met


def _radius_and_area(
    contour: Array, gaps: Array, between: Flags, followed: list[tuple[float, tuple[Polar, Polar]]]
) -> tuple[float, float]:
    """Mean length of the rays in contact [m] and area [m^2].

    By the rays `between` the tongues and by the points of the sides of these, which rays may miss. Where rays leave the contact
    and meet it again, what lies between does not count.
    """
    rays = 2 * np.pi * np.arange(contour.size) / contour.size
    phi, a, sums = [rays[between]], [contour[between]], -gaps[between].sum(axis=0) * (2 * np.pi / contour.size)
    for corner, sides in followed:
        # from the widest angle at the roots on, in the place of the sector between these
        roots, starts = np.array([(angle[np.abs(angle).argmax()], radius[0]) for angle, radius in sides]).T
        for root, (angle, radius) in zip(roots, sides, strict=True):
            path, reach = np.append(root, angle), np.append(radius[0], radius)
            sums = sums + [abs(np.trapezoid(reach**power, path)) for power in (1, 2)]
        sums = sums - [abs(np.trapezoid(starts**power, roots)) for power in (1, 2)]
        phi.append(np.mod(corner + roots, 2 * np.pi))
        a.append(starts)
    points, radii = np.concatenate(phi), np.concatenate(a)
    order = np.argsort(points)
    points, radii = points[order], radii[order]
    points, radii = np.append(points, points[0] + 2 * np.pi), np.append(radii, radii[0])
    length, square = sums + [np.trapezoid(radii**power, points) for power in (1, 2)]
    return float(length) / (2 * np.pi), float(square) / 2
