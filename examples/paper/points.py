"""One boundary element solution of the case studies, and the folder that keeps the finished ones.

Every finished point is on disk before it counts (`flatpunch.parallel`): after an interrupt the next run goes on from there.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch import bem
from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch._support.progress import Report
from flatpunch.parallel import Folder, point_keys, solve_points
from paper import base_stress
from paper.cases import Body, Shape, indenter, kernel

_FORMAT = 2
"""Raised whenever a change in the boundary elements or here moves the numbers: points of older formats are computed anew."""

_TOLERANCE = 1e-6
"""Tolerance of the boundary elements; ten times as much leaves 1e-5 of the force."""

_VERSION = (_FORMAT, _TOLERANCE)


@dataclass(frozen=True, slots=True)
class Point:
    """What is solved: body, indenter, depth, and cells per side.

    `fields` keeps the contact mask as well, and changes the depth until a0 = h; `base` adds the normal stress at the layer's
    lower face.
    """

    body: Body
    shape: Shape
    eccentricity: float
    depth: float
    cells: int
    fields: bool = False
    base: bool = False


Numbers = dict[str, Any]
"""Arrays of a solved point by name: force, radius, area, contour, eccentricity, peak; mask, spacing; base_tension, ..."""


class Store:
    """Finished points in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = Folder(folder)

    def load(self, point: Point) -> Numbers:
        """Return a finished point."""
        (key,) = point_keys(solve, {point: point}, _VERSION).values()
        return dict(self.folder.read(key).numbers or {})

    def solve(self, points: Iterable[Point], jobs: int, progress: Report | None = None) -> int:
        """Solve what is missing, in so many processes; the number of points solved.

        Points of one body, indenter and size share the indenter and the kernel.
        """
        solved = solve_points(
            solve,
            {point: point for point in points},
            store=self.folder,
            workers=jobs,
            progress=progress,
            version=_VERSION,
            cost=lambda point: point.cells**2 * (4 if point.fields else 1),
            group=lambda point: (point.body, point.shape, point.eccentricity, point.cells),
            retry_failed=True,
        )
        for point, reason in solved.failed.items():
            raise ValueError(f"{point}: {reason}")
        return solved.fresh


def solve(point: Point) -> Numbers:
    """Solve a point by boundary elements."""
    (solution,) = bem.solve(
        kernel(point.body),
        _indenter(point.shape, point.eccentricity),
        depths=[_depth_of_unit_radius(point) if point.fields else point.depth],
        grid=point.cells,
        tolerance=_TOLERANCE,
        angles=360,
    )
    return _numbers(point, solution)


@byte_cached
def _indenter(shape: Shape, eccentricity: float) -> Any:
    return indenter(shape, eccentricity)


def _depth_of_unit_radius(point: Point) -> float:
    """Depth at which the boundary elements find a0 = h = 1: secant rule in logarithms, whose second step moves it by 1e-4."""
    shape, cells = indenter(point.shape, point.eccentricity), point.cells // 2
    depths = [point.depth, 1.02 * point.depth]
    radii: list[float] = []
    for _ in range(4):
        (found,) = bem.solve(kernel(point.body), shape, depths=[depths[len(radii)]], grid=cells, tolerance=_TOLERANCE)
        radii.append(found.radius)
        if len(radii) > 1:
            slope = np.log(depths[-1] / depths[-2]) / np.log(radii[-1] / radii[-2])
            depths.append(float(depths[-1] * radii[-1] ** -slope))
            if len(radii) == 3:
                break
    return depths[-1]


def _numbers(point: Point, solution: bem.Solution) -> Numbers:
    outline = solution.outline
    found: Numbers = {
        "depth": solution.depth,
        "force": solution.force,
        "radius": solution.radius,
        "area": solution.area,
        "contour": outline.contour,
        "peak": float(solution.pressure.max()),
        "converged": solution.converged,
        "eccentricity": contact_eccentricity(outline.phi, outline.contour, outline.half_axes),
    }
    if point.fields:
        found |= {"mask": solution.contact, "x": solution.grid.x, "y": solution.grid.y}
    if point.base:
        found |= base_stress.under_cells(solution.pressure, solution.grid.spacing)
    return found


def contact_eccentricity(phi: Array, contour: Array, half_axes: tuple[float, float]) -> float:
    """e of (26), from an outline that is known to a few hundredths of a cell along each ray.

    Single rays at 0 and pi/2 would put their scatter into e. The outline over the ellipse of its second moments is smooth, so its
    even harmonics up to cos 6 phi are fitted, and b1 and b2 read from the fit; NaN without an outline.
    """
    if not np.all(np.isfinite(contour)):
        return float("nan")
    long, short = half_axes
    ellipse = 1 / np.hypot(np.cos(phi) / long, np.sin(phi) / short)
    even = np.arange(0, 8, 2)
    fit = np.linalg.lstsq(np.cos(even * phi[:, None]), np.log(contour / ellipse), rcond=None)[0]
    b1, b2 = long * np.exp(fit.sum()), short * np.exp(np.cos(even * np.pi / 2) @ fit)
    return float(np.sqrt(max(0.0, 1 - (b2 / b1) ** 2)))
