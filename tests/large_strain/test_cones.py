"""Factors of force at large strain under cones, sharp and rounded, and pyramids."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import flatpunch as fp
from flatpunch.contact.finite_strain.caps import Capped, place_of
from flatpunch.contact.finite_strain.tables import ANGLES, DEEP, POISSON
from flatpunch.indenters.shapes.pointed import face_gradients
from support.large_strain import GEL, LAW, POINTS, H, cone


@pytest.mark.parametrize(
    ("angle", "poisson", "share", "coarse", "fine"),
    [
        (20, 0.4999, 0.1, 0.97137, 0.97142),
        (35, 0.4999, 0.25, 0.95085, 0.95094),
        (45, 0.4999, 0.1, 0.92638, 0.92608),
        (30, 0.47, 0.4, 1.02273, 1.02299),
    ],
)
def test_factors_of_cones_by_elements_that_share_nothing_with_the_table(angle, poisson, share, coarse, fine):
    """Printed by `python -m finite_strain.independent` (felupe 11.3.0) on 12 and 24 cells; low-order meshes are off by 0.1 %."""
    gel = fp.Medium([fp.Layer(5e3, poisson, H)], base=fp.RigidBase())
    found = fp.indent(gel, cone(angle), depth=share * H, finite_strain=LAW)
    assert float(found.strain_factor[0]) == pytest.approx(fine, abs=1e-3)
    assert coarse == pytest.approx(fine, abs=1e-3)


@pytest.mark.parametrize(("angle", "known", "error"), [(20, 0.97, 0.004), (35, 0.9575, 0.0125), (55, 0.90, 0.01)])
def test_cones_on_half_spaces_of_other_finite_elements(angle, known, error):
    """Of issue 55: 3 % at 20 degrees, 3 to 5.5 % at 35 and 10 % at 55, to the digits that it gives."""
    found = fp.indent(fp.HalfSpace(5e3, 0.4999), cone(angle), depth=1e-6, finite_strain=LAW)
    assert float(found.strain_factor[0]) == pytest.approx(known, abs=error)


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(
    poisson=st.floats(POISSON, 0.5),
    angle=st.floats(*ANGLES),
    share=st.floats(1e-6, 1.0),
    young=st.floats(1e2, 1e9),
    thickness=st.floats(1e-8, 1e-1),
)
def test_factors_of_cones_do_not_depend_on_units_and_begin_as_on_a_half_space(poisson, angle, share, young, thickness):
    tip, depth = cone(angle), share * DEEP * thickness * (1 - 1e-9)
    layer = fp.Medium([fp.Layer(young, poisson, thickness)], base=fp.RigidBase())
    unit = fp.Medium([fp.Layer(1.0, poisson, 1.0)], base=fp.RigidBase())
    found = fp.indent(layer, tip, depth=depth, finite_strain=LAW)
    same = fp.indent(unit, tip, depth=depth / thickness, finite_strain=LAW)
    assert found.strain_factor.values == pytest.approx(same.strain_factor.values, rel=1e-9)
    assert found.force.values == pytest.approx(same.force.values * young * thickness**2, rel=1e-8)
    half = fp.indent(fp.HalfSpace(young, poisson), tip, depth=[1e-3, 1.0], finite_strain=LAW)
    assert half.strain_factor.values[0] == half.strain_factor.values[1]
    assert half.stiffness.values == pytest.approx(2 * half.force.values / half.depth.values, rel=1e-9)
    shallow = fp.indent(layer, tip, depth=1e-7 * thickness, finite_strain=LAW)
    assert float(shallow.strain_factor[0]) == pytest.approx(float(half.strain_factor[0]), abs=1e-5)
    assert 0.85 < float(found.strain_factor[0]) < 1.3


PYRAMIDS = (
    fp.Pyramid(4, np.radians(55)),
    fp.Vickers(),
    fp.Berkovich(),
    fp.CubeCorner(),
    fp.AfmPyramid(*np.radians([30, 40, 35])),
    fp.Pyramid(12, np.radians(20)),
)


@pytest.mark.parametrize("tip", PYRAMIDS)
@pytest.mark.parametrize("medium", [GEL, fp.HalfSpace(5e3, 0.47)])
def test_factors_of_pyramids_are_between_those_of_the_cones_through_edges_and_faces(medium, tip):
    """The cone with the same areas; the error reaches both others, and is not less on layers, on which factors cross."""
    depth, faces = np.array([1e-7, 1e-6, 2.4e-6]), face_gradients(tip)
    height = float(tip.height(np.array(1.0), np.array(tip.corners)).min())
    angles = np.degrees(np.arctan([height, np.hypot(*faces.T).max()]))
    phi = np.linspace(0, 2 * np.pi, 200001)[:-1]
    area = np.mean(tip.height(np.array(1.0), phi) ** -2.0)
    equal = fp.indent(medium, cone(np.degrees(np.arctan(area**-0.5))), depth=depth, finite_strain=LAW)
    found, linear = (
        fp.indent(medium, tip, depth=depth, finite_strain=law, method="fourth-order") for law in (LAW, None)
    )
    assert found.strain_factor.values == pytest.approx(equal.strain_factor.values, rel=1e-8)
    assert found.force.values == pytest.approx(linear.force.values * found.strain_factor.values, rel=1e-12)
    half = fp.HalfSpace(5e3, 0.4999 if medium is GEL else 0.47)
    for body in (medium, half):
        own = fp.indent(body, cone(np.degrees(np.arctan(area**-0.5))), depth=depth, finite_strain=LAW).strain_factor
        for angle in angles:
            other = fp.indent(body, cone(angle), depth=depth, finite_strain=LAW)
            assert (found.force_error >= np.abs(other.strain_factor - own) / found.strain_factor).all()
    assert "estimated by the cone with the same areas" in found.attrs["notes"]
    assert "slopes and strains as small" not in found.attrs["notes"]
    back = fp.indent(medium, tip, force=found.force.values, finite_strain=LAW, method="fourth-order")
    assert back.depth.values == pytest.approx(depth, rel=1e-7)


def test_error_of_pyramids_vanishes_with_the_number_of_faces():
    """A pyramid of many faces is a cone."""
    error = [
        float(fp.indent(GEL, fp.Pyramid(n, 0.6), depth=1e-6, finite_strain=LAW, method="fourth-order").force_error[0])
        for n in (3, 4, 6, 12, 40)
    ]
    round_tip = fp.indent(GEL, fp.Cone(0.6), depth=1e-6, finite_strain=LAW)
    assert (np.diff(error) < 0).all()
    assert error[-1] == pytest.approx(float(round_tip.force_error[0]), abs=2e-4)


@pytest.mark.parametrize("thickness", [np.inf, 12e-6])
@pytest.mark.parametrize("poisson", [0.46, 0.4999])
@pytest.mark.parametrize("angle", [15.0, 35.0, 54.0])
def test_rounded_cones_begin_as_spheres_and_end_as_sharp_cones(angle, poisson, thickness):
    """The same factor up to the end of the cap, continuous there; stiffness is the slope; forces give their depths back."""
    half = fp.HalfSpace(5e3, poisson)
    medium = half if thickness == np.inf else fp.Medium([fp.Layer(5e3, poisson, thickness)], base=fp.RigidBase())
    tip, ball = fp.SpheroCone(np.radians(angle), 1e-6), fp.Sphere(1e-6)
    place = place_of(medium, tip)
    assert isinstance(place, Capped)
    cap = np.linspace(0.1, 1, 5) * min(place.end_of_cap, place.deepest) * (1 - 1e-9)
    found, sphere = (fp.indent(medium, each, depth=cap, finite_strain=LAW) for each in (tip, ball))
    assert found.force.values == pytest.approx(sphere.force.values, rel=1e-6)
    two = place.ratio(place.end_of_cap * np.array([1 - 1e-8, 1 + 1e-8]))
    assert two[0][0] == pytest.approx(two[0][1], abs=1e-6)
    assert two[2][0] == pytest.approx(two[2][1], abs=1e-6)
    depth = np.linspace(1.1 * place.end_of_cap, min(place.deepest, 40 * place.end_of_cap) * (1 - 1e-9), 6)
    curve = fp.indent(medium, tip, depth=depth, finite_strain=LAW)
    two = [fp.indent(medium, tip, depth=(1 + s) * depth[:-1], finite_strain=LAW).force.values for s in (1e-4, -1e-4)]
    assert curve.stiffness.values[:-1] == pytest.approx((two[0] - two[1]) / (2e-4 * depth[:-1]), rel=1e-6)
    back = fp.indent(medium, tip, force=curve.force.values, finite_strain=LAW)
    assert back.depth.values == pytest.approx(depth, rel=1e-9)
    if thickness == np.inf:
        sharp = fp.indent(medium, cone(angle), depth=1e-3, finite_strain=LAW)
        deep = fp.indent(medium, tip, depth=1e-3, finite_strain=LAW)
        assert float(deep.strain_factor[0]) == pytest.approx(float(sharp.strain_factor[0]), abs=1e-6)
        assert float(deep.force_error[0]) == pytest.approx(float(sharp.force_error[0]), abs=1e-6)


def test_error_of_rounded_cones_holds_at_all_points_of_finite_elements():
    """Random points on half-spaces and layers; the safety factors are the largest that they need."""
    rows = [json.loads(line) for line in (POINTS / "points_rounded.jsonl").read_text().splitlines()]
    share = {False: [], True: []}
    for row in rows:
        angle, poisson, depth, thickness = row["place"]
        layer = fp.Medium([fp.Layer(1.0, poisson, min(thickness, 1e9))], base=fp.RigidBase())
        medium = fp.HalfSpace(1.0, poisson) if thickness == np.inf else layer
        ratio, _, error = place_of(medium, fp.SpheroCone(np.radians(angle), 1.0)).ratio(
            np.array([depth * row["depth"]])
        )
        share[thickness < np.inf].append(abs(float(ratio[0]) - row["ratio"]) / float(error[0]))
    assert len(rows) == 32
    assert max(*share[False], *share[True]) <= 1 + 1e-6
