"""State of a slightly non-round contact along its loading path."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np

from flatpunch._support.checks import Array, Flags


@dataclass(frozen=True, slots=True)
class PerturbedContact:
    """Contacts of a non-round indenter at n base radii; shape (n,) each.

    Attributes
    ----------
    radius : ndarray
        Base radius a [m].
    depth, force, stiffness : ndarray
        d [m], F [N], dF/dd [N/m].
    depth_slope : ndarray
        a d'(a) of the base contact [m].
    shape_radius : ndarray
        Base radius of the series that gives the outline [m]; `radius` unless that series has another base.
    size : ndarray
        abar [m]: the outline is abar exp(w).
    mean_radius, area : ndarray
        a0 [m] and contact area [m^2].
    swing : ndarray
        Largest |w|.
    terms : ndarray, shape (n, 3)
        x2, x3, x4 of ln F; of general profiles x2, its product with <w^3>/<w^2> (of the size of x3) and zero.
    """

    radius: Array
    depth: Array
    force: Array
    stiffness: Array
    depth_slope: Array
    shape_radius: Array
    size: Array
    mean_radius: Array
    area: Array
    swing: Array
    terms: Array


@dataclass(frozen=True, slots=True)
class PathPoint:
    """Points of a loading path: base radius a [m], d [m], F [N], dF/dd [N/m] and a d'(a) [m], shape (n,) each."""

    radius: Array
    depth: Array
    force: Array
    stiffness: Array
    depth_slope: Array


def sized(
    path: PathPoint,
    shape_radius: Array,
    size: Array,
    measures: tuple[Array, Array, Array],
    terms: tuple[Array, Array, Array],
) -> PerturbedContact:
    """Contacts at points of a path with outlines of some size; `measures` of w are ln<e^w>, ln<e^2w> and the largest |w|."""
    log_mean, log_square, swing = measures
    return PerturbedContact(
        radius=path.radius,
        depth=path.depth,
        force=path.force,
        stiffness=path.stiffness,
        depth_slope=path.depth_slope,
        shape_radius=shape_radius,
        size=size,
        mean_radius=size * np.exp(log_mean),
        area=np.pi * size**2 * np.exp(log_square),
        swing=swing,
        terms=np.column_stack(terms),
    )


_Points = TypeVar("_Points", PathPoint, PerturbedContact)


def selected(points: _Points, rows: Flags) -> _Points:
    """Some of the points of a path."""
    return replace(points, **{part.name: getattr(points, part.name)[rows] for part in fields(points)})
