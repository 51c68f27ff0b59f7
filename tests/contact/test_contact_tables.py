"""Round contact and flat punches on layers against recomputed tables (sources on top of each file)."""

import csv
import warnings
from pathlib import Path

import numpy as np
import pytest

import flatpunch as fp

DATA = Path(__file__).parents[1] / "data"
H = 2.5e-6
YOUNG = 3e6

# The tables give ten digits: half a unit of the last one is at most 5e-10 of the value, their own error 4e-12 and 1e-9.
PRINTED = 1e-9


def rows(name):
    lines = [line for line in (DATA / name).read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return [{key: number(text) for key, text in row.items()} for row in csv.DictReader(lines)]


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


def layer_on_rigid_base(row):
    bonded = row["base"] == "bonded"
    # a sliding layer does not feel its Poisson ratio; the table leaves it empty
    nu = row["nu"] if bonded else 0.3
    medium = fp.Medium([fp.Layer(YOUNG, nu, H, bonded=bonded)], base=fp.RigidBase())
    return medium, YOUNG / (1 - nu**2)


RIGID = rows("layer_on_rigid_base.csv")
COATED = rows("coated_half_space.csv")


def label(row):
    return "-".join(str(entry) for entry in list(row.values())[:5])


@pytest.mark.parametrize("row", RIGID, ids=label)
def test_indent_on_a_layer_on_a_rigid_base(row):
    medium, modulus = layer_on_rigid_base(row)
    a = row["beta"] * H
    for n in (1, 2, 4):
        curve = fp.indent(medium, fp.PowerLaw(n, 7.0), radius=a)
        depth, force = float(curve["depth"][0]), float(curve["force"][0])
        assert depth / (7.0 * a**n) == pytest.approx(row[f"d{n}"], rel=PRINTED)
        assert force / (2 * modulus * 7.0 * a ** (n + 1)) == pytest.approx(row[f"F{n}"], rel=PRINTED)
        assert float(curve["stiffness"][0]) / (2 * modulus * a) == pytest.approx(row["Kbar"], rel=PRINTED)


@pytest.mark.parametrize("row", RIGID, ids=label)
def test_flat_punch_on_a_layer_on_a_rigid_base(row):
    medium, modulus = layer_on_rigid_base(row)
    a = row["beta"] * H
    punch = fp.flat_punch(medium, a)
    assert punch.beta == pytest.approx(row["beta"], rel=1e-15)
    assert punch.normalized_stiffness == pytest.approx(row["Kbar"], rel=PRINTED)
    # Krein: e^2 = d(a Kbar)/da = Kbar + beta Kbar'
    assert punch.edge_coefficient**2 == pytest.approx(row["Kbar"] + row["beta"] * row["dKbar_dbeta"], rel=PRINTED)
    for n in (1, 2, 4):
        assert punch.moment(n) == pytest.approx(row[f"kappa{n}"], rel=PRINTED)
    for rho in ("0", "0.25", "0.5", "0.75", "0.9", "0.99"):
        ours = float(punch.pressure(float(rho) * a)) * np.pi * a / modulus
        assert ours == pytest.approx(row[f"pbar_{rho}"], rel=PRINTED)


@pytest.mark.parametrize("row", COATED, ids=label)
def test_flat_punch_on_a_coated_half_space(row):
    medium = fp.Medium(
        [fp.Layer(float(row["E1"]) * 1e9, float(row["nu1"]), H)],
        base=fp.HalfSpace(float(row["E2"]) * 1e9, float(row["nu2"])),
    )
    with warnings.catch_warnings():
        # under the stiff film the pressure is negative in part; when that is said is tested with the punch
        warnings.simplefilter("ignore", fp.FlatpunchWarning)
        punch = fp.flat_punch(medium, row["a_over_h"] * H)
    # the table's own trust is 1e-9
    assert punch.normalized_stiffness == pytest.approx(row["Kbar"], rel=2e-9)
    assert punch.moment(1) == pytest.approx(row["kappa1"], rel=2e-9)
    assert punch.moment(2) == pytest.approx(row["kappa2"], rel=2e-9)
