"""Factors of force at large strain under spheres: other finite elements, errors, identities."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import flatpunch as fp
from flatpunch.contact.finite_strain.tables import FILE, POISSON, SPHERES, THIN, Strained, of_poisson, tables
from support.large_strain import GEL, LAW, POINTS, cone, end_of_spheres, large


@pytest.mark.parametrize(
    ("ratio", "share", "known"),
    [
        (0.2, [0.05, 0.14, 0.23], [0.996, 0.992, 0.988]),
        (0.5, [0.05, 0.14, 0.23, 0.32, 0.41, 0.5], [0.987, 0.990, 0.985, 0.980, 0.979, 0.984]),
        (1.0, [0.05, 0.14, 0.23, 0.32, 0.41, 0.5], [0.985, 0.978, 0.974, 0.968, 0.962, 0.960]),
    ],
)
def test_factors_of_other_finite_elements(ratio, share, known):
    """Of issue 55, which gives 0.004 as their error."""
    found = large(ratio, share)
    assert (np.abs(found.strain_factor - known) < 0.004 + found.force_error).all()


def test_error_holds_at_points_that_did_not_make_the_table():
    """Points between the nodes are on a finer mesh; the safety factor is the largest needed at them, and at no node."""
    record = json.loads(FILE.read_text())
    for family, table in tables().items():
        rows = [json.loads(line) for line in (POINTS / f"points_{family}.jsonl").read_text().splitlines()]
        share = {cells: [] for cells in record["record"]["cells of nodes and checks"][family]}
        for row in rows:
            z, y, x = row["place"]
            # under cones the depth follows from a contact radius
            ratio, _, error = table.at(z, y, np.array(x * row.get("depth", 1.0)))
            share[row["cells"]].append(abs(ratio - row["ratio"]) / error)
        at_nodes, apart = share.values()
        refined = len(record["record"]["refined nodes"][family])
        # the error covers the other solution of doubtful nodes
        doubtful = len(table.doubts)
        assert sorted(at_nodes)[-1 - doubtful] < 1e-2
        assert max(at_nodes) < 1
        assert len(at_nodes) == table.series.size - refined + doubtful
        assert len(apart) == sum(record["record"]["checks"][family]) + refined
        # the largest mesh error and the largest safety factor are met, all others are below
        assert max(apart) <= 1 + 1e-3
        assert max(abs(row["linear"] - 1) for row in rows) == pytest.approx(record["tables"][family]["linear"])


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(
    poisson=st.floats(POISSON, 0.5),
    over=st.floats(THIN, 30.0),
    share=st.floats(1e-6, 1.0),
    young=st.floats(1e2, 1e9),
    radius=st.floats(1e-8, 1e-1),
)
def test_factors_do_not_depend_on_units_and_end_in_linear_theory(poisson, over, share, young, radius):
    tip, deepest = fp.Sphere(radius), end_of_spheres(radius, over * radius) * (1 - 1e-9)
    layer = fp.Medium([fp.Layer(young, poisson, over * radius)], base=fp.RigidBase())
    unit = fp.Medium([fp.Layer(1.0, poisson, over)], base=fp.RigidBase())
    found = fp.indent(layer, tip, depth=share * deepest, finite_strain=LAW)
    same = fp.indent(unit, fp.Sphere(1.0), depth=share * deepest / radius, finite_strain=LAW)
    assert found.strain_factor.values == pytest.approx(same.strain_factor.values, rel=1e-9)
    assert found.force.values == pytest.approx(same.force.values * young * radius**2, rel=1e-9)
    tiny = fp.indent(layer, tip, depth=1e-8 * deepest, finite_strain=LAW)
    assert tiny.strain_factor.values == pytest.approx(1.0, abs=1e-3)
    assert 0.89 < float(found.strain_factor[0]) < 1.3


@pytest.mark.parametrize("tip", [fp.Sphere(7e-6), *map(cone, (12.0, 35.0, 58.0))])
def test_forces_give_their_depths_back_and_stiffness_is_the_slope(tip):
    depth = np.linspace(1e-7, 2.45e-6, 9)
    curve = fp.indent(GEL, tip, depth=depth, finite_strain=LAW)
    back = fp.indent(GEL, tip, force=curve.force.values, finite_strain=LAW)
    assert back.depth.values == pytest.approx(depth, rel=1e-9)
    step = 1e-4 * depth
    two = [fp.indent(GEL, tip, depth=depth + sign * step, finite_strain=LAW).force.values for sign in (1, -1)]
    assert curve.stiffness.values == pytest.approx((two[0] - two[1]) / (2 * step), rel=1e-6)
    assert (curve.force_error.values > 0).all()
    assert curve.attrs["finite_strain"] == LAW


def test_families_meet_at_the_radius_and_at_the_half_space():
    """A step at h = R would be the errors of both tables; layers of 1000 radii are half-spaces."""
    tip, depth = fp.Sphere(1.0), np.linspace(0.01, 0.49, 7)

    def at(over, poisson):
        layer = fp.Medium([fp.Layer(1.0, poisson, over)], base=fp.RigidBase())
        return fp.indent(layer, tip, depth=depth, finite_strain=LAW).strain_factor.values

    for poisson in (0.4, 0.45, 0.47, 0.5):
        both = sum(Strained(family, of_poisson(poisson), 1.0, 0.5).ratio(depth)[2] for family in SPHERES)
        assert (np.abs(at(1 - 1e-9, poisson) - at(1 + 1e-9, poisson)) < both).all()
        half = fp.indent(fp.HalfSpace(1.0, poisson), tip, depth=depth, finite_strain=LAW).strain_factor.values
        assert at(1000.0, poisson) == pytest.approx(half, abs=1e-4)
