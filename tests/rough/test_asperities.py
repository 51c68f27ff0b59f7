"""Coupled asperities against boundary elements, closed forms and identities."""

import numpy as np
import pytest

import flatpunch as fp

R = 10e-6
BALL = fp.Paraboloid(R)
BEADS = np.array([(0.0, 0.0), (15e-6, 0.0), (0.0, 15e-6)])
LOWER = np.array([0.0, 0.0, -1e-7])
BODIES = {
    "thick gel": fp.Medium([fp.Layer(5e3, 0.5, 20e-6)], base=fp.RigidBase()),
    "thin gel": fp.Medium([fp.Layer(5e3, 0.5, 5e-6)], base=fp.RigidBase()),
    "half-space": fp.HalfSpace(5e3, 0.5),
    "stiff film": fp.Medium([fp.Layer(50e3, 0.3, 5e-6)], base=fp.HalfSpace(5e3, 0.3)),
    "power law": fp.PowerLawHalfSpace(5e3, 5e-6, 0.3, 0.3),
}
bodies = pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)


@pytest.mark.long
@bodies
def test_three_beads_against_boundary_elements(body):
    """0.2 % of the total force and 1.5 % of each while the gap is more than half a radius; 256 cells leave 0.1 %."""
    depth = [0.3e-6, 1e-6]
    coupled = fp.asperities(body, BALL, BEADS, LOWER, depth=depth)
    assert (coupled.gap.values > 0.5 * coupled.radius.values.max(axis=1)).all()
    x = (np.arange(241) - 120) * 30e-6 / 240 + 7.5e-6
    squares = (x - BEADS[:, 0, None, None]) ** 2 + (x[:, None] - BEADS[:, 1, None, None]) ** 2
    tip = fp.HeightMap(x, x, np.min(squares / (2 * R) - LOWER[:, None, None], axis=0))
    cells = fp.indent(body, tip, depth=depth, method=fp.BoundaryElements(grid=256, fields=True))
    assert coupled.force.values == pytest.approx(cells.force.values, rel=2e-3)
    gx, gy = cells.x.values + tip.centre[0], cells.y.values + tip.centre[1]
    nearest = np.argmin((gx - BEADS[:, 0, None, None]) ** 2 + (gy[:, None] - BEADS[:, 1, None, None]) ** 2, axis=0)
    area = (gx[1] - gx[0]) ** 2
    own = [[float(p[nearest == i].sum()) * area for i in range(3)] for p in cells.pressure.values]
    assert coupled.asperity_force.values == pytest.approx(np.array(own), rel=1.5e-2)


@bodies
def test_force_and_depth_control_agree_and_stiffness_is_the_slope(body):
    depth = 1e-6 * np.array([0.999, 1.0, 1.001])
    coupled = fp.asperities(body, BALL, BEADS, LOWER, depth=depth)
    assert np.diff(coupled.force.values[[0, 2]])[0] / 2e-9 == pytest.approx(float(coupled.stiffness[1]), rel=5e-4)
    back = fp.asperities(body, BALL, BEADS, LOWER, force=coupled.force.values)
    assert back.depth.values == pytest.approx(depth, rel=1e-6)
    assert back.asperity_force.values == pytest.approx(coupled.asperity_force.values, rel=1e-5)


def test_one_asperity_is_the_contact_alone():
    body = BODIES["thin gel"]
    for tip, rel in ((BALL, 1e-6), (fp.Cone(0.3), 1e-6), (fp.Pyramid(4, 0.3), 1e-4)):
        depth = [0.0, 0.2e-6, 1e-6]
        alone, one = fp.indent(body, tip, depth=depth), fp.asperities(body, tip, [(3e-6, 0.0)], depth=depth)
        # cubics between the points of a curve, which for pyramids is one between tabulated solutions
        assert one.force.values == pytest.approx(alone.force.values, rel=rel)
        assert one.radius.values[:, 0] == pytest.approx(alone.radius.values, rel=rel)
        assert one.stiffness.values[1:] == pytest.approx(alone.stiffness.values[1:], rel=1e-4)
        assert one.contacts.values.tolist() == [0, 1, 1]


def test_far_apart_each_sinks_by_the_force_of_the_other():
    """Point forces on a half-space: depth less F/(pi E* distance)."""
    body, apart, star = BODIES["half-space"], 1e-3, 5e3 / 0.75
    pair = fp.asperities(body, BALL, [(0, 0), (apart, 0)], depth=1e-6)
    force = pair.asperity_force.values[0]
    assert pair.asperity_depth.values[0] == pytest.approx(1e-6 - force[::-1] / (np.pi * star * apart), rel=1e-9)
    assert force == pytest.approx(4 / 3 * star * np.sqrt(R) * pair.asperity_depth.values[0] ** 1.5, rel=1e-6)


# each pair against 256 cells of boundary elements, which leave 1e-4; the second half is that of the reports on thin layers
PAIRS = [
    (fp.HalfSpace(5e3, 0.3), 0.01, (0.1, 0.6, 1.5)),
    (fp.Medium([fp.Layer(5e3, 0.5, R)], base=fp.RigidBase()), 0.02, (0.3, 0.6, 1.5)),
    (fp.Medium([fp.Layer(5e3, 0.4, 0.3 * R, bonded=False)], base=fp.RigidBase()), 0.01, (0.3, 1.0, 2.0)),
    (fp.Medium([fp.Layer(5e3, 0.45, 0.1 * R)], base=fp.RigidBase()), 0.005, (0.3, 0.63, 1.46)),
    (fp.Medium([fp.Layer(5e3, 0.5, 0.1 * R)], base=fp.RigidBase()), 0.01, (0.6, 0.94, 1.46)),
]


@pytest.mark.long
@pytest.mark.parametrize(("body", "share", "gaps"), PAIRS)
def test_the_stated_error_holds(body, share, gaps):
    """The error of the total force of two equal contacts, less than ten times too large where it is more than 0.1 %."""
    depth = share * R
    radius = float(fp.indent(body, BALL, depth=depth).radius[0])
    for gap in gaps:
        half = (1 + gap / 2) * radius
        coupled = fp.asperities(body, BALL, [(-half, 0), (half, 0)], depth=depth)
        x = (np.arange(241) - 120) * (2 * half + 3 * radius) / 240
        tip = fp.HeightMap(x, x, (np.minimum((x - half) ** 2, (x + half) ** 2) + x[:, None] ** 2) / (2 * R))
        cells = fp.indent(body, tip, depth=depth, method=fp.BoundaryElements(grid=256))
        true, stated = abs(float(coupled.force[0] / cells.force[0]) - 1), float(coupled.force_error[0])
        assert true <= stated + 1e-4
        assert stated < 10 * max(true, 1e-3)
        assert ("the error of the force is up to" in coupled.notes) == (stated > 0.01)


@pytest.mark.long
def test_errors_of_lower_ones_contain_those_of_their_neighbours():
    """Each force beside a deeper contact, against cells whose own error is that of a single one at the same depth."""
    film = fp.GradedLayer(fp.ExponentialModulus(1e6, 6.7e6, 0.75e-6), 0.45, 0.75e-6)
    body, depth, apart, lower = fp.Medium([film], base=fp.HalfSpace(0.1e6, 0.3)), 0.22e-6, 1.76e-6, 0.08e-6
    side, count = apart / 100, 300
    places = np.array([(-50 * side, 0.0), (50 * side, 0.0)])
    coupled = fp.asperities(body, BALL, places, [0.0, -lower], depth=depth)
    x = (np.arange(count) - count / 2) * side
    alone = np.hypot(x - places[:, :1], x[:, None, None])
    heights = BALL.height(alone, 0 * alone) + np.array([0.0, lower])[:, None]
    surface = fp.Topography(-heights.min(axis=1), side, periodic=False)
    pressure = fp.rough_contact(body, surface, depth=depth, fields=True).pressure.values[0]
    single = fp.Topography(-heights[:, 0], side, periodic=False)
    for i, own in enumerate((pressure[:, x < 0], pressure[:, x >= 0])):
        deep, stated = float(coupled.asperity_depth[0, i]), float(coupled.asperity_force_error[0, i])
        of_cells = fp.rough_contact(body, single, depth=deep).force[0] / fp.indent(body, BALL, depth=deep).force[0]
        true = abs(float(coupled.asperity_force[0, i] * of_cells) / (own.sum() * side**2) - 1)
        assert true <= stated
        assert stated < 10 * true


def test_hundreds_of_touching_asperities_converge():
    """At a force on a layer that all load together; Newton's steps are exact, so that force and stiffness are."""
    rng, side = np.random.default_rng(0), np.arange(16) * 1.2 * R
    places = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2) + 0.3 * R * rng.random((256, 2))
    heights, force = -0.01 * R * rng.random(256), 5e3 * R**2 * 0.256 * np.array([1, 1.002])
    for body in (fp.Medium([fp.Layer(5e3, 0.45, 2 * R)], base=fp.RigidBase()), BODIES["half-space"]):
        coupled = fp.asperities(body, BALL, places, heights, force=force)
        assert coupled.valid.all()
        assert coupled.force.values == pytest.approx(force, rel=1e-9)
        slope = np.diff(coupled.force)[0] / np.diff(coupled.depth)[0]
        assert slope == pytest.approx(coupled.stiffness.values.mean(), rel=1e-4)


def test_hundreds_share_a_force_that_one_alone_could_not_bear():
    """Laws reach as deep as the depths that are found, not as deep as one asperity under the whole force."""
    rng, side = np.random.default_rng(1), np.arange(20) * 2.2 * R
    places = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2) + 0.3 * R * rng.random((400, 2))
    body, heights = fp.Medium([fp.Layer(5e3, 0.45, 2 * R)], base=fp.RigidBase()), -0.1 * R * rng.random(400)
    pressed = fp.asperities(body, fp.Sphere(R), places, heights, depth=[0.02 * R, 0.4 * R])
    assert pressed.contacts.values.tolist() == pytest.approx([80, 400], abs=20)
    assert pressed.gap[-1] > 0.5 * pressed.radius[-1].max()
    back = fp.asperities(body, fp.Sphere(R), places, heights, force=pressed.force.values)
    assert back.depth.values == pytest.approx(pressed.depth.values, rel=1e-6)
    assert back.asperity_force.values == pytest.approx(pressed.asperity_force.values, rel=1e-6)
    with pytest.raises(ValueError, match="beyond this indenter"):
        fp.indent(body, fp.Sphere(R), force=pressed.force.values[-1])


def test_mixed_tips_and_lower_ones_touch_later():
    body = BODIES["thick gel"]
    tips = [BALL, fp.Cone(0.2), fp.Sphere(5e-6)]
    coupled = fp.asperities(body, tips, 3 * BEADS, [0.0, -0.5e-6, -2e-6], depth=[0.2e-6, 1e-6, 3e-6])
    assert coupled.contacts.values.tolist() == [1, 2, 3]
    order = [2, 0, 1]
    turned = fp.asperities(
        body, [tips[i] for i in order], 3 * BEADS[order], np.array([0, -0.5e-6, -2e-6])[order], depth=1e-6
    )
    assert turned.asperity_force.values[0] == pytest.approx(coupled.asperity_force.values[1][order], rel=1e-6)


def test_merging_neighbours_are_marked():
    coupled = fp.asperities(BODIES["half-space"], BALL, BEADS / 3, depth=[0.05e-6, 0.5e-6, 3e-6])
    assert coupled.valid.values.tolist() == [True, True, False]
    assert coupled.gap.values[-1] < 0
    assert "merged" in coupled.notes


def test_summits_of_a_surface():
    rough = fp.self_affine(64, 1e-6, rms_slope=0.05, roll_off=32e-6, cut_off=16e-6, seed=2)
    rough = fp.Topography(rough.heights, rough.spacing, periodic=False)
    summits = rough.summits()
    tips = [fp.EllipticParaboloid(a / 2, b / 2) for a, b in summits.curvatures]
    body = BODIES["half-space"]
    touching = np.argsort(summits.heights)[-4:]
    coupled = fp.asperities(
        body, [tips[i] for i in touching], summits.positions[touching], summits.heights[touching], depth=0.05e-6
    )
    cells = fp.rough_contact(body, rough, depth=0.05e-6)
    # summits of 16 cells; the highest cell is a little lower than its summit
    assert float(coupled.force[0]) == pytest.approx(float(cells.force[0]), rel=0.1)


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"positions": [1.0, 2.0]}, ValueError, "positions has shape"),
        ({"positions": [(0, 0), (0, 0), (1, 1)]}, ValueError, r"positions\[0\] and positions\[1\] are equal"),
        ({"heights": [0.0, 1.0]}, ValueError, "heights has 2 values for 3"),
        ({"tips": [BALL, BALL]}, ValueError, "tips has 2 entries"),
        ({"tips": fp.RoundedPunch(1e-6, 1e-7)}, ValueError, "RoundedPunch"),
        ({"tips": "abc"}, TypeError, "indenter"),
        ({"tips": None}, TypeError, "indenter"),
        ({"tips": fp.Cylinder(1e-6)}, ValueError, "Cylinder, which has a flat end"),
        ({"depth": None}, ValueError, "exactly one"),
        ({"positions": np.random.default_rng(0).random((5001, 2))}, ValueError, "at most 5000"),
    ],
)
def test_refusals(change, error, words):
    with pytest.raises(error, match=words):
        fp.asperities(**{"medium": BODIES["half-space"], "tips": BALL, "positions": BEADS, "depth": 1e-7, **change})
