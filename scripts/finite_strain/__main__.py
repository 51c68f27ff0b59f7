"""Make src/flatpunch/contact/data/finite_strain.json: forces at large strain over those of linear theory.

python -m finite_strain [thin thick sharp rounded]        (in scripts; about 45 minutes of one core)

Points of a family are in `points_<family>.jsonl`. Every one is written as it is solved, and a second run solves only what is
missing. The table is made of the nodes alone. Its error is measured at others: nodes on a finer mesh, and points of their own on
the finer mesh, at any thickness, depth and Poisson ratio.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from importlib.metadata import version
from itertools import product
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev

from finite_strain.independent import CONES as OTHERS
from finite_strain.laws import Law
from finite_strain.point import Linear, Point, cone_point, point
from finite_strain.tips import Ball, RoundedCone
from flatpunch.contact.finite_strain.caps import Capped, place_of
from flatpunch.contact.finite_strain.tables import (
    ANGLES,
    CONES,
    DEEP,
    FILE,
    SPHERES,
    Table,
    angle_at,
    of_poisson,
    poisson_at,
)
from flatpunch.numerics.chebyshev import nodal_transform, unit_nodes

CELLS = {"thin": (6, 9), "thick": (6, 9), CONES: (4, 6)}
"""Cells under the contact at the nodes, and where the error is measured."""
NODES = {"thin": (7, 5, 6), "thick": (5, 7, 7), CONES: (5, 6, 6)}
"""Chebyshev nodes of Poisson ratio, thickness or angle, and depth."""
MORE = {"thick": (0.5, 0.0, 1.0)}
"""Nodes of the thickness besides those of Chebyshev: half-space, near which deep ratios are curved, middle and other end."""
CHECKS, AGAIN = {"thin": 16, "thick": 16, CONES: 32}, {"thin": 6, "thick": 6, CONES: 30}
"""Points of each family between the nodes, and nodes that are solved again."""

DEEPEST = {"thick": [(0.0316, 0.0, 1.0), (0.0316, 0.15, 1.0), (1.0, 0.0, 1.0), (0.8944, 1.0, 1.0)]}
"""Ends of the coordinates at which ratios are measured besides."""

DOUBTFUL: dict[str, tuple[int, ...]] = {"thin": (), "thick": (114, 140), CONES: ()}
"""Numbers of nodes at which the coarse mesh settles on another solution, which breaks with its neighbours: what the finer one
differs by is part of the error."""
REFINED = {**DOUBTFUL, "thick": (*DOUBTFUL["thick"], 183)}
"""Nodes that are solved on the finer mesh; at the last the coarse one has no solution."""

ROUNDED, STEEPEST, INCOMPRESSIBLE = 32, 55.0, 0.4999
"""Number of points under rounded cones, the largest angle [degrees], and the largest Poisson ratio."""

Place = tuple[float, float, float]
"""Coordinates (z, y, x) in [0, 1] of Poisson ratio, thickness or angle, and depth."""
Quadruple = tuple[float, ...]
"""Angle, Poisson ratio, depth and thickness of a rounded cone."""


def axes(family: str) -> list[np.ndarray]:
    """Nodes of each coordinate."""
    more = MORE.get(family, ())
    z, y, x = ((1 + unit_nodes(count - (len(more) if i == 1 else 0))) / 2 for i, count in enumerate(NODES[family]))
    return [z, np.append(y, more), x]


def nodes(family: str) -> list[Place]:
    """Nodes of a family, the depth running first."""
    return list(product(*axes(family)))


def checks(family: str) -> tuple[list[Place], list[Place]]:
    """Points between the nodes, dense towards the ends of each coordinate, and nodes to be solved again.

    The points of thick layers include deep ones on a half-space, those of cones the ones that other finite elements solve.
    """
    random = np.random.default_rng(55)
    between = np.round((1 - np.cos(np.pi * random.uniform(size=(CHECKS[family], 3)))) / 2, 4).clip(1e-3, 1)
    at = nodes(family)
    again = [at[i] for i in random.choice(len(at), AGAIN[family], replace=False)]
    places = [(float(z), float(y), float(x)) for z, y, x in between]
    if family in DEEPEST:
        places += DEEPEST[family]
    if family == CONES:
        low, high = ANGLES
        places += [(of_poisson(p), (a - low) / (high - low), d / DEEP) for a, p, d in OTHERS]
    return places, again


def contact(family: str, place: Place, cells: int) -> Point:
    """Finite elements at a place of a table."""
    law = Law(poisson_at(place[0]))
    if family == CONES:
        return cone_point(law, RoundedCone(angle_at(place[1])), 1.0, DEEP * place[2], cells)
    depth, radius, thickness = SPHERES[family](place[2], place[1])
    return point(law, Ball(radius), thickness, depth, cells)


class Points:
    """Solved points of a family, kept in a file."""

    def __init__(self, family: str) -> None:
        self.family, self.path = family, Path(__file__).parent / f"points_{family}.jsonl"
        rows = map(json.loads, self.path.read_text().splitlines()) if self.path.exists() else ()
        self.known = {(*row["place"], row["cells"]): row for row in rows}

    def row(self, place: Place, cells: int) -> dict[str, float]:
        """A point, solved if it is not known."""
        key = (*(round(coordinate, 6) for coordinate in place), cells)
        if key not in self.known:
            solved = asdict(contact(self.family, place, cells))
            self.known[key] = {
                "place": key[:3],
                "cells": cells,
                **{name: float(value) for name, value in solved.items()},
            }
            with self.path.open("a") as file:
                file.write(json.dumps(self.known[key]) + "\n")
            print(self.known[key], flush=True)
        row: dict[str, float] = self.known[key]
        return row

    def ratios(self, places: list[Place], cells: int) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates (n, 3), with the depth that was reached, and ratios of forces."""
        rows = [self.row(place, cells) for place in places]
        at = np.array(places)
        at[:, 2] *= [row.get("depth", 1.0) for row in rows]
        return at, np.array([row["ratio"] for row in rows])


def made(family: str) -> dict[str, object]:
    """Table of a family."""
    points, (between, again), (cells, finer) = Points(family), checks(family), CELLS[family]
    each = [points.ratios([place], finer if i in REFINED[family] else cells) for i, place in enumerate(nodes(family))]
    at, ratios = (np.concatenate(parts) for parts in zip(*each, strict=True))
    grows = family in SPHERES
    values = ((ratios - 1) / (at[:, 2] if grows else 1.0)).reshape(NODES[family])
    depths = chebyshev.chebvander(2 * at[:, 2] - 1, NODES[family][2] - 1).reshape(*NODES[family], -1)
    across = np.linalg.inv(chebyshev.chebvander(2 * axes(family)[1] - 1, NODES[family][1] - 1))

    def series_of(values: np.ndarray) -> np.ndarray:
        """Chebyshev coefficients of values at the nodes."""
        lines = np.linalg.solve(depths, values[..., None])[..., 0]
        found: np.ndarray = np.round(np.einsum("aA,bB,ABc->abc", nodal_transform(NODES[family][0]), across, lines), 7)
        return found

    def doubt_of(i: int) -> np.ndarray:
        """What the table would change by, had a node the other solution."""
        place, change = nodes(family)[i], np.zeros(values.size)
        change[i] = (points.ratios([place], cells)[1][0] - ratios[i]) / (at[i, 2] if grows else 1.0)
        return series_of(change.reshape(values.shape))

    series = series_of(values)
    doubts = np.array([doubt_of(i) for i in DOUBTFUL[family]])
    table, need = Table(series, 1.0, 0.0, grows, doubts), 0.0

    def off(places: list[Place]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distance of the table from finer elements, its last terms, and how the mesh counts."""
        at, ratios = points.ratios(places, finer)
        found, _, last = np.array([table.at(z, y, np.array(x)) for z, y, x in at]).T
        return found - ratios, last, at[:, 2] if grows else np.ones(len(at))

    moved, _, weight = off([place for place in again if nodes(family).index(place) not in REFINED[family]])
    mesh = float(max(np.abs(moved) / weight))
    for place, away, last, share in zip(between, *off(between), strict=True):
        need = max(need, (abs(away) - mesh * share) / last)
        print(family, place, f"table {away:+.1e} last terms {last:.1e}")
    linear = max(abs(row["linear"] - 1) for row in points.known.values())
    print(family, "mesh", mesh, "safety", need, "linear theory", linear)
    return {
        "series": series.tolist(),
        "safety": float(need),
        "mesh": mesh,
        "grows": grows,
        "doubts": doubts.tolist(),
        "linear": linear,
    }


def rounded_places() -> list[Quadruple]:
    """Random angles [degrees], Poisson ratios, depths and thicknesses over the radius of the cap, where cap and flank count."""
    random, places = np.random.default_rng(56), []
    for i in range(ROUNDED):
        angle, share, z, over = random.uniform((10.0, 0.5, 0.0, 2.3), (STEEPEST, 0.95, 1.0, 8.0))
        sine = np.sin(np.radians(angle))
        lost = 1 / np.cos(np.radians(angle)) - 1
        depth = (sine * np.arctanh(sine) + lost) / share - lost
        thickness = np.inf if i % 2 else over * (depth + lost)
        places.append((angle, min(poisson_at(z), INCOMPRESSIBLE), depth, thickness))
    return [tuple(round(float(value), 6) for value in place) for place in places]


def caps() -> list[float]:
    """Share of the next order in the ratio of rounded cones, by least squares, and what compressible points need besides."""
    path, found = Path(__file__).parent / "points_rounded.jsonl", []
    known = (
        {tuple(row["place"]): row for row in map(json.loads, path.read_text().splitlines())} if path.exists() else {}
    )
    for place in rounded_places():
        angle, poisson, depth, thickness = place
        if place not in known:
            solved = asdict(cone_point(Law(poisson), RoundedCone(angle, 1.0), thickness, depth, CELLS[CONES][1]))
            known[place] = {"place": place, **{name: float(value) for name, value in solved.items()}}
            with path.open("a") as file:
                file.write(json.dumps(known[place]) + "\n")
        row = known[place]
        at = place_of(Linear(Law(poisson), thickness).medium, RoundedCone(angle, 1.0).shape)
        assert isinstance(at, Capped)
        ratio, error, between = (float(each[0]) for each in at.parts(np.array([depth * row["depth"]])))
        found.append(
            (ratio - row["ratio"], error, between * at.beyond_second_order, between * of_poisson(poisson) ** 2)
        )
        print("rounded", place, "off {:+.1e} tables {:.1e} next order {:.1e}".format(*found[-1][:3]), flush=True)
    off, error, term, compressible = np.array(found).T
    share = float(off @ term / (term @ term))
    return [share, float(np.max((np.abs(off - share * term) - error) / compressible, initial=0.0))]


def main(families: list[str]) -> None:
    """Solve what is missing, and write the tables; the safety factors of rounded cones need them."""
    found = json.loads(Path(str(FILE)).read_text())
    found["tables"].update({family: made(family) for family in families if family in NODES})
    found["record"] = {
        "made_by": "scripts/finite_strain",
        "law": "mu/2 (I - 3) + kappa/2 (J - 1)^2, I = J^(-2/3) tr F^T F",
        "elements": "Q2 displacements, P1 pressure; the penalty (spheres) or the cell at the apex (cones) extrapolated",
        "cells of nodes and checks": CELLS,
        "nodes": NODES,
        "refined nodes": REFINED,
        "checks": {name: [len(each) for each in checks(name)] for name in NODES},
        "versions": {name: version(name) for name in ("scikit-fem", "numpy", "scipy")},
    }
    Path(str(FILE)).write_text(json.dumps(found, indent=1) + "\n")
    if "rounded" in families:
        found["caps"] = caps()
        Path(str(FILE)).write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:] or [*NODES, "rounded"])
