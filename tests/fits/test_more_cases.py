"""Two bodies, force maps, `check` on fit cases, and the examples of adhesion and relaxation."""

import contextlib
import csv
import importlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

import flatpunch as fp
from flatpunch.files import CaseError
from flatpunch.fits import Curve, fit, read_curve
from flatpunch.fits.batch import Batch, fit_batch
from flatpunch.fits.case import read_fit_case
from flatpunch.fits.distributions import map_figure
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase, TwoBodies
from support.commands import run
from support.platforms import SIGNALS
from support.synthetic_curves import synthetic

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "fit"
PAIR = """
[upper]
layers = [{ young = { fit = "2 MPa", min = "0.1 MPa", max = "100 MPa" }, poisson = 0.45, thickness = "1 um" }]
base = { kind = "half-space", young = "50 MPa", poisson = 0.3 }
[lower]
base = { kind = "half-space", young = "10 MPa", poisson = 0.3 }
[indenter]
kind = "paraboloid"
radius = "3 um"
"""


@pytest.mark.long
def test_two_bodies(tmp_path):
    path = tmp_path / "pair.toml"
    path.write_text(PAIR, encoding="utf-8")
    case = read_fit_case(path)
    name = "upper.layers[0].young"
    assert list(case.free) == [name]
    truth = TwoBodies(Medium([Layer(5e6, 0.45, 1e-6)], HalfSpace(50e6, 0.3)), HalfSpace(10e6, 0.3))
    curve = synthetic(truth, Paraboloid(3e-6), 2e-7, noise=0.003)
    result = fit(curve, case.medium, case.indenter, case.free)
    assert abs(result[name] - 5e6) < 4 * result.estimates[name].stderr
    assert result.model_error() < 1e-6
    # the other one, a half-space by itself
    other = fit(curve, truth, Paraboloid(3e-6), {"lower.base.young": 3e6})
    assert abs(other["lower.base.young"] - 10e6) < 4 * other.estimates["lower.base.young"].stderr


@pytest.mark.parametrize("name", ["thin_gel", "sticky_gel", "relaxing_cell"])
def test_check_knows_fit_cases(name):
    done = run("check", EXAMPLES / f"{name}.toml", exits=0)
    assert "Fitted    layers[0].young, from" in done.output


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('min = "10 ms"', 'min = "10 s"', "relaxation.time: the start 2 s must lie between minimum 10 s"),
        ("equilibrium = { fit = 0.5 }", "equilibrium = { fit = 1.5 }", "equilibrium = 1.5 must be below 1"),
        ('"4 um"', '{ fit = "4 um", max = "1 um" }', r"thickness: the start 4 µm must lie between minimum none"),
        ('kind = "rigid"', 'kind = "half-space"\nyoung = "1 MPa"\npoisson = 0.3', "relaxation goes with"),
        ('radius = "2.5 um"', 'radius = "2.5 um"\nyoung = { fit = "1 GPa" }', "young is no known field"),
        ("[indenter]", '[fit]\nsegment = "retract"\n[indenter]', "segment = 'retract' does not go with this case"),
    ],
)
def test_check_finds_mistakes_without_a_curve(tmp_path, old, new, message):
    text = (EXAMPLES / "relaxing_cell.toml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "case.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(CaseError, match=message):
        read_fit_case(path)
    assert run("check", path).exit_code == 2


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "truth"),
    [
        ("sticky_gel", {"layers[0].young": 4e3, "work_of_adhesion": 2e-4}),
        ("relaxing_cell", {"layers[0].young": 2e3, "relaxation.equilibrium": 0.35, "relaxation.time": 0.8}),
    ],
)
def test_examples_give_their_known_answers(name, truth):
    """The curves were made with these values and noise; within four standard errors."""
    case = read_fit_case(EXAMPLES / f"{name}.toml")
    curve = read_curve(EXAMPLES / f"{name}.csv", **case.reading)
    result = fit(curve, case.medium, case.indenter, case.free, **{**case.arguments, "quick": True})
    for parameter, value in truth.items():
        assert abs(result[parameter] - value) < 4 * result.estimates[parameter].stderr, parameter


def test_times_come_with_the_file(tmp_path):
    case = read_fit_case(EXAMPLES / "relaxing_cell.toml")
    curve = read_curve(EXAMPLES / "relaxing_cell.csv", **case.reading)
    assert curve.time is not None
    assert curve.time[-1] == 6
    bare = tmp_path / "bare.csv"
    text = (EXAMPLES / "relaxing_cell.csv").read_text(encoding="utf-8")
    bare.write_text(text.replace("time (s)", "time"), encoding="utf-8")
    done = run("fit", bare, EXAMPLES / "relaxing_cell.toml", exits=2)
    assert "column 'time' (time) has no unit" in done.output


@pytest.mark.long
def test_force_map(tmp_path):
    """A file of many curves: all are read, each with its place; a bad one costs nothing else."""
    h5py = pytest.importorskip("h5py")
    pytest.importorskip("afmformats")
    from afmformats.mod_force_distance import AFMForceDistance

    gel = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase())
    path, spring = tmp_path / "map.h5", 0.05
    with h5py.File(path, "w") as file:
        for i in range(6):
            curve = synthetic(gel, Paraboloid(3e-6), 4e-7, seed=i, points=300, noise=0.005)
            force = np.full(300, 1e-9) if i == 4 else curve.force
            columns = {
                "force": force,
                "height (measured)": -(curve.depth + force / spring),
                "segment": np.zeros(300, dtype=np.uint8),
            }
            known = {
                "imaging mode": "force-distance",
                "spring constant": spring,
                "position x": 1e-6 * (i % 3),
                "position y": 1e-6 * (i // 3),
                "enum": i,
                "point count": 300,
                "path": path,
            }
            AFMForceDistance(columns, known).export_data(file, fmt="hdf5")
    case = tmp_path / "case.toml"
    case.write_text(
        '[[layers]]\nyoung = { fit = "3 kPa" }\npoisson = 0.5\nthickness = "1 um"\n[base]\nkind = "rigid"\n'
        '[indenter]\nkind = "paraboloid"\nradius = "3 um"\n',
        encoding="utf-8",
    )
    done = run("fit", path, case, "-o", tmp_path / "map.csv", "--plot", tmp_path / "map.png", exits=0)
    assert "5 of 6 curves fitted" in done.output
    lines = (tmp_path / "map.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("curve,file,index,ok,reason,layers[0].young [Pa]")
    assert [line.split(",")[2] for line in lines[1:]] == list("012345")
    assert "position x [m]" in lines[0]
    assert (tmp_path / "map.png").stat().st_size > 10_000
    # one of its curves by itself
    one = read_curve(path, index=5)
    assert one.spring_constant == spring
    batch = fit_batch([path], gel, Paraboloid(3e-6), ["layers[0].young"], workers=1)
    assert [row["index"] for row in batch.rows] == list(range(6))
    assert len(map_figure(batch, "layers[0].young").axes) == 3  # map, its bar, histogram


@pytest.mark.long
def test_interrupt_keeps_what_was_done(tmp_path, monkeypatch):
    """Ctrl-C in a folder: the curves fitted so far are in the table, whole."""
    batch = importlib.import_module("flatpunch.fits.batch")
    for i in range(40):
        (tmp_path / f"c{i:02}.csv").write_text(
            (EXAMPLES / "thin_gel.csv").read_text(encoding="utf-8"), encoding="utf-8"
        )
    real = batch.fit_rows

    def interrupted(*arguments, **named):
        yield next(iter(real(*arguments, **named)))
        raise KeyboardInterrupt

    monkeypatch.setattr(batch, "fit_rows", interrupted)
    out = tmp_path.parent / f"{tmp_path.name}.csv"
    done = run("fit", tmp_path, EXAMPLES / "thin_gel.toml", "-o", out, exits=130)
    assert "Interrupted after 16 of 40 curves" in done.output
    assert len(out.read_text(encoding="utf-8").splitlines()) == 17
    # the same command goes on; a curve that has changed meanwhile is fitted again
    monkeypatch.setattr(batch, "fit_rows", real)
    changed = (EXAMPLES / "thin_gel.csv").read_text(encoding="utf-8").splitlines()
    (tmp_path / "c03.csv").write_text("\n".join(changed[:-20]), encoding="utf-8")
    done = run("fit", tmp_path, EXAMPLES / "thin_gel.toml", "-o", out, exits=0)
    assert "15 of 40 curves were fitted by an earlier run" in done.output
    table = out.read_text(encoding="utf-8")
    rows = list(csv.DictReader(table.splitlines()))
    assert int(rows[3]["points"]) < int(rows[2]["points"]) == int(rows[39]["points"])
    assert not out.with_suffix(".records").exists()
    # an uninterrupted run writes the same, to the last digit
    assert run("fit", tmp_path, EXAMPLES / "thin_gel.toml", "-o", out).exit_code == 0
    assert out.read_text(encoding="utf-8") == table


@pytest.mark.long
def test_records_of_a_batch_are_kept_as_it_goes(tmp_path, monkeypatch):
    """What is in the folder is not fitted again, whatever is added; other cases, and damaged records, are."""
    batch = importlib.import_module("flatpunch.fits.batch")
    gel, start = (Medium([Layer(young, 0.5, 1e-6)], RigidBase()) for young in (5e3, 3e3))
    curves = [synthetic(gel, Paraboloid(3e-6), 4e-7, seed=i, points=300) for i in range(20)]
    curves[7] = Curve(curves[7].depth, np.full(300, 1e-9), name="flat")
    fitted = []
    real = batch._Job.one

    def counted(job, item):
        fitted.append(item[0])
        return real(job, item)

    monkeypatch.setattr(batch._Job, "one", counted)

    def run(some, tip=3e-6, free=("layers[0].young",)):
        fitted.clear()
        return fit_batch(some, start, Paraboloid(tip), list(free), workers=1, store=tmp_path)

    first = run(curves[:18])
    assert len(fitted) == 18
    # what could not be evaluated is tried again
    again = run(curves)
    assert [c.name for c in fitted] == ["flat", "synthetic-18", "synthetic-19"]
    np.testing.assert_array_equal(again.column("layers[0].young")[:18], first.column("layers[0].young"))
    assert [row["curve"] for row in again.rows] == [c.name for c in curves]
    run(curves, tip=2e-6)
    assert len(fitted) == 20
    files = sorted(tmp_path.glob("*.json"), key=lambda file: file.stat().st_size)
    files[-1].write_bytes(files[-1].read_bytes().replace(b"synthetic", b"synthetiq"))
    with pytest.warns(fp.FlatpunchWarning, match="Its curves are fitted again"):
        run(curves)
    assert 1 < len(fitted) < 20
    with pytest.raises(ValueError, match="store"):
        fit_batch(curves, start, Paraboloid(3e-6), ["layers[0].young"], store=files[0])


def test_slow_fits_are_kept_one_by_one(tmp_path, monkeypatch):
    """Whatever ends a run, by the power supply too, costs no more than the fit that goes on."""
    batch = importlib.import_module("flatpunch.fits.batch")
    monkeypatch.setattr(batch, "_PAUSE", 0.0)
    gel, seen, files = HalfSpace(5e3, 0.5), [], []
    curves = [synthetic(gel, Paraboloid(3e-6), 4e-7, seed=i, points=300) for i in range(3)]

    def progress(done):
        seen.append(done)
        files.append(len(list(tmp_path.glob("*.json"))))

    fit_batch(curves, gel, Paraboloid(3e-6), ["base.young"], workers=1, store=tmp_path, progress=progress)
    assert seen == files == [1, 2, 3]


def test_a_histogram_counts_with_errors():
    """The interval of the median holds the median of the distribution in 95 % or a little more of samples."""
    rng, held = np.random.default_rng(1), 0
    for _ in range(300):
        rows = [{"curve": "", "ok": i > 2, "reason": "", "E": v} for i, v in enumerate(rng.lognormal(0, 1, 30))]
        median = Batch(tuple(rows)).median("E")
        held += median.low <= 1 <= median.high
    # 27 values: the exact coverage of these ranks is 0.981
    assert 0.95 < held / 300 <= 1
    rows = [{"curve": str(i), "ok": i != 4, "reason": "", "base.young": float(i % 3)} for i in range(40)]
    columns = {"base.young low": 0.0, "base.young high": 1.0}
    axes = map_figure(Batch(tuple({**r, **columns} for r in rows)), "base.young").axes
    assert "39 curves, 1 left out" in axes[1].get_title()
    assert len(axes[1].containers) == 2  # bars and their errors
    few = Batch(tuple({"curve": "", "ok": True, "reason": "", "E": float(i)} for i in range(5)))
    assert few.median("E").high == np.inf


def _workers(pid):
    """Worker processes of a process."""
    return [child for child in psutil.Process(pid).children() if "popen_loky" in " ".join(_command(child))]


def _command(process):
    with contextlib.suppress(psutil.Error):
        return process.cmdline()
    return []


@pytest.mark.long
@SIGNALS
@pytest.mark.parametrize("late", [False, True], ids=["as workers start", "as they work"])
def test_an_interrupt_of_a_parallel_batch_is_told_once(late, tmp_path):
    """As a terminal does it: to all processes at once."""
    folder, out = tmp_path / "curves", tmp_path / "table.csv"
    folder.mkdir()
    for i in range(400):
        (folder / f"c{i:03}.csv").symlink_to(EXAMPLES / "thin_gel.csv")
    command = ["fit", str(folder), str(EXAMPLES / "thin_gel.toml"), "-o", str(out), "--workers", "2"]
    with subprocess.Popen(
        [sys.executable, "-m", "flatpunch", *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as run:
        end = time.monotonic() + 60
        while not _workers(run.pid):
            assert time.monotonic() < end, "no workers"
            assert run.poll() is None, run.stdout.read()
            time.sleep(0.02)
        end = time.monotonic() + 120
        while late and not list(out.parent.glob("table.records/*.json")):
            assert time.monotonic() < end, "no records"
            time.sleep(0.02)
        os.killpg(run.pid, signal.SIGINT)
        told = run.stdout.read()
    assert run.returncode == 130, told
    assert told.count("Interrupted after" if late else "Interrupted") == 1
    assert "Traceback" not in told
    assert "KeyboardInterrupt" not in told
    if late:
        assert 16 < len(out.read_text(encoding="utf-8").splitlines()) < 400


@pytest.mark.long
def test_a_folder_whose_workers_are_killed_is_fitted(tmp_path):
    """Others go on, nothing is lost, and the table is that of a run in one process."""
    folder, out = tmp_path / "curves", tmp_path / "table.csv"
    folder.mkdir()
    for i in range(60):
        (folder / f"c{i:03}.csv").symlink_to(EXAMPLES / "thin_gel.csv")
    command = ["fit", str(folder), str(EXAMPLES / "thin_gel.toml"), "-o", str(out), "--workers", "2"]
    killed = set()
    with subprocess.Popen(
        [sys.executable, "-m", "flatpunch", *command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as run:
        while len(killed) < 2 and run.poll() is None:
            for worker in _workers(run.pid):
                # once as it starts, and once as it works
                time.sleep(3.0 * len(killed))
                if worker.pid not in killed and worker.is_running():
                    killed.add(worker.pid)
                    worker.kill()
            time.sleep(0.02)
        said = run.stdout.read()
    assert run.returncode == 0, said
    assert killed
    rows = list(csv.DictReader(out.read_text(encoding="utf-8").splitlines()))
    assert [row["curve"] for row in rows] == [f"c{i:03}.csv" for i in range(60)]
    assert {row["ok"] for row in rows} == {"True"}, said


@pytest.mark.long
def test_batch_of_relaxing_curves():
    """Batches know the same physics; curves without times become records."""
    case = read_fit_case(EXAMPLES / "relaxing_cell.toml")
    curve = read_curve(EXAMPLES / "relaxing_cell.csv")
    part = curve.taken(slice(None, None, 5))
    bare = Curve(part.depth, part.force, name="bare")
    batch = fit_batch(
        [part, bare], case.medium, case.indenter, case.free, relaxation=case.physics.relaxation, workers=1
    )
    assert [row["ok"] for row in batch.rows] == [True, False]
    assert "no times" in batch.failed[0]["reason"]
    assert batch.rows[0]["relaxation.time"] == pytest.approx(0.8, rel=0.05)


@pytest.mark.parametrize("quick", [False, True])
def test_a_curve_deeper_than_its_layer_is_told(quick):
    """400 nm into a layer of 100 nm on glass: no modulus makes that true."""
    tip = fp.Paraboloid(5e-6)
    depth = np.linspace(-1e-7, 4e-7, 300)
    force = fp.indent(fp.HalfSpace(5e3, 0.45), tip, depth=np.maximum(depth, 0))["force"].values
    layer = fp.Medium([fp.Layer(5e3, 0.45, 1e-7)], fp.RigidBase())
    noise = 1e-12 * np.random.default_rng(1).standard_normal(depth.size)
    found = fp.fit(fp.Curve(depth, force + noise), layer, tip, ["layers[0].young"], contact=0.0, quick=quick)
    assert "no tip gets there" in " ".join(found.notes)
