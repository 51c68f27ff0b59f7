"""Breakthroughs that do not recover, loads that are taken back, readings out of order, tips counted outwards."""

import numpy as np
import pytest

from flatpunch.fit import Curve, CurveError, Measured, fit
from flatpunch.fit.measured.approach import approach_of
from flatpunch.fit.measured.drops import breaks
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace

START, TIP, YOUNG = HalfSpace(1e3, 0.5), Paraboloid(4e-6), 4e3


def hertz(depth):
    """Force on the gel, zero before the contact [N]."""
    return 4 / 3 * YOUNG / 0.75 * np.sqrt(TIP.radius) * np.maximum(depth, 0.0) ** 1.5


def noisy(depth, force, **more):
    """A curve with noise of 0.2 % of the largest force."""
    return Curve(depth, force + 2e-3 * np.ptp(force) * np.random.default_rng(0).normal(size=force.size), **more)


@pytest.mark.parametrize("left", [0.05, 0.3])
@pytest.mark.parametrize("base", [False, True])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_lies_before_a_breakthrough_is_fitted(left, base, sign):
    """The force falls to a share and stays there, or rises on a stiff base, and the tip comes back."""
    way = np.concatenate([np.linspace(-6e-7, 1e-6, 900), np.linspace(1e-6, -6e-7, 900)])
    broken, at = np.arange(way.size) >= 740, way[740]
    after = left * hertz(at) + 20 * base * hertz(way - at - 5e-8)
    force = np.where(broken, np.where(way > at - 3e-7, after, 0.0), hertz(way))
    found = fit(noisy(way, sign * force), START, TIP, ["base.young"])
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.01)
    assert any("drops" in note and "breakthrough" in note for note in found.notes)


def test_a_load_that_is_taken_back_is_no_breakthrough():
    """A ramp of load with a nose of 20 readings, in which the tip goes on by 1 % and the force falls by 4 %."""
    top = hertz(1e-6)
    load = np.concatenate([np.zeros(200), np.linspace(0, top, 800), top * np.linspace(1, 0.96, 20)])
    depth = np.concatenate([np.linspace(-3e-7, 0, 200), 1e-6 * np.linspace(0, 1, 800) ** (2 / 3)])
    depth = np.append(depth, 1e-6 + 1e-8 * np.sin(np.linspace(0, np.pi / 2, 20)))
    found = fit(noisy(depth, load), START, TIP, ["base.young"])
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.01)
    assert not any("breakthrough" in note for note in found.notes)


def test_slopes_and_corners_are_no_breaks():
    along = np.linspace(-1, 1, 1000)
    noise = 1e-3 * np.random.default_rng(1).normal(size=1000)
    assert breaks(5 * along + noise) == breaks(np.maximum(along, 0) + noise) == []
    # beside a step are others of the opposite sign
    assert 738 in breaks(np.maximum(along, 0) - 0.1 * (along > 0.5) + noise)


def test_readings_out_of_order_are_sorted_by_their_times():
    way = np.concatenate([np.linspace(-6e-7, 1e-6, 600), np.linspace(1e-6, -6e-7, 600)])
    curve = noisy(way, hertz(way), time=np.arange(1200.0))
    mixed = curve.taken(np.random.default_rng(2).permutation(1200))
    assert approach_of(mixed).part.depth == pytest.approx(approach_of(curve).part.depth)
    # times that begin again at the retract are no disorder
    again = noisy(way, hertz(way), time=np.concatenate([np.arange(600.0), np.arange(600.0)]))
    assert approach_of(again).whole is again


@pytest.mark.parametrize("depth", [1.0, -1.0])
@pytest.mark.parametrize("force", [1.0, -1.0])
def test_tips_behind_soft_cantilevers_counted_either_way(depth, force):
    """The cantilever bends three times as far as the tip goes in: the sign of force and tip follows from their noise."""
    spring = hertz(1e-6) / 3e-6
    inside = np.linspace(0, 1e-6, 4000)
    piezo = np.linspace(-2e-6, 4e-6, 1200)
    tip = np.where(piezo > 0, np.interp(piezo, inside + hertz(inside) / spring, inside), piezo)
    load = hertz(tip) + 1e-3 * hertz(1e-6) * np.random.default_rng(3).normal(size=1200)
    curve = Curve(depth * (piezo - load / spring), force * load, spring_constant=spring)
    assert fit(curve, START, TIP, ["base.young"])["base.young"] == pytest.approx(YOUNG, rel=0.02)


@pytest.mark.parametrize("depth", [1.0, -1.0])
@pytest.mark.parametrize("force", [1.0, -1.0])
def test_a_tip_with_a_sensor_of_its_own_counted_either_way(depth, force):
    """The noise of the force does not move it: a depth that fell while the force grew showed no contact."""
    tip = np.linspace(-1e-6, 1e-6, 900)
    load = hertz(tip) + 1e-3 * hertz(1e-6) * np.random.default_rng(3).normal(size=900)
    curve = Curve(depth * tip, force * load, spring_constant=5e-3)
    assert fit(curve, START, TIP, ["base.young"])["base.young"] == pytest.approx(YOUNG, rel=0.01)


@pytest.mark.parametrize("wrong", [{"curve": 1}, {"indenter": 3}, {"values": 3}])
def test_measured_checks_what_it_is_given(wrong):
    way = np.linspace(0, 1e-6, 40)
    with pytest.raises(TypeError, match=r"Measured\.(curve|indenter|values) = "):
        Measured(**{"curve": Curve(way, hertz(way)), **wrong})


@pytest.mark.parametrize("spring", [None, 2e-2])
@pytest.mark.parametrize("seed", range(4))
def test_a_pop_in_after_which_the_force_rises_at_once_is_found(spring, seed):
    """Within two to six readings the force is higher than before; the first of two is where the fit ends."""
    rng = np.random.default_rng(seed)
    places, fine = np.sort(rng.uniform(0.45, 0.9, 2)), np.linspace(-1e-6, 5e-7, 60000)
    force = hertz(fine)
    for place in places:
        force[fine > place * 5e-7] -= rng.uniform(0.06, 0.12) * hertz(place * 5e-7)
    # the tip jumps where its cantilever is softer than the sample yields
    way = np.maximum.accumulate(fine + (force / spring if spring else 0))
    base = np.linspace(way[0], way[-1], 300)
    at = np.searchsorted(way, base)
    read = force[at] + 1e-3 * force.max() * rng.normal(size=base.size)
    curve = Curve.from_piezo(base, read, spring) if spring else Curve(base, read)
    found = fit(curve, START, TIP, ["base.young"])
    deep = float(curve.depth[found.used.size - 1])
    assert deep == pytest.approx(places[0] * 5e-7, abs=2.5e-8)
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.02)
    assert any("drops" in note for note in found.notes)


@pytest.mark.parametrize("kind", ["lost", "shaken", "held"])
@pytest.mark.parametrize("at", [0, 150, 420, 560])
@pytest.mark.parametrize("count", [3, 6, 10])
def test_bursts_of_readings_are_left_out(kind, at, count):
    """In front of the contact, at it, in it, and where the record begins."""
    rng = np.random.default_rng(count)
    depth = np.linspace(-8e-7, 4e-7, 600)
    force = hertz(depth)
    top, burst = force.max(), slice(at, at + count)
    force += 2e-3 * top * rng.normal(size=600)
    force[burst] = {"lost": -0.3 * top, "shaken": top * rng.normal(size=count) + 4 * top, "held": 8 * top}[kind]
    found = fit(Curve(depth, force), START, TIP, ["base.young"])
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.01)
    assert any(f"Readings {at} to {at + count - 1} (" in note for note in found.notes)


def test_a_snap_into_contact_is_no_burst():
    """Ten readings below the background, from which the force rises to the contact without adhesion."""
    depth = np.linspace(-8e-7, 4e-7, 300)
    force = hertz(depth) - 0.05 * hertz(4e-7) * np.where(depth > 0, np.maximum(1 - depth / 4e-8, 0.0), 0.0)
    with pytest.raises(CurveError, match="pulled in"):
        fit(noisy(depth, force), START, TIP, ["base.young"])


def test_a_long_hold_ends_the_approach_at_its_corner():
    """Creep within a hundredth of the hold was taken for a saturated detector."""
    load = np.concatenate([np.linspace(0, hertz(1e-6), 2000), np.full(6000, hertz(1e-6))])
    depth = np.append(1e-6 * np.linspace(0, 1, 2000) ** (2 / 3), 1e-6 + 1e-7 * (1 - np.exp(-np.linspace(0, 5, 6000))))
    free = np.linspace(-8e-7, 0, 400)
    force = np.append(np.zeros(400), load)
    force += 2e-4 * force.max() * np.random.default_rng(1).normal(size=force.size)
    curve = Curve(np.append(free, depth), force)
    assert abs(approach_of(curve).end - 2400) < 8
    assert fit(curve, START, TIP, ["base.young"])["base.young"] == pytest.approx(YOUNG, rel=0.005)


@pytest.mark.parametrize("tilt", [0.1, -0.6])
def test_a_contact_that_only_a_tilted_background_shows(tilt):
    """The detector's tilt, over the largest force, hides the contact from a constant."""
    depth = np.linspace(-2e-7, 2e-7, 800)
    base = depth + hertz(depth) / 4e-4
    read = hertz(depth) + tilt * hertz(2e-7) * (base - base[0]) / np.ptp(base)
    read += 1e-3 * read.max() * np.random.default_rng(2).normal(size=800)
    found = fit(Curve.from_piezo(base, read, 4e-4), START, TIP, ["base.young"])
    estimate = found.estimates["base.young"]
    assert estimate.low < YOUNG < estimate.high < 1.2 * YOUNG
    assert any("tilted" in note for note in found.notes)


def test_saturation_over_a_tilt_is_no_retract():
    depth = np.linspace(-2e-7, 1e-7, 300)
    force = np.minimum(hertz(depth), 0.5 * hertz(1e-7)) - 0.06 * hertz(1e-7) * (depth + 2e-7) / 2e-7
    with pytest.raises(CurveError, match="saturated"):
        fit(noisy(depth, np.minimum(force, force.max())), START, TIP, ["base.young"])


def test_a_line_through_a_dozen_readings():
    depth = np.linspace(-1e-7, 1e-7, 12)
    found = fit(
        Curve.from_piezo(depth + hertz(depth) / 1e-3, hertz(depth), 1e-3), START, TIP, ["base.young"], baseline="linear"
    )
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.01)


@pytest.mark.parametrize("seed", range(12))
def test_bursts_that_overlap_or_follow_each_other(seed):
    rng = np.random.default_rng(seed)
    depth = np.linspace(-8e-7, 4e-7, 900)
    force, at, (count, second) = hertz(depth), int(rng.integers(60, 830)), rng.integers(5, 10, 2)
    top, read = force.max(), force + 1e-3 * force.max() * rng.normal(size=900)
    for begin, long in ((at, count), (at + int(rng.integers(2, count + 1)), second)):
        read[begin : begin + long] = force[begin : begin + long] + top * rng.choice([-1, 1]) * rng.uniform(0.3, 4)
    found = fit(Curve(depth, read), START, TIP, ["base.young"])
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.01)
    assert any(f"Readings {at} to" in note for note in found.notes)


@pytest.mark.parametrize("left", [3, 5, 11])
@pytest.mark.parametrize("seed", range(3))
def test_a_drop_among_the_last_readings_is_no_saturated_detector(left, seed):
    """A fall by 6 % before the last readings; with those before the fall their mean slope is zero."""
    rng = np.random.default_rng(seed)
    depth = np.linspace(-6e-7, 6e-7, 350)
    force = hertz(depth) - 0.06 * hertz(6e-7) * (np.arange(350) >= 350 - left)
    found = fit(Curve(depth, force + 5e-3 * force.max() * rng.normal(size=350)), START, TIP, ["base.young"])
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.02)
    assert abs(found.used.size - (350 - left)) <= 3
    assert any("drops by" in note or "falls by" in note or "may be a drop" in note for note in found.notes)


@pytest.mark.parametrize("place", [1e-7, 3.4e-7])
def test_a_drop_of_a_few_noise_levels(place):
    """By 4 % where the noise of readings is 0.9 %: the modulus was 10 to 20 % too low."""
    depth = np.linspace(-4e-7, 4e-7, 2000)
    force = hertz(depth) - 0.04 * hertz(4e-7) * (depth > place)
    read = force + 9e-3 * force.max() * np.random.default_rng(3).normal(size=2000)
    found = fit(Curve(depth, read), START, TIP, ["base.young"])
    assert abs(found.estimates["base.young"].value / YOUNG - 1) < 0.01 + 0.04 * (place < 2e-7)
    assert any("drops by" in note for note in found.notes)


@pytest.mark.parametrize("seed", range(12))
def test_steps_of_a_converter_are_no_bursts_and_no_drops(seed):
    """More than half of the readings are on the rise, where all of them differ."""
    rng = np.random.default_rng(seed)
    depth = np.linspace(-7e-7, 1e-6, 851)
    step = hertz(1e-6) * rng.uniform(8e-4, 2e-3)
    read = np.round((hertz(depth) + 0.15 * step * rng.normal(size=851)) / step) * step
    found = fit(Curve(depth, read), START, TIP, ["base.young"])
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.01)
    assert not any("drops by" in note or "Readings" in note for note in found.notes)


@pytest.mark.parametrize("tilt", [-0.25, -0.1, 0.1, 0.25])
@pytest.mark.parametrize("soft", [0.4, 1.0])
def test_a_tilt_that_few_readings_show(tilt, soft):
    """Five of 24 readings are free of contact: a constant alone gave moduli up to four times too large."""
    depth = np.linspace(-4e-7, 4e-7, 4000)
    k = soft * hertz(4e-7) / 4e-7
    way = depth + hertz(depth) / k
    base = np.linspace(-0.3 * way[-1], way[-1], 24)
    force = np.interp(base, way, hertz(depth))
    read = force + tilt * force.max() * (base - base[0]) / np.ptp(base)
    read += 2e-3 * force.max() * np.random.default_rng(5).normal(size=24)
    estimate = fit(Curve.from_piezo(base, read, k), START, TIP, ["base.young"]).estimates["base.young"]
    assert estimate.low < 1.01 * YOUNG
    assert estimate.high > 0.99 * YOUNG
    assert estimate.high < 2 * estimate.low


def test_a_noisy_ramp_of_load_ends_at_its_corner():
    """The way before the contact is no part of the straight line of the ramp."""
    top, creep = hertz(1e-6), 1e-7 * (1 - np.exp(-np.linspace(0, 3, 2200)))
    load = np.concatenate([np.zeros(1100), np.linspace(0, top, 1300), np.full(2200, top)])
    depth = np.concatenate([np.linspace(-1e-6, 0, 1100), 1e-6 * np.linspace(0, 1, 1300) ** (2 / 3), 1e-6 + creep])
    curve = Curve(depth, load + 8e-3 * top * np.random.default_rng(2).normal(size=4600))
    assert abs(approach_of(curve).end - 2400) < 20
    assert fit(curve, START, TIP, ["base.young"])["base.young"] == pytest.approx(YOUNG, rel=0.01)


def test_a_hold_within_the_segment_of_the_approach():
    """Exports that number two segments count the hold to the first one; its relaxation was called a load taken back."""
    way = np.concatenate([np.linspace(-6e-7, 6e-7, 800), np.full(300, 6e-7), np.linspace(6e-7, -6e-7, 800)])
    force = hertz(way)
    force[800:1100] *= 1 - 0.2 * (1 - np.exp(-np.linspace(0, 3, 300)))
    curve = noisy(way, force, segment=np.repeat([0.0, 1.0], [1100, 800]))
    found = fit(curve, START, TIP, ["base.young"])
    assert approach_of(curve).end == 800
    assert not any("falls by" in note or "drops by" in note for note in found.notes)


def test_a_force_far_off_is_no_depth_without_its_decimal_mark():
    """Indentations that the instrument computed from the force jump with it; the base does not."""
    base = np.linspace(-6e-7, 8e-7, 900)
    force, k = hertz(np.interp(base, base + hertz(base) / 0.02, base)), 0.02
    rng = np.random.default_rng(4)
    read = force + 1e-3 * force.max() * rng.normal(size=900)
    read[500:507] -= 8e-6 * k * rng.uniform(size=7)
    found = fit(Curve(base - read / k, read, spring_constant=k), START, TIP, ["base.young"])
    assert found["base.young"] == pytest.approx(YOUNG, rel=0.02)
