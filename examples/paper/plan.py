"""Which boundary element solutions each figure takes, at full size and for a quick look.

Depths are those at which the second-order method expects the contact radius wanted; what the boundary elements find there is
plotted at the radius they find.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.contact import indent
from flatpunch.reference import elliptic
from paper.cases import LAYERS, Body, Shape, indenter, medium
from paper.points import Point


@dataclass(frozen=True, slots=True)
class Plan:
    """Sizes of a run.

    Attributes
    ----------
    eccentricities : tuple of float
        e_g of the maps; e = e_g = 0 needs no solution.
    log_thickness : tuple of float
        log10(h/a0) of the maps.
    thicknesses : tuple of float
        h over the half-space's contact radius at the largest depth, for the curves.
    fractions : tuple of float
        d/d_max of the markers.
    curve_eccentricities : tuple of float
        e_g of figures 6 to 9; the paper's text does not state its own.
    map_cells, curve_cells, outline_cells : int
        Cells per side.
    """

    eccentricities: tuple[float, ...]
    log_thickness: tuple[float, ...]
    thicknesses: tuple[float, ...]
    fractions: tuple[float, ...]
    curve_eccentricities: tuple[float, ...]
    map_cells: int
    curve_cells: int
    outline_cells: int

    def points(self, figures: tuple[int, ...]) -> list[Point]:
        """All points that the figures need, each once."""
        found: list[Point] = []
        for body, numbers in zip(LAYERS, ((2, 3), (4, 5)), strict=True):
            if set(figures) & set(numbers):
                found += [p for row in self.map_rows(body) for p in row]
        for body, numbers in zip(LAYERS, ((6, 7), (8, 9)), strict=True):
            if set(figures) & set(numbers):
                found += [
                    p
                    for e in self.curve_eccentricities
                    for t in self.thicknesses
                    for p in self.curve(body, "ellipse", e, t)
                ]
        if 10 in figures:
            found += [self.outline_point(body) for body in LAYERS]
        if set(figures) & {11, 12}:
            found += [p for body in LAYERS for t in self.thicknesses for p in self.curve(body, "pyramid", 0.0, t)]
        return list(dict.fromkeys(found))

    def map_rows(self, body: Body) -> list[list[Point]]:
        """Points of a map: a row for each e_g, from thick to thin."""
        radii = 10.0 ** -np.sort(np.array(self.log_thickness))[::-1]
        return [
            [
                Point(body, "ellipse", e, float(d), self.map_cells, base=bool(body == "unbonded" and radius > 0.3))
                for radius, d in zip(radii, _depths(body, "ellipse", e, tuple(radii)), strict=True)
            ]
            for e in self.eccentricities
        ]

    def curve(self, body: Body, shape: Shape, eccentricity: float, thickness: float) -> list[Point]:
        """Markers of one curve."""
        deepest = half_space_depth(shape, eccentricity, 1 / thickness)
        base = body == "unbonded" and thickness < 3
        return [
            Point(body, shape, eccentricity, round_figures(f * deepest), self.curve_cells, base=base)
            for f in self.fractions
        ]

    def outline_point(self, body: Body) -> Point:
        """Figure 10: h = a0; boundary elements search for the depth, beginning with that of second order."""
        (depth,) = _depths(body, "pyramid", 0.0, (1.0,))
        return Point(body, "pyramid", 0.0, float(depth), self.outline_cells, fields=True)


def full() -> Plan:
    """The figures as they are printed."""
    return Plan(
        eccentricities=(0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95),
        log_thickness=tuple(np.linspace(-1.0, 2.0, 13)),
        thicknesses=(0.25, 0.5, 1.0, 2.0, 5.0),
        fractions=tuple(np.linspace(0.1, 1.0, 10)),
        curve_eccentricities=(0.5, 0.8),
        map_cells=320,
        curve_cells=256,
        outline_cells=512,
    )


def quick() -> Plan:
    """The same figures from few points on coarse grids."""
    return Plan(
        eccentricities=(0.3, 0.6, 0.9),
        log_thickness=(-1.0, 0.0, 1.0, 2.0),
        thicknesses=(0.5, 2.0),
        fractions=(0.3, 0.65, 1.0),
        curve_eccentricities=(0.5, 0.8),
        map_cells=128,
        curve_cells=96,
        outline_cells=128,
    )


@byte_cached
def _depths(body: Body, shape: Shape, eccentricity: float, radii: tuple[float, ...]) -> Array:
    """Depths at which second order finds the mean radii, to the six figures that make a point's name."""
    result = indent(medium(body), indenter(shape, eccentricity), radius=np.array(radii), method="second-order")
    return np.array([round_figures(d) for d in result.depth.values])


def round_figures(value: float) -> float:
    """Six significant figures: keys of points must not hang on the last bit."""
    return float(f"{value:.6g}")


def half_space_depth(shape: Shape, eccentricity: float, radius: float) -> float:
    """Depth at which the exact half-space contact has the mean radius."""
    if shape == "pyramid":
        # a0 tan(alpha)/d of it
        return radius / 0.6754
    unit = elliptic.elliptic_paraboloid(1 - eccentricity**2, 1.0, 1.0, depth=1.0)
    phi = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    return float((radius / unit.outline(phi).mean()) ** 2)


def half_space_force(shape: Shape, eccentricity: float, depth: float) -> float:
    """Exact force of the half-space, E* = 1."""
    if shape == "pyramid":
        # F/(E* d^2 cot(alpha)) of a square pyramid on a half-space, by boundary elements (1024 x 1024, extrapolated; 1e-5)
        return 0.73762 * depth**2
    return elliptic.elliptic_paraboloid(1 - eccentricity**2, 1.0, 1.0, depth=depth).force
