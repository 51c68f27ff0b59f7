"""Layers, films and gradings: independent tables, thin limits, Krein's identity against differences, many instabilities."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.adhesion.branch import stiffness_growth
from flatpunch.contact.adhesion.case import adhesive_case
from support.fredholm import CASES, pull_off

DATA = Path(__file__).parent.parent / "data"


def rows(name):
    with (DATA / name).open() as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def layer(poisson, *, bonded=True, thickness=1.0):
    """A layer with E* = 1."""
    return fp.Medium([fp.Layer(1 - poisson**2, poisson, thickness, bonded=bonded)], base=fp.RigidBase())


def unit_layer(name):
    poisson = CASES[name]
    return layer(0.3 if poisson is None else poisson, bonded=poisson is not None)


@pytest.mark.parametrize("row", rows("jkr_layer_pull_off.csv"), ids=lambda row: f"{row['base']} {row['theta']}")
def test_pull_off_table(row):
    work = 1 / float(row["theta"])
    point = fp.pull_off(unit_layer(row["base"]), fp.Paraboloid(1.0), work_of_adhesion=work)
    # ten digits printed after the point; the radius of a minimum by series in the other road is good to 1e-7
    assert point.force / (np.pi * work) == pytest.approx(float(row["force"]), abs=2e-10)
    assert point.radius == pytest.approx(float(row["beta"]), rel=2e-7)


def test_table_is_what_its_script_gives():
    row = rows("jkr_layer_pull_off.csv")[9]
    force, beta = pull_off(float(row["theta"]), CASES[row["base"]])
    assert force == pytest.approx(float(row["force"]), abs=1e-9)
    assert beta == pytest.approx(float(row["beta"]), rel=1e-6)


@pytest.mark.parametrize(("poisson", "bonded", "limit"), [(0.3, True, -2), (0.3, False, -2), (0.5, True, -3)])
def test_thin_limits_of_the_pull_off_force(poisson, bonded, limit):
    medium = layer(poisson, bonded=bonded)
    theta = np.array([1e-5, 1e-6, 1e-7]) if limit == -2 else np.array([1e-7, 1e-8, 1e-9])
    points = [fp.pull_off(medium, fp.Paraboloid(1.0), work_of_adhesion=1 / value) for value in theta]
    force = np.array([point.force * value / np.pi for point, value in zip(points, theta, strict=True)])
    thinness = np.array([1 / point.radius for point in points])
    # corrections are a series in h/a: three points take off its first two powers
    extrapolated = np.polynomial.polynomial.polyfit(thinness, force, 2)[0]
    assert abs(force[-1] - limit) < 0.15
    # what the third power leaves: (h/a)^3 over the three points, 1e-4 for compressible layers, 1e-2 for incompressible ones,
    # whose series starts with a larger coefficient
    assert extrapolated == pytest.approx(limit, abs=1e-4 if limit == -2 else 1e-2)


@pytest.mark.parametrize(
    "medium",
    [
        layer(0.5),
        fp.Medium([fp.Layer(1.0, 0.3, 1.0)], base=fp.HalfSpace(0.01, 0.3)),
        fp.Medium([fp.Layer(1.0, 0.3, 0.3), fp.Layer(5.0, 0.4, 0.5)], base=fp.HalfSpace(0.1, 0.3)),
    ],
    ids=["bonded incompressible", "film", "two layers"],
)
def test_stiffness_growth_is_the_derivative_of_the_stiffness(medium):
    case = adhesive_case(compliance(medium), fp.Paraboloid(1.0), 0.1)
    a, step = np.geomspace(1e-3, 20, 30), 1e-3
    growth, power = stiffness_growth(case.kernel, case.branch.evaluate(a))
    samples = [case.branch.evaluate(a * np.exp(j * step)).stiffness for j in (-2, -1, 1, 2)]
    difference = (samples[0] - 8 * samples[1] + 8 * samples[2] - samples[3]) / (12 * step)
    # five points: 0.03 step^4 = 3e-14, and the noise 1e-11 of the punch family over the step
    assert np.allclose(growth, difference, rtol=3e-8)
    after, before = (stiffness_growth(case.kernel, case.branch.evaluate(a * np.exp(j * step)))[0] for j in (1, -1))
    # three points: step^2/6 times the third logarithmic derivative, of order one
    assert np.allclose(power, np.log(after / before) / (2 * step) - 1, atol=3e-6)


@pytest.mark.parametrize("thickness", [0.05, 1.0, 20.0])
@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_slopes_and_energy_balance(thickness, poisson):
    # dE = F dd along the branch of equilibria: the adhesion enters through both sides
    from flatpunch.contact.adhesion.loop import contact_energy

    case = adhesive_case(compliance(layer(poisson, thickness=thickness)), fp.Paraboloid(10.0), 0.3)
    ends = np.log(case.stability.depth[0].start * np.array([1.0, 5.0]))
    t, v = np.polynomial.legendre.leggauss(40)
    x = ends[0] + (ends[1] - ends[0]) / 2 * (t + 1)
    contact = case.branch.at(np.exp(x))
    work = np.sum(contact.force * contact.depth_slope * v) * (ends[1] - ends[0]) / 2
    energy = contact_energy(case, np.exp(ends))
    # the derivatives along the branch are good to 1e-9
    assert energy[1] - energy[0] == pytest.approx(work, rel=1e-8)
    step = 1e-4
    above, below = case.branch.at(np.exp(x + step)), case.branch.at(np.exp(x - step))
    scale = np.abs(contact.force_slope).max()
    assert np.allclose((above.force - below.force) / (2 * step), contact.force_slope, rtol=0, atol=1e-6 * scale)


@pytest.mark.long
@pytest.mark.parametrize("quantity", ["depth", "force"])
@pytest.mark.parametrize(
    ("medium", "indenter"),
    [
        (fp.HalfSpace(1.0, 0.3), fp.Paraboloid(10.0)),
        (layer(0.5), fp.Paraboloid(10.0)),
        (layer(0.5, thickness=0.6), fp.Cylinder(1.0)),
        (fp.Medium([fp.Layer(1e4, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)), fp.PowerLaw(4.0, 1e-4)),
    ],
    ids=["half-space", "layer", "flat end", "film"],
)
def test_area_of_the_loop_is_the_energy_lost(medium, indenter, quantity):
    loop = fp.adhesion_loop(medium, indenter, work_of_adhesion=0.3, points=3001, **{quantity: 0.5})
    area = np.trapezoid(loop.force, loop.depth)
    # trapezoids of step 1/3000, the last of them beside a square root: 3000^-1.5 = 6e-6
    assert loop.attrs["energy_lost"] == pytest.approx(float(area), rel=2e-5)
    jumps = json.loads(loop.attrs["jumps"])
    assert jumps[0]["kind"] == "jump_in"
    assert jumps[-1]["kind"] == "pull_off"
    # a jump at prescribed depth never gains energy
    assert quantity == "force" or all(jump["energy"] > 0 for jump in jumps)


@pytest.mark.long
def test_a_film_has_two_stable_contacts():
    medium = fp.Medium([fp.Layer(1e4, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    found = []
    for work in np.geomspace(0.03, 300, 9):
        point = fp.pull_off(medium, fp.PowerLaw(4.0, 1e-3), work_of_adhesion=work)
        found.append(len(point.depth_instabilities))
        assert point.depth_minimum.depth == min(p.depth for p in point.depth_instabilities)
        for here in point.depth_instabilities:
            curve = fp.indent(
                medium, fp.PowerLaw(4.0, 1e-3), radius=here.radius * np.array([0.99, 1.01]), work_of_adhesion=work
            )
            # a minimum of the depth: both neighbours lie above
            assert (curve.depth > here.depth).all()
    assert max(found) == 2


def test_flat_end_on_a_thin_incompressible_layer_shrinks_before_it_is_lost():
    medium = layer(0.5, thickness=0.2)
    point = fp.pull_off(medium, fp.Cylinder(1.0), work_of_adhesion=0.01)
    assert point.force_minimum.radius == 1.0
    assert point.depth_minimum.radius < 0.5
    depth = np.linspace(1.01 * point.depth, 0.99 * point.depth_minimum.depth, 20)
    curve = fp.indent(medium, fp.Cylinder(1.0), depth=depth, work_of_adhesion=0.01)
    assert curve.stable_depth.all()
    assert not curve.stable_force.any()
    assert (np.diff(curve.radius) < 0).all()


def test_equal_layers_are_one_body():
    stack = fp.Medium([fp.Layer(1.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    radius = np.geomspace(0.01, 10, 20)
    a = fp.indent(stack, fp.Paraboloid(10.0), radius=radius, work_of_adhesion=0.3)
    b = fp.indent(fp.HalfSpace(1.0, 0.3), fp.Paraboloid(10.0), radius=radius, work_of_adhesion=0.3)
    # both terms of the force cancel in part: rounding of the larger one, times the panels' 1e-12
    assert np.allclose(a.force, b.force, rtol=1e-9, atol=1e-10)


def test_scaling():
    # lengths times s, moduli times e: forces times e s^2, w times e s
    s, e = 1e-6, 1e6
    one = fp.pull_off(layer(0.3), fp.Paraboloid(10.0), work_of_adhesion=0.3)
    medium = fp.Medium([fp.Layer(e * (1 - 0.3**2), 0.3, s)], base=fp.RigidBase())
    other = fp.pull_off(medium, fp.Paraboloid(10.0 * s), work_of_adhesion=0.3 * e * s)
    assert other.force == pytest.approx(one.force * e * s**2, rel=1e-11)
    # the radius of a minimum is known to the noise of the slope, 1e-10
    assert other.radius == pytest.approx(one.radius * s, rel=1e-8)
    assert other.depth_minimum.depth == pytest.approx(one.depth_minimum.depth * s, rel=1e-11)


def test_power_law_half_space():
    from flatpunch.media import PowerLawHalfSpace

    # pull-off -(3 + k)/2 pi w R, whatever the modulus
    medium = PowerLawHalfSpace(modulus=1.0, depth=1.0, exponent=0.3, poisson=0.3)
    point = fp.pull_off(medium, fp.Paraboloid(10.0), work_of_adhesion=0.3)
    assert point.force == pytest.approx(-1.65 * np.pi * 0.3 * 10.0, rel=1e-11)


def test_graded_layer_and_two_bodies():
    from flatpunch.media import GradedLayer, TwoBodies

    # a grading so slight that it is none; two halves of one compliance
    plain = fp.pull_off(layer(0.3), fp.Paraboloid(10.0), work_of_adhesion=0.3)
    graded = fp.Medium([GradedLayer(lambda z: 0.91 * (1 + 1e-9 * z), 0.3, 1.0)], base=fp.RigidBase())
    # the grading itself, and the targets of graded punches, 1e-7
    point = fp.pull_off(graded, fp.Paraboloid(10.0), work_of_adhesion=0.3)
    assert point.force == pytest.approx(plain.force, rel=1e-7)
    twice = fp.Medium([fp.Layer(2 * 0.91, 0.3, 1.0)], base=fp.RigidBase())
    point = fp.pull_off(TwoBodies(twice, twice), fp.Paraboloid(10.0), work_of_adhesion=0.3)
    assert point.force == pytest.approx(plain.force, rel=1e-10)


PRESSED = {
    "half-space": fp.HalfSpace(1.0, 0.3),
    "soil": fp.PowerLawHalfSpace(modulus=1.0, depth=1.0, exponent=0.4, poisson=0.3),
    "film": fp.Medium([fp.Layer(5.0, 0.3, 0.5)], fp.HalfSpace(1.0, 0.3)),
    "graded": fp.Medium([fp.GradedLayer(fp.ExponentialModulus(1.0, 3.0, 1.0), 0.3, 1.0)], fp.HalfSpace(3.0, 0.3)),
    "two bodies": fp.TwoBodies(layer(0.3), fp.HalfSpace(1.0, 0.3)),
}


@pytest.mark.long
@pytest.mark.parametrize("work", [1e-4, 1e-2])
@pytest.mark.parametrize("body", PRESSED)
def test_the_pressure_balances_the_stress_at_the_surface(body, work):
    """The part that pulls is that of a flat punch on this body: on power-law half-spaces its edge is not a root."""
    for tip in (fp.Paraboloid(2.0), fp.Cone(0.3), fp.Truncated(fp.Cone(0.3), height_removed=0.1)):
        at = {"radius": 0.8, "work_of_adhesion": work}
        r = 0.8 * np.array([0.01, 0.3, 0.6, 0.9, 0.99])
        p, error = fp.pressure(PRESSED[body], tip, r, 0.0, return_error=True, **at)
        fields = fp.fields(PRESSED[body], tip, r, 0.0, 0.0, **at)
        assert np.all(
            np.abs(p + fields.stress.values[2]) <= error + (fields.attrs["stress_error"] + 1e-11) * np.abs(p).max()
        )
        assert error.max() < 1e-3 * np.abs(p).max()
