"""The command line as a user meets it: results, readable refusals, exit statuses, nothing half-written."""

import re
import signal
import subprocess
import sys
import time

import matplotlib.image
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.cli import terminal
from flatpunch.cli.app import app
from flatpunch.files import load, shipped_cases
from support.platforms import SIGNALS

CASE = """
title = "Gel"
angles = 24
layers = [{ young = "5 kPa", poisson = 0.5, thickness = "1.2 um" }]
base = { kind = "rigid" }
indenter = { kind = "pyramid", sides = 4, half_opening_angle = "35 deg" }
control = { depth = { start = "10 nm", stop = "400 nm", points = 12 } }
"""


def run(*arguments):
    # The width fixes the line breaks of tables and help.
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "120", "NO_COLOR": "1"})


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "gel.toml"
    path.write_text(CASE, encoding="utf-8")
    return path


@pytest.mark.long
def test_solve_writes_what_it_prints(case, tmp_path):
    nc, csv, png = tmp_path / "gel.nc", tmp_path / "out.csv", tmp_path / "gel.png"
    done = run("solve", case, "-o", nc, "--csv", csv, "--plot", png)
    assert done.exit_code == 0, done.output
    xr.testing.assert_identical(load(nc).drop_dims("phi"), load(csv))
    direct = fp.indent(
        fp.Medium([fp.Layer(5e3, 0.5, 1.2e-6)], base=fp.RigidBase()),
        fp.Pyramid(sides=4, inclination=np.radians(55)),
        depth=np.linspace(1e-8, 4e-7, 12),
        angles=24,
    )
    # the same calculation up to the last digit of the angle
    np.testing.assert_allclose(load(nc)["force"], direct["force"], rtol=1e-13)
    assert f"{float(direct['force'][-1]) * 1e12:.4g}" in done.output  # the column is in pN
    assert "10 of 12 steps, method refined" in done.output
    height, width, _ = matplotlib.image.imread(png).shape
    assert width > height > 500
    assert sorted(path.name for path in tmp_path.iterdir()) == ["gel.nc", "gel.png", "gel.toml", "out.csv"]


def test_the_error_of_the_force_is_a_column(case):
    done = run("solve", case)
    assert "force error" in done.output
    # of the corrections that come with the package
    assert "0.05" in done.output


def test_round_contacts_are_exact_and_have_no_such_column(case):
    tip = case.read_text(encoding="utf-8").replace('kind = "pyramid"', 'kind = "cone"').replace("sides = 4, ", "")
    case.write_text(tip, encoding="utf-8")
    for command in ("solve", "check"):
        done = run(command, case)
        assert "exact (round tip)" in done.output
        assert "first-order" not in done.output
        assert "force error" not in done.output


def test_large_errors_have_a_note(case):
    case.write_text('method = "first-order"\n' + case.read_text(encoding="utf-8"), encoding="utf-8")
    done = run("solve", case)
    assert re.search(
        r"Note: At depths of [\d.]+ nm and\s+more: the force is expected to be off by up to [\d.]+ %", done.output
    )
    assert re.search(r"outline is expected to be off by up to \d+ % of the mean radius", " ".join(done.output.split()))


def test_solve_alone_prints_only(case, tmp_path):
    done = run("solve", case)
    assert done.exit_code == 0
    assert "stiffness" in done.output
    assert "Written" not in done.output
    assert [path.name for path in tmp_path.iterdir()] == ["gel.toml"]


def test_notes_of_a_result_are_printed(case):
    """A film 30 times stiffer than its base: the first-order outline does not exist there, and the user is told."""
    stiff = CASE.replace('"5 kPa"', '"3 GPa"').replace(
        'kind = "rigid"', 'kind = "half-space", young = "0.1 GPa", poisson = 0.3'
    )
    stiff = 'method = "first-order"\n' + stiff
    case.write_text(stiff.replace('"400 nm"', '"4 um"'), encoding="utf-8")
    done = run("solve", case)
    assert done.exit_code == 0, done.output
    assert "Note: " in done.output
    assert re.search(r"theory", done.output)


def test_outlines_in_a_table_on_request(case, tmp_path):
    assert run("solve", case, "--csv", tmp_path / "out.csv", "--outlines").exit_code == 0
    assert load(tmp_path / "out.csv").sizes["phi"] == 24


@pytest.mark.parametrize(
    ("tip", "method", "expected"),
    [
        ('kind = "cone"', "exact (round tip)", "force and outline exact up to rounding"),
        ('kind = "pyramid", sides = 4', "refined (its corrections for this tip on one layer", "force to about 0.05 %"),
    ],
)
def test_check_says_method_error_time_and_memory(case, tip, method, expected):
    case.write_text(CASE.replace('kind = "pyramid", sides = 4', tip), encoding="utf-8")
    lines = {line.split()[0]: line for line in run("check", case).output.splitlines() if line.strip()}
    assert method in lines["Method"]
    assert expected in lines["Expected"]
    assert re.search(r"at most \d+ MB of memory, about a second", lines["Takes"])


def test_expected_error_of_a_series_is_that_of_the_result(case):
    case.write_text('method = "second-order"\n' + CASE, encoding="utf-8")
    checked = run("check", case).output
    (force, outline) = re.search(r"Expected +force to ([\d.]+) %, outline to ([\d.]+) %", checked).groups()
    result = fp.indent(
        fp.Medium([fp.Layer(5e3, 0.5, 1.2e-6)], base=fp.RigidBase()),
        fp.Pyramid(sides=4, inclination=np.radians(55)),
        depth=4e-7,
        method="second-order",
    )
    # two digits are printed
    np.testing.assert_allclose(float(force), 100 * result["force_error"], rtol=0.05)
    np.testing.assert_allclose(float(outline), 100 * result["contour_error"], rtol=0.05)


@pytest.mark.parametrize(("name", "command"), [("thin_gel", "fit"), ("hard_film", "fit-film")])
def test_solving_a_case_of_a_fit_names_the_command(name, command):
    path = shipped_cases()[0].parent / "fit" / f"{name}.toml"
    done = run("solve", path)
    assert done.exit_code == 2
    assert f"fit it to a measured curve with `flatpunch {command} CURVE {path}`" in " ".join(done.output.split())


def test_check_says_what_would_be_solved(case, tmp_path):
    done = run("check", case)
    assert done.exit_code == 0
    assert "Layer young 5 kPa, poisson 0.5, thickness 1.2 µm, bonded to the base" in done.output
    assert "depth, 12 steps from 10 nm to 400 nm" in done.output
    assert [path.name for path in tmp_path.iterdir()] == ["gel.toml"]


@pytest.mark.long
def test_demo_solves_every_shipped_case(tmp_path):
    done = run("demo", "-o", tmp_path / "results")
    assert done.exit_code == 0, done.output
    for source in shipped_cases():
        target = tmp_path / "results" / source.name
        assert target.read_text() == source.read_text()
        assert load(target.with_suffix(".nc"))["valid"].all()
        assert target.with_suffix(".png").stat().st_size > 10_000


@pytest.mark.long
def test_demo_keeps_what_the_user_changed(tmp_path, monkeypatch):
    monkeypatch.setattr("flatpunch.files.shipped_cases", lambda: shipped_cases()[:1])
    mine = tmp_path / shipped_cases()[0].name
    mine.write_text(CASE, encoding="utf-8")
    done = run("demo", "-o", tmp_path)
    assert done.exit_code == 0
    assert "is kept and solved as it is" in done.output
    assert mine.read_text(encoding="utf-8") == CASE
    assert load(mine.with_suffix(".nc")).sizes["step"] == 12


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (
            ('"1.2 um"', '"5 kPa"'),
            [],
            "layers[0].thickness = '5 kPa' has the dimension of a pressure; a length such as '1.2 um'",
        ),
        (("poisson", "poison"), [], "layers[0].poison is no known field; did you mean 'poisson'?"),
        (("[{ young", "[{ young"), ["-o", "gel.txt"], "--output gel.txt: the ending must be .nc or .csv"),
        (("[{ young", "[{ young"), ["-o", "none/gel.nc"], "--output none/gel.nc: the folder none does not exist"),
        (("[{ young", "[{ young"), ["--csv", "gel.nc"], "--csv gel.nc: the ending must be .csv"),
        (("[{ young", "[{ young"), ["--plot", "gel.jpeg"], "--plot gel.jpeg: the ending must be .png or .pdf or .svg"),
    ],
)
def test_bad_input_ends_with_status_2(case, monkeypatch, change, options, message):
    """Refused before any work: `indent` must not even be called."""
    monkeypatch.setattr(fp, "indent", lambda *_, **__: pytest.fail("solved before the input was checked"))
    case.write_text(CASE.replace(*change), encoding="utf-8")
    done = run("solve", case, *options)
    assert done.exit_code == 2
    assert message in done.stderr
    assert "Traceback" not in done.output
    assert done.stderr.startswith("Error: ")


def test_bad_command_lines_end_with_status_2(tmp_path):
    for arguments in (
        ["solve"],
        ["solve", tmp_path / "none.toml"],
        ["solve", tmp_path],
        ["press"],
        ["solve", "a", "--colour"],
    ):
        done = run(*arguments)
        assert done.exit_code == 2, arguments
        assert "Traceback" not in done.output


def test_unreachable_target_is_readable(case):
    """A sphere cannot be pressed in deeper than its own radius allows: the refusal comes from the contact theory."""
    sphere = CASE.replace(
        'kind = "pyramid", sides = 4, half_opening_angle = "35 deg"', 'kind = "sphere", radius = "1 um"'
    )
    case.write_text(sphere.replace('"400 nm"', '"40 mm"'), encoding="utf-8")
    done = run("solve", case)
    assert done.exit_code == 2
    assert "Error: " in done.stderr
    assert "Traceback" not in done.output


@pytest.mark.parametrize("where", ["flatpunch.indent", "flatpunch.files.save", "flatpunch.plots.result.figure"])
def test_interrupts_end_with_status_130(case, tmp_path, monkeypatch, where):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    (tmp_path / "gel.nc").write_bytes(b"older")
    monkeypatch.setattr(where, interrupt)
    done = run("solve", case, "-o", tmp_path / "gel.nc", "--plot", tmp_path / "gel.png")
    assert done.exit_code == 130
    assert done.stderr.strip() == "Interrupted. No file was left half-written."
    assert sorted(path.name for path in tmp_path.iterdir()) == ["gel.nc", "gel.toml"]
    assert ((tmp_path / "gel.nc").read_bytes() == b"older") == (where != "flatpunch.plots.result.figure")


@pytest.mark.long
@SIGNALS
def test_a_real_interrupt(case, tmp_path):
    """The signal itself, in a process of its own, while the solver is at work."""
    script = (
        "import sys, time, flatpunch as fp\n"
        "from flatpunch import cli\n"
        "fp.indent = lambda *a, **k: (print('solving', flush=True), time.sleep(60))\n"
        f"sys.argv = ['flatpunch', 'solve', {str(case)!r}, '-o', {str(tmp_path / 'gel.nc')!r}]\n"
        "cli.main()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "solving\n"
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert errors.strip() == "Interrupted. No file was left half-written."
    assert [path.name for path in tmp_path.iterdir()] == ["gel.toml"]


@pytest.mark.long
def test_interrupt_while_importing(tmp_path, case):
    """The imports take most of the first second, so that is when an early Ctrl-C arrives."""
    script = (
        "import sys\n"
        "class Interrupts:\n"
        "    def find_spec(self, name, *_):\n"
        "        if name == 'xarray': raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupts())\n"
        f"sys.argv = ['flatpunch', 'check', {str(case)!r}]\n"
        "from _flatpunch_command import main\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 130
    assert done.stderr.strip() == "Interrupted. No file was left half-written."


def test_the_command_runs_as_a_module():
    """`python -m flatpunch`, where the script is not on the path."""
    done = subprocess.run(
        [sys.executable, "-m", "flatpunch", "--version"], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.strip() == f"flatpunch {fp.__version__}"


def test_mistakes_of_the_package_show_their_traceback_on_request(case, monkeypatch):
    monkeypatch.setenv("FLATPUNCH_TRACEBACK", "1")

    def broken(*_, **__):
        raise AssertionError("a bug")

    monkeypatch.setattr(fp, "indent", broken)
    done = run("solve", case)
    assert isinstance(done.exception, AssertionError)


def test_help_teaches():
    assert "flatpunch demo" in run("--help").output
    assert "CASE.toml" in run("check", "--help").output
    assert run("--version").output.strip() == f"flatpunch {fp.__version__}"
    # without arguments the help is shown; older typer ends that with status 0, newer with 2
    assert "Usage" in run().output


def test_long_work_tells_a_log_what_it_does(monkeypatch, capsys):
    monkeypatch.setattr(terminal, "_SILENCE", 0.02)
    with terminal.progress("Film", 2) as step:
        step("step 3 of 40")
        time.sleep(0.2)
    assert "Film: step 3 of 40, 0 s so far" in capsys.readouterr().err.splitlines()
