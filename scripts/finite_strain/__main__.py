"""Make src/flatpunch/contact/data/finite_strain.json: forces at large strain over those of linear theory.

python -m finite_strain [thin thick]        (in scripts; about a quarter of an hour of one core)

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

from finite_strain.laws import Law
from finite_strain.point import point
from finite_strain.tips import Ball
from flatpunch.contact.finite_strain import FAMILIES, FILE, Table, poisson_at
from flatpunch.numerics.chebyshev import nodal_transform, unit_nodes

CELLS, FINER = 6, 9
"""Cells under the contact at the nodes, and where the error is measured."""
NODES = {"thin": (6, 5, 6), "thick": (5, 4, 6)}
"""Chebyshev nodes of Poisson ratio, thickness and depth."""
CHECKS, AGAIN = 16, 6
"""Points of each family between the nodes, and nodes that are solved again."""

REFINED = {"thin": (0,), "thick": ()}
"""Numbers of nodes that are solved on the finer mesh: the coarse one settles on another solution there, 0.7 % off, which breaks
with its neighbours; 9 and 12 cells agree within 1e-5."""

Place = tuple[float, float, float]
"""Coordinates (z, y, x) in [0, 1] of Poisson ratio, thickness and depth."""


def nodes(family: str) -> list[Place]:
    """Nodes of a family, the depth running first."""
    return list(product(*((1 + unit_nodes(count)) / 2 for count in NODES[family])))


def checks(family: str) -> tuple[list[Place], list[Place]]:
    """Points between the nodes, dense towards the ends of each coordinate, and nodes to be solved again."""
    random = np.random.default_rng(55)
    between = np.round((1 - np.cos(np.pi * random.uniform(size=(CHECKS, 3)))) / 2, 4).clip(1e-3, 1)
    at = nodes(family)
    return [(float(z), float(y), float(x)) for z, y, x in between], [
        at[i] for i in random.choice(len(at), AGAIN, replace=False)
    ]


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
            depth, radius, thickness = FAMILIES[self.family](place[2], place[1])
            solved = asdict(point(Law(poisson_at(place[0])), Ball(radius), thickness, depth, cells))
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

    def ratios(self, places: list[Place], cells: int) -> np.ndarray:
        """Ratios of forces."""
        return np.array([self.row(place, cells)["ratio"] for place in places])


def made(family: str) -> dict[str, object]:
    """Table of a family."""
    points, (between, again) = Points(family), checks(family)
    at = np.array(nodes(family))
    ratios = points.ratios(nodes(family), CELLS)
    for i in REFINED[family]:
        ratios[i] = points.ratios([nodes(family)[i]], FINER)[0]
    values = ((ratios - 1) / at[:, 2]).reshape(NODES[family])
    series = np.round(np.einsum("aA,bB,cC,ABC->abc", *map(nodal_transform, NODES[family]), values), 7)
    again = [place for place in again if nodes(family).index(place) not in REFINED[family]]
    moved = points.ratios(again, FINER) - points.ratios(again, CELLS)
    mesh = float(max(np.abs(moved) / np.array(again)[:, 2]))
    table, need = Table(series, 1.0, mesh), 0.0
    for place, ratio in zip(between, points.ratios(between, FINER), strict=True):
        found, _, off = (float(each) for each in table.at(place[0], place[1], np.array(place[2])))
        spread = off - mesh * place[2]
        need = max(need, (abs(found - ratio) - mesh * place[2]) / spread)
        print(family, place, f"ratio {ratio:.5f} table {found - ratio:+.1e} last terms {spread:.1e}")
    linear = max(abs(row["linear"] - 1) for row in points.known.values())
    print(family, "mesh", mesh, "safety", need, "linear theory", linear)
    return {"series": series.tolist(), "safety": float(need), "mesh": mesh, "linear": linear}


def main(families: list[str]) -> None:
    """Solve what is missing, and write the table once all families are known."""
    tables = {family: made(family) for family in families}
    if families != list(NODES):
        return
    record = {
        "made_by": "scripts/finite_strain",
        "law": "mu/2 (I - 3) + kappa/2 (J - 1)^2, I = J^(-2/3) tr F^T F",
        "elements": "Q2 displacements, P1 pressure, penalty contact extrapolated",
        "cells": {"nodes": CELLS, "checks": FINER},
        "nodes": NODES,
        "refined nodes": REFINED,
        "checks": {"between": CHECKS, "nodes again": AGAIN},
        "versions": {name: version(name) for name in ("scikit-fem", "numpy", "scipy")},
    }
    Path(str(FILE)).write_text(json.dumps({"record": record, "tables": tables}, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:] or list(NODES))
