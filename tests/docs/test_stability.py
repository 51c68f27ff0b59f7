"""Every public name has the version in which it came; references are the same everywhere."""

import re
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import flatpunch as fp

DOCS = Path(__file__).resolve().parents[2] / "docs"
NAMES = tomllib.loads((DOCS / "public_names.toml").read_text(encoding="utf-8"))
LISTED = [name for names in NAMES.values() for name in names]


def test_every_public_name_has_its_version():
    """Those of the package and those of the reference, which another test compares with the rooms."""
    reference = set(re.findall(r"^   ([\w.]+)$", (DOCS / "api.md").read_text(encoding="utf-8"), re.MULTILINE))
    public = (reference | set(fp.__all__)) - {"__version__"}
    assert sorted(public - set(LISTED)) == [], "add to docs/public_names.toml, under the next version"
    assert sorted(set(LISTED) - public) == [], "gone: list it in CHANGELOG.md, take it from public_names.toml"
    assert len(LISTED) == len(set(LISTED))


@pytest.mark.parametrize("name", LISTED)
def test_every_listed_name_is_there_and_described(name):
    room, _, last = f"flatpunch.{name}".rpartition(".")
    assert (getattr(import_module(room), last, None) or import_module(f"{room}.{last}")).__doc__
