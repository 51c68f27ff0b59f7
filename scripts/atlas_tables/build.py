"""Make the table of a family: solve on a grid of its parameters, refine it until the series end, drop what is negligible.

Parameter points are Chebyshev-Lobatto points, so that a finer grid keeps those of a coarser one. Every medium solved is kept in
a folder if one is given; an interrupted build goes on from there.
"""

from __future__ import annotations

from collections.abc import Iterable
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.polynomial import chebyshev

from atlas_tables.families import Family
from atlas_tables.solving import panel_edges, solve_medium
from flatpunch._support.checks import Array
from flatpunch._support.progress import Report
from flatpunch._version import __version__
from flatpunch.atlas import Table
from flatpunch.atlas.panel import Panel, SparseSeries
from flatpunch.compliances import compliance
from flatpunch.parallel import solve_points
from flatpunch.punch.matrix import sufficient_terms

Grid = tuple[int, ...]
Found = dict[tuple[float, ...], dict[str, Any]]


class Ways(TypedDict, total=False):
    """How points are solved: arguments of `flatpunch.parallel.solve_points`.

    `store` is a folder in which solved media are kept: a build that was interrupted goes on from there. `workers` is the number
    of processes, one for each core by default; `scheduler` the address of a Dask scheduler that does the work instead. With
    `progress` True a bar is shown for each grid.
    """

    store: str | Path | None
    workers: int | None
    scheduler: str | None
    progress: bool | Report | None


def build(family: Family, **ways: Unpack[Ways]) -> Table:
    """Compute the table of a family, without a measured bound of its error: `verify` finds it.

    RuntimeError, with the first reason, if media could not be solved, or if the finest grid does not meet the tolerance.
    """
    grid: Grid = tuple(6 for _ in family.parameters)
    while True:
        found = _solve_grid(family, grid, ways)
        tails = _tails(family, found, grid)
        coarse = [i for i, tail in enumerate(tails) if tail > family.tolerance]
        if not coarse:
            return _table(family, found, grid)
        if any(2 * grid[i] > 96 for i in coarse):
            names = ", ".join(family.parameters[i].name for i in coarse)
            raise RuntimeError(
                f"The series of {family.name!r} over {names} still end at {max(tails):.1e} on {grid} intervals; "
                f"{family.tolerance:g} was asked for. Narrow the range, choose another scale, or raise the tolerance."
            )
        grid = tuple(2 * n if i in coarse else n for i, n in enumerate(grid))


def _solve_grid(family: Family, grid: Grid, ways: Ways) -> Found:
    axes = [p.at(lobatto(n)).tolist() for p, n in zip(family.parameters, grid, strict=True)]
    low, high = family.beta
    media = {values: _medium(family, values) for values in product(*axes)}
    same = {"low": low, "high": high, "responses": family.responses, **_common_terms(family)}
    points = {values: {"medium": medium, **same} for values, medium in media.items()}
    title = f"{family.name} {' x '.join(str(n + 1) for n in grid)}".strip()
    solved = solve_points(solve_medium, points, title=title, **ways)
    if failed := solved.failed:
        values = next(values for values in points if values in failed)
        raise RuntimeError(
            f"{len(failed)} of {len(points)} media of {family.name!r} could not be solved; the first, "
            f"{_named(family, values)}: {failed[values]}. Narrow the ranges of the family."
        )
    return {values: dict(solved[values].numbers or {}) for values in points}


def _medium(family: Family, values: Iterable[float]) -> Any:
    return family.make(**{p.name: v for p, v in zip(family.parameters, values, strict=True)})


def _common_terms(family: Family) -> dict[str, list[int]]:
    """As "terms", the number of coefficients on each panel that all media need, where that depends on their parameters.

    A series cut at another length for each medium would not be a smooth function of the parameters.
    """
    corners = product(*((p.low, p.high) for p in family.parameters))
    kernels = [compliance(_medium(family, values)) for values in corners]
    if not any(kernel.graded for kernel in kernels):
        return {}
    edges = panel_edges(*family.beta)
    return {"terms": [max(sufficient_terms(kernel, high) for kernel in kernels) for _, high in edges]}


def _named(family: Family, values: Iterable[float]) -> str:
    return ", ".join(f"{p.name} = {v:.6g}" for p, v in zip(family.parameters, values, strict=True))


def _dense(family: Family, found: Found, grid: Grid, name: str) -> Array:
    """Chebyshev coefficients over the parameters, shape (outputs, NODES, n_1 + 1, ...); short series are filled with zeros."""
    columns = [numbers[name] for numbers in found.values()]
    outputs = max(column.shape[1] for column in columns)
    values = np.zeros((len(columns), columns[0].shape[0], outputs))
    for row, column in zip(values, columns, strict=True):
        row[:, : column.shape[1]] = column
    dense = values.reshape(*(n + 1 for n in grid), *values.shape[1:])
    for axis, n in enumerate(grid):
        dense = np.moveaxis(np.tensordot(lobatto_transform(n), dense, axes=(1, axis)), 0, axis)
    # parameters, beta, outputs -> outputs, beta, parameters
    return np.ascontiguousarray(np.moveaxis(dense, [-1, -2], [0, 1]))


def sparse(dense: Array, cutoff: float) -> SparseSeries:
    """What is above the cutoff of coefficients of shape (outputs, NODES, degrees of parameter 1, ...)."""
    output, beta_degree, *degrees = np.nonzero(np.abs(dense) >= cutoff)
    return SparseSeries(dense.shape[0], dense[output, beta_degree, *degrees], output, beta_degree, tuple(degrees))


def lobatto(intervals: int) -> Array:
    """Chebyshev-Lobatto points cos(pi j/intervals), j = intervals ... 0, ascending; doubling `intervals` keeps every point."""
    j = np.arange(intervals, -1, -1)
    points = np.sin(np.pi * (intervals - 2 * j) / (2 * intervals))
    return np.asarray(points)


def lobatto_transform(intervals: int) -> Array:
    """Matrix from values at the Lobatto points to Chebyshev coefficients, shape (intervals + 1, intervals + 1)."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(lobatto(intervals), intervals)))


def _tails(family: Family, found: Found, grid: Grid) -> list[float]:
    """Largest coefficient among the last of each parameter, over all panels, in units of the tolerance of its kind."""
    tails = [0.0 for _ in grid]
    for i, _ in enumerate(panel_edges(*family.beta)):
        for name, tolerance in _kinds(family):
            dense = np.abs(_dense(family, found, grid, f"{i}/{name}"))
            for axis in range(len(grid)):
                # the last two coefficients of a series estimate its remainder
                last = np.moveaxis(dense, 2 + axis, 0)[-2:].max()
                tails[axis] = max(tails[axis], float(last) * family.tolerance / tolerance)
    return tails


def _kinds(family: Family) -> list[tuple[str, float]]:
    """Names of what is tabulated, each with its tolerance."""
    # of the responses to outlines, which enter the force with the square of the asymmetry
    loose = max(family.tolerance, 1e-8)
    more = [("stiffening", loose), ("edge_1", loose), ("edge_2", loose)] if family.responses else []
    return [("flat", family.tolerance), *more]


def _table(family: Family, found: Found, grid: Grid) -> Table:
    panels = []
    numbers = next(iter(found.values()))
    for i, (low, high) in enumerate(panel_edges(*family.beta)):
        # coefficients below this share of the tolerance are dropped: a hundred thousand of them add up to about the tolerance
        series = {
            name: sparse(_dense(family, found, grid, f"{i}/{name}"), 0.3 * tolerance)
            for name, tolerance in _kinds(family)
        }
        orders = numbers[f"{i}/orders"] if family.responses else np.zeros(0, dtype=int)
        panels.append(Panel(low, high, series, orders))
    attributes = {
        "created": datetime.now(UTC).strftime("%Y-%m-%d"),
        "created_by": f"flatpunch {__version__}",
        "tolerance": family.tolerance,
        "grid": [n + 1 for n in grid],
    }
    return Table(family.name, family.title, family.parameters, tuple(panels), float("nan"), attributes)
