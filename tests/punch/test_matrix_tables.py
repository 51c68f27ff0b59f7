"""Flat punch and power-law profiles against tables, straight from the small matrix (no radius family, no solution object)."""

import csv
from pathlib import Path

import numpy as np
import pytest

from flatpunch.compliances import compliance
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase
from flatpunch.punch.basis import power_edge, power_moments, regular_part
from flatpunch.punch.matrix import solve_round, sufficient_terms

DATA = Path(__file__).parents[1] / "data"
RADII = (0, 0.25, 0.5, 0.75, 0.9, 0.99)


def table(name):
    with open(DATA / name, encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def layer_row(beta, nu, bonded, exponents):
    """What the tables list, for one layer on a rigid base: a = 1, f = r^n."""
    medium = Medium([Layer(1.0, nu, 1 / beta, bonded)], RigidBase())
    return row(medium, beta, exponents)


def row(medium, beta, exponents):
    kernel = compliance(medium)
    terms = sufficient_terms(kernel, beta)
    responses = solve_round(kernel, np.array([beta]), terms)
    c, edge = responses.flat[0], responses.edge[0]
    e = 1 / np.pi + edge[0]
    result = {"Kbar": np.pi * c[0]}
    result["dKbar_dbeta"] = ((np.pi * e) ** 2 - np.pi * c[0]) / beta
    for n in exponents:
        b = power_moments(n, 0, terms)
        result[f"kappa{n}"] = (n + 1) * np.pi * b @ c
        depth = (power_edge(n, 0) + b @ edge) / e
        result[f"d{n}"], result[f"F{n}"] = depth, np.pi * (depth * c[0] - b @ c)
    r = np.array(RADII, dtype=float)
    pbar = np.pi * c @ regular_part(0, terms, r) / np.sqrt(1 - r**2)
    return result | {f"pbar_{x:g}": value for x, value in zip(RADII, pbar, strict=True)}


@pytest.mark.parametrize(
    "expected", table("layer_on_rigid_base.csv"), ids=lambda t: f"{t['base']}-{t['nu']}-{t['beta']}"
)
def test_layer_on_a_rigid_base(expected):
    bonded = expected["base"] == "bonded"
    ours = layer_row(float(expected["beta"]), float(expected["nu"] or 0.3), bonded, (1, 2, 4))
    columns = [name for name in expected if name not in ("base", "nu", "beta")]
    assert len(columns) == 17
    for name in columns:
        # ten digits are printed, so the last one is worth up to 5e-10; dKbar is a difference of the order of
        # Kbar/beta
        assert ours[name] == pytest.approx(float(expected[name]), rel=1e-9), name


@pytest.mark.parametrize("expected", table("coated_half_space.csv"), ids=lambda t: f"{t['E2']}-{t['a_over_h']}")
def test_coated_half_space(expected):
    t = {name: float(value) for name, value in expected.items()}
    medium = Medium([Layer(t["E1"], t["nu1"], 1.0)], HalfSpace(t["E2"], t["nu2"]))
    ours = row(medium, t["a_over_h"], (1, 2))
    for name, column in (("Kbar", "Kbar"), ("kappa1", "kappa1"), ("kappa2", "kappa2")):
        # the table is good to 1e-9 and printed to ten digits
        assert ours[name] == pytest.approx(t[column], rel=3e-9), name


@pytest.mark.parametrize("expected", table("hayes1972_flat_punch.csv"), ids=lambda t: f"{t['nu']}-{t['a_over_h']}")
def test_hayes_1972(expected):
    t = {name: float(value) for name, value in expected.items() if name != "status"}
    ours = layer_row(t["a_over_h"], t["nu"], True, ())["Kbar"]
    # eight decimals are printed, at least 5e-9 relative
    assert ours == pytest.approx(t["kappa_exact"], rel=1e-8)
    # Hayes' truncation error is listed in per cent with two decimals; its own value carries three or four
    # digits
    listed = t["hayes_error_percent"] / 100
    assert t["kappa_hayes"] / ours - 1 == pytest.approx(listed, abs=5.1e-5)
