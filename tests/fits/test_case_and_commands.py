"""Case files of fits, the two commands, batches and pictures."""

import csv
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flatpunch.cli.fit import _announce
from flatpunch.contact.physics import Physics
from flatpunch.files import CaseError, load, read_case
from flatpunch.fits import Curve, Free, Settings, fit
from flatpunch.fits.batch import fit_batch
from flatpunch.fits.case import FitCase, drift, read_fit_case
from flatpunch.fits.description import seconds_of
from flatpunch.fits.distributions import map_figure
from flatpunch.fits.pictures import fit_figure
from flatpunch.indenters import Cone, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase, TransverselyIsotropicLayer
from support.commands import run
from support.synthetic_curves import synthetic

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "fit"
GEL = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase())
YOUNG = "layers[0].young"
CASE = """
[[layers]]
young = { fit = "5 kPa", min = "1 kPa", max = "50 kPa" }
poisson = 0.5
thickness = { fit = "1 um" }
[base]
kind = "rigid"
[indenter]
kind = "pyramid"
sides = 4
half_opening_angle = { fit = "35 deg", min = "30 deg", max = "40 deg" }
"""


def _case(folder, text=CASE):
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_free_values_of_a_case(tmp_path):
    case = read_fit_case(_case(tmp_path))
    assert list(case.free) == [YOUNG, "layers[0].thickness", "indenter.inclination"]
    assert case.medium.layers[0].young == 5e3
    assert case.free[YOUNG].minimum == 1e3
    # half opening angle and inclination add up to a right angle: limits change places
    np.testing.assert_allclose(
        np.degrees([case.free["indenter.inclination"].minimum, case.free["indenter.inclination"].maximum]), [50, 60]
    )
    assert case.settings.method == "auto"


def test_curve_and_fit_tables(tmp_path):
    text = (
        CASE
        + '[fit]\nbaseline = "linear"\ndepth_to = "300 nm"\n[curve]\nspring_constant = "0.05 N/m"\nunits = { force = "nN" }\n'
    )
    case = read_fit_case(_case(tmp_path, text))
    assert case.settings.baseline == "linear"
    assert case.settings.depth_to == 3e-7
    assert case.reading["spring_constant"] == 0.05
    assert case.reading["units"] == {"force": "nN"}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('min = "1 kPa"', 'min = "1 km"', r"layers\[0\].young.min = '1 km' has the dimension of a length"),
        ('min = "1 kPa"', 'lowest = "1 kPa"', "lowest is no known field"),
        ('fit = "5 kPa"', 'fit = "5"', "has no unit"),
        ("sides = 4", "sides = { fit = 4 }", "cannot be fitted"),
        ('kind = "rigid"', 'kind = "half-space"', "young is missing"),
        ("[base]", "[fit]\nbaseline = 'cubic'\n[base]", "baseline = 'cubic'"),
    ],
)
def test_mistakes_in_a_case(tmp_path, old, new, message):
    with pytest.raises(CaseError, match=message):
        read_fit_case(_case(tmp_path, CASE.replace(old, new)))


@pytest.mark.long
def test_example_gives_its_known_answer(tmp_path):
    """The example's curve was made with 2.6 kPa and 60 pN of noise."""
    picture, table, drift = tmp_path / "fit.png", tmp_path / "fit.csv", tmp_path / "drift.png"
    done = run(
        "fit",
        EXAMPLES / "thin_gel.csv",
        EXAMPLES / "thin_gel.toml",
        "--plot",
        picture,
        "-o",
        table,
        "--profile",
        "--drift",
        drift,
        exits=0,
    )
    assert "2.6 kPa" in done.output
    assert "profile" in done.output
    assert min(picture.stat().st_size, drift.stat().st_size) > 10_000
    (values,) = csv.DictReader(table.read_text(encoding="utf-8").splitlines())
    # four standard errors
    assert float(values["layers[0].young [Pa]"]) == pytest.approx(
        2600, abs=4 * float(values["layers[0].young stderr [Pa]"])
    )


def test_folder(tmp_path):
    """One bad file among the curves is told and costs nothing else; the table has a line for it."""
    for i in range(3):
        (tmp_path / f"c{i}.csv").write_text((EXAMPLES / "thin_gel.csv").read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "broken.csv").write_text("depth (nm),force (nN)\n1,2\n3,4\n", encoding="utf-8")
    out = tmp_path.parent / f"{tmp_path.name}.nc"
    done = run("fit", tmp_path, EXAMPLES / "thin_gel.toml", "-o", out, "--plot", out.with_suffix(".png"), exits=0)
    assert "3 of 4 curves fitted" in done.output
    assert "a fit needs 12 or more" in done.output
    table = load(out)
    assert table["ok"].values.tolist() == [False, True, True, True]
    np.testing.assert_allclose(table[YOUNG].values[1:], 2600, rtol=0.01)


def test_a_folder_without_curves_is_read_to_its_end(tmp_path):
    """Each file with the reason why it is none, and no mistake of the package after the last."""
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("way,signal\n1,2\n2,3\n3,4\n")
    printed = run("read", tmp_path, exits=0).stdout
    assert printed.count("not read") == 2


def test_read_shows_each_curve_of_a_folder(tmp_path):
    for name in ("a.csv", "b.csv"):
        shutil.copy(EXAMPLES / "thin_gel.csv", tmp_path / name)
    (tmp_path / "c.csv").write_text("no numbers\n", encoding="utf-8")
    done = run("read", tmp_path, EXAMPLES / "thin_gel.toml", exits=0)
    assert done.output.count("contact: begins at") == 2
    assert "c.csv\n  not read: c.csv: no rows of numbers" in done.output
    picture = run("read", tmp_path, "--plot", tmp_path / "x.png", exits=2)
    assert "--plot goes with a single curve" in picture.output


def test_a_case_of_stresses_serves_for_what_needs_its_bodies_alone():
    case = EXAMPLES.parent / "hard_coating_on_steel.toml"
    sample = read_fit_case(case).sample
    assert (sample.medium, sample.indenter) == (read_case(case).medium, read_case(case).indenter)


def test_correct_command():
    done = run("correct", EXAMPLES / "thin_gel.toml", "--reported", "8 kPa", "--depth", "500 nm", exits=0)
    assert "Dimitriadis" in done.output
    assert "Clifford" in done.output
    bad = run("correct", EXAMPLES / "thin_gel.toml", "--reported", "8", "--depth", "500 nm", exits=2)
    assert "--reported = '8' has no unit" in bad.output


def test_command_refuses_before_fitting(tmp_path):
    done = run("fit", "x.csv", EXAMPLES / "thin_gel.toml", "-o", "x.docx", exits=2)
    assert "the ending must be .csv or .nc" in done.output


@pytest.mark.long
def test_batch_keeps_order_and_reasons(tmp_path):
    curves = [synthetic(GEL, Sphere(3e-6), 0.4e-6, seed=i, points=300) for i in range(40)]
    curves[5] = Curve(curves[5].depth, np.ones(300), name="flat")
    seen = []
    one = fit_batch(curves, GEL, Sphere(3e-6), [YOUNG], workers=1, progress=seen.append)
    two = fit_batch(curves, GEL, Sphere(3e-6), [YOUNG], workers=2)
    assert seen[-1] == 40
    assert [row["curve"] for row in two.rows][4:7] == ["synthetic-4", "flat", "synthetic-6"]
    assert len(two.failed) == 1
    assert "at every point" in two.failed[0]["reason"]
    np.testing.assert_array_equal(one.column(YOUNG), two.column(YOUNG))
    assert np.nanmedian(one.column(YOUNG)) == pytest.approx(5e3, rel=0.01)
    one.save(tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text(encoding="utf-8").startswith("curve,ok,reason,layers[0].young [Pa]")
    with pytest.raises(ValueError, match=r"kept as .csv or .nc"):
        one.save(tmp_path / "t.txt")
    with pytest.raises(ValueError, match=r"the start 5 kPa must lie between minimum 100 kPa and maximum none"):
        fit_batch(curves, GEL, Sphere(3e-6), {YOUNG: (1e5, None)}, workers=1)


@pytest.mark.long
def gel_of(thickness):
    return Medium([Layer(2600.0, 0.5, thickness)], RigidBase())


def test_known_values_of_each_curve():
    """A map over 1 to 4 um of gel: each modulus with the thickness of its place; with one for all it is far off."""
    thick, tip = np.array([1e-6, 2e-6, 4e-6]), Sphere(5e-6)
    curves = [replace(synthetic(gel_of(t), tip, 0.3e-6, noise=0.002), name=f"{t}") for t in thick]
    start = gel_of(2e-6)
    batch = fit_batch(curves, start, tip, [YOUNG], values={"layers[0].thickness": thick}, workers=1)
    np.testing.assert_allclose(batch.column(YOUNG), 2600, rtol=0.01)
    blind = fit_batch(curves, start, tip, [YOUNG], workers=1)
    assert np.ptp(blind.column(YOUNG)) > 1000
    for values, words in (
        ({"layers[0].thickness": thick[:2]}, r"needs one value for each of the 3 curves"),
        ({YOUNG: thick}, "is fitted; leave it out of values"),
        ({"layers[0].depth": thick}, "is not part of this case"),
    ):
        with pytest.raises(ValueError, match=words):
            fit_batch(curves, start, tip, [YOUNG], values=values)


def test_known_values_from_a_table(tmp_path):
    folder = tmp_path / "map"
    folder.mkdir()
    for i, t in enumerate((1e-6, 3e-6)):
        curve = synthetic(gel_of(t), Sphere(5e-6), 0.3e-6, noise=0.002)
        columns = np.column_stack([curve.depth * 1e9, curve.force * 1e9])
        np.savetxt(folder / f"c{i}.csv", columns, delimiter=",", header="depth (nm),force (nN)", comments="")
    (tmp_path / "known.csv").write_text("curve,layers[0].thickness [nm]\nc1.csv,3000\nc0.csv,1000\n", encoding="utf-8")
    (tmp_path / "case.toml").write_text(
        'layers = [{ young = { fit = "2 kPa" }, poisson = 0.5, thickness = "2 um" }]\nbase = { kind = "rigid" }\n'
        'indenter = { kind = "sphere", radius = "5 um" }\n',
        encoding="utf-8",
    )
    command = ["fit", str(folder), str(tmp_path / "case.toml"), "--values", str(tmp_path / "known.csv")]
    done = run(*command, "-o", tmp_path / "out.csv", exits=0)
    rows = list(csv.DictReader((tmp_path / "out.csv").read_text(encoding="utf-8").splitlines()))
    np.testing.assert_allclose([float(row["layers[0].young [Pa]"]) for row in rows], 2600, rtol=0.01)
    (tmp_path / "known.csv").write_text("curve,layers[0].thickness [nm]\nc1.csv,3000\n", encoding="utf-8")
    done = run(*command, exits=2)
    assert "known.csv: no line for c0.csv" in done.output.replace("\n", " ")


def test_pictures():
    film = Medium([Layer(5e3, 0.4, 1e-6)], HalfSpace(1e4, 0.3))
    curve = synthetic(film, Sphere(3e-6), 0.3e-6, points=200)
    result = fit(curve, film, Sphere(3e-6), {YOUNG: None, "base.young": (5e3, 1e5)})
    assert len(fit_figure(result).axes) == 2
    # a force map: positions come with the curves
    curves = [
        Curve(curve.depth, curve.force, meta={"metadata": {"position x": i * 1e-6, "position y": 0.0}})
        for i in range(3)
    ]
    batch = fit_batch(curves, film, Sphere(3e-6), [YOUNG], workers=1)
    assert len(map_figure(batch, YOUNG).axes) == 3  # map, its bar, histogram


def test_a_drift_needs_a_homogeneous_layer_on_top():
    fibres = Medium([TransverselyIsotropicLayer(2e4, 1e4, 0.3, 0.2, 4e3, 1e-6)], RigidBase())
    case = FitCase("fibres", fibres, Sphere(5e-6), {YOUNG: Free()}, Settings())
    with pytest.raises(ValueError, match=r"layers\[0\] must be a homogeneous layer"):
        drift(Curve(np.linspace(0, 1e-7, 20), np.linspace(0, 1e-9, 20)), case)


def test_a_fit_that_takes_minutes_says_so_before_it_starts(capsys):
    case = read_fit_case(EXAMPLES / "thin_gel.toml")
    _announce(case)
    assert capsys.readouterr().err == ""
    _announce(replace(case, settings=replace(case.settings, method="bem")))
    assert capsys.readouterr().err == "This fit takes many minutes.\n"
    film, free = Medium([Layer(5e3, 0.4, 1e-6)], HalfSpace(2e4, 0.3)), {YOUNG: Free(), "work_of_adhesion": Free()}
    for physics, expected in ((Physics(1e-4), ""), (Physics(1e-4, 1e-8), "This fit takes about a minute.\n")):
        _announce(FitCase("film", film, Sphere(3e-6), free, Settings(), physics=physics))
        assert capsys.readouterr().err == expected


def test_curves_of_a_joint_fit_count_by_the_tables_that_they_need():
    """Scaled problems under spheres are the same on a half-space, under a cone another one."""
    case = FitCase(
        "joint", HalfSpace(5e3, 0.5), Sphere(3e-6), {"base.young": Free()}, Settings(), physics=Physics(1e-4)
    )

    def seconds(*tips):
        return seconds_of(replace(case, curves=tuple({"indenter": tip, "values": {}} for tip in tips)))

    assert seconds(None, Sphere(5e-6)) == seconds_of(case)
    assert seconds(None, Cone(0.4)) == 2 * seconds_of(case)
