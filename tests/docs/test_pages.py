"""Pages name what exists: tests in the validation, every public name in the reference, every theory page in its index."""

import re
from pathlib import Path
from types import ModuleType

import pytest

import flatpunch as fp
from flatpunch import atlas, bem, files, fits, kernels

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


def test_validation_names_tests_that_exist():
    text = (DOCS / "validation.md").read_text(encoding="utf-8")
    named = set(re.findall(r"[a-z_]+/test_[a-z0-9_]+", text))
    assert len(named) > 30
    assert [name for name in sorted(named) if not (ROOT / "tests" / f"{name}.py").is_file()] == []


@pytest.mark.parametrize(
    ("prefix", "names"),
    [
        ("", [name for name in fp.__all__ if not isinstance(getattr(fp, name), ModuleType)]),  # parts list their names
        ("atlas.", [*atlas.__all__]),
        ("bem.", bem.__all__),
        ("fits.", fits.__all__),
        ("kernels.", kernels.__all__),
        ("files.", files.__all__),
    ],
    ids=["flatpunch", "atlas", "bem", "fits", "kernels", "files"],
)
def test_the_reference_lists_every_public_name(prefix, names):
    listed = set(re.findall(r"^   ([\w.]+)$", (DOCS / "api.md").read_text(encoding="utf-8"), re.MULTILINE))
    top = set(fp.__all__)
    missing = [n for n in names if n != "__version__" and f"{prefix}{n}" not in listed and not (prefix and n in top)]
    assert missing == []


def test_the_theory_index_lists_every_page():
    text = (DOCS / "theory" / "index.md").read_text(encoding="utf-8")
    pages = {path.name for path in (DOCS / "theory").glob("*.md")} - {"index.md"}
    assert [page for page in sorted(pages) if f"]({page})" not in text] == []


def test_every_example_says_what_it_reproduces():
    """A title and a text; of a paper, its source with its year or a shipped case."""
    paths = sorted((DOCS / "examples").glob("*/plot_*.py"))
    assert {path.parent.name for path in paths} == {"jobs", "papers"}
    for path in paths:
        title, text = re.match(r'r?"""\n(.+)\n=+\n\n(.*?)"""', path.read_text(encoding="utf-8"), re.DOTALL).groups()
        assert len(title) < 90, path.name
        assert path.parent.name == "jobs" or re.search(r"(19|20)\d\d|examples/\w+\.toml", title + text), path.name
