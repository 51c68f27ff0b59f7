"""The words are true: examples run and print what they say, case files are read, commands and links exist."""

import contextlib
import io
import re
import warnings
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flatpunch.cli.app import app
from flatpunch.files import read_case

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md")]
PAGES += sorted(path for path in (ROOT / "docs").rglob("*.md") if "_build" not in path.parts)


def blocks(language):
    """All fenced blocks of a language, as (page and line, text)."""
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for match in re.finditer(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
            line = text[: match.start()].count("\n") + 1
            found.append(pytest.param(match[1], id=f"{page.relative_to(ROOT)}:{line}"))
    return found


@pytest.mark.long
@pytest.mark.parametrize("code", blocks("python"))
def test_python_blocks(code, tmp_path, monkeypatch):
    """Run a block; every comment "prints: ..." is one line that it prints. Those for other programs need the program."""
    for host in re.findall(r"^(?:from|import) (ContactMechanics|micromechanics|tamaas)\b", code, re.MULTILINE):
        pytest.importorskip(host, reason=f"{host} is installed in environments of its own only")
        warnings.simplefilter("ignore")  # its own; pytest restores the filters
    monkeypatch.chdir(tmp_path)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "<example>", "exec"), {"__name__": "example"})
    promised = re.findall(r"# prints: (.*)", code)
    assert printed.getvalue().splitlines() == promised


@pytest.mark.parametrize("text", blocks("toml"))
def test_case_file_blocks(text, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    read_case(path)


def test_the_tutorial_shows_a_shipped_case(tmp_path):
    """The case file in the tutorial is the shipped one, comments aside."""
    (text,) = (block.values[0] for block in blocks("toml") if block.id.startswith("docs/tutorial"))
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    shown, shipped = read_case(path), read_case(ROOT / "examples" / "afm_pyramid_on_gel.toml")
    assert (shown.medium, shown.indenter, shown.title) == (shipped.medium, shipped.indenter, shipped.title)
    assert list(shown.values) == list(shipped.values)


@pytest.mark.parametrize("text", blocks("sh"))
def test_commands_exist(text):
    """Every `make` target, every sub-command and option of `flatpunch`, and every example file that is named."""
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    commands = [line.split("#")[0].split() for line in text.splitlines() if line.split("#")[0].strip()]
    for words in commands:
        if words[0] == "make":
            assert words[1] in targets, words
        if words[0] == "flatpunch":
            command = words[1:3] if words[1] in ("atlas", "plugin") else words[1:2]  # those with commands of their own
            shown = CliRunner().invoke(app, [*command, "--help"], env={"COLUMNS": "200", "NO_COLOR": "1"})
            assert shown.exit_code == 0, words
            for option in (word for word in words[2:] if word.startswith("-")):
                assert option in shown.output, (words, option)
        for word in words:
            if word.startswith("examples/"):
                assert (ROOT / word).exists(), word


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#\s]+)\)", page.read_text(encoding="utf-8")):
        if not re.match(r"[a-z]+:", target):
            assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_the_architecture_names_every_part():
    """A part of the package that ARCHITECTURE.md does not name is missing from the map."""
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    source = ROOT / "src" / "flatpunch"
    parts = {path.name for path in source.iterdir() if (path / "__init__.py").is_file()}
    assert [name for name in sorted(parts) if name not in text] == []
