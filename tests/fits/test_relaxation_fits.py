"""Relaxation from ramp, hold and retract over time: synthetic truth made by `indent`, and what is refused."""

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.contact.physics import Physics
from flatpunch.fits import Curve, CurveError, Sample, fit
from flatpunch.fits.measured.cycles import levelled, turns
from flatpunch.fits.pictures import fit_figure
from flatpunch.fits.viscoelastic import HistoryModel
from flatpunch.indenters import Pyramid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, PowerLawRelaxation, Prony, RigidBase, StandardLinearSolid

GEL = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase())
START = Medium([Layer(1.2e4, 0.5, 1e-6)], RigidBase())
BEAD = Sphere(3e-6)
YOUNG, SHARE, TIME = "layers[0].young", "relaxation.equilibrium", "relaxation.time"
SOLID = StandardLinearSolid(0.4, 0.5)


def ramp(law, tip=BEAD, *, points=600, noise=0.01, seed=1, end=5.0):
    """0.3 s in the air, 0.5 s down, hold, 1 s back; the contact at 40 nm."""
    time = np.linspace(0, end, points)
    depth = np.interp(time, [0, 0.3, 0.8, end - 1, end], np.array([-0.5, 0, 1, 1, -0.5]) * 3e-7)
    force = indent(GEL, tip, time=time, depth=depth, relaxation=law, angles=8)["force"].values
    force = force + noise * force.max() * np.random.default_rng(seed).normal(size=points)
    return Curve(depth + 40e-9, force, time=time, name="ramp")


@pytest.mark.long
@pytest.mark.parametrize(
    ("tip", "law", "start", "names"),
    [
        (BEAD, SOLID, StandardLinearSolid(0.7, 5.0), {SHARE: 0.4, TIME: 0.5}),
        (Pyramid(4, 0.4), PowerLawRelaxation(0.2, 1.0), PowerLawRelaxation(0.05, 1.0), {"relaxation.exponent": 0.2}),
        (
            BEAD,
            Prony([0.3, 0.3], [0.1, 1.5]),
            Prony([0.2, 0.2], [0.05, 3.0]),
            {
                "relaxation.weights[0]": 0.3,
                "relaxation.times[1]": 1.5,
                "relaxation.times[0]": 0.1,
                "relaxation.weights[1]": 0.3,
            },
        ),
    ],
    ids=["solid", "power-law", "prony"],
)
def test_truth_comes_back(tip, law, start, names):
    """Within four standard errors."""
    result = fit(ramp(law, tip), START, tip, [YOUNG, *names], relaxation=start)
    for name, truth in {YOUNG: 5e3, "contact": 40e-9, **names}.items():
        estimate = result.estimates[name]
        assert abs(estimate.value - truth) < 4 * estimate.stderr, name
    assert abs(result.memory) < 0.3
    assert len(fit_figure(result).axes) == 2


CYCLES = {
    "twice": ([0, 0.3, 0.8, 2, 2.5, 3, 3.5, 4.5, 5], [-0.5, 0, 1, 1, -0.5, -0.5, 1, 1, -0.5]),
    "deeper": ([0, 0.3, 0.8, 2, 2.5, 3, 3.5, 4.5, 5], [-0.5, 0, 0.6, 0.6, 0.2, 0.2, 1, 1, -0.5]),
}
"""Times [s] and depths over the largest: a second cycle from the air, and one that begins in contact."""


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "spring"),
    [("twice", None), ("deeper", None), pytest.param("deeper", 0.05, marks=pytest.mark.slow)],
)
def test_several_cycles(name, spring):
    """The second cycle meets a surface that has not recovered; within four standard errors."""
    corners, depths = CYCLES[name]
    time = np.linspace(0, 5, 300)
    way = 3e-7 * np.interp(time, corners, depths)
    if spring is None:
        force = indent(GEL, BEAD, time=time, depth=way, relaxation=SOLID, angles=8)["force"].values
    else:
        force = HistoryModel(Sample(GEL, BEAD, Physics(relaxation=SOLID))).behind(
            time, way, spring, np.zeros(0), None, once=False
        )[1]
    noisy = force + 0.01 * force.max() * np.random.default_rng(5).normal(size=300)
    if spring is None:
        curve = Curve(way + 40e-9, noisy, time=time)
    else:
        curve = Curve.from_piezo(way + 40e-9, noisy, spring, time=time)
    start = StandardLinearSolid(0.6, 1.0)
    result = fit(curve, START, BEAD, [YOUNG, SHARE, TIME], relaxation=start, quick=True)
    for parameter, truth in {YOUNG: 5e3, SHARE: 0.4, TIME: 0.5, "contact": 40e-9}.items():
        assert abs(result[parameter] - truth) < 4 * result.estimates[parameter].stderr, parameter
    assert "2 loading cycles are fitted together." in result.notes


def test_turns_of_noisy_positions():
    """Noise and drift make no turn; holds do not either."""
    time = np.linspace(0, 5, 2000)
    rng = np.random.default_rng(0)
    for corners, depths in CYCLES.values():
        position = np.interp(time, corners, depths) + 0.005 * rng.normal(size=time.size) + 0.01 * np.sin(3 * time)
        at = turns(position)
        assert len(at) == 3
        assert (time[at] >= np.array([0.79, 2.4, 3.4])).all()
        assert (time[at] <= np.array([2.01, 3.1, 4.51])).all()
        level = levelled(position, at)
        assert np.abs(level - np.interp(time, corners, depths)).max() < 0.04
        # readings of a hold that differ by rounding are one turn
        held = np.interp(time, corners, depths)
        assert len(turns(np.where(np.arange(2000) % 2, held, held * (1 - 1e-15)))) == 3
        signs = np.sign(np.diff(level))
        assert [(signs[a:b] * s >= 0).all() for a, b, s in zip([0, *at], [*at, 1999], [1, -1, 1, -1], strict=True)]


@pytest.mark.long
def test_behind_a_cantilever():
    """The tip sinks in during the hold as the force relaxes; the history is that of the piezo."""
    spring, points = 0.05, 400
    time = np.linspace(0, 4, points)
    piezo = np.interp(time, [0, 0.3, 0.8, 3, 4], np.array([-0.5, 0, 1.5, 1.5, -0.5]) * 3e-7)
    model = HistoryModel(Sample(GEL, BEAD, Physics(relaxation=SOLID)))
    depth, force = model.behind(time, piezo, spring, np.zeros(0), None)
    # what the model solves for is a history of `indent`: 1e-6 of the force, as the tables are good to 1e-7
    exact = indent(GEL, BEAD, time=time, depth=depth, relaxation=SOLID, angles=8)["force"].values
    np.testing.assert_allclose(force, exact, rtol=0, atol=1e-6 * force.max())
    np.testing.assert_allclose(depth + force / spring, piezo, rtol=0, atol=1e-13)
    noisy = force + 0.005 * force.max() * np.random.default_rng(3).normal(size=points)
    curve = Curve.from_piezo(piezo + 40e-9, noisy, spring, time=time)
    result = fit(curve, START, BEAD, [YOUNG, SHARE], relaxation=StandardLinearSolid(0.6, 0.5), quick=True)
    for name, truth in ((YOUNG, 5e3), (SHARE, 0.4), ("contact", 40e-9)):
        assert abs(result[name] - truth) < 4 * result.estimates[name].stderr, name


@pytest.mark.long
def test_elastic_limit():
    """A relaxation far slower than the curve is no relaxation: the modulus is that of the elastic fit, and the note says so."""
    curve = ramp(StandardLinearSolid(0.4, 1e6))
    slow = fit(curve, START, BEAD, [YOUNG], relaxation=StandardLinearSolid(0.4, 1e6))
    top = int(np.argmax(curve.depth)) + 1
    plain = fit(curve.taken(slice(0, top)), START, BEAD, [YOUNG])
    error = np.hypot(slow.estimates[YOUNG].stderr, plain.estimates[YOUNG].stderr)
    assert abs(slow[YOUNG] - plain[YOUNG]) < 4 * error
    found = fit(
        ramp(StandardLinearSolid(0.0, 8.0), end=3.0),
        START,
        BEAD,
        [YOUNG, TIME],
        relaxation=StandardLinearSolid(0.0, 2.0),
    )
    assert any("longer than the curve" in note for note in found.notes)


@pytest.mark.long
def test_large_strain_names_no_remedy_that_relaxation_excludes():
    """A bead pressed to more than a third of the layer: the note has the error, and not the option that is refused."""
    time, depth = np.linspace(0, 3, 200), np.linspace(-2e-7, 4.5e-7, 200)
    force = indent(GEL, BEAD, time=time, depth=depth, relaxation=SOLID, angles=8)["force"].values
    notes = " ".join(fit(Curve(depth, force, time=time), START, BEAD, [YOUNG], relaxation=SOLID).notes)
    assert "less force than linear theory" in notes
    assert "finite_strain" not in notes


def test_what_is_refused():
    curve = ramp(SOLID)
    law = {"free": [YOUNG, TIME], "relaxation": SOLID}
    without = Curve(curve.depth, curve.force, meta={"no time": "column 'Time' has no unit."})
    with pytest.raises(CurveError, match=r"has no times\. column 'Time' has no unit"):
        fit(without, GEL, BEAD, **law)
    with pytest.raises(CurveError, match="time must grow"):
        fit(Curve(curve.depth, curve.force, time=curve.time[::-1]), GEL, BEAD, **law)
    dipping = np.array(curve.force)
    dipping[-60:-20] -= 0.2 * dipping.max()
    sticking = Curve(curve.depth, dipping, time=curve.time)
    # approach and hold are fitted all the same, and that it is approximate is said
    held = fit(sticking, GEL, BEAD, **law)
    assert any("approximate" in note for note in held.notes)
    assert held.curve.time.max() < 4.1
    assert any("left out" in note for note in fit(sticking, GEL, BEAD, adhesion="above", **law).notes)
    with pytest.raises(ValueError, match="depth_to and force_to do not go"):
        fit(curve, GEL, BEAD, depth_to=1e-7, **law)
    with pytest.raises(ValueError, match="relaxation goes with a half-space or with layers on a RigidBase"):
        fit(curve, Medium([Layer(5e3, 0.5, 1e-6)], HalfSpace(1e5, 0.3)), BEAD, **law)
    with pytest.raises(ValueError, match="fit young, and keep the time"):
        fit(curve, GEL, BEAD, [TIME], relaxation=PowerLawRelaxation(0.2, 1.0))
    with pytest.raises(ValueError, match="do not go together"):
        fit(curve, GEL, BEAD, work_of_adhesion=1e-3, **law)


@pytest.mark.long
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("first", "last"), [(-1, 1), (-1, 0.5), (-0.5, -1.5)])
def test_a_fast_ramp_before_a_long_hold(first, last, sign):
    """Twenty readings of a ramp and 380 of a hold; no way back, half of it, or further out than the ramp began."""
    time = np.linspace(0, 4, 400)
    depth = 3e-7 * np.interp(time, [0, 0.2, 3.9, 4], [first, 1, 1, last])
    force = indent(GEL, BEAD, time=time, depth=depth, relaxation=SOLID, angles=8)["force"].values
    force = force + 0.003 * force.max() * np.random.default_rng(2).normal(size=400)
    start = StandardLinearSolid(0.6, 1.0)
    found = fit(
        Curve(sign * depth, force, time=time),
        START,
        BEAD,
        [YOUNG, SHARE, TIME],
        relaxation=start,
        quick=True,
    )
    for name, truth in {YOUNG: 5e3, SHARE: 0.4, TIME: 0.5}.items():
        assert abs(found[name] - truth) < 4 * found.estimates[name].stderr, name
