"""The command line in hostile surroundings: one readable message and status 2, no traceback, nothing half-written."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from flatpunch._support.messages import message, toml
from flatpunch._support.whole_file import REMEDY
from support import case_mutations
from support.commands import run
from support.platforms import PROC, SIGNALS

CASE = """
title = "gel µ"
[[layers]]
young = "5 kPa"
poisson = 0.45
thickness = "1 um"
[base]
kind = "rigid"
[indenter]
kind = "sphere"
radius = "5 um"
[control]
depth = ["10 nm", "20 nm"]
"""


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE, encoding="utf-8")
    return path


def refused(done, *words):
    assert done.exit_code == 2, done.output
    assert "Traceback" not in done.output
    assert "mistake of flatpunch" not in done.output
    # words may be wrapped on a terminal
    for word in words:
        assert word in " ".join(done.output.split()), done.output


def test_outputs_are_checked_before_the_work(case, tmp_path, monkeypatch):
    def solved(*_, **__):
        raise AssertionError("solved before the output was checked")

    monkeypatch.setattr("flatpunch.cli.app._solve", solved)
    (tmp_path / "folder.nc").mkdir()
    (tmp_path / "loop.nc").symlink_to(tmp_path / "loop.nc")
    refused(run("solve", case, "-o", tmp_path / "folder.nc"), "is a folder")
    refused(run("solve", case, "-o", tmp_path / "none" / "x.nc"), "does not exist")
    refused(run("solve", case, "-o", tmp_path / "x.txt"), "the ending must be")
    refused(run("solve", case, "--plot", tmp_path / ("x" * 300 + ".png")), "cannot be written")
    refused(run("demo", "-o", case), "case.toml")


@PROC
def test_outputs_where_nobody_can_write(case):
    refused(run("solve", case, "-o", "/proc/x.nc"), "cannot be written")
    refused(run("demo", "-o", "/proc/demo"), "/proc/demo", REMEDY)
    refused(run("atlas", "export", "bonded-layer", "--csv", "/proc/x.csv"), "/proc/x.csv", REMEDY)


def test_a_full_disk_is_one_message(case, tmp_path, monkeypatch):
    def full(self, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    for output in ("x.nc", "x.csv"):
        refused(run("solve", case, "-o", tmp_path / output), output, "No space left on device", REMEDY)
    refused(run("demo", "-o", tmp_path / "demo"), "No space left on device", REMEDY)
    refused(run("atlas", "export", "bonded-layer", "--csv", tmp_path / "x.csv"), "No space left on device", REMEDY)
    assert not [path for path in tmp_path.rglob("*") if "unfinished" in path.name or path.suffix in (".nc", ".csv")]


def test_no_memory_is_told_like_every_other_error(case, monkeypatch):
    def greedy(*_, **__):
        raise MemoryError

    monkeypatch.setattr("flatpunch.cli.app._solve", greedy)
    refused(run("solve", case), "not enough memory")


@pytest.mark.long
@pytest.mark.parametrize("name", [n for n in case_mutations.monsters() if n not in ("many keys", "many depths")])
def test_monsters(name, tmp_path):
    path = tmp_path / "monster.toml"
    path.write_bytes(case_mutations.monsters()[name])
    for command in (("check", path), ("solve", path), ("sweep", path, "--vary", "a=1,2"), ("fit", path, path)):
        done = run(*command)
        refused(done)
        assert len(done.output) < 8000


@pytest.mark.parametrize(
    "arguments",
    [
        ("sweep", "CASE", "--vary", "layers.0.thickness=1um:2um:99999999:log"),
        ("sweep", "CASE", "--vary", "layers.0.thickness=1um:2um:30000", "--vary", "layers.0.young=1kPa:2kPa:30000"),
        ("sweep", "CASE", "--vary", "layers.0.thickness=1um:2um:\u0663"),
        ("sweep", "CASE", "--vary", "layers.0.thickness=1e999999999um,2um"),
        ("sweep", "CASE", "--vary", "x" * 5000 + "=1"),
        ("sweep", "CASE", "--vary", "layers.0.young=" + "1kPa," * 5000 + "1kPa"),
        ("atlas", "export", "bonded-layer", "--csv", "x.csv", "--beta", "0.1:1:999999999"),
        ("atlas", "query", "bonded-layer", "--beta", "nan", "--set", "poisson=inf"),
        ("atlas", "show", "/dev/zero"),
        ("atlas", "show", "none.nc"),
        ("correct", "CASE", "--reported", "1e999999999 Pa", "--depth", "1 nm"),
        ("correct", "CASE", "--reported", "5 kPa", "--depth", "-1 nm"),
        ("fit", "/dev/zero", "CASE"),
        ("fit", "/proc", "CASE"),
    ],
    ids=lambda a: " ".join(a)[:60],
)
def test_arguments_of_all_sorts(arguments, case):
    done = run(*(case if a == "CASE" else a for a in arguments))
    refused(done)
    assert len(done.output) < 5000


def shell(command, case, **environment):
    """Run in a shell, so that streams can be closed."""
    flatpunch = f"{sys.executable} -m flatpunch"
    done = subprocess.run(
        ["bash", "-c", command.replace("flatpunch", flatpunch).replace("CASE", str(case))],
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        timeout=60,
        check=False,
    )
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    return done


@pytest.mark.long
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full, a disk that is always full")
def test_full_stream(case):
    full = shell("flatpunch check CASE > /dev/full", case)
    assert full.returncode == 2
    assert "No space left on device" in full.stderr


@pytest.mark.long
def test_closed_and_narrow_streams(case):
    closed = shell("flatpunch check CASE >&- 2>&-", case)
    assert (closed.returncode, closed.stderr) == (0, "")
    narrow = shell("flatpunch check CASE", case, PYTHONIOENCODING="ascii", LC_ALL="C")
    assert narrow.returncode == 0
    assert "gel u" in narrow.stdout
    assert "1 um" in narrow.stdout


@SIGNALS
def test_an_interruption_while_libraries_load(case):
    program = (
        "import os, signal, sys\n"
        "class Loading:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'flatpunch.cli.app':\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Loading())\n"
        "from flatpunch.cli import main\n"
        "main()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, "check", str(case)], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr) == (130, "\nInterrupted.\n")


@pytest.mark.parametrize(
    ("python", "written"),
    [
        ("read the file with skip_nan=True.", "read the file with skip_nan = true."),
        ("Give columns={'depth': 0}.", "Give columns = {'depth': 0}."),
        ("not with method='bem'.", "not with method = 'bem'."),
        ("x == 3 and a/l = 0.1", "x == 3 and a/l = 0.1"),
        ("vary['layers[0].young'] = 3", 'vary."layers[0].young" = 3'),
        ("the round limit is Cone(inclination).", "the round limit is kind = 'cone' with inclination."),
        ("between axis and face in radians. Degrees go through math.radians.", "between axis and face."),
    ],
)
def test_messages_speak_toml(python, written):
    assert toml(python) == written


def test_what_a_library_or_python_says_is_not_passed_on():
    import numpy as np
    from scipy.optimize import brentq

    from flatpunch.numerics import gauss

    for mistake in (
        lambda: brentq(lambda x: x**2 + 1, 0, 1),
        lambda: np.ones(3) + np.ones(4),
        lambda: gauss.gauss("three"),
        lambda: [*3],
    ):
        try:
            mistake()
        except Exception as error:
            told = message(error)
        assert "mistake of flatpunch" in told
        assert "different signs" not in told
        assert "not iterable" not in told


def test_tracebacks_on_request(case, monkeypatch):
    def broken(*_, **__):
        raise KeyError("a mistake")

    monkeypatch.setattr("flatpunch.cli.app._solve", broken)
    done = run("solve", case, exits=2)
    assert "KeyError" in done.output
    assert "mistake of flatpunch" in done.output
    monkeypatch.setenv("FLATPUNCH_TRACEBACK", "1")
    assert isinstance(run("solve", case).exception, KeyError)
    assert Path(case).exists()


@pytest.mark.parametrize("command", ["fit", "fit-film"])
def test_a_case_file_before_the_curve_is_in_the_wrong_place(case, tmp_path, command):
    refused(run(command, case, tmp_path), "this is the case file; give the curve before it")


def test_a_folder_for_a_case_file_is_called_a_folder(tmp_path):
    refused(run("solve", tmp_path), "it is a folder, not a file")


@pytest.mark.parametrize("command", ["solve", "stress", "slip", "compare", "design"])
@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("", "`flatpunch fit CURVE"),
        ("[film]\ndepth_min = '1 nm'", "`flatpunch fit-film CURVE"),
        ("[plan]\ndepth = '1 nm'\nnoise = '1 pN'", "`flatpunch fit CURVE"),
    ],
)
def test_case_files_of_fits_are_named_for_what_they_are(tmp_path, command, table, words):
    path = tmp_path / "case.toml"
    path.write_text(CASE.replace('"5 kPa"', "{ fit = '5 kPa' }") + table, encoding="utf-8")
    refused(run(command, path), "looks for values", words)
    refused(run("sweep", path, "--vary", "indenter.radius=1um,2um"), "looks for values", words)


def test_case_files_of_corrections_are_checked_and_named(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE.replace("[control]", "[correct]\nreported = '5 kPa'").replace('["10 nm", "20 nm"]', "'9 nm'"))
    refused(run("solve", path), "corrects a reported modulus", "`flatpunch correct")
    done = run("check", path, exits=0)
    assert "Reported  5 kPa at a depth of 9 nm" in done.output
    path.write_text(
        "method = 'bem'"
        + path.read_text()
        .replace('"sphere"', '"pyramid"\nsides = 4')
        .replace('radius = "5 um"', 'inclination = "20 deg"')
    )
    assert "about a minute" in run("check", path).output


def test_warnings_are_notes(case):
    """Neither the line of the source nor its path; those of libraries come with tracebacks only."""
    program = (
        "import warnings\nimport flatpunch.cli.app as app\nfrom flatpunch import FlatpunchWarning\n"
        "def warned(*_):\n    warnings.warn('points cannot be kept', FlatpunchWarning)\n"
        "    warnings.warn('deep', RuntimeWarning)\n"
        "app.app = warned\napp.main()\n"
    )
    for variable, shown in (("UNUSED", False), ("FLATPUNCH_TRACEBACK", True)):
        done = subprocess.run(
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
            env={**os.environ, variable: "1"},
        )
        assert done.stderr.startswith("Note: points cannot be kept\n")
        assert ("RuntimeWarning: deep" in done.stderr) is shown
