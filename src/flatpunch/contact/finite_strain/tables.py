"""Series in Chebyshev polynomials of the ratio of forces, and their coordinates.

The ratio depends on the depth and the thickness over the radius of a sphere, or on the angle of a cone and the depth over the
thickness, and on the Poisson ratio, not on the modulus. It is tabulated for a neo-Hookean solid that is bonded to a rigid base,
or a half-space, without friction; `scripts/finite_strain` makes the tables and says how. There are three: spheres on layers
thinner and thicker than the radius, and sharp cones.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array

FILE = files("flatpunch.contact") / "data" / "finite_strain.json"

THIN = 0.1
"""Least thickness over the radius."""
DEEP = 0.5
"""Largest depth over the thickness of layers under cones, and under spheres of larger radius."""

CONES, ANGLES = "sharp", (10.0, 60.0)
"""Name of the table of cones, and its angles between flank and surface [degrees]."""

POISSON = 0.4
"""Least Poisson ratio."""

SPHERES: dict[str, Callable[[float, float], tuple[float, float, float]]] = {
    "thin": lambda x, y: (DEEP * x**2, THIN ** (y - 1), 1.0),
    "thick": lambda x, y: (float(thick_end(np.array(y))) * x**2, 1.0, 1 / y if y > 0 else math.inf),
}
"""Depth, radius and thickness at coordinates (x, y) in [0, 1] of each table of spheres."""


def thick_end(y: Array) -> Array:
    """Largest depth over the radius of spheres whose radii are y <= 1 of the thickness: at most half of the thickness."""
    return 1 / (1 + y * y)


def angle_at(y: float) -> float:
    """Angle of a cone [degrees] at a coordinate in [0, 1]."""
    return ANGLES[0] + (ANGLES[1] - ANGLES[0]) * y


def poisson_at(z: float) -> float:
    """Poisson ratio at a coordinate in [0, 1]: thin layers are soft by their compressibility, so that it is a root."""
    return 0.5 - (0.5 - POISSON) * z**2


def of_poisson(poisson: float) -> float:
    """Inverse of `poisson_at`, for Poisson ratios of the table."""
    return math.sqrt((0.5 - poisson) / (0.5 - POISSON))


@dataclass(frozen=True, slots=True)
class Table:
    """Series of one family, over coordinates (z, y, x) in [0, 1] of Poisson ratio, thickness or angle, and depth.

    Attributes
    ----------
    series : ndarray, shape (z, y, x)
        Chebyshev coefficients of (ratio - 1)/x, or of ratio - 1.
    safety : float
        Error between the nodes over the last terms of the series, the largest at points that did not make it.
    mesh : float
        Error of the finite elements, over x if strains grow with it.
    grows : bool
        Whether strains vanish at x = 0, as under spheres. Those under a cone on a half-space do not depend on the depth.
    doubts : ndarray, shape (n, z, y, x)
        Changes of the series had each of n nodes the other of two solutions on which meshes settle.
    """

    series: Array
    safety: float
    mesh: float
    grows: bool
    doubts: Array

    def at(self, z: float, y: float | Array, x: Array) -> tuple[Array, Array, Array]:
        """Ratio of forces, its derivative by x, and its error, shape (n,) each; y may have that shape too."""
        u, v = np.broadcast_arrays(2 * np.asarray(y) - 1, 2 * x - 1)
        plane = np.asarray(chebyshev.chebval(2 * z - 1, self.series))
        value = chebyshev.chebval2d(u, v, plane)
        slope = 2 * chebyshev.chebval2d(u, v, chebyshev.chebder(plane, axis=1))
        ends = (chebyshev.chebval(u, plane[:, -1]), chebyshev.chebval(v, plane[-1]))
        last = sum(map(np.abs, (*ends, chebyshev.chebval2d(u, v, self.series[-1]))))
        other = sum(
            np.abs(chebyshev.chebval2d(u, v, np.asarray(chebyshev.chebval(2 * z - 1, each)))) for each in self.doubts
        )
        weight, rise = (x, value) if self.grows else (np.ones_like(x), np.zeros_like(x))
        return 1 + weight * value, rise + weight * slope, weight * (self.mesh + self.safety * last + other)


@byte_cached
def tables() -> dict[str, Table]:
    """The tables that come with the package."""
    found = _file()["tables"]
    return {
        name: Table(np.array(each["series"]), each["safety"], each["mesh"], each["grows"], np.array(each["doubts"]))
        for name, each in found.items()
    }


@byte_cached
def next_order() -> tuple[float, float]:
    """Share of the term of next order in the ratio of rounded cones (`Capped`), and error at the least Poisson ratio besides."""
    share, spread = _file()["caps"]
    return share, spread


def _file() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(FILE.read_text())
    return found
