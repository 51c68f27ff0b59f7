"""Stiffness from unloading curves: exact on power laws, and against the instrument's own on a real test."""

import csv
import re

import numpy as np
import pytest

from flatpunch.fits import Curve, CurveError, Tip, fit_film, read_curve, unloading, unloadings
from flatpunch.fits.films.film import normalised_stiffness
from flatpunch.fits.films.oliver_pharr import DIAMOND
from flatpunch.fits.films.unloading import film_curves
from flatpunch.fits.measured.cycles import load_cycles
from flatpunch.media import HalfSpace, Layer, Medium
from support.commands import run


def _cycle(depth, force, stiffness, exponent=1.5, noise=0.0, seed=0):
    """Load like h^2, hold, unload along a power law of this stiffness."""
    gap = exponent * force / stiffness
    up = np.linspace(0, 1, 300)
    down = np.linspace(1, 0, 400)
    h = np.concatenate([depth * up, np.full(50, depth), depth - gap * (1 - down)])
    p = np.concatenate([force * up**2, np.full(50, force), force * down**exponent])
    return Curve(h, p + noise * force * np.random.default_rng(seed).normal(size=p.size))


@pytest.mark.parametrize("exponent", [1.2, 1.5, 2.0])
def test_power_law_is_found(exponent):
    found = unloading(_cycle(500e-9, 10e-3, 1e5, exponent))
    # the fit ends when a step is 1e-4 of its standard error; without noise that is rounding
    assert found.stiffness == pytest.approx(1e5, rel=1e-6)
    assert found.exponent == pytest.approx(exponent, rel=1e-6)
    assert found.final_depth == pytest.approx(500e-9 - exponent * 10e-3 / 1e5, rel=1e-6)


def test_noise_is_told():
    """0.5 % noise: within four standard errors, in each of ten curves."""
    for seed in range(10):
        found = unloading(_cycle(500e-9, 10e-3, 1e5, noise=0.005, seed=seed))
        assert abs(found.stiffness - 1e5) < 4 * found.stderr


def test_film_from_unloadings():
    """Cycles to twenty depths instead of a continuous stiffness."""
    tip = Tip.from_coefficients([24.5, 200.0])
    film = Medium([Layer(210e9, 0.25, 500e-9)], HalfSpace(70e9, 0.2))
    h_c = np.linspace(30e-9, 400e-9, 20)
    a = np.sqrt(tip.area(h_c) / np.pi)
    modulus = film.surface_modulus * normalised_stiffness(film, a)
    stiffness = 2 * tip.beta * a / (1 / modulus + 1 / DIAMOND.surface_modulus)
    force = 5e9 * tip.area(h_c)
    depth = h_c + tip.epsilon * force / stiffness
    points = unloadings(_cycle(*values) for values in zip(depth, force, stiffness, strict=True))
    start = Medium([Layer(100e9, 0.25, 500e-9)], HalfSpace(70e9, 0.2))
    assert fit_film(points, start, tip, compare=False)["layers[0].young"] == pytest.approx(210e9, rel=1e-4)


def test_loading_alone_is_refused():
    h = np.linspace(0, 1e-6, 200)
    with pytest.raises(CurveError, match=r"points of unloading between 0\.5 and 0\.98"):
        unloading(Curve(h, h**2))


@pytest.mark.parametrize("sheet", ["Test 001", "Test 002"])
def test_real_unloading_agrees_with_continuous_stiffness(sheet, measured):
    """The instrument's harmonic stiffness at the end of loading and the slope of unloading, 3 % apart at most."""
    curve = read_curve(measured / "micromechanics" / "Example.xls", sheet=sheet)
    found = unloading(curve)
    near = np.isfinite(curve.stiffness) & (curve.depth > 0.97 * found.depth)
    assert found.stiffness == pytest.approx(np.median(curve.stiffness[near]), rel=0.03)
    assert 1.0 < found.exponent < 2.0


TIP = Tip.from_coefficients([24.5, 200.0])
FILM = Medium([Layer(210e9, 0.25, 500e-9)], HalfSpace(70e9, 0.2))
FILM_CASE = """
[[layers]]
young = { fit = "100 GPa" }
poisson = 0.25
thickness = "500 nm"
[base]
kind = "half-space"
young = "70 GPa"
poisson = 0.2
[indenter]
kind = "berkovich"
[film]
area_coefficients = [24.5, 200.0]
"""


def _cycles(count, left=0.0, noise=0.001, seed=0):
    """Load cycles to growing depths on the film, taken back to a share of their load: depth [m] and force [N] of each."""
    h_c = np.geomspace(20e-9, 400e-9, count)
    a = np.sqrt(TIP.area(h_c) / np.pi)
    modulus = FILM.surface_modulus * normalised_stiffness(FILM, a)
    stiffness = 2 * TIP.beta * a / (1 / modulus + 1 / DIAMOND.surface_modulus)
    force = 5e9 * TIP.area(h_c)
    depth = h_c + TIP.epsilon * force / stiffness
    rng, last, found = np.random.default_rng(seed), (0.0, 0.0), []
    for h, p, s in zip(depth, force, stiffness, strict=True):
        share = np.linspace(1, left, 300)
        up = np.linspace(0, 1, 200)[:-1]
        # what was left before is loaded along a straight line, then on like h^2
        rise = np.column_stack([last[0] + (h - last[0]) * up, last[1] + (p - last[1]) * up**1.5])
        fall = np.column_stack([h - 1.5 * p / s * (1 - share ** (1 / 1.5)), p * share])
        hold = np.column_stack([np.full(30, h), np.full(30, p)])
        cycle = np.concatenate([rise, hold, fall])
        found.append(cycle + np.array([0.0, noise * p]) * rng.normal(size=cycle.shape))
        last = tuple(fall[-1])
    return found


def _text(cycles):
    rows = np.concatenate(cycles)
    return "depth (nm),load (mN)\n" + "\n".join(f"{h * 1e9:.5f},{p * 1e3:.7f}" for h, p in rows) + "\n"


@pytest.mark.long
@pytest.mark.parametrize("left", [0.0, 0.3, 0.6], ids=["whole", "partial", "to 60 %"])
@pytest.mark.parametrize("layout", ["one record", "blocks"])
def test_command_on_load_cycles(tmp_path, layout, left):
    """Fourteen cycles, one below the other or in one record: the film within 1 %, its table, and its picture."""
    cycles = _cycles(14, left)
    text = _text(cycles) if layout == "one record" else "\n".join(_text([c]) for c in cycles)
    (tmp_path / "cycles.csv").write_text(text, encoding="utf-8")
    (tmp_path / "case.toml").write_text(FILM_CASE, encoding="utf-8")
    out, picture = tmp_path / "points.csv", tmp_path / "film.png"
    command = [
        "fit-film",
        str(tmp_path / "cycles.csv"),
        str(tmp_path / "case.toml"),
        "-o",
        str(out),
        "--plot",
        str(picture),
    ]
    done = run(*command, exits=0)
    points = list(csv.DictReader(out.read_text(encoding="utf-8").splitlines()))
    assert len(points) == 14
    found = float(re.search(r"Young's modulus of layer 1 +([\d.]+) GPa", done.output)[1])
    # 0.1 % noise on 120 points of each unloading; the stiffness of each is good to 0.2 %, the film to a few times that
    assert found == pytest.approx(210, rel=0.01)
    assert "One-tenth rule" in done.output
    for name in ("Gao", "Perriot-Barthel", "Bec", "King", "Saha-Nix"):
        assert name in done.output
    assert picture.stat().st_size > 10_000


@pytest.mark.long
def test_a_plastic_cycle_is_sent_to_the_command_for_films(tmp_path):
    """`flatpunch fit` of a load cycle that leaves an imprint: refused, with the command that takes it."""
    rows = np.concatenate([[[h, 0.0] for h in np.linspace(-50e-9, 0, 100)], _cycles(1)[0]])
    (tmp_path / "cycle.csv").write_text(_text([rows]), encoding="utf-8")
    (tmp_path / "case.toml").write_text(FILM_CASE, encoding="utf-8")
    done = run("fit", tmp_path / "cycle.csv", tmp_path / "case.toml", exits=2)
    assert "flatpunch fit-film" in done.output
    assert "the loading was plastic" in done.output
    # one cycle alone is too little for a film
    done = run("fit-film", tmp_path / "cycle.csv", tmp_path / "case.toml", exits=2)
    assert "1 unloading found" in done.output


def _record(force, depth=None):
    return Curve(np.asarray(force) if depth is None else depth, np.asarray(force))


def test_cycles_are_found_whatever_their_loads():
    rng = np.random.default_rng(0)
    force = np.concatenate(
        [np.append(np.linspace(0, p, 200), np.linspace(p, 0.2 * p, 100)) for p in (0.01, 0.1, 1, 10)]
    )
    found = load_cycles(_record(force * (1 + 0.002 * rng.normal(size=force.size)), force))
    assert [peak for _, peak, _ in found] == pytest.approx([199, 499, 799, 1099], abs=6)
    assert load_cycles(_record(np.linspace(0, 1, 500))) == []
    assert len(load_cycles(_record(np.append(np.linspace(0, 1, 500), np.linspace(1, 0, 300))))) == 1


def _in_air(seed):
    """Drift of the force before the contact while the tip advances to the surface: depth [m], force [N], both random."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(100, 600))
    wave = np.sin(np.linspace(0, rng.uniform(4, 20), count) + rng.uniform(0, 6))
    return np.linspace(-rng.uniform(10e-9, 100e-9), 0, count), 1e-3 * rng.uniform(0.5e-3, 20e-3) * (wave - 0.5)


@pytest.mark.parametrize("seed", range(20))
def test_drift_in_air_is_no_cycle(seed):
    """Drift of .05 to 2 % of the load: one cycle, that begins near the surface; its unloading is that without drift."""
    cycle = _cycle(300e-9, 1e-3, 4e4, noise=1e-4, seed=seed)
    depth, force = _in_air(seed)
    whole = Curve(np.append(depth, cycle.depth), np.append(force, cycle.force))
    ((begin, peak, _),) = load_cycles(whole)
    # 2 % of a load that grows like h^2 is reached in a seventh of the 300 readings of loading
    assert depth.size - 30 < begin < depth.size + 60
    assert depth.size + 280 < peak < depth.size + 355
    assert unloading(whole).stiffness == pytest.approx(unloading(cycle).stiffness, rel=1e-9)


def test_a_pop_in_and_a_withdrawal_are_no_cycles():
    """The force falls while the tip advances; and it waves by a tenth of the adhesion while the tip withdraws in air."""
    rise = np.linspace(0, 1, 400)
    force = np.concatenate([rise, np.linspace(0.97, 0.5, 5), np.linspace(0.5, 1.4, 400)])
    assert load_cycles(Curve(np.linspace(0, 1e-7, force.size), force)) == []
    back = np.concatenate([rise[::-1], np.linspace(0, -0.3, 60), np.linspace(-0.3, 0, 10)])
    air = 0.03 * np.sin(np.linspace(0, 20, 500))
    depth = np.concatenate([rise, np.linspace(1, -0.2, back.size), np.linspace(-0.2, -2, 500)])
    assert len(load_cycles(Curve(1e-7 * depth, np.concatenate([rise, back, air])))) == 1


@pytest.mark.long
@pytest.mark.parametrize("left", [0.0, 0.3, 0.6])
def test_many_plastic_cycles_are_sent_there_too(tmp_path, left):
    """Under the cone of the same area, whose forces are solved in a tenth of the time."""
    cone = FILM_CASE.replace('"berkovich"', '"cone"\ninclination = "19.7 deg"')
    (tmp_path / "cycles.csv").write_text(_text(_cycles(8, left)), encoding="utf-8")
    (tmp_path / "case.toml").write_text(cone, encoding="utf-8")
    done = run("fit", tmp_path / "cycles.csv", tmp_path / "case.toml", exits=2)
    assert "flatpunch fit-film" in done.output


def _book(path, sheets):
    from openpyxl import Workbook

    book = Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def _rows(curve, stiffness=None):
    more = [] if stiffness is None else [stiffness]
    titles = ["Depth (nm)", "Load (mN)", *(["Stiffness (N/m)"] if more else [])]
    none = 1.79e308
    values = [[none] * curve.depth.size] if more else []
    if more:
        values[0][int(np.argmax(curve.force))] = stiffness
    return [titles, *map(list, zip((curve.depth * 1e9).tolist(), (curve.force * 1e3).tolist(), *values, strict=True))]


CYCLES = [_cycle(depth, 2e-3 * (depth / 1e-7) ** 2, 8e4 * depth / 1e-7) for depth in np.linspace(80e-9, 400e-9, 17)]


@pytest.mark.long
@pytest.mark.parametrize("title", ["Results", "Tabelle"])
@pytest.mark.parametrize("stiff", [False, True])
def test_sheets_of_results_are_none_of_the_tests(tmp_path, title, stiff):
    """Seventeen tests, and as many rows of results that look like a curve; one stiffness a test beside the readings."""
    results = [["Test", "Depth (nm)", "Load (mN)", "Pmax (mN)"]]
    results += [[i + 1, float(c.depth.max() * 1e9), float(c.force.max() * 1e3), 1.0] for i, c in enumerate(CYCLES)]
    sheets = {title: results} | {f"Test {i:03d}": _rows(c, 8e4 if stiff else None) for i, c in enumerate(CYCLES)}
    found = film_curves(_book(tmp_path / "t.xlsx", sheets), {})
    assert len(found) == 1
    # depths to a micrometre in nanometres are floats
    np.testing.assert_allclose(found[0].stiffness, [unloading(c).stiffness for c in CYCLES], rtol=1e-6)
    assert found[0].meta["notes"] == ()


@pytest.mark.long
def test_one_bad_test_costs_one_test_and_is_named(tmp_path):
    short = [*_rows(CYCLES[0])[:8]]
    up = [_rows(CYCLES[1])[0], *_rows(CYCLES[1])[1:250]]
    sheets = {"Test 1": short, "Test 2": up} | {f"Test {i}": _rows(c) for i, c in enumerate(CYCLES[3:], 3)}
    (points,) = film_curves(_book(tmp_path / "t.xlsx", sheets), {})
    assert points.depth.size == len(CYCLES) - 3
    assert len(points.meta["notes"]) == 2
    for name in ("Test 1", "Test 2"):
        assert any(name in note and note.startswith("Left out") for note in points.meta["notes"])


@pytest.mark.long
def test_a_folder_of_tests_is_one_sample(tmp_path):
    folder = tmp_path / "tests"
    folder.mkdir()
    for i, curve in enumerate(CYCLES):
        rows = "\n".join(f"{h * 1e9:.8g}\t{p * 1e3:.8g}" for h, p in zip(curve.depth, curve.force, strict=True))
        (folder / f"{i:03d}.txt").write_text("Depth (nm)\tLoad (mN)\n" + rows)
    (folder / "LICENSE").write_text("words")
    (tmp_path / "case.toml").write_text(FILM_CASE)
    ran = run("fit-film", folder, tmp_path / "case.toml", exits=0)
    assert f"tests: {len(CYCLES)} points" in ran.output


@pytest.mark.parametrize(("exponent", "words"), [(1.4, None), (2.0, None), (3.0, "is 3.0"), (6.0, "on the limit")])
def test_odd_exponents_are_noted(exponent, words):
    notes = unloading(_cycle(400e-9, 5e-3, 1e5, exponent, noise=1e-4)).notes
    assert bool(notes) == (words is not None)
    if words:
        assert words in notes[0]
        points = unloadings(_cycle(h, 5e-3 * h / 4e-7, 1e5, exponent, noise=1e-4) for h in np.linspace(2e-7, 4e-7, 6))
        assert "So are 5 more of 6 unloadings" in points.meta["notes"][0]


@pytest.mark.parametrize("bad", ["loading", "held", "empty", "words", "short"])
def test_a_bad_test_of_a_folder_costs_one_test_and_is_named(tmp_path, bad):
    """Whole tests with drift in air, each in its file, and one that cannot be evaluated: the others count, it is named."""
    texts = {}
    for i, cycle in enumerate(CYCLES[:6]):
        depth, force = _in_air(i)
        whole = Curve(np.append(depth, cycle.depth), np.append(force, cycle.force))
        texts[f"test_{i}.csv"] = _text([np.column_stack([whole.depth, whole.force])])
    rows = np.column_stack([CYCLES[7].depth, CYCLES[7].force])
    # taken back to 96 % of the load in its noise, and what is no test at all
    held = np.concatenate([rows[:350], rows[350:358]])
    texts["test_bad.csv"] = {
        "loading": _text([rows[:300]]),
        "held": _text([held]),
        "empty": "",
        "words": "no numbers\n",
        "short": _text([rows[:5]]),
    }[bad]
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (points,) = film_curves(tmp_path, {})
    assert points.depth.size == 6
    assert [note for note in points.meta["notes"] if "test_bad" in note and note.startswith("Left out")]
    with pytest.raises(CurveError) as error:
        unloadings([Curve(*rows.T, name="one.csv")])
    assert "1 unloading found" in str(error.value)
    assert "0 <" not in str(error.value)


def test_a_load_that_is_hardly_taken_back_is_named():
    """The end of the fitted part would be above its beginning: the test is named, and no argument of the function."""
    up = np.linspace(0, 1, 300)
    force = np.concatenate([up, np.linspace(1, 0.85, 60)])
    depth = np.concatenate([up, np.linspace(1, 0.95, 60)])
    with pytest.raises(CurveError, match=r"odd: the force falls to 8.% of its largest value only"):
        unloadings([Curve(1e-7 * depth, force, name="odd")] * 2, upper=0.85)
