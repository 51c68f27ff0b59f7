"""Make src/flatpunch/contact/data/finite_strain.json: forces at large strain over those of linear theory.

python -m finite_strain [thin thick sharp]        (in scripts; about half an hour of one core)

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
from finite_strain.point import Point, cone_point, point
from finite_strain.tips import Ball, RoundedCone
from flatpunch.contact.finite_strain import ANGLES, CONES, DEEP, FILE, POISSON, SPHERES, Table, angle_at, poisson_at
from flatpunch.numerics.chebyshev import nodal_transform, unit_nodes

CELLS = {"thin": (6, 9), "thick": (6, 9), CONES: (4, 6)}
"""Cells under the contact at the nodes, and where the error is measured."""
NODES = {"thin": (6, 5, 6), "thick": (5, 4, 6), CONES: (4, 6, 6)}
"""Chebyshev nodes of Poisson ratio, thickness or angle, and depth."""
CHECKS, AGAIN = {"thin": 16, "thick": 16, CONES: 32}, {"thin": 6, "thick": 6, CONES: 12}
"""Points of each family between the nodes, and nodes that are solved again."""

REFINED: dict[str, tuple[int, ...]] = {"thin": (0,), "thick": (), CONES: ()}
"""Numbers of nodes that are solved on the finer mesh: the coarse one settles on another solution there, 0.7 % off, which breaks
with its neighbours; 9 and 12 cells agree within 1e-5."""

Place = tuple[float, float, float]
"""Coordinates (z, y, x) in [0, 1] of Poisson ratio, thickness or angle, and depth."""


def nodes(family: str) -> list[Place]:
    """Nodes of a family, the depth running first."""
    return list(product(*((1 + unit_nodes(count)) / 2 for count in NODES[family])))


def checks(family: str) -> tuple[list[Place], list[Place]]:
    """Points between the nodes, dense towards the ends of each coordinate, and nodes to be solved again.

    The points of cones include those that other finite elements solve.
    """
    random = np.random.default_rng(55)
    between = np.round((1 - np.cos(np.pi * random.uniform(size=(CHECKS[family], 3)))) / 2, 4).clip(1e-3, 1)
    at = nodes(family)
    again = [at[i] for i in random.choice(len(at), AGAIN[family], replace=False)]
    places = [(float(z), float(y), float(x)) for z, y, x in between]
    if family == CONES:
        low, high = ANGLES
        places += [
            (float(np.sqrt((0.5 - p) / (0.5 - POISSON))), (a - low) / (high - low), d / DEEP) for a, p, d in OTHERS
        ]
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
    at, ratios = points.ratios(nodes(family), cells)
    for i in REFINED[family]:
        ratios[i] = points.ratios([nodes(family)[i]], finer)[1][0]
    grows = family in SPHERES
    values = ((ratios - 1) / (at[:, 2] if grows else 1.0)).reshape(NODES[family])
    depths = chebyshev.chebvander(2 * at[:, 2] - 1, NODES[family][2] - 1).reshape(*NODES[family], -1)
    lines = np.linalg.solve(depths, values[..., None])[..., 0]
    series = np.round(np.einsum("aA,bB,ABc->abc", *map(nodal_transform, NODES[family][:2]), lines), 7)
    table, need = Table(series, 1.0, 0.0, grows), 0.0

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
    return {"series": series.tolist(), "safety": float(need), "mesh": mesh, "grows": grows, "linear": linear}


def main(families: list[str]) -> None:
    """Solve what is missing, and write the table once all families are known."""
    tables = {family: made(family) for family in families}
    if families != list(NODES):
        return
    record = {
        "made_by": "scripts/finite_strain",
        "law": "mu/2 (I - 3) + kappa/2 (J - 1)^2, I = J^(-2/3) tr F^T F",
        "elements": "Q2 displacements, P1 pressure; the penalty (spheres) or the cell at the apex (cones) extrapolated",
        "cells of nodes and checks": CELLS,
        "nodes": NODES,
        "refined nodes": REFINED,
        "checks": {name: [len(each) for each in checks(name)] for name in NODES},
        "versions": {name: version(name) for name in ("scikit-fem", "numpy", "scipy")},
    }
    Path(str(FILE)).write_text(json.dumps({"record": record, "tables": tables}, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:] or list(NODES))
