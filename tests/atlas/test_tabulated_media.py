"""Media that take their flat punches from a table: the same calls, the same responses."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import atlas
from flatpunch.compliances import compliance

GEL = fp.Medium([fp.Layer(young=5e3, poisson=0.48, thickness=2e-6)], base=fp.RigidBase())
FILM = fp.Medium([fp.Layer(young=3e9, poisson=0.35, thickness=1e-6)], base=fp.HalfSpace(young=7e10, poisson=0.22))
GRADED = fp.Medium(
    [fp.GradedLayer(young=fp.LinearModulus(2e9, 5e9, 1e-6), poisson=0.3, thickness=1e-6)],
    base=fp.HalfSpace(young=5e9, poisson=0.3),
)
SLIDING = fp.Medium(
    [fp.Layer(young=3e9, poisson=0.35, thickness=1e-6, bonded=False)], base=fp.HalfSpace(young=7e10, poisson=0.22)
)
DEPTHS = np.array([2e-9, 5e-8, 4e-7])


@pytest.mark.parametrize("medium", [GEL, FILM, GRADED, SLIDING], ids=["gel", "film", "graded", "sliding"])
@pytest.mark.parametrize("method", ["first-order", "second-order", "fourth-order"])
@pytest.mark.parametrize(
    "indenter", [fp.Sphere(radius=5e-6), fp.Pyramid(sides=4, inclination=0.35)], ids=["sphere", "pyramid"]
)
def test_curves_are_those_of_the_medium(medium, method, indenter):
    table = atlas.tabulated(medium)
    found, direct = (fp.indent(body, indenter, depth=DEPTHS, method=method, angles=24) for body in (table, medium))
    assert found.attrs.pop("flat_punches").startswith(f"table '{table.solution.family}', relative error below")
    assert found.attrs == direct.attrs
    for name in ("force", "radius", "area"):
        # depths come from first derivatives of the table, outlines from second ones, and the fourth order from two more: each
        # costs up to two digits
        tolerance = 1e-6 + 1000 * table.solution.error
        np.testing.assert_allclose(
            found[name], direct[name], rtol=tolerance if method != "fourth-order" else 10 * tolerance
        )


def test_other_calls(recwarn):
    table, tip = atlas.tabulated(GEL), fp.Sphere(radius=5e-6)
    found, direct = (
        (
            fp.flat_punch(body, 3e-6).stiffness,
            fp.flat_punch(body, 3e-6).moment(2.0),
            fp.flat_punch(body, 3e-6).edge_coefficient,
            *fp.pressure(body, tip, [0.0, 1e-6], 0.0, depth=2e-7),
            fp.pull_off(body, tip, work_of_adhesion=1e-4).force,
            *fp.compliance(body)(np.array([1e5, 1e6])),
            float(
                fp.indent(
                    body,
                    tip,
                    depth=[0.0, 1e-7, 2e-7],
                    time=[0.0, 1.0, 2.0],
                    relaxation=fp.StandardLinearSolid(equilibrium=0.5, time=1.0),
                ).force[-1]
            ),
        )
        for body in (table, GEL)
    )
    assert found == pytest.approx(direct, rel=1e-7)
    assert fp.flat_punch(table, 3e-6).error == atlas.table("bonded-layer").bound
    assert not recwarn.list


def test_equal_media_share_their_solutions():
    assert compliance(atlas.tabulated(GEL)) is compliance(atlas.tabulated(GEL))
    assert compliance(atlas.tabulated(GEL)) is not compliance(GEL)


def test_outside_is_solved_or_refused():
    tip = fp.Sphere(radius=5e-6)
    # contact radii from a ten-thousandth of the layer on
    depths = np.array([1e-14, 1e-8])
    found = fp.indent(atlas.tabulated(GEL), tip, depth=depths)
    np.testing.assert_allclose(found.force, fp.indent(GEL, tip, depth=depths).force, rtol=1e-8)
    assert found.attrs["flat_punches"].endswith("1 of 2 contacts are outside it and were solved directly")
    with pytest.raises(ValueError, match=r"the table 'bonded-layer' holds 0\.001 \.\.\. 100\. outside='solve'"):
        fp.indent(atlas.tabulated(GEL, outside="refuse"), tip, depth=depths)
    with pytest.raises(ValueError, match=r"it is one of 'solve', 'refuse'"):
        atlas.tabulated(GEL, outside="never")


@pytest.mark.parametrize(
    ("medium", "message"),
    [
        (fp.HalfSpace(young=1.0, poisson=0.3), "No table holds this HalfSpace: the atlas knows one layer"),
        (
            fp.Medium([fp.Layer(1.0, 0.3, 1.0), fp.Layer(2.0, 0.3, 1.0)], base=fp.RigidBase()),
            "No table holds this Medium",
        ),
        (
            fp.Medium([fp.Layer(1.0, -0.2, 1.0)], base=fp.RigidBase()),
            r"belongs to 'bonded-layer', but poisson = -0\.2 lies outside",
        ),
        (
            fp.Medium([fp.Layer(1e5, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)),
            r"belongs to 'bonded-coating', but modulus_ratio = 100000",
        ),
    ],
)
def test_media_that_no_table_holds(medium, message):
    with pytest.raises(ValueError, match=message):
        atlas.tabulated(medium)
