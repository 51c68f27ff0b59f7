"""Planned curves: standard errors against differences of `indent` and against fits; what is degenerate; case files."""

import re

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.files import CaseError
from flatpunch.fits import LogNormal, Normal, Uniform, fit, plan_scan, planned, read_fit_case
from flatpunch.fits.case import plan_of
from flatpunch.fits.description import describe_fit
from flatpunch.indenters import Cone, Pyramid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase, TwoBodies
from flatpunch.media.paths import value_of, with_values
from support.commands import run
from support.sticky_curves import sticky
from support.synthetic_curves import synthetic

YOUNG, THICK = "layers[0].young", "layers[0].thickness"
GEL, BEAD = Medium([Layer(5e3, 0.45, 1e-6)], RigidBase()), Sphere(3e-6)
FILM = Medium([Layer(2e9, 0.35, 1e-6)], HalfSpace(20e9, 0.3))
PAIR = TwoBodies(Medium([Layer(1e9, 0.4, 5e-7)], HalfSpace(3e9, 0.3)), HalfSpace(5e9, 0.2))


@pytest.mark.parametrize(
    ("medium", "tip", "free"),
    [
        (GEL, BEAD, [YOUNG, THICK, "indenter.radius"]),
        (FILM, Cone(0.35), [YOUNG, "layers[0].poisson", "indenter.inclination"]),
        (PAIR, BEAD, ["upper.layers[0].thickness", "lower.base.young"]),
    ],
    ids=["gel", "film", "two bodies"],
)
@pytest.mark.parametrize("spring", [None, 0.1])
def test_errors_by_differences(medium, tip, free, spring):
    """The information of central differences of `indent`: their own error, 1e-8, over the smallest eigenvalue of it."""
    depth, noise, count = 2e-7, 1e-10, 301
    z = np.linspace(-1e-7, depth, count)
    inside = z > 1e-12

    def force(values):
        medium_, tip_ = with_values(medium, tip, values)
        found = np.zeros(count)
        found[inside] = indent(medium_, tip_, depth=z[inside], angles=1)["force"].values
        return found

    rows = []
    for name in free:
        value = value_of(medium, tip, name)
        h = 1e-4 * value
        rows.append((force({name: value + h}) - force({name: value - h})) / (2 * h))
    stiffness = np.zeros(count)
    stiffness[inside] = indent(medium, tip, depth=z[inside], angles=1)["stiffness"].values
    rows += [-stiffness, np.ones(count)]
    jacobian = np.array(rows) / (noise * (1 if spring is None else 1 + stiffness / spring))
    unit = 1 / np.sqrt(np.diag(jacobian @ jacobian.T))
    scaled = jacobian * unit[:, None]
    expected = np.sqrt(np.diag(np.linalg.inv(scaled @ scaled.T))) * unit
    plan = planned(
        medium, tip, free, depth=depth, noise=noise, points=count, spring_constant=spring, baseline="constant"
    )
    assert plan.names == (*free, "contact", "baseline")
    np.testing.assert_allclose(plan.errors, expected, rtol=3e-3)


@pytest.mark.long
@pytest.mark.parametrize(("medium", "tip"), [(GEL, BEAD), (FILM, Cone(0.35))], ids=["gel", "film"])
def test_errors_are_those_of_the_fit(medium, tip):
    """At the fitted values; what is left is the contact point, which the noise moves by 1 % of the depth."""
    curve = synthetic(medium, tip, 0.4e-6, points=600)
    result = fit(curve, medium, tip, [YOUNG, THICK], baseline="constant")
    planning = {"depth": 0.4e-6, "noise": result.noise, "points": 600}
    plan = planned(*result.case, [YOUNG, THICK], **planning, baseline="constant")
    for name in result.names:
        assert plan[name] == pytest.approx(result.estimates[name].stderr, rel=0.04), name
    np.testing.assert_allclose(plan.correlation, result.correlation, atol=0.03)
    # by itself the tilt counts that such a fit does not exclude: on average what a tilt that is fitted costs
    tilted = planned(*result.case, [YOUNG, THICK], **planning, baseline="linear")
    assert planned(*result.case, [YOUNG, THICK], **planning)[YOUNG] == tilted[YOUNG] > plan[YOUNG]


def test_adhesive_retract():
    """The errors of a fit of a sticking tip, from its own model."""
    body, work = HalfSpace(5e3, 0.5), 1e-4
    found = [
        planned(body, BEAD, ["base.young", "work_of_adhesion"], depth=3e-7, noise=n, work_of_adhesion=work)
        for n in (1e-11, 2e-11)
    ]
    assert found[1]["work_of_adhesion"] == pytest.approx(2 * found[0]["work_of_adhesion"], rel=1e-12)
    assert found[0].judgement("work_of_adhesion") == "determined"
    plain = planned(body, BEAD, ["base.young"], depth=3e-7, noise=1e-11)
    # a dip below the baseline fixes the contact point: the modulus is better known than without one
    alone = planned(body, BEAD, ["base.young"], depth=3e-7, noise=1e-11, work_of_adhesion=work)
    assert alone["base.young"] < plain["base.young"]


@pytest.mark.long
def test_readings_near_the_instability_of_a_cantilever_are_not_planned():
    """As in fits; with them the work of adhesion would be known 1.4 times better. Readings are even over another way there."""
    body, names, spring = HalfSpace(5e3, 0.5), ["base.young", "work_of_adhesion"], 0.01
    curve = sticky(body, BEAD, 1e-4, 3e-7, spring=spring, noise=0.005, points=600)
    result = fit(curve, body, BEAD, names, work_of_adhesion=1e-4)
    depth = result.depth[result.used]
    plan = planned(
        *result.case,
        names,
        depth=float(depth.max()),
        before=-float(depth.min()),
        points=depth.size,
        noise=result.noise,
        spring_constant=spring,
        work_of_adhesion=result["work_of_adhesion"],
    )
    for name in names:
        assert plan[name] == pytest.approx(result.estimates[name].stderr, rel=0.25), name


def test_half_space_determines_the_contact_modulus_only():
    """E and Poisson's ratio of a half-space are one number, E/(1 - nu^2), at any depth and noise; a prior of one tells both."""
    body = HalfSpace(5e3, 0.4)
    names = ["base.young", "base.poisson"]
    plan = planned(body, BEAD, names, depth=4e-7, noise=1e-13)
    assert [plan.judgement(name) for name in names] == ["not determined"] * 2
    assert any("Only a combination of base.young and base.poisson" in note for note in plan.notes)
    known = planned(body, BEAD, names, depth=4e-7, noise=1e-13, priors={"base.poisson": Normal(0.4, 0.05)})
    assert known["base.poisson"] == pytest.approx(0.05, rel=1e-6)
    # d ln E = -2 nu d nu/(1 - nu^2)
    assert known["base.young"] / 5e3 == pytest.approx(0.8 * 0.05 / 0.84, rel=1e-3)


@pytest.mark.long
def test_no_effect_and_little_effect():
    same = Medium([Layer(5e3, 0.5, 1e-6)], HalfSpace(5e3, 0.5))
    plan = planned(same, BEAD, [YOUNG, THICK], depth=2e-7, noise=1e-11)
    assert any("layers[0].thickness has hardly any effect" in note for note in plan.notes)
    assert plan.judgement(YOUNG) == "determined"
    shallow = planned(GEL, BEAD, [YOUNG, THICK], depth=2e-8, noise=1e-10)
    assert shallow.judgement(THICK) == "not determined"
    assert any("hardly distinguished" in note for note in shallow.notes)
    assert "not determined" in shallow.summary()
    assert "standard error" in str(shallow)


@pytest.mark.long
def test_more_depth_and_more_readings_help():
    errors = [planned(GEL, BEAD, [YOUNG], depth=d, noise=1e-11)[YOUNG] for d in (1e-7, 2e-7, 4e-7)]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]
    few, many = (planned(GEL, BEAD, [YOUNG], depth=2e-7, noise=1e-11, points=n)[YOUNG] for n in (2000, 8000))
    assert few / many == pytest.approx(2, rel=2e-2)


@pytest.mark.long
def test_tips_that_are_not_round_say_what_is_taken():
    plan = planned(GEL, Pyramid(4, 0.35), [YOUNG], depth=2e-7, noise=1e-11)
    assert any("mean profile" in note for note in plan.notes)
    # the fourth order, which fits take
    curve = synthetic(GEL, Pyramid(4, 0.35), 0.4e-6, points=600)
    result = fit(curve, GEL, Pyramid(4, 0.35), [YOUNG], baseline="constant")
    plan = planned(*result.case, [YOUNG], depth=0.4e-6, noise=result.noise, points=600, baseline="constant")
    assert plan[YOUNG] == pytest.approx(result.estimates[YOUNG].stderr, rel=0.1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"depth": 0}, "depth = 0"),
        ({"noise": -1}, "noise = -1"),
        ({"points": 2}, "points = 2"),
        ({"free": []}, "free is empty"),
        ({"free": ["layers[3].young"]}, "not part of this case; it has"),
        ({"baseline": "sine"}, "baseline = 'sine' is unknown"),
        ({"priors": {"base.young": Normal(1, 1)}}, r"priors: 'base\.young'"),
        ({"priors": {YOUNG: 3}}, "must be Normal"),
    ],
)
def test_messages(change, message):
    given = {"free": [YOUNG], "depth": 1e-7, "noise": 1e-11, **change}
    with pytest.raises(ValueError, match=message):
        planned(GEL, BEAD, given.pop("free"), **given)


CASE = """
[[layers]]
young = { fit = "5 kPa" }
poisson = 0.45
thickness = { fit = "1 um" }
[base]
kind = "rigid"
[indenter]
kind = "sphere"
radius = "3 um"
[curve]
spring_constant = "0.05 N/m"
"""
KNOWN = """
[priors]
"layers[0].thickness" = { mean = "1 um", std = "5 %" }
"indenter.radius" = { median = "3 um", relative = 0.02 }
spring_constant = { min = "0.04 N/m", max = "60 mN/m" }
contact = { mean = "0 nm", std = "20 nm" }
[posterior]
draws = 500
seed = 3
[plan]
depth = "400 nm"
noise = "30 pN"
points = 800
"""


def _read(tmp_path, text):
    path = tmp_path / "gel.toml"
    path.write_text(text)
    return path, read_fit_case(path)


@pytest.mark.parametrize(
    ("contact", "told"),
    [
        ('"free"', "contact free,"),
        ('"100 nm"', "contact 100 nm,"),
        ('{ min = "100 nm", max = "600 nm" }', "contact free, between 100 nm and 600 nm,"),
        ('{ max = "600 nm" }', "contact free, between any and 600 nm,"),
    ],
)
def test_the_contact_point_is_described(tmp_path, contact, told):
    _, case = _read(tmp_path, f"{CASE}[fit]\ncontact = {contact}\n")
    assert told in "\n".join(describe_fit(case))


@pytest.mark.long
def test_case_file(tmp_path):
    path, case = _read(tmp_path, CASE + KNOWN)
    assert case.priors == {
        THICK: Normal(1e-6, 5e-8),
        "indenter.radius": LogNormal(3e-6, 0.02),
        "spring_constant": Uniform(0.04, 0.06),
        "contact": Normal(0.0, 2e-8),
    }
    assert case.posterior == {"draws": 500, "seed": 3}
    plan = plan_of(case)
    direct = planned(
        GEL,
        BEAD,
        [YOUNG, THICK],
        depth=4e-7,
        noise=3e-11,
        points=800,
        spring_constant=0.05,
        priors={THICK: Normal(1e-6, 5e-8), "contact": Normal(0.0, 2e-8)},
    )
    np.testing.assert_array_equal(plan.errors, direct.errors)
    done = run("check", path, exits=0)
    assert "Planned   800 readings to a depth of 400 nm, noise 30 pN" in done.output
    assert re.search(r"Young's modulus of layer 1 +5 kPa +± [\d.]+ %: determined", done.output)


@pytest.mark.long
def test_posterior_on_the_command_line(tmp_path):
    path, _ = _read(
        tmp_path, CASE.replace('[curve]\nspring_constant = "0.05 N/m"', "") + KNOWN.replace("spring_constant", "#")
    )
    curve = synthetic(GEL, BEAD, 0.4e-6, points=200, noise=0.003)
    np.savetxt(
        tmp_path / "gel.csv",
        np.column_stack([curve.depth, curve.force]),
        delimiter=",",
        header="depth [m],force [N]",
        comments="",
    )
    for target in ("corner.png", "draws.csv"):
        done = run("fit", tmp_path / "gel.csv", path, "--posterior", tmp_path / target, exits=0)
        assert (tmp_path / target).stat().st_size > 0
        assert "500 draws" in done.output
    draws = np.genfromtxt(tmp_path / "draws.csv", delimiter=",", names=True)
    assert draws.size == 500


def test_priors_that_cannot_be_drawn_are_refused_before_the_fit(tmp_path):
    """Of a sticking tip the numbers that are held, and the calibration; there is no curve to be read."""
    path, _ = _read(tmp_path, 'work_of_adhesion = "0.1 mJ/m^2"\n' + CASE + KNOWN.replace("spring_constant", "#"))
    done = run("fit", tmp_path / "gel.csv", path, "--posterior", tmp_path / "corner.png", exits=2)
    assert "indenter.radius is not drawn" in done.output.replace("\n", " ")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('std = "5 %"', 'sd = "5 %"', "must be { mean"),
        ('mean = "1 um"', 'mean = "1 kPa"', r"layers\[0\]\.thickness"),
        ("relative = 0.02", 'relative = "2 %"', "must be a plain number"),
        ("[0].thickness", "[1].thickness", "is not part of this case"),
        ("contact =", "kontakt =", "priors: kontakt is not part of this case"),
        ('noise = "30 pN"', "", "plan.noise"),
        ('noise = "30 pN"', 'noise = "0 pN"', None),
    ],
)
def test_case_file_messages(tmp_path, old, new, message):
    assert old in CASE + KNOWN
    text = CASE + KNOWN.replace(old, new)
    if message is None:
        done = run("check", _read(tmp_path, text)[0], exits=2)
        assert "noise = 0" in done.output
        return
    with pytest.raises(CaseError, match=message):
        _read(tmp_path, text)


def test_plans_are_for_one_curve_in_elastic_contact(tmp_path):
    law = '\n[relaxation]\nkind = "standard-linear-solid"\nequilibrium = 0.5\ntime = "1 s"\n'
    with pytest.raises(CaseError, match="leave it out of fits of relaxation"):
        _read(tmp_path, CASE + KNOWN + law)
    with pytest.raises(CaseError, match="needs something to be fitted"):
        _read(tmp_path, (CASE + KNOWN).replace('{ fit = "5 kPa" }', '"5 kPa"').replace('{ fit = "1 um" }', '"1 um"'))


@pytest.mark.parametrize(
    "prior",
    ['{ median = "2 mm", relative = 0.02 }', '{ mean = "3 mm", std = "1 %" }', '{ min = "1 mm", max = "2 mm" }'],
)
def test_priors_that_exclude_the_case_are_refused(tmp_path, prior):
    """A tip of 3 um cannot be one of 2 mm; draws of it took half a minute and meant nothing."""
    text = CASE + KNOWN.replace('{ median = "3 um", relative = 0.02 }', prior)
    with pytest.raises(
        CaseError, match=r"priors: indenter.radius is .* mm ± .*, but the case has 3 µm\. Check the units"
    ):
        _read(tmp_path, text)


@pytest.mark.long
def test_tips_and_depths_are_scanned_at_once(tmp_path):
    """Each line is the plan of that tip to that depth; what cannot be planned says why."""
    gel = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase())
    tips = {"bead": Sphere(4e-6), "small": Sphere(3e-7)}
    names = ["layers[0].young", "layers[0].thickness"]
    scan = plan_scan(gel, tips, names, depths=[1e-7, 4e-7], noise=3e-11)
    assert list(scan.plans) == [(tip, depth) for tip in tips for depth in (1e-7, 4e-7)]
    alone = planned(gel, Sphere(4e-6), names, depth=4e-7, noise=3e-11)
    np.testing.assert_array_equal(scan.plans["bead", 4e-7].errors, alone.errors)
    (tmp_path / "case.toml").write_text(
        'layers = [{ young = { fit = "5 kPa" }, poisson = 0.5, thickness = { fit = "1 um" } }]\n'
        'base = { kind = "rigid" }\nindenter = { kind = "sphere", radius = "4 um" }\n'
        '[plan]\ndepth = ["100 nm", "400 nm"]\nnoise = "30 pN"\nindenters.small = { kind = "sphere", radius = "300 nm" }\n'
    )
    said = "\n".join(describe_fit(read_fit_case(tmp_path / "case.toml")))
    for row in scan.rows():
        assert all(cell in said for cell in row[1:])
    with pytest.raises(TypeError, match="mapping of names to indenters"):
        plan_scan(gel, [Sphere(1e-6)], names, depths=[1e-7], noise=1e-11)
