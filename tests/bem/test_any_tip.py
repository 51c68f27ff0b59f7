"""Tips without an outline about one apex: maps of several summits, flat tops, noise, rectangles; rollers and rounded punches."""

import numpy as np
import pytest

import flatpunch as fp

E, NU = 1e9, 0.3
BODY = fp.HalfSpace(E, NU)
STAR = E / (1 - NU**2)
R = 2e-6
X, Y = np.linspace(-2e-6, 2e-6, 161), np.linspace(-1e-6, 1e-6, 81)


def ball(x=0.0, y=0.0, height=0.0):
    return height + ((X - x) ** 2 + (Y[:, None] - y) ** 2) / (2 * R)


def hertz(depth):
    return 4 / 3 * STAR * np.sqrt(R) * depth**1.5


def test_two_summits_feel_each_other():
    """Each sinks by what the other has pressed down, F/(pi E* distance), to first order of radius over distance."""
    tip, depth, apart = fp.HeightMap(X, Y, np.minimum(ball(-1e-6), ball(1e-6))), 2e-8, 2e-6
    curve = fp.indent(BODY, tip, depth=depth)
    assert curve.attrs["method"] == "bem"
    force = hertz(depth)
    for _ in range(20):
        force = hertz(depth - force / (np.pi * STAR * apart))
    assert float(curve.force[0]) == pytest.approx(2 * force, rel=2e-3)
    assert int(curve.patches[0]) == 2
    assert bool(curve.valid[0])
    assert "contour" not in curve
    assert "no outline" in fp.plot_outline(curve).get_title()
    by_force = fp.indent(BODY, tip, force=float(curve.force[0]))
    assert float(by_force.depth[0]) == pytest.approx(depth, rel=1e-4)
    pressure = fp.pressure(BODY, tip, [0.0, 2e-6, 1e-6], 0.0, depth=depth)
    assert pressure[0] == pytest.approx(pressure[1], rel=0.01)
    assert pressure[2] == 0


@pytest.mark.long
def test_a_second_summit_beyond_the_circle_is_not_forgotten():
    tip = fp.HeightMap(X, Y, np.minimum(ball(1e-6), ball(-1e-6, height=1e-8)))
    assert tip.rising
    assert tip.elsewhere == pytest.approx(1e-8)
    shallow, deep = fp.indent(BODY, tip, depth=[5e-9]), fp.indent(BODY, tip, depth=[3e-8])
    assert shallow.attrs["method"] == "refined"
    assert deep.attrs["method"] == "bem"
    assert int(deep.patches[0]) == 2
    alone = fp.indent(BODY, tip, depth=3e-8, method="second-order")
    assert not alone.valid[0]
    assert "method='bem'" in alone.notes
    # also where the depth follows from a force
    force = float(deep.force[0])
    assert float(fp.indent(BODY, tip, force=force, method="bem").depth[0]) == pytest.approx(3e-8, rel=1e-3)


def test_noise_agrees_with_the_rough_solver_on_the_same_cells():
    noisy = ball() + 1e-9 * np.random.default_rng(1).standard_normal((Y.size, X.size))
    noisy -= noisy.min()
    tip = fp.HeightMap(X, Y, noisy)
    assert not tip.rising
    h = X[1] - X[0]
    grid = fp.bem.Grid(X.size, Y.size, h, (-tip.centre[0], -tip.centre[1]))
    # the spline between the points is lower than the lowest of them
    lower = float(tip.height(*(np.asarray(each) for each in _polar(tip, noisy))))
    depth = 2e-8
    cells = fp.indent(BODY, tip, depth=depth + lower, method=fp.BoundaryElements(grid=grid))
    rough = fp.rough_contact(BODY, fp.Topography(-noisy, h, periodic=False), depth=depth)
    assert float(cells.force[0]) == pytest.approx(float(rough.force[0]), rel=1e-4)
    assert int(cells.patches[0]) > 1


def _polar(tip, noisy):
    j, i = np.unravel_index(np.argmin(noisy), noisy.shape)
    x, y = X[i] - tip.centre[0], Y[j] - tip.centre[1]
    return np.hypot(x, y), np.arctan2(y, x)


def test_a_flat_top_agrees_with_the_exact_truncated_tip():
    tip = fp.HeightMap(X, Y, np.maximum(ball() - 1e-8, 0.0))
    exact = fp.indent(BODY, fp.Truncated(fp.Paraboloid(R), 1e-8), depth=[1e-8, 4e-8])
    # the spline rounds the border of the flat over two points of a tenth of its radius
    assert fp.indent(BODY, tip, depth=[1e-8, 4e-8]).force.values == pytest.approx(exact.force.values, rel=0.01)


@pytest.mark.long
def test_contact_at_the_border_of_the_map_is_marked():
    ridge = fp.HeightMap(X, Y, X**2 / (2 * R) + 0 * Y[:, None])
    curve = fp.indent(BODY, ridge, depth=1e-8)
    assert not curve.valid[0]
    assert "border of the map" in curve.notes
    # a tip that rises, pressed in beyond its map; one whose missing values cut it off
    assert fp.indent(BODY, fp.HeightMap(X, Y, ball()), depth=[1e-7, 7e-7], method="bem").valid.values.tolist() == [
        True,
        False,
    ]
    small = fp.HeightMap(X, Y, np.where(ball() > 5e-8, np.nan, ball()))
    assert fp.indent(BODY, small, depth=[2e-8, 1.5e-7], method="bem").valid.values.tolist() == [True, False]


@pytest.mark.long
def test_missing_values_at_the_rim_change_nothing_inside():
    whole, part = fp.HeightMap(X, Y, ball()), fp.HeightMap(X, Y, np.where(ball() > 1.5e-7, np.nan, ball()))
    assert part.reach < np.sqrt(2 * R * 1.5e-7)
    for method in ("second-order", "bem"):
        force = [float(fp.indent(BODY, tip, depth=3e-8, method=method).force[0]) for tip in (whole, part)]
        assert force[0] == pytest.approx(force[1], rel=1e-3)
    assert np.isinf(part.height(np.array(0.9e-6), np.array(0.0)))
    tilt = 0.1 * X + 0 * Y[:, None]
    level = fp.HeightMap(X, Y, np.where(ball() > 1.5e-7, np.nan, ball() + tilt), level=True)
    assert level.centre == pytest.approx((0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("method", ["exact", "first-order", "second-order", "fourth-order", "refined"])
def test_fast_methods_refuse_by_name(method):
    for tip in (
        fp.HeightMap(X, Y, np.minimum(ball(-1e-6), ball(1e-6))),
        fp.Roller(R, 1e-6),
        fp.RoundedPunch(1e-6, 1e-7),
    ):
        with pytest.raises(ValueError, match=f"{type(tip).__name__} .*method='bem'"):
            fp.indent(BODY, tip, depth=1e-8, method=method)


@pytest.mark.parametrize(
    "act",
    [
        lambda tip: fp.indent(BODY, tip, radius=1e-8),
        lambda tip: fp.pressure(BODY, tip, 0.0, 0.0, radius=1e-8),
        lambda tip: fp.Tilted(tip, 0.01),
        lambda tip: fp.Truncated(tip, 1e-9),
        lambda tip: fp.indent(BODY, tip, depth=[0, 1e-8], time=[0, 1], relaxation=fp.Prony([0.5], [1.0])),
    ],
)
def test_what_needs_an_outline_refuses(act):
    with pytest.raises(ValueError, match="flat end that is not round"):
        act(fp.RoundedPunch(1e-6, 1e-7))


def test_what_needs_the_highest_stress_refuses():
    with pytest.raises(ValueError, match="highest stresses lie along edges and ends"):
        fp.critical_load(BODY, fp.RoundedPunch(1e-6, 1e-7), [fp.Strength(yield_stress=1e6)])


def test_fields_under_several_summits():
    tip = fp.HeightMap(X, Y, np.minimum(ball(-1e-6), ball(1e-6)))
    inside = fp.fields(BODY, tip, x=[0.0, 2e-6, 1e-6], y=0.0, z=[8e-8], depth=2e-8)
    below, beside, between = inside.von_mises.values.ravel()
    assert below == pytest.approx(beside, rel=0.02)
    assert between < 0.1 * below


def test_a_crowned_roller_is_an_ellipse_until_its_end():
    roller, ellipse = fp.Roller(5e-3, 4e-3, crown=10e-3), fp.EllipticParaboloid(100.0, 50.0)
    steel = fp.HalfSpace(210e9, 0.3)
    for method, rel in (("refined", 1e-4), ("bem", 1e-4)):
        force = fp.indent(steel, roller, depth=1e-6, method=method).force
        assert float(force[0]) == pytest.approx(float(fp.indent(steel, ellipse, depth=1e-6).force[0]), rel=rel)


@pytest.mark.long
def test_a_long_roller_is_a_line_contact():
    """Half-width sqrt(4 F R/(pi E* length)) in the middle, where the ends do not reach."""
    steel, length = fp.HalfSpace(210e9, 0.3), 4e-3
    roller = fp.Roller(5e-3, length, end_radius=0.2e-3)
    contact = fp.indent(steel, roller, force=200.0, method=fp.BoundaryElements(fields=True))
    p = contact.pressure.values[0]
    h = float(contact.x[1] - contact.x[0])
    line = p[p.shape[0] // 2].sum() * h
    a = np.sqrt(4 * line * 5e-3 / (np.pi * 210e9 / 0.91))
    assert p[p.shape[0] // 2].max() == pytest.approx(2 * line / (np.pi * a), rel=5e-3)
    # the load per length rises at the ends; in the middle it is a little less than the mean
    assert line == pytest.approx(200.0 / (length - 2 * 0.2e-3), rel=0.1)
    sharp = fp.indent(steel, fp.Roller(5e-3, length), force=200.0)
    assert "presses like the edge of a punch" in sharp.notes
    assert sharp.valid.all()


def test_a_rounded_punch_is_between_two_sharp_ones():
    """Square ends: F = 1.15 E* side depth; with small radii it is close to the punch of the flat and what touches beyond."""
    punch, depth = fp.RoundedPunch(1e-3, 0.05e-3), 1e-7
    contact = fp.indent(BODY, punch, depth=depth)
    force, error = float(contact.force[0]), float(contact.force_error[0])
    assert error < 0.02
    beyond = np.sqrt(2 * 0.05e-3 * depth)
    low, high = (1.1523 * STAR * 2 * half * depth for half in (0.95e-3, 0.95e-3 + beyond))
    assert low * (1 - error) < force < high * (1 + error)
    np.testing.assert_allclose(punch.box(np.inf), ((1e-3, 1e-3), (0.0, 0.0)), atol=1e-15)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: fp.Roller(1e-3, 1e-3, crown=1.0, end_radius=1e-4), "both given"),
        (lambda: fp.Roller(1e-3, 1e-3, end_radius=1e-3), "more than half"),
        (lambda: fp.Roller(1e-3, -1e-3), "Roller.length"),
        (lambda: fp.RoundedPunch(1e-3, 1e-3), "nothing of it is flat"),
        (lambda: fp.RoundedPunch(1e-3, 1e-4, sides=2), "sides"),
    ],
)
def test_shapes_refuse(make, words):
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.long
def test_the_first_failure_under_two_summits_is_that_of_one():
    """Each fails at the load of a single one, a little more for the help of the other; also where the second is lower."""
    film = fp.Medium([fp.Layer(2e9, 0.3, 3e-7)], base=BODY)
    strengths = [fp.Strength(yield_stress=1e8)] * 2
    alone = fp.critical_load(film, fp.Paraboloid(R), strengths)
    equal = fp.critical_load(film, fp.HeightMap(X, Y, np.minimum(ball(-1e-6), ball(1e-6))), strengths)
    assert equal.force == pytest.approx(2 * alone.force, rel=0.03)
    assert equal.place[2] == pytest.approx(alone.place[2], rel=0.1)
    lower = fp.critical_load(film, fp.HeightMap(X, Y, np.minimum(ball(-1e-6), ball(1e-6, height=1e-8))), strengths)
    assert alone.force < lower.force < equal.force
    tip = fp.HeightMap(X, Y, np.minimum(ball(-1e-6), ball(1e-6)))
    peaks = fp.peak_stresses(film, tip, force=equal.force)
    assert peaks.von_mises.values.max() == pytest.approx(1e8, rel=0.03)


@pytest.mark.long
@pytest.mark.parametrize(
    "tip",
    [
        'kind = "roller"\nradius = "5 mm"\nlength = "2 mm"\nend_radius = "0.2 mm"',
        'kind = "rounded-punch"\nhalf_width = "1 mm"\ncorner_radius = "0.1 mm"',
    ],
)
def test_the_command_line_solves_and_draws_them(tip, tmp_path):
    from typer.testing import CliRunner

    from flatpunch.cli.app import app

    case = tmp_path / "case.toml"
    body = 'base = { kind = "half-space", young = "210 GPa", poisson = 0.3 }\n'
    stress = """[stress]
x = { start = "-0.1 mm", stop = "0.1 mm", points = 5 }
z = ["20 um", "40 um"]
strengths = [{ yield_stress = "1 GPa" }]
"""
    case.write_text(f'{body}[indenter]\n{tip}\n[control]\nforce = "100 N"\n{stress}', encoding="utf-8")
    for command in ("solve", "stress", "check", "show-tip"):
        picture = (
            ["--output" if command == "show-tip" else "--plot", str(tmp_path / "out.png")] if command != "check" else []
        )
        done = CliRunner().invoke(app, [command, str(case), *picture], env={"COLUMNS": "120", "NO_COLOR": "1"})
        assert done.exit_code == 0, (command, done.output)
        assert "not searched under this tip" in done.output or command != "stress"


@pytest.mark.long
def test_outline_of_slender_contacts_is_that_of_rays_to_their_ends():
    """Rays are read inside the box of the contact alone: their number grows with its length over its width."""
    grid = fp.bem.Grid(nx=16, ny=4096, spacing=1.0)
    contact = np.zeros(grid.shape)
    contact[48:-48, 3:-3] = 1.0
    outline = fp.bem.trace_outline(grid, contact, sharp=True)
    assert outline.contour[outline.phi.size // 4] == pytest.approx(2000.0, abs=1.0)
    assert outline.contour[0] == pytest.approx(5.0, abs=0.5)
    assert outline.area == 4000 * 10


@pytest.mark.long
@pytest.mark.parametrize("length", [5e-5, 2e-4, 1e-3])
def test_error_of_rollers_narrower_than_their_cells(length):
    """Line loads of finite length, at their mean displacement: contacts 200 to 20000 times as long as wide."""
    star, radius, force = 210e9 / 0.91, 1e-5, 1e-2
    found = fp.indent(fp.HalfSpace(210e9, 0.3), fp.Roller(radius, length), force=force)
    # a uniform line load presses deeper in its middle than on average
    middle = 1 + np.log(np.pi * length**3 * star / (force * radius))
    depth = force / (np.pi * star * length) * (middle + 2 * np.log(2) - 2)
    missing = float(found.stiffness[0]) * abs(float(found.depth[0]) - depth) / force
    assert missing < float(found.force_error[0]) + 0.02


@pytest.mark.long
@pytest.mark.parametrize("force", [1e-4, 1.0])
def test_contacts_narrower_than_a_cell_reach_their_force(force):
    """A roller a thousand times longer than its radius: no cell centre is at the line of first touch."""
    curve = fp.indent(BODY, fp.Roller(radius=1e-3, length=1.0, end_radius=1e-3), force=force)
    assert float(curve.force[0]) == pytest.approx(force, rel=1e-6)
    assert "not converged" not in curve.notes
    assert not curve.valid[0]
    assert "the force is expected to be off" in curve.notes
