"""Several curves, one sample: what no curve determines by itself."""

import dataclasses

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.files import CaseError, load
from flatpunch.fits import Curve, CurveError, Measured, fit, fit_together, read_fit_case
from flatpunch.fits.pictures import fit_figure
from flatpunch.indenters import Cone, Paraboloid, Pyramid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase, StandardLinearSolid
from support.commands import run
from support.synthetic_curves import synthetic

YOUNG, THICKNESS = "layers[0].young", "layers[0].thickness"


def layer(young=5e3, thickness=1e-6):
    return Medium([Layer(young, 0.5, thickness)], RigidBase())


def named(curve, name):
    return dataclasses.replace(curve, name=name)


def two_tips(seed, noise=0.01, thickness=1e-6):
    """A small and a large bead, to modest depths."""
    return [
        Measured(
            named(
                synthetic(
                    layer(thickness=thickness), Sphere(radius), 0.25e-6, noise=noise, seed=seed + i, contact=i * 1e-8
                ),
                f"bead {i}",
            ),
            indenter=Sphere(radius),
        )
        for i, radius in enumerate((0.5e-6, 5e-6))
    ]


@pytest.mark.long
def test_two_tips_determine_modulus_and_thickness():
    found = fit_together(two_tips(1), layer(2e3, 2e-6), Sphere(1e-6), free=[YOUNG, THICKNESS])
    for name, truth in ((YOUNG, 5e3), (THICKNESS, 1e-6)):
        e = found.estimates[name]
        assert e.low < truth < e.high
        assert e.stderr < 0.03 * truth
    alone = fit(two_tips(1)[0].curve, layer(5e3, 1e-6), Sphere(0.5e-6), [YOUNG, THICKNESS])
    assert found.estimates[THICKNESS].stderr < 0.2 * alone.estimates[THICKNESS].stderr
    assert found.agreement > 1e-3
    assert not found.notes


def test_residuals_are_drawn_as_they_are_weighted():
    """Behind a cantilever the noise moves the tip as well: over the noise of the detector all residuals are alike."""
    curves = []
    for i, radius in enumerate((2e-6, 10e-6)):
        clean = synthetic(layer(), Sphere(radius), 0.3e-6, noise=0)
        noise = 0.01 * clean.force.max() * np.random.default_rng(i).normal(size=clean.force.size)
        piezo = clean.depth + clean.force / 0.05
        curve = Curve.from_piezo(piezo, clean.force + noise, 0.05, name=f"bead {i}")
        curves.append(Measured(curve, indenter=Sphere(radius)))
    found = fit_together(curves, layer(2e3), Sphere(2e-6), free=[YOUNG])
    bottom = fit_figure(found).axes[1]
    for line in bottom.get_lines()[:2]:
        drawn = line.get_ydata()
        # of 500 normal readings none is beyond 5
        assert np.abs(drawn).max() < 5
        assert np.std(drawn) == pytest.approx(1, abs=0.1)


def test_exact_data_give_exact_values():
    found = fit_together(two_tips(1, noise=0), layer(2e3, 2e-6), Sphere(1e-6), free=[YOUNG, THICKNESS])
    assert found[YOUNG] == pytest.approx(5e3, rel=1e-4)
    assert found[THICKNESS] == pytest.approx(1e-6, rel=1e-4)


def test_a_single_group_equals_one_long_curve():
    """Two halves of the same readings, contact and background shared by construction: the values of the one fit, closely."""
    whole = synthetic(layer(), Sphere(3e-6), 0.4e-6, points=2000)
    halves = [named(whole.taken(slice(i, None, 2)), f"half {i}") for i in range(2)]
    one = fit(whole, layer(2e3), Sphere(3e-6), [YOUNG], baseline="constant").estimates[YOUNG]
    both = fit_together(halves, layer(2e3), Sphere(3e-6), [YOUNG], baseline="constant").estimates[YOUNG]
    assert abs(one.value - both.value) < 0.2 * one.stderr
    assert both.stderr == pytest.approx(one.stderr, rel=0.05)


@pytest.mark.long
def test_a_tilt_that_is_not_excluded_widens_joint_intervals_and_draws():
    """20 times three curves with tilts of half a per cent of the rise; 95 % intervals miss more than four with 0.3 %."""
    held, z = 0, np.linspace(-4e-7, 6e-7, 300)
    clean = 4 / 3 * 4e3 / 0.75 * 2e-3 * np.maximum(z, 0) ** 1.5
    for seed in range(20):
        rng = np.random.default_rng(seed)
        forces = [
            clean + clean.max() * (0.01 * rng.normal(size=z.size) + 0.005 * rng.normal() * (z - z[0]) / np.ptp(z))
            for _ in range(3)
        ]
        curves = [Curve(z, force, name=str(i)) for i, force in enumerate(forces)]
        found = fit_together(curves, HalfSpace(2e3, 0.5), Paraboloid(4e-6), ["base.young"])
        held += found.estimates["base.young"].low < 4e3 < found.estimates["base.young"].high
    assert held >= 16
    # errors of draws: those of 2000 independent ones, and the ends of an interval
    low, high = found.posterior(2000).interval("base.young")
    e = found.estimates["base.young"]
    assert (high - low) == pytest.approx(e.high - e.low, rel=0.15)
    assert found.unseen.any()


def test_own_thicknesses():
    """One modulus, a thickness at each place."""
    truths = {"thin": 0.6e-6, "thick": 1.5e-6, "middle": 1e-6}
    curves = [
        named(synthetic(layer(thickness=h), Sphere(3e-6), 0.3e-6, noise=0.002, seed=i, points=800), name)
        for i, (name, h) in enumerate(truths.items())
    ]
    found = fit_together(curves, layer(2e3), Sphere(3e-6), free=[YOUNG], own=[THICKNESS])
    assert found.shared == (YOUNG,)
    for name, h in truths.items():
        e = found.estimates[f"{THICKNESS} @ {name}"]
        assert abs(e.value - h) < 4 * e.stderr
        assert f"thickness of layer 1 ({name})" in found.summary()
    rows = found.rows()
    assert [row["curve"] for row in rows] == list(truths)
    assert len({row[YOUNG] for row in rows}) == 1
    assert found.to_csv().splitlines()[0].startswith("curve,layers[0].young [Pa]")


def test_curves_that_do_not_agree():
    """A thickness that is not the same at both places, taken as one."""
    curves = two_tips(1)
    other = two_tips(5, thickness=2e-6)[1]
    found = fit_together([curves[0], other], layer(), Sphere(1e-6), free=[YOUNG])
    assert found.agreement < 1e-3
    assert any("do not agree with one sample" in note for note in found.notes)
    known = Measured(other.curve, other.indenter, {THICKNESS: 2e-6})
    assert fit_together([curves[0], known], layer(), Sphere(1e-6), free=[YOUNG]).agreement > 1e-3


def test_noise_of_each_counts():
    """A noisy curve beside a clean one adds next to nothing, and harms nothing."""
    clean = named(synthetic(layer(), Sphere(3e-6), 0.4e-6, noise=0.002, seed=1), "clean")
    noisy = named(synthetic(layer(), Sphere(3e-6), 0.4e-6, noise=0.1, seed=2), "noisy")
    one = fit(clean, layer(2e3), Sphere(3e-6), [YOUNG], baseline="constant").estimates[YOUNG]
    both = fit_together([clean, noisy], layer(2e3), Sphere(3e-6), [YOUNG], baseline="constant").estimates[YOUNG]
    assert abs(both.value - one.value) < 0.3 * one.stderr
    assert both.stderr == pytest.approx(one.stderr, rel=0.05)


@pytest.mark.long
def test_relaxing_curves():
    """Fast and slow ramps of one solid."""
    solid, curves = StandardLinearSolid(0.4, 0.5), []
    for i, speed in enumerate((1.0, 0.2)):
        time = np.linspace(0, 3 / speed, 200)
        depth = np.interp(time * speed, [0, 0.5, 1.0, 2, 3], np.array([-0.5, 0, 1, 1, -0.5]) * 3e-7)
        force = indent(layer(), Sphere(3e-6), time=time, depth=depth, relaxation=solid, angles=8)["force"].values
        force = force + 0.01 * force.max() * np.random.default_rng(i).normal(size=200)
        curves.append(Curve(depth, force, time=time, name=f"ramp {i}"))
    names = [YOUNG, "relaxation.equilibrium"]
    found = fit_together(curves, layer(2e3), Sphere(3e-6), names, relaxation=StandardLinearSolid(0.6, 0.5))
    for name, truth in zip(names, (5e3, 0.4), strict=True):
        e = found.estimates[name]
        assert abs(e.value - truth) < 4 * e.stderr


def test_what_is_refused():
    curves = two_tips(1)
    case = (layer(), Sphere(1e-6))
    with pytest.raises(ValueError, match="two or more"):
        fit_together(curves[:1], *case, free=[YOUNG])
    with pytest.raises(ValueError, match="used twice"):
        fit_together([curves[0], curves[0]], *case, free=[YOUNG])
    with pytest.raises(ValueError, match="in free and in own"):
        fit_together(curves, *case, free=[YOUNG], own=[YOUNG])
    with pytest.raises(ValueError, match="no parameter is shared"):
        fit_together(curves, *case, own=[YOUNG])
    with pytest.raises(ValueError, match="can have no value of its own"):
        fit_together([curves[0], Measured(curves[1].curve, values={YOUNG: 1e3})], *case, free=[YOUNG])
    with pytest.raises(ValueError, match="its parameters cannot be shared"):
        fit_together(curves, *case, free=[YOUNG, "indenter.radius"])
    with pytest.raises(TypeError, match=r"values\['layers\[0\].thickness'\]"):
        Measured(curves[1].curve, values={"layers[0].thickness": "2e-6"})
    with pytest.raises(TypeError, match="must be a Curve"):
        fit_together([1, 2], *case, free=[YOUNG])
    with pytest.raises(ValueError, match="is not part of this case"):
        fit_together([c.curve for c in curves], layer(), Cone(0.3), free=["indenter.radius"])
    # the first curve shows no adhesion: what is wrong with the second is said before any is fitted
    for second, message in (
        (Measured(curves[1].curve, values={THICKNESS: -1e-6}), "Layer.thickness = -1e-06 must be"),
        (
            Measured(curves[1].curve, indenter=Pyramid(4, 0.3)),
            "strength = 100 kPa does not go with the indenter Pyramid",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            fit_together([curves[0], second], *case, free=[YOUNG], work_of_adhesion=1e-4, strength=1e5)
    flat = dataclasses.replace(curves[0].curve, force=0 * curves[0].curve.force)
    with pytest.raises(CurveError, match="bead 0: the force is 0 N at every point"):
        fit_together([flat, curves[1]], *case, free=[YOUNG])


CASE = """
[[layers]]
young = { fit = "2 kPa" }
poisson = 0.5
thickness = { fit = "1.2 um", each = true }
[base]
kind = "rigid"
[indenter]
kind = "sphere"
radius = "3 um"
[[curves]]
file = "one.csv"
[[curves]]
file = "two.csv"
indenter = { kind = "sphere", radius = "5 um" }
values = { "layers[0].thickness" = "700 nm" }
"""


def written(folder, text=CASE):
    for name, radius, thickness in (("one", 3e-6, 1e-6), ("two", 5e-6, 0.6e-6)):
        curve = synthetic(layer(thickness=thickness), Sphere(radius), 0.3e-6, noise=0.003)
        rows = "\n".join(f"{z * 1e9:.4f},{f * 1e9:.7f}" for z, f in zip(curve.depth, curve.force, strict=True))
        (folder / f"{name}.csv").write_text("depth (nm),force (nN)\n" + rows, encoding="utf-8")
    (folder / "case.toml").write_text(text, encoding="utf-8")
    return folder / "case.toml"


def test_case_file_with_curves(tmp_path):
    case = written(tmp_path)
    loaded = read_fit_case(case)
    assert loaded.own == (THICKNESS,)
    assert loaded.curves[1]["values"] == {THICKNESS: pytest.approx(7e-7)}
    checked = run("check", case)
    assert "thickness, from 1.2 µm, for each curve" in checked.output
    assert "Curves    one.csv" in checked.output
    done = run("fit", case, "-o", tmp_path / "table.csv", "--plot", tmp_path / "fit.png", exits=0)
    assert "2 curves, one sample" in done.output
    assert "thickness of layer 1 (two)" in done.output
    assert (tmp_path / "fit.png").stat().st_size > 10_000
    table = (tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()
    assert len(table) == 3
    assert "layers[0].thickness [m],layers[0].thickness stderr [m]" in table[0]
    young = [float(line.split(",")[1]) for line in table[1:]]
    assert young[0] == young[1] == pytest.approx(5e3, rel=0.1)


def test_mistakes_with_curves(tmp_path):
    case = written(tmp_path)
    assert "names its own curves" in run("fit", tmp_path / "one.csv", case).output
    begin = CASE.index("[[curves]]")
    one = CASE[:begin] + '[[curves]]\nfile = "one.csv"\n'
    for text, message in (
        (CASE[:begin], "each = true, which goes with two or more"),
        (one, "curves has one entry"),
        (CASE.replace('"layers[0].thickness" =', '"layers[3].thickness" ='), r"layers\[3\].thickness is not part"),
        (CASE.replace("each = true", "each = 1"), "each = 1 must be true or false"),
        (CASE.replace('"700 nm"', '"700 Pa"'), "pressure"),
        (CASE.replace('"700 nm"', '"-700 nm"'), "Layer.thickness = -7e-07 must be finite and > 0"),
    ):
        with pytest.raises(CaseError, match=message):
            read_fit_case(written(tmp_path, text))
    plain = written(tmp_path, CASE[:begin].replace(", each = true", ""))
    assert "the case names no curves" in run("fit", plain).output
    absent = written(tmp_path, CASE.replace("two.csv", "three.csv"))
    assert "three.csv" in run("fit", absent).output


@pytest.mark.slow
def test_intervals_hold_the_truth():
    """200 pairs of curves: coverage of 95 % intervals within 91 to 99 % (2.5 standard errors)."""
    covered = {YOUNG: 0, THICKNESS: 0}
    for seed in range(200):
        found = fit_together(two_tips(100 + 2 * seed), layer(2e3, 2e-6), Sphere(1e-6), free=[YOUNG, THICKNESS])
        for name, truth in ((YOUNG, 5e3), (THICKNESS, 1e-6)):
            covered[name] += found.estimates[name].low <= truth <= found.estimates[name].high
    assert all(182 <= hits <= 198 for hits in covered.values())


def test_a_tilt_of_one_curve_is_noted_as_in_a_fit_of_it_alone():
    gel, tip = HalfSpace(4e3, 0.5), Paraboloid(4e-6)
    depth = np.linspace(-6e-7, 4e-7, 400)
    force = np.zeros(400)
    force[depth > 0] = indent(gel, tip, depth=depth[depth > 0]).force
    rng = np.random.default_rng(0)
    curves = [
        Curve(depth, force + force.max() * (tilt * np.linspace(0, 1, 400) + 1e-3 * rng.normal(size=400)), name=name)
        for name, tilt in (("tilted", 0.2), ("flat", 0.0))
    ]
    joint = fit_together(curves, HalfSpace(1e3, 0.5), tip, ["base.young"])
    alone = fit(curves[0], HalfSpace(1e3, 0.5), tip, ["base.young"])
    notes = [[note for note in result.notes if "is tilted" in note] for result in (alone, *joint.results)]
    assert [len(each) for each in notes] == [1, 1, 0]
    assert notes[0] == notes[1]
    assert joint["base.young"] == pytest.approx(4e3, rel=0.005)


def beads(springs, radius=5e-6, deepest=4e-7):
    """Curves on a half-space behind cantilevers whose constants are known to 10 %."""
    curves = []
    for i, spring in enumerate(springs):
        curve = synthetic(HalfSpace(5e3, 0.5), Paraboloid(radius), deepest, noise=0.003, seed=i, points=300)
        known = {"calibration": {"spring_constant": 0.1}}
        curves.append(
            Curve.from_piezo(curve.depth + curve.force / spring, curve.force, spring, name=f"bead {i}", meta=known)
        )
    return curves


@pytest.mark.parametrize(("springs", "share"), [((1.0, 1.0), 1.0), ((1.0, 1.1), 0.5**0.5)], ids=["one", "two"])
def test_errors_of_a_cantilever_are_shared_by_its_curves(springs, share):
    """F = k delta: a relative error of k is one of E, for both curves the same or, of two cantilevers, independent."""
    found = fit_together(beads(springs), HalfSpace(2e3, 0.5), Paraboloid(5e-6), ["base.young"])
    assert found.estimates["base.young"].stderr / found["base.young"] == pytest.approx(0.1 * share, rel=0.1)


def test_curves_of_a_joint_fit_have_the_notes_of_the_theory(tmp_path):
    """A paraboloid pressed to more than its radius; files, and what belongs to one curve only."""
    case = (HalfSpace(2e3, 0.5), Paraboloid(2e-7))
    found = fit_together(beads((1.0, 1.0), radius=2e-7), *case, ["base.young"])
    for result in found.results:
        assert any("% less force on a half-space" in note for note in result.notes)
        assert result.notes[-1] in found.summary()
    data = load(found.save(tmp_path / "both.nc"))
    assert data["curve"].values.tolist() == ["bead 0"] * 300 + ["bead 1"] * 300
    np.testing.assert_array_equal(data["fitted"].values[300:], found.results[1].force)
    with pytest.raises(ValueError, match=r"curve.* belongs to each of the 2 curves: take it from one of `results`"):
        _ = found.curve
    assert found.results[0].results == (found.results[0],)
    quick = fit_together(beads((1.0, 1.0), radius=2e-7), *case, ["base.young"], quick=True)
    assert not any("less force" in note for result in quick.results for note in result.notes)
