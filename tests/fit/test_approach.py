"""Where approach, hold and retract of a curve are, what is named, and which baseline the data ask for."""

from pathlib import Path

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.fit import Curve, CurveError, fit, read_curve
from flatpunch.fit.case import read_fit_case
from flatpunch.fit.measured.approach import approach_of
from flatpunch.fit.reading import reading_of, traces
from flatpunch.indenters import Cone, Paraboloid
from flatpunch.media import HalfSpace

CASES = Path(__file__).parents[3] / "shared" / "cases"
GEL, START, TIP = HalfSpace(4e3, 0.5), HalfSpace(1e3, 0.5), Paraboloid(4e-6)


def hertz(depth):
    """Force on the gel, zero before the contact [N]."""
    return 4 / 3 * GEL.young / (1 - GEL.poisson**2) * np.sqrt(TIP.radius) * np.maximum(depth, 0.0) ** 1.5


def noisy(depth, force, share=1e-3, seed=0, **more):
    """A curve with noise, as a share of the largest force."""
    return Curve(depth, force + share * force.max() * np.random.default_rng(seed).normal(size=force.size), **more)


def modulus(curve, **settings):
    """Fitted modulus over the true one, and the result."""
    found = fit(curve, START, TIP, ["base.young"], **settings)
    return found["base.young"] / GEL.young, found


@pytest.mark.parametrize(
    ("folder", "file", "young", "note"),
    [
        ("21_load_hold_called_saturated", "segmentid.txt", 4e5, None),
        ("21_load_hold_called_saturated", "no_segments.txt", 4e5, None),
        ("24_breakthrough_called_saturated", "curve.csv", 5e3, "at 949.3 nm"),
        ("24_breakthrough_called_saturated", "earlier.csv", 5e3, "at 799.9 nm"),
        ("25_start_backwards_turns_direction", "curve.csv", 5e3, None),
    ],
)
def test_curves_of_laboratories(folder, file, young, note):
    """Made with these moduli; 0.5 % is what their notes promise."""
    if not CASES.is_dir():
        pytest.skip(f"needs the curves of {CASES}, which are not part of the repository")
    case = read_fit_case(CASES / folder / "case.toml")
    curve = read_curve(CASES / folder / file, **case.reading)
    found = fit(curve, case.medium, case.indenter, case.free, **case.arguments)
    assert found["base.young"] == pytest.approx(young, rel=0.005)
    assert note is None or any("drops" in text and note in text for text in found.notes)


@pytest.mark.parametrize("back", [0.02, 0.06, 0.1])
@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_start_that_goes_back_is_no_turn(back, whole, sign):
    """The long way decides; noise of 0.1 % moves the modulus by 0.1 % here."""
    way = np.concatenate([np.linspace(0, -back, 60), np.linspace(-back, 1, 1200), np.linspace(1, 0, 900 * whole)])
    depth = 1e-6 * way - 6e-7
    ratio, found = modulus(noisy(sign * depth, hertz(depth)))
    assert ratio == pytest.approx(1, rel=0.005)
    assert sum("sign turned" in note for note in found.notes) == (sign < 0)


def test_a_retract_longer_than_the_approach_is_none():
    """Its force changes where the tip turns."""
    depth = np.concatenate([np.linspace(-2e-7, 5e-7, 400), np.linspace(5e-7, -1.5e-6, 1000)])
    assert modulus(noisy(depth, hertz(depth)))[0] == pytest.approx(1, rel=0.005)


@pytest.mark.parametrize("nose", [False, True])
@pytest.mark.parametrize("segments", [False, True])
def test_a_load_ramp_ends_where_the_load_stops_growing(nose, segments):
    """Creep of 6 % at the held load is no approach; taken for one it moves the modulus by several per cent."""
    top = hertz(np.array([1e-6]))[0]
    load = np.concatenate([np.zeros(200), np.linspace(0, top, 800)])
    depth = np.concatenate(
        [np.linspace(-3e-7, 0, 200), np.interp(load[200:], hertz(g := np.linspace(0, 1e-6, 4000)), g)]
    )
    creep = 1e-6 + 6e-8 * (1 - np.exp(-np.linspace(0, 3, 150)))
    parts = [(depth, load), (creep, np.full(150, top))]
    if nose:
        parts.append((creep[-1] + 4e-9 * np.sin(np.linspace(0, np.pi / 2, 10)), top * np.linspace(1, 0.97, 10)))
    last = parts[-1][0][-1]
    away = np.linspace(last, 0, 600)
    parts.append((away, 0.97 * hertz(away * 1e-6 / last)))
    number = np.repeat(np.arange(len(parts)), [p[0].size for p in parts]).astype(float)
    curve = noisy(*map(np.concatenate, zip(*parts, strict=True)), segment=number if segments else None)
    assert abs(approach_of(curve).end - 1000) <= 3
    assert modulus(curve)[0] == pytest.approx(1, rel=0.005)


@pytest.mark.parametrize("noise", [0.003, 0.01, 0.03])
@pytest.mark.parametrize("hold", [100, 400])
def test_a_noisy_load_that_is_held_is_no_saturated_detector(noise, hold):
    """Creep of up to a tenth of the depth, at first faster than the ramp; noise reaches the held load on the ramp already."""
    rng, top = np.random.default_rng(hold), hertz(np.array([1e-6]))[0]
    for _ in range(12):
        load = np.linspace(0, top, int(rng.integers(400, 1200)))
        free = np.linspace(-rng.uniform(4e-7, 1.5e-6), 0, int(rng.integers(150, 800)))
        creep = 1e-6 + rng.uniform(0, 1e-7) * (1 - np.exp(-np.linspace(0, 3, hold)))
        depth = np.concatenate([free, np.interp(load, hertz(g := np.linspace(0, 1e-6, 4000)), g), creep])
        force = np.concatenate([np.zeros(free.size), load, np.full(hold, top)])
        curve = Curve(depth, force + noise * top * rng.normal(size=force.size))
        ends = free.size + load.size
        # as many readings as noise of four levels, or a moving average, needs to be seen above the ramp
        assert -8 * noise * load.size - 30 < approach_of(curve).end - ends < 30
        estimate = fit(curve, START, TIP, ["base.young"], quick=True).estimates["base.young"]
        assert abs(estimate.value - GEL.young) < 4 * estimate.stderr


@pytest.mark.parametrize("place", [0.5, 0.75, 0.97])
@pytest.mark.parametrize("size", [0.03, 0.12])
def test_a_drop_is_named_and_what_lies_before_it_is_fitted(place, size):
    depth = np.linspace(-5e-7, 1e-6, 1500)
    force = hertz(depth)
    force -= np.where(depth > place * 1e-6, size * force.max(), 0.0)
    ratio, found = modulus(noisy(depth, force))
    assert ratio == pytest.approx(1, rel=0.01)
    note = next(note for note in found.notes if "drops" in note)
    # noise of six levels at either side of the drop, over the force that is left
    assert float(note.split("(")[1].split("%")[0]) / 100 == pytest.approx(size, rel=0.25)
    assert found.depth[found.used].max() == pytest.approx(place * 1e-6, rel=0.01)


@pytest.mark.parametrize("level", [0.4, 0.9])
def test_a_reading_that_stays_is_saturated(level):
    depth = np.linspace(-5e-7, 1e-6, 1500)
    force = np.minimum(hertz(depth), level * hertz(depth).max())
    with pytest.raises(CurveError, match="saturated"):
        modulus(noisy(depth, force))


@pytest.mark.parametrize(("left", "plastic"), [(0.0, False), (0.3, True), (0.85, True)])
@pytest.mark.parametrize("spring", [None, 60.0])
def test_an_imprint_is_named_behind_a_cantilever_as_well(left, plastic, spring):
    """A cone on a polymer: loading by its hardness, unloading from what is left with an exponent of 1.5."""
    tip, deepest = Cone(np.radians(30)), 1.1e-7
    out = np.linspace(-1e-7, 0, 200)
    load = 1e-5 * (np.linspace(0, 1, 400) ** 2)
    down, back = np.linspace(0, deepest, 400), np.linspace(1, 0, 300)
    unload = load[-1] * back ** (1.5 if plastic else 2)
    depth = np.concatenate([out, down, deepest * (left + (1 - left) * back), np.linspace(left * deepest, -1e-7, 200)])
    force = np.concatenate([0 * out, load, unload, np.zeros(200)])
    force = force + 1e-8 * np.random.default_rng(1).normal(size=force.size)
    curve = Curve(depth, force) if spring is None else Curve.from_piezo(depth + force / spring, force, spring)
    if plastic:
        with pytest.raises(CurveError, match="imprint"):
            fit(curve, HalfSpace(1e9, 0.3), tip, ["base.young"])
    else:
        assert fit(curve, HalfSpace(1e9, 0.3), tip, ["base.young"])["base.young"] > 1e8


def test_a_soft_cell_with_hysteresis_is_fitted():
    """The unloading loses half of the force: dissipation, no imprint of a stiff body."""
    depth = np.concatenate([np.linspace(-5e-7, 1e-6, 900), np.linspace(1e-6, -5e-7, 900)])
    force = hertz(depth)
    force[900:] *= np.clip(1 - 0.5 * (1e-6 - depth[900:]) / 1e-6, 0.3, 1)
    assert modulus(noisy(depth, force))[0] == pytest.approx(1, rel=0.005)


@pytest.mark.parametrize("left", [0.0, 0.4])
def test_an_imprint_that_may_be_hysteresis_is_named(left):
    """An unloading of a gel that ends at a share of the depth is no reason to refuse, and the note has the share."""
    up = np.linspace(0, 1e-6, 900)
    depth = np.concatenate([np.linspace(-5e-7, 0, 400), up, left * 1e-6 + (1 - left) * up[::-1], up[:300] - 1e-6])
    force = np.concatenate([np.zeros(400), hertz(up), hertz(up[::-1]), np.zeros(300)])
    ratio, found = modulus(noisy(depth, force))
    assert ratio == pytest.approx(1, rel=0.005)
    named = [note for note in found.notes if f"ends {left:.0%} of the depth short" in note]
    assert len(named) == (left > 0)
    assert not named or "factor of about 1.7" in named[0]


def test_a_wave_in_the_baseline_is_no_load_cycle():
    """Interference of 1 % of the force on approach and retract; the one load cycle is refused for its imprint."""
    way = np.linspace(-3e-6, 1e-6, 2000)
    depth = np.append(way, way[::-1])
    force = 1e9 / GEL.young * np.append(hertz(way), hertz((way[::-1] - 4e-7) / 0.6))
    wave = 0.01 * force.max() * np.sin(depth / 1e-7 + 1.0)
    wave[:2000] *= 0.5
    with pytest.raises(CurveError, match=r"the unloading ends .*% of the depth short"):
        fit(noisy(depth, force + wave, 1e-4), HalfSpace(1e8, 0.5), TIP, ["base.young"])


def test_outliers_are_named_and_a_robust_loss_ignores_them():
    """21 of 2000 readings off by a third of the largest force; a robust fit is as good as one without them."""
    depth = np.append(way := np.linspace(-5e-7, 8e-7, 1000), way[::-1])
    force, rng = hertz(depth), np.random.default_rng(1)
    force = force + 1e-3 * force.max() * rng.normal(size=force.size)
    clean = Curve(depth, force.copy())
    force[50::97] += np.ptp(force) / 3
    spiked = Curve(depth, force)
    assert any("Outliers" in note for note in modulus(spiked)[1].notes)
    before, robust = (
        modulus(curve, loss=loss)[1].estimates["base.young"] for curve, loss in ((clean, "linear"), (spiked, "cauchy"))
    )
    assert robust.low <= GEL.young <= robust.high
    # the cauchy loss has an efficiency of about 0.4 for normal noise
    assert robust.high - robust.low < 3 * (before.high - before.low)


@pytest.mark.parametrize("spring", [None, 0.02])
def test_files_that_are_broken_are_named(spring):
    """Rows that are not in order, a decimal mark that was lost, a gap: the message says which, and where."""
    depth = np.linspace(-5e-7, 1e-6, 1500)
    force, rng = hertz(depth), np.random.default_rng(0)
    way = depth if spring is None else depth + force / spring

    def made(way, force):
        return Curve(way, force) if spring is None else Curve.from_piezo(way, force, spring)

    order = rng.permutation(way.size)
    with pytest.raises(CurveError, match="not in the order of the measurement"):
        modulus(made(way[order], force[order]))
    lost = np.where(np.arange(way.size) == 1234, 1e3 * way, way)
    with pytest.raises(CurveError, match=r"reading 1234, .* a decimal mark lost"):
        modulus(made(lost, force))
    with pytest.raises(CurveError, match=r"1 of 1500 values of force are no finite numbers \(rows 77"):
        made(way, np.where(np.arange(way.size) == 77, np.nan, force))


@pytest.mark.parametrize("tilt", [-0.03, 0.0, 0.02, 0.1])
def test_the_baseline_that_the_data_ask_for(tilt):
    """20 curves: 95 % intervals miss more than four with a probability of 0.3 %; the note names what a constant would give."""
    depth = np.linspace(-1e-6, 6e-7, 800)
    force = hertz(depth)
    along = tilt * force.max() * (depth - depth[0]) / np.ptp(depth)
    inside = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        curve = Curve(depth, force + along + 5e-3 * force.max() * rng.normal(size=800))
        found = fit(curve, START, TIP, ["base.young"], quick=True)
        estimate = found.estimates["base.young"]
        inside.append(estimate.low <= GEL.young <= estimate.high)
        told = any("baseline = 'constant' base.young" in note for note in found.notes)
        assert told if abs(tilt) == 0.1 else not (told and tilt == 0)
    assert sum(inside) >= 16


def test_a_constant_that_was_asked_for_names_the_tilt():
    depth = np.linspace(-1e-6, 6e-7, 800)
    force = hertz(depth)
    curve = noisy(depth, force + 0.1 * force.max() * (depth - depth[0]) / np.ptp(depth))
    _, found = modulus(curve, baseline="constant")
    assert "tilt" not in found.estimates
    assert any("with baseline = 'linear' base.young = 3.999 kPa (+2.6%)" in note for note in found.notes)


@pytest.mark.parametrize("direction", ["growing", "falling"])
def test_the_direction_can_be_given(direction):
    depth = np.linspace(-5e-7, 1e-6, 900)
    sign = 1.0 if direction == "growing" else -1.0
    assert modulus(noisy(sign * depth, hertz(depth)), direction=direction)[0] == pytest.approx(1, rel=0.005)


def test_a_reading_has_all_that_was_found():
    depth = np.concatenate([np.linspace(-5e-7, 1e-6, 900), np.linspace(1e-6, -5e-7, 900)])
    curve = noisy(depth, hertz(depth))
    lines = " ".join(reading_of(curve).lines)
    for word in ("direction:", "approach: points 0 to", "retract: points", "baseline: constant", "contact: begins at"):
        assert word in lines
    axes = fp.plot_measured(curve)
    assert {"approach", "retract", "baseline", "contact"} <= set(axes.get_legend_handles_labels()[1])
    flat = Curve(depth, 1e-12 * np.random.default_rng(0).normal(size=depth.size))
    lines = reading_of(flat).lines
    assert any(line.startswith("refused: ") for line in lines)
    assert "direction = 'growing'" in lines[-1]
    assert fp.plot_measured(flat).get_title().endswith("refused")


def test_pictures_show_what_is_behind_a_drop_as_left_out():
    depth = np.linspace(-1e-6, 1e-6, 600)
    force = 1e-9 * np.maximum(depth / 1e-6, 0) ** 1.5
    force[570:] -= 1.5e-10
    noise = 1e-13 * np.random.default_rng(0).normal(size=depth.size)
    shown = {name: position for name, position, _ in traces(reading_of(Curve(depth, force + noise)))}
    assert shown["left out"].size == 30
    assert shown["baseline"].size == 570
    assert shown["contact"] == pytest.approx(0, abs=1e-8)
