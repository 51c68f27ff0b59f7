"""The numbers behind the figures: boundary elements from the store, the fast methods computed where they are compared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator

from flatpunch._support.checks import Array
from flatpunch.contact import MethodName, indent
from paper.cases import Body, Shape, indenter, medium
from paper.plan import Plan, half_space_depth, half_space_force
from paper.points import Numbers, Store

FAST: tuple[MethodName, ...] = ("first-order", "second-order")
METHODS = ("bem", *FAST)
NAMES = {"bem": "boundary elements", "first-order": "first order (the paper)", "second-order": "second order"}

_FINE_ROWS = np.arange(1, 39) / 38
"""Rows of a drawn map, over the largest e_g."""


@dataclass(frozen=True, slots=True)
class Map:
    """e - e_g of one body.

    Attributes
    ----------
    body : str
        Which layer.
    eccentricity : ndarray, shape (rows,)
        e_g; the first row is 0, where e = 0.
    log_thickness : ndarray, shape (rows, columns)
        log10(h/a0) at which the boundary elements were solved, falling along a row.
    excess : dict of ndarray, shape (rows, columns)
        e - e_g by method, all at those points.
    fine : dict of (ndarray, ndarray, ndarray)
        For drawing, by method: e_g (n,), log10(h/a0) (m,), e - e_g (n, m).
    """

    body: Body
    eccentricity: Array
    log_thickness: Array
    excess: dict[str, Array]
    fine: dict[str, tuple[Array, Array, Array]]


def eccentricity_map(plan: Plan, body: Body, store: Store) -> Map:
    """Collect one map."""
    rows = plan.map_rows(body)
    e_g = np.array([0.0, *plan.eccentricities])
    solved = [[store.load(point) for point in row] for row in rows]
    radius = np.array([[n["radius"] for n in row] for row in solved], dtype=float)
    place = np.vstack([np.sort(plan.log_thickness)[::-1], -np.log10(radius)])
    excess = {"bem": np.array([[n["eccentricity"] for n in row] for row in solved]) - e_g[1:, None]}
    for method in FAST:
        excess[method] = np.array([_eccentricity(body, e, a, method) - e for e, a in zip(e_g[1:], radius, strict=True)])
    excess = {method: np.vstack([np.zeros(place.shape[1]), values]) for method, values in excess.items()}
    log_h = np.linspace(float(np.min(plan.log_thickness)), float(np.max(plan.log_thickness)), 61)
    rows_at = [_along(x, y, log_h) for x, y in zip(place, excess["bem"], strict=True)]
    fine = {"bem": _smooth(e_g, log_h, np.array(rows_at))}
    for method, count in (("first-order", _FINE_ROWS.size), ("second-order", 2 * e_g.size - 1)):
        some = np.linspace(0.0, float(e_g[-1]), count + 1)[1:]
        curves = [_eccentricity(body, float(e), 10.0**-log_h, method) - e for e in some]
        fine[method] = _smooth(np.append(0.0, some), log_h, np.vstack([np.zeros(log_h.size), curves]))
    return Map(body, e_g, place, excess, fine)


def _smooth(e_g: Array, log_h: Array, rows: Array) -> tuple[Array, Array, Array]:
    """A map on the fine rows; monotone between the rows given, so nothing overshoots."""
    every = np.append(0.0, _FINE_ROWS * e_g[-1])
    return every, log_h, np.asarray(PchipInterpolator(e_g, rows)(every))


def _along(x: Array, y: Array, at: Array) -> Array:
    """Values of a row at other thicknesses: its ends lie up to 1 % off the round ones, and are held there."""
    order = np.argsort(x)
    return np.asarray(PchipInterpolator(x[order], y[order])(np.clip(at, x.min(), x.max())))


def _eccentricity(body: Body, e_g: float, radius: Array, method: MethodName) -> Array:
    """e of (26) at mean radii; NaN where the method has no outline, or one that is longer across."""
    result = indent(medium(body), indenter("ellipse", e_g), radius=np.asarray(radius), method=method, angles=4)
    long, short = result.contour.values[:, 0], result.contour.values[:, 1]
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(1 - (short / long) ** 2))


@dataclass(frozen=True, slots=True)
class Curves:
    """Curves of one indenter on one layer at one thickness.

    Attributes
    ----------
    body, shape, eccentricity, thickness
        The case; thickness is h over the half-space's contact radius at the largest depth.
    deepest : float
        d_max.
    bem : dict
        depth, radius, force of the markers.
    lines : dict of Dataset
        Fast methods along the whole depth.
    at_markers : dict of Dataset
        Fast methods at the markers' depths.
    exact : float
        Largest force on the half-space.
    own : dict of float
        The same by each fast method.
    """

    body: Body
    shape: Shape
    eccentricity: float
    thickness: float
    deepest: float
    bem: dict[str, Array]
    lines: dict[str, xr.Dataset]
    at_markers: dict[str, xr.Dataset]
    exact: float
    own: dict[str, float]

    def force_deviation(self, method: str, *, same: bool) -> Array:
        """Relative difference in force at the markers: normalised by each method's own half-space (`same`), or by the exact."""
        scale = self.own[method] / self.exact if same else 1.0
        return np.asarray(self.at_markers[method].force.values / scale / self.bem["force"] - 1)

    def radius_deviation(self, method: str) -> Array:
        """Relative difference in mean radius at the markers."""
        return np.asarray(self.at_markers[method].radius.values / self.bem["radius"] - 1)


def curves(plan: Plan, body: Body, shape: Shape, eccentricity: float, store: Store) -> list[Curves]:
    """One set of curves for each thickness."""
    found = []
    tip = indenter(shape, eccentricity)
    for thickness in plan.thicknesses:
        deepest = half_space_depth(shape, eccentricity, 1 / thickness)
        solved = [store.load(point) for point in plan.curve(body, shape, eccentricity, thickness)]
        markers = {name: np.array([float(n[name]) for n in solved]) for name in ("depth", "radius", "force")}
        along = np.linspace(deepest / 61, deepest, 61)
        solve: Any = {m: lambda d, b, m=m: indent(medium(b), tip, depth=d, method=m, angles=8) for m in FAST}
        found.append(
            Curves(
                body,
                shape,
                eccentricity,
                thickness,
                deepest,
                markers,
                {m: solve[m](along, body) for m in FAST},
                {m: solve[m](markers["depth"], body) for m in FAST},
                half_space_force(shape, eccentricity, deepest),
                {m: float(solve[m](np.array([deepest]), "half-space").force[0]) for m in FAST},
            )
        )
    return found


@dataclass(frozen=True, slots=True)
class Outlines:
    """Figure 10: outlines at h = a0, lengths in d/tan(alpha).

    Attributes
    ----------
    body : str
        Which layer.
    phi : ndarray, shape (n,)
        Polar angles.
    contours : dict of ndarray, shape (n,)
        By method, boundary elements included.
    mask, x, y : ndarray
        Contact cells of the boundary elements, and their coordinates.
    thickness : float
        h/a0 of the boundary elements.
    """

    body: Body
    phi: Array
    contours: dict[str, Array]
    mask: Array
    x: Array
    y: Array
    thickness: float


def outlines(plan: Plan, body: Body, store: Store) -> Outlines:
    """All outlines at the boundary elements' own mean radius, each over its own depth as in the paper."""
    numbers: Numbers = store.load(plan.outline_point(body))
    depth, radius, contour = float(numbers["depth"]), float(numbers["radius"]), np.asarray(numbers["contour"])
    phi = np.linspace(0, 2 * np.pi, contour.size, endpoint=False)
    lines = {"bem": contour / depth}
    for method in FAST:
        result = indent(medium(body), indenter("pyramid"), radius=radius, method=method, angles=phi.size)
        lines[method] = result.contour.values[0] / float(result.depth[0])
    return Outlines(body, phi, lines, numbers["mask"], numbers["x"] / depth, numbers["y"] / depth, 1 / radius)
