"""Every command's help ends with two examples, and they run on the files that `flatpunch demo` leaves behind."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from typer.main import get_command
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.cli.app import app
from flatpunch.cli.examples import EXAMPLES

ROOT = Path(__file__).resolve().parents[2]


def commands():
    """Names of all commands, "atlas show" among them."""
    names = []
    for name, command in get_command(app).commands.items():
        inner = getattr(command, "commands", None)
        names += [name] if inner is None else [f"{name} {each}" for each in inner]
    return names


def shown(command):
    """Help as a wide terminal shows it."""
    done = CliRunner().invoke(app, [*command.split(), "--help"], env={"COLUMNS": "250", "NO_COLOR": "1"})
    assert done.exit_code == 0
    return done.output


@pytest.mark.parametrize("command", commands())
def test_help_has_two_examples(command):
    lines = [line.strip() for line in shown(command).splitlines()]
    examples = [line for line in lines if line.startswith(f"flatpunch {command}")]
    assert tuple(examples) == EXAMPLES[command]
    # names in square brackets that the terminal takes for markup vanish
    assert "[]" not in shown(command)


@pytest.mark.long
@pytest.mark.parametrize(
    "line",
    [
        line
        for command, lines in EXAMPLES.items()
        if command != "app"  # its page stays until it is ended
        for line in lines
    ],
)
def test_examples_run(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples", "demo-results")
    from flatpunch.files import shipped_cases

    # all cases are solved in the test of the demo itself
    monkeypatch.setattr("flatpunch.files.shipped_cases", lambda: shipped_cases()[:1])
    # results of the demo, whose cases would take longer
    for name in re.findall(r"demo-results/\w+\.nc", line):
        fp.save(fp.indent(fp.HalfSpace(5e3, 0.5), fp.Sphere(1e-6), depth=1e-7), name)
    # eight thicknesses teach no more than three
    words = shlex.split(line.split("|")[0].replace(":8:log", ":3:log"))
    done = CliRunner().invoke(app, words[1:], env={"COLUMNS": "120", "NO_COLOR": "1"})
    assert done.exit_code == 0, done.output
    for name in re.findall(r"[\w/.-]+\.(?:nc|csv|png|pdf|svg|py|bib)", line):
        if not name.startswith("demo-results"):
            assert Path(name).stat().st_size > 100, name


@pytest.mark.long
def test_demo_leaves_all_files_of_the_examples(tmp_path, monkeypatch):
    from flatpunch.files import shipped_cases

    monkeypatch.setattr("flatpunch.files.shipped_cases", lambda: shipped_cases()[:1])
    assert CliRunner().invoke(app, ["demo", "-o", str(tmp_path / "demo-results")]).exit_code == 0
    left = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")}
    named = set(
        re.findall(r"demo-results/\S+\.(?:toml|csv)", " ".join(line for lines in EXAMPLES.values() for line in lines))
    )
    beside = {name for name in named if "/fit/" in name or "/rough/" in name}
    assert beside <= left
    assert {Path(name).name for name in named - beside} <= {path.name for path in shipped_cases()}
