"""No output replaces an input or anything that is not meant; what was computed outlives a full disk."""

import inspect
import os
import shutil
import stat
import subprocess
import sys
import zipfile
from functools import partial
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
from typer.main import get_command

import flatpunch as fp
from flatpunch._support.whole_file import sealed, write_whole
from flatpunch.atlas.library import folder as shipped_tables
from flatpunch.cli.app import app
from flatpunch.cli.terminal import outputs_of
from flatpunch.fits.places import Records
from support import commands
from support.platforms import PIPES

BODY = """
title = "Gel"
layers = [{ young = "5 kPa", poisson = 0.5, thickness = "2 um" }]
base = { kind = "rigid" }
"""
PROFILE = 'indenter = { kind = "radial-profile", file = "tip.csv" }\n'
FITTED = BODY.replace('"5 kPa"', '{ fit = "5 kPa" }') + PROFILE
DEPTHS = '[control]\ndepth = ["100 nm", "200 nm"]\n'
FILES = {
    "solve.toml": BODY + PROFILE + DEPTHS,
    "ball.toml": BODY + 'indenter = { kind = "sphere", radius = "5 um" }\n' + DEPTHS,
    "map.toml": BODY + 'indenter = { kind = "height-map", file = "scan.npz" }\n' + DEPTHS,
    "slip.toml": BODY + PROFILE + DEPTHS + "[slip]\nfriction = 0.3\n",
    "rough.toml": BODY + '[surface]\nkind = "file"\nfile = "scan.npz"\n[control]\npressure = "10 Pa"\n',
    "design.toml": BODY
    + PROFILE
    + '[control]\ndepth = "100 nm"\n[design]\nquantity = "force"\nvalue = "1 nN"\ndepth = "100 nm"\n'
    + '[design.vary]\n"layers[0].young" = ["1 kPa", "9 kPa"]\n',
    "fit.toml": FITTED + '[correct]\nreported = "8 kPa"\ndepth = "300 nm"\n',
    "joint.toml": FITTED + '[[curves]]\nfile = "curve.csv"\n[[curves]]\nfile = "other.csv"\n',
    "film.toml": FITTED + "[film]\narea_coefficients = [24.5, 180.0]\n",
}
# how each command is called, and the files that it reads; "name.table" stands for a file of the table of the atlas
CALLS = {
    **{name: [(["solve.toml"], ["solve.toml", "tip.csv"])] for name in ("solve", "show-tip", "show-medium", "stress")},
    "sweep": [(["solve.toml", "--vary", "layers.0.young=1kPa,2kPa"], ["solve.toml", "tip.csv"])],
    "slip": [(["slip.toml"], ["slip.toml", "tip.csv"])],
    "rough": [(["rough.toml"], ["rough.toml", "scan.npz"])],
    "design": [(["design.toml"], ["design.toml", "tip.csv"])],
    "compare": [(["ball.toml"], ["ball.toml"])],
    "correct": [(["fit.toml"], ["fit.toml", "tip.csv"])],
    "fit": [
        (["curve.csv", "fit.toml"], ["curve.csv", "fit.toml", "tip.csv"]),
        (["curves.zip", "fit.toml"], ["curves.zip", "fit.toml"]),
        (["tests.xlsx", "fit.toml"], ["tests.xlsx"]),
        (["folder", "fit.toml"], ["folder/one.csv", "folder/two.csv", "fit.toml"]),
        (["joint.toml"], ["joint.toml", "curve.csv", "other.csv", "tip.csv"]),
    ],
    "read": [(["curve.csv", "fit.toml"], ["curve.csv", "fit.toml", "tip.csv"]), (["tests.xlsx"], ["tests.xlsx"])],
    "fit-film": [
        (["film.csv", "film.toml"], ["film.csv", "film.toml"]),
        (["films", "film.toml"], ["films/one.csv", "films/two.csv"]),
    ],
    "cite": [(["result.nc"], ["result.nc"])],
    "plugin write": [(["nanite", "ball.toml"], ["ball.toml"]), (["slippy", "fit.toml"], ["fit.toml", "tip.csv"])],
    "atlas export": [(["./table.nc"], ["table.nc"])],
}


def registered():
    """Commands by name, with the functions that they call."""
    for name, command in get_command(app).commands.items():
        for inner, each in getattr(command, "commands", {"": command}).items():
            yield f"{name} {inner}".strip(), each, inspect.unwrap(each.callback)


OUTPUTS = {name: outputs_of(function) for name, _, function in registered()}


run = partial(commands.run, columns=400)


def words(done):
    return " ".join(done.output.split())


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """All files that commands read."""
    folder = tmp_path_factory.mktemp("made")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    r = np.linspace(0, 6e-6, 60)
    np.savetxt(
        folder / "tip.csv", np.column_stack([r * 1e6, r**2 * 1e11]), "%.6f", ",", header="r [um],f [um]", comments=""
    )
    axis = np.arange(16) * 1e-7
    np.savez(folder / "scan.npz", x=axis, y=axis, z=1e-8 * np.random.default_rng(0).random((16, 16)))
    shipped = fp.files.shipped_cases()[0].parent / "fit"
    for folders in ("folder", "films"):
        (folder / folders).mkdir()
    for name in ("curve.csv", "other.csv", "folder/one.csv", "folder/two.csv"):
        shutil.copy(shipped / "thin_gel.csv", folder / name)
    for name in ("film.csv", "films/one.csv", "films/two.csv"):
        shutil.copy(shipped / "hard_film.csv", folder / name)
    with zipfile.ZipFile(folder / "curves.zip", "w") as archive:
        for name in ("curve.csv", "other.csv"):
            archive.write(folder / name, name)
    from openpyxl import Workbook

    book = Workbook()
    book.active.append(["Depth (nm)", "Force (nN)"])
    for i in range(60):
        book.active.append([10.0 * i, max(i - 20.0, 0.0) ** 1.5])
    book.save(folder / "tests.xlsx")
    fp.save(fp.indent(fp.HalfSpace(5e3, 0.5), fp.Sphere(1e-6), depth=1e-7), folder / "result.nc")
    shutil.copy(shipped_tables() / "sliding-layer.nc", folder / "table.nc")
    return folder


@pytest.fixture
def place(made, tmp_path, monkeypatch):
    folder = tmp_path / "place"
    shutil.copytree(made, folder)
    monkeypatch.chdir(folder)
    return folder


def test_every_file_that_a_command_writes_is_marked():
    """A new command is in the tests below, and its options for files are marked; folders are the exception."""
    assert set(CALLS) == {name for name, outputs in OUTPUTS.items() if outputs}
    for name, command, function in registered():
        parameters = inspect.signature(function, eval_str=True).parameters
        given = {p.name for p in command.params if p.param_type_name == "option"}
        files = {name for name in given & set(parameters) if "Path" in str(parameters[name].annotation)}
        others = {"demo": {"output"}, "fit": {"values"}}  # a folder, and a file that is read
        assert files - set(OUTPUTS[name]) <= others.get(name, set()), name
    assert sum(map(len, OUTPUTS.values())) >= 28


@pytest.mark.long
@pytest.mark.parametrize(
    ("command", "call", "output"),
    [
        pytest.param(command, call, output, id=f"{command} {' '.join(call[0][:1])} --{output}")
        for command, calls in CALLS.items()
        for call in calls
        for output in OUTPUTS[command]
    ],
)
def test_no_output_replaces_an_input(command, call, output, place):
    """By its own name, if that has an ending that the output may have, by a symbolic link to it, and by a hard link."""
    arguments, inputs = call
    option, endings = OUTPUTS[command][output]
    before = {name: Path(name).read_bytes() for name in inputs}
    for name in inputs:
        for ending in endings:
            Path(f"soft{ending}").unlink(missing_ok=True)
            Path(f"hard{ending}").unlink(missing_ok=True)
            Path(f"soft{ending}").symlink_to(name)
            os.link(name, f"hard{ending}")
            for target in (
                f"soft{ending}",
                f"hard{ending}",
                *([name, f"none/../{name}"] if name.endswith(ending) else []),
            ):
                done = run(*command.split(), *arguments, option, target, exits=2)
                assert option in words(done)
                # nothing was read aloud, solved or drawn before
                assert words(done).startswith("Error:")
                other = "with a single curve", "a joint fit is kept as .csv"
                if not any(text in words(done) for text in other):
                    assert "an input of the command, which would be replaced. Name another file." in words(done)
        assert {each: Path(each).read_bytes() for each in inputs} == before


@pytest.mark.parametrize("command", ["solve", "sweep", "stress", "compare"])
def test_case_files_of_any_ending_are_inputs(command, place):
    for ending in (".csv", ".nc"):
        case = Path("solve.toml").rename(f"case{ending}")
        for option, endings in OUTPUTS[command].values():
            if ending in endings:
                more = ["--vary", "layers.0.young=1kPa,2kPa"] if command == "sweep" else []
                done = run(command, case, *more, option, case, exits=2)
                assert "an input of the command" in words(done)
        assert case.rename("solve.toml").read_text() == FILES["solve.toml"]


@pytest.mark.parametrize("command", [name for name, outputs in OUTPUTS.items() if len(outputs) > 1])
def test_one_file_for_two_outputs_is_refused(command, place):
    arguments, _ = CALLS[command][0]
    for one, two in combinations(OUTPUTS[command].values(), 2):
        for ending in set(one[1]) & set(two[1]):
            done = run(*command.split(), *arguments, one[0], f"x{ending}", two[0], f"./x{ending}", exits=2)
            assert "Give each output a name of its own." in words(done)


def test_a_link_to_an_output_is_the_same_file(place):
    Path("link.csv").symlink_to("x.nc")
    done = run("solve", "solve.toml", "-o", "x.nc", "--csv", "link.csv")
    assert "the same file as --output x.nc" in words(done)


@PIPES
def test_what_is_not_a_file_is_not_replaced(place):
    os.mkfifo("pipe.nc")
    for path in ("pipe.nc", "device.nc"):
        Path("device.nc").unlink(missing_ok=True)
        Path("device.nc").symlink_to("/dev/null")
        done = run("solve", "solve.toml", "-o", path, exits=2)
        assert "is a pipe or a device, not a file" in words(done)
        with pytest.raises(fp.files.ResultError, match="pipe or a device"):
            fp.save(fp.load("result.nc"), path)
    assert stat.S_ISFIFO(Path("pipe.nc").stat().st_mode)


def test_protected_files_stay_and_others_keep_their_rights(place):
    Path("x.nc").write_bytes(b"mine")
    Path("x.nc").chmod(0o444)
    done = run("solve", "solve.toml", "-o", "x.nc", exits=2)
    assert "x.nc: is write-protected. Name another file." in words(done)
    with pytest.raises(OSError, match="write-protected"):
        write_whole(Path("x.nc"), b"other")
    assert Path("x.nc").read_bytes() == b"mine"
    Path("x.nc").chmod(0o640)
    assert run("solve", "solve.toml", "-o", "x.nc").exit_code == 0
    assert stat.S_IMODE(Path("x.nc").stat().st_mode) == 0o640
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        os.chown("x.nc", 12345, 12345)
        write_whole(Path("x.nc"), b"other")
        assert (Path("x.nc").stat().st_uid, Path("x.nc").stat().st_gid) == (12345, 12345)


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["show-tip", "solve.toml"], "solve-tip.png"),
        (["show-medium", "solve.toml"], "solve-medium.png"),
        (["plugin", "write", "nanite", "ball.toml"], "flatpunch_nanite.py"),
        (["fit-film", "films", "film.toml", "-o", "points.csv"], "points-2.csv"),
    ],
)
def test_names_that_a_command_chooses_replace_nothing(arguments, name, place):
    Path(name).write_bytes(b"mine")
    done = run(*arguments, exits=2)
    assert f"{name} exists and was not named." in words(done)
    assert Path(name).read_bytes() == b"mine"
    if "-o" not in arguments:
        assert run(*arguments, "-o", name).exit_code == 0
        assert Path(name).read_bytes() != b"mine"


def test_a_second_demo_replaces_nothing(tmp_path, monkeypatch):
    from flatpunch.files import shipped_cases

    monkeypatch.setattr("flatpunch.files.shipped_cases", lambda: shipped_cases()[:1])
    case = tmp_path / shipped_cases()[0].name
    case.with_suffix(".csv").write_bytes(b"mine")
    done = run("demo", "-o", tmp_path, exits=0)
    assert f"not solved again; {case.stem}.csv would be replaced" in words(done)
    assert case.with_suffix(".csv").read_bytes() == b"mine"
    assert not case.with_suffix(".nc").exists()


def test_a_folder_of_records_loses_records_only(place):
    """Not even sealed files that are none."""
    foreign = {
        "notes.json": b"{}",
        "sealed.json": sealed(b'{"reason": "", "seconds": 1}'),
        "a.txt": b"",
        "list.json": sealed(b"[]"),
    }
    Path("mine.records").mkdir()
    for name, content in foreign.items():
        (Path("mine.records") / name).write_bytes(content)
    with pytest.warns(fp.FlatpunchWarning, match="the file stays where it is"):
        assert run("fit", "folder", "fit.toml", "-o", "mine.csv").exit_code == 0
    assert {path.name: path.read_bytes() for path in Path("mine.records").iterdir()} == foreign


def test_what_only_looks_unfinished_is_not_removed(tmp_path):
    for name in (".unfinished-thesis.txt", ".unfinished-0-1-x", f".unfinished-{'g' * 8}-1-{'x' * 8}"):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (0, 0))
    Records(tmp_path)
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.long
def test_a_folder_fit_leaves_its_own_tables_out(place):
    for _ in range(2):
        done = run("fit", "folder", "fit.toml", "-o", "folder/table.csv", exits=0)
        assert "2 of 2 curves fitted" in words(done)
    run("fit", "curve.csv", "fit.toml", "-o", "folder/single.csv")
    assert "2 of 2 curves fitted" in words(run("fit", "folder", "fit.toml"))


FAILING = [
    ("solve", ["ball.toml", "-o", "x.nc", "--csv", "y.csv"]),
    ("sweep", ["ball.toml", "--vary", "layers.0.young=1kPa,2kPa", "-o", "x.nc", "--csv", "y.csv", "--plot", "z.png"]),
    ("stress", ["ball.toml", "-o", "x.nc", "--csv", "y.csv"]),
    ("slip", ["slip.toml", "-o", "y.csv", "--plot", "z.png"]),
    ("compare", ["ball.toml", "-o", "y.csv", "--plot", "z.png"]),
    ("fit", ["curve.csv", "fit.toml", "-o", "y.csv", "--plot", "z.png"]),
    ("fit", ["folder", "fit.toml", "-o", "y.csv", "--plot", "z.png"]),
    ("fit-film", ["film.csv", "film.toml", "-o", "y.csv", "--plot", "z.png"]),
    ("design", ["design.toml", "--csv", "y.csv", "--plot", "z.png"]),
]


@pytest.mark.long
@pytest.mark.parametrize(("command", "arguments"), FAILING, ids=[f"{c} {a[0]}" for c, a in FAILING])
def test_each_output_is_tried_by_itself_after_the_result_is_printed(command, arguments, place, monkeypatch):
    """The disk is full for each file in turn."""
    targets = [Path(word) for option, word in pairwise(arguments) if option in ("-o", "--csv", "--plot")]
    whole = run(command, *arguments, exits=0)
    shown = words(whole).partition("Written:")[0]
    real = os.replace
    for full in targets:
        for path in targets:
            path.unlink(missing_ok=True)

        def replace(source, target, full=full):
            if Path(target).name == full.name:
                raise OSError(28, "No space left on device")
            real(source, target)

        monkeypatch.setattr("flatpunch._support.whole_file.os.replace", replace)
        done = run(command, *arguments, exits=2)
        # results with the time that they took apart
        assert len(words(done).partition("Written:")[0]) > 0.9 * len(shown)
        assert f"Not written: {full}" in words(done)
        assert f"{full}: cannot be written (No space left on device)" in words(done)
        rest = [path for path in targets if path != full]
        assert all(str(path) in words(done).partition("Not written")[0] for path in rest)
        assert all(path.exists() for path in rest)
        assert not full.exists()
        assert not list(Path().glob(".unfinished-*"))


def test_records_stay_when_the_table_cannot_be_written(place, monkeypatch):
    real = os.replace

    def replace(source, target):
        if Path(target).suffix == ".csv":
            raise OSError(28, "No space left on device")
        real(source, target)

    with monkeypatch.context() as full:
        full.setattr("flatpunch._support.whole_file.os.replace", replace)
        assert run("fit", "folder", "fit.toml", "-o", "y.csv").exit_code == 2
    assert "2 of 2 curves were fitted by an earlier run" in words(run("fit", "folder", "fit.toml", "-o", "y.csv"))
    assert not Path("y.records").exists()


@pytest.mark.long
def test_the_help_says_what_is_replaced():
    for name, outputs in OUTPUTS.items():
        assert ("replace files of the same name without asking" in words(run(*name.split(), "--help"))) == bool(outputs)


def shell(command):
    flatpunch = f"{sys.executable} -m flatpunch"
    return subprocess.run(
        ["bash", "-c", command.replace("flatpunch", flatpunch)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.long
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full, a disk that is always full")
def test_full_streams_end_with_status_2_and_one_line(place):
    for command in ("flatpunch --help", "flatpunch solve ball.toml -o x.nc"):
        done = shell(f"{command} > /dev/full")
        assert (done.returncode, done.stderr) == (2, "Error: standard output: No space left on device.\n")
    # what could be written was
    assert fp.load("x.nc").sizes["step"] == 2
    done = shell("flatpunch check none.toml 2> /dev/full")
    assert (done.returncode, done.stdout) == (2, "Error: standard error: No space left on device.\n")


@pytest.mark.long
def test_a_reader_that_leaves_costs_no_file(place):
    done = shell("flatpunch solve ball.toml -o x.nc | true; exit ${PIPESTATUS[0]}")
    assert (done.returncode, done.stderr) == (141, "")
    assert fp.load("x.nc").sizes["step"] == 2
