"""One boundary element solution of the case studies, and the folder that keeps the finished ones.

A point is kept as `<key>.npz`; the key is a hash of everything that determines the numbers. Files are written under a
temporary name and renamed, so that an interrupt leaves whole files only and the next run goes on from there.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import tempfile
import zipfile
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flatpunch import bem
from flatpunch._validation import Array
from flatpunch.paper import base_stress
from flatpunch.paper.cases import Body, Shape, indenter, kernel

_FORMAT = 2
"""Raised whenever a change in the boundary elements or here moves the numbers: points of older formats are computed anew."""

_TOLERANCE = 1e-6
_ANGLES = 360


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

    @property
    def key(self) -> str:
        """File name: a hash of all of it."""
        text = json.dumps([_FORMAT, _TOLERANCE, asdict(self)], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:24]


Numbers = dict[str, Any]
"""Arrays of a solved point by name: force, radius, area, contour, eccentricity, peak; mask, spacing; base_tension, ..."""


class Store:
    """Finished points in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def path(self, point: Point) -> Path:
        """Where a point is kept."""
        return self.folder / f"{point.key}.npz"

    def missing(self, points: Iterable[Point]) -> list[Point]:
        """Points that are not there yet, in order, each once."""
        return [p for p in dict.fromkeys(points) if not self.path(p).exists()]

    def load(self, point: Point) -> Numbers:
        """A finished point."""
        try:
            with np.load(self.path(point)) as data:
                return {name: data[name][()] for name in data.files}
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            raise ValueError(f"{self.path(point)} cannot be read ({error}). Delete it and run again.") from None

    def save(self, point: Point, numbers: Numbers) -> None:
        """Keep a point, whole or not at all."""
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **numbers)
        write_whole(self.path(point), buffer.getvalue())


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it appears whole or not at all."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".unfinished-")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def solve(points: list[Point], store: Store) -> int:
    """Solve points of one body, indenter and size, each kept as soon as it is finished; the number solved."""
    if not points:
        return 0
    first = points[0]
    shape = indenter(first.shape, first.eccentricity)
    for point in points:
        (solution,) = bem.solve(
            kernel(first.body),
            shape,
            depths=[_depth_of_unit_radius(point) if point.fields else point.depth],
            grid=point.cells,
            tolerance=_TOLERANCE,
            angles=_ANGLES,
        )
        store.save(point, _numbers(point, solution))
    return len(points)


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
