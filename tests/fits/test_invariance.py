"""Fits do not change with what says nothing about the sample: offsets, tilt, units, thinning, doubling, signs, segment layout.

Each kind of model gets a curve, the curve changed, and must give the same values: within a thousandth of the standard error
plus the descent's own tolerance (`SETTLED`, 1e-4 standard errors) where only numbers are shifted, within the statistical
error of the points left out where points are.
"""

import dataclasses
import re

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.fits import Curve, CurveError, fit
from flatpunch.indenters import Cone, Paraboloid, Pyramid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase, StandardLinearSolid
from support.sticky_curves import sticky
from support.synthetic_curves import synthetic

GEL = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase())
START = Medium([Layer(2e3, 0.5, 1e-6)], RigidBase())
TIP = Sphere(3e-6)
SOLID = StandardLinearSolid(0.4, 0.5)
SPRING = 0.02


def elastic():
    return synthetic(GEL, TIP, 0.4e-6, points=1200, contact=3e-8), (START, TIP, ["layers[0].young"]), {}


def sharp():
    body = HalfSpace(5e4, 0.4)
    return synthetic(body, Cone(0.5), 0.4e-6, points=500), (HalfSpace(1e3, 0.4), Cone(0.5), ["base.young"]), {}


def pyramid():
    tip = Pyramid(4, 0.4)
    return synthetic(GEL, tip, 0.4e-6, points=500), (START, tip, ["layers[0].young"]), {}


def cantilever():
    clean = synthetic(GEL, TIP, 0.4e-6, noise=0, points=1200)
    noise = 0.005 * clean.force.max() * np.random.default_rng(4).normal(size=1200)
    curve = Curve.from_piezo(clean.depth + clean.force / SPRING, clean.force + noise, SPRING)
    return curve, (START, TIP, ["layers[0].young"]), {}


def adhesive():
    curve = sticky(GEL, TIP, 1e-4, 3e-7, points=300)
    return curve, (START, TIP, ["layers[0].young", "work_of_adhesion"]), {"work_of_adhesion": 3e-5}


def relaxing():
    time = np.linspace(0, 5, 500)
    depth = np.interp(time, [0, 0.3, 0.8, 4, 5], np.array([-0.5, 0, 1, 1, -0.5]) * 3e-7)
    force = indent(GEL, TIP, time=time, depth=depth, relaxation=SOLID, angles=8)["force"].values
    force = force + 0.01 * force.max() * np.random.default_rng(1).normal(size=500)
    names = ["layers[0].young", "relaxation.equilibrium"]
    return Curve(depth, force, time=time), (START, TIP, names), {"relaxation": SOLID}


KINDS = {f.__name__: f for f in (elastic, sharp, pyramid, cantilever, adhesive, relaxing)}


def changed(curve, *, force=0.0, depth=0.0, tilt=0.0):
    """The curve with a constant force (over its rise), a constant depth (over its range) and a tilt (rises over the range)."""
    rise, way = np.ptp(curve.force), np.ptp(curve.position)
    new = curve.force + force * rise + tilt * rise * (curve.position - curve.position[0]) / way
    if curve.meta.get("piezo"):
        rest = {"time": curve.time, "meta": curve.meta}
        return Curve.from_piezo(curve.position + depth * way, new, curve.spring_constant, **rest)
    return dataclasses.replace(curve, depth=curve.depth + depth * way, force=new)


def same(one, other, share=0.01, scale=None):
    """Values of two fits agree to a share of the standard error."""
    for name in one.objective.model.free:
        a, b = one.estimates[name], other.estimates[name]
        assert abs(a.value - b.value * (scale or {}).get(name, 1.0)) < share * a.stderr, (name, a.value, b.value)


SHIFTS = [
    {"force": 1.0},
    {"force": -1.0},
    {"force": 300.0},
    {"force": -300.0},
    {"depth": 50.0},
    {"depth": -50.0},
    {"force": -7.0, "depth": 3.0},
]


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_constant_force_and_depth(kind):
    curve, case, settings = KINDS[kind]()
    whole = fit(curve, *case, quick=True, **settings)
    for shift in SHIFTS:
        same(whole, fit(changed(curve, **shift), *case, quick=True, **settings))


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_tilt_where_asked_for(kind, request):
    if kind == "cantilever":
        why = "the modulus moves by more than a hundredth of its standard error; why is not known"
        request.applymarker(pytest.mark.xfail(strict=True, reason=why))
    curve, case, settings = KINDS[kind]()
    whole = fit(curve, *case, baseline="linear", quick=True, **settings)
    for tilt in (
        {"tilt": 0.2},
        {"tilt": -0.2},
        {"tilt": 5.0},
        {"tilt": -5.0},
        {"tilt": -1.0, "force": 2.0, "depth": -1.0},
    ):
        same(whole, fit(changed(curve, **tilt), *case, baseline="linear", quick=True, **settings))


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
def test_signs(kind):
    """Conventions of instruments: depth or force counted the other way. What was turned is said."""
    curve, case, settings = KINDS[kind]()
    whole = fit(curve, *case, quick=True, **settings)
    for sign in ({"depth": -1.0}, {"force": -1.0}, {"depth": -1.0, "force": -1.0}):
        other = fit(curve.turned(**sign), *case, quick=True, **settings)
        same(whole, other)
        assert sum("sign turned" in note for note in other.notes) == len(sign)


@pytest.mark.parametrize("kind", ["elastic", "sharp", "cantilever"])
def test_thinned_and_doubled(kind):
    """Doubled points change nothing but the interval, and the last one, which counts once; half the points move the value by
    about a standard error."""
    curve, case, settings = KINDS[kind]()
    whole = fit(curve, *case, quick=True, **settings)
    same(
        whole,
        fit(curve.taken(np.repeat(np.arange(curve.depth.size), 2)), *case, quick=True, **settings),
        share=0.2,
    )
    same(whole, fit(curve.taken(slice(None, None, 2)), *case, quick=True, **settings), share=4)


@pytest.mark.long
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_units(kind, scale):
    """A body of another stiffness, a million times more or less: the modulus scales, nothing else changes."""
    curve, (medium, tip, free), settings = KINDS[kind]()
    whole = fit(curve, medium, tip, free, quick=True, **settings)
    if curve.spring_constant is None:
        other = dataclasses.replace(curve, force=curve.force * scale)
    else:
        other = Curve.from_piezo(curve.position, curve.force * scale, curve.spring_constant * scale)
    names = dict.fromkeys(("layers[0].young", "base.young", "work_of_adhesion"), 1 / scale)
    found = fit(other, medium, tip, dict.fromkeys(free), quick=True, **settings)
    same(whole, found, scale=names)


def test_every_layout_of_segments_gives_the_same_approach():
    """Approach alone, with its retract, with a pause in between, with the file's own numbers: one value."""
    up, case, _ = elastic()
    whole = fit(up, *case, quick=True)
    back = up.taken(slice(None, None, -1))
    pause = Curve(np.full(400, up.depth[-1]), up.force[-1] * np.linspace(1, 0.9, 400))
    for parts in ([up, back], [up, pause, back], [up, pause], [up, back.taken(slice(0, 200))]):
        joined = Curve(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("depth", "force")))
        same(whole, fit(joined, *case, quick=True))
        numbers = np.concatenate([np.full(p.depth.size, i) for i, p in enumerate(parts)])
        same(whole, fit(dataclasses.replace(joined, segment=numbers), *case, quick=True))


@pytest.mark.xfail(strict=True, reason="creep without noise goes into the fit: the modulus is 4 % low")
def test_a_long_pause_in_which_the_tip_creeps_on():
    """It is cut off where it begins, however long it is; a slow contact after a fast way to the surface is no pause."""
    up, case, _ = elastic()
    whole = fit(up, *case, quick=True)
    n = up.depth.size
    creep = up.depth[-1] + 1e-8 * np.linspace(0, 1, 8 * n)[1:]
    held = Curve(np.append(up.depth, creep), np.append(up.force, up.force[-1] * np.linspace(1, 0.7, creep.size)))
    same(whole, fit(held, *case, quick=True))
    far = up.depth[0] - np.linspace(1e-5, 0, n // 5, endpoint=False)
    noise = up.force[: far.size]
    fast = Curve(np.append(far, up.depth), np.append(noise, up.force))
    found = fit(fast, *case, quick=True)
    assert found.used.size == fast.depth.size


@pytest.mark.parametrize("count", [20, 100, 5000])
def test_short_and_long_contacts(count):
    """Of 10 000 points a few are in contact; within four standard errors of the truth."""
    body, tip = HalfSpace(2e3, 0.5), Paraboloid(5e-6)
    step = 300e-9 / count
    depth = step * (np.arange(10000) - 10000 + count + 1)
    force = np.zeros(10000)
    force[depth > 0] = indent(body, tip, depth=depth[depth > 0], angles=8)["force"].values
    force += 0.01 * force.max() * np.random.default_rng(count).normal(size=10000)
    for curve in (Curve(depth, force), Curve(np.append(depth, depth[::-1]), np.append(force, force[::-1]))):
        found = fit(curve, HalfSpace(1e3, 0.5), tip, ["base.young"], quick=True).estimates["base.young"]
        assert abs(found.value - 2e3) < 4 * found.stderr


def test_contact_between_limits_of_the_user():
    curve, case, _ = elastic()
    inside = fit(curve, *case, contact={"min": 0.0, "max": 1e-7})
    same(fit(curve, *case), inside)
    cut = fit(curve, *case, contact=(5e-8, None))
    assert cut.estimates["contact"].at_bound
    assert cut["contact"] == pytest.approx(5e-8)
    with pytest.raises(ValueError, match="must be below the maximum"):
        fit(curve, *case, contact=(1e-7, 0.0))


@pytest.mark.xfail(
    strict=True,
    reason="5 periods of a wave are not continued into the contact: the modulus is 30 % high, in its interval",
)
def test_wave_of_laser_interference():
    """A wave on the background, amplitude 5 % of the rise: within 20 %, the truth in the interval, and said."""
    curve, case, _ = elastic()
    long = synthetic(GEL, TIP, 0.4e-6, points=1200, contact=3e-8)
    z = np.linspace(-2e-6, 0, 4000, endpoint=False) - 0.2e-6 + 3e-8
    rng = np.random.default_rng(3)
    curve = Curve(np.append(z, long.depth), np.append(0.01 * long.force.max() * rng.normal(size=4000), long.force))
    wave = 0.05 * curve.force.max() * np.sin(2 * np.pi * curve.depth / 4e-7 + 0.7)
    found = fit(dataclasses.replace(curve, force=curve.force + wave), *case)
    estimate = found.estimates["layers[0].young"]
    assert estimate.low < 5e3 < estimate.high
    assert estimate.value == pytest.approx(5e3, rel=0.2)
    assert any("The force without contact waves by about" in note for note in found.notes)


def test_drag_of_the_liquid():
    """Force proportional to the speed of the base: an approach that slows down, with its times."""
    curve, case, _ = elastic()
    way = (curve.depth - curve.depth[0]) / np.ptp(curve.depth)
    time = 1 - np.sqrt(1 - 0.99 * way)
    speed = np.gradient(curve.depth, time)
    drag = 0.3 * curve.force.max() / speed.max()
    slowed = Curve(curve.depth, curve.force + drag * speed, time=time)
    found = fit(slowed, *case, drag="free")
    assert found["drag"] == pytest.approx(drag, rel=0.05)
    estimate = found.estimates["layers[0].young"]
    assert abs(estimate.value - 5e3) < 4 * estimate.stderr
    with pytest.raises(CurveError, match="drag is a force per speed"):
        fit(curve, *case, drag="free")


@pytest.mark.parametrize("spring", [None, 0.05])
@pytest.mark.parametrize("tops", [(1, 1), (0.5, 1), (0.2, 0.4, 0.6, 0.8, 1)])
def test_several_cycles_are_never_glued_together(tops, spring):
    """The first advance of at least half of the longest is fitted, and said to be."""
    corners = [-1.0, *np.array([(top, -1.0) for top in tops]).ravel()]
    way = np.interp(np.linspace(0, len(corners) - 1, 400 * len(corners)), np.arange(len(corners)), corners) * 4e-7
    force = indent(GEL, TIP, depth=np.maximum(way, 0), angles=8)["force"].values
    force = force + 0.01 * force.max() * np.random.default_rng(0).normal(size=way.size)
    curve = Curve(way, force) if spring is None else Curve.from_piezo(way + force / spring, force, spring)
    found = fit(curve, START, TIP, ["layers[0].young"], quick=True)
    estimate = found.estimates["layers[0].young"]
    assert abs(estimate.value - 5e3) < 4 * estimate.stderr
    assert re.search(r"The record has \d loading cycles; cycle 1 is fitted", " ".join(found.notes))
    assert found.curve.depth.size < 600
