"""Every public name has the version in which it came; references are the same everywhere; old names warn."""

import re
import tomllib
import warnings
from importlib import import_module
from pathlib import Path

import pytest

import flatpunch as fp
from flatpunch._support.deprecation import deprecated

DOCS = Path(__file__).resolve().parents[2] / "docs"
NAMES = tomllib.loads((DOCS / "public_names.toml").read_text(encoding="utf-8"))
LISTED = [name for names in NAMES.values() for name in names]


def test_every_public_name_has_its_version():
    """Those of the package and those of the reference, which another test compares with the rooms."""
    reference = set(re.findall(r"^   ([\w.]+)$", (DOCS / "api.md").read_text(encoding="utf-8"), re.MULTILINE))
    public = (reference | set(fp.__all__)) - {"__version__"}
    assert sorted(public - set(LISTED)) == [], "add to docs/public_names.toml, under the next version"
    assert sorted(set(LISTED) - public) == [], "a public name is gone: deprecate it instead"
    assert len(LISTED) == len(set(LISTED))


@pytest.mark.parametrize("name", LISTED)
def test_every_listed_name_is_there_and_described(name):
    room, _, last = f"flatpunch.{name}".rpartition(".")
    assert (getattr(import_module(room), last, None) or import_module(f"{room}.{last}")).__doc__


def test_deprecated_functions_classes_and_keywords_warn():
    @deprecated("1.0", "2.0", "new")
    def old(x):
        """Doc."""
        return x

    @deprecated("1.0", "2.0", "width=", keywords={"breadth": lambda value: {"width": 2 * value}})
    class Box:
        def __init__(self, width=0):
            self.width = width

    with pytest.warns(
        DeprecationWarning, match=r"old is deprecated since flatpunch 1.0 and goes in 2.0: use new\."
    ) as met:
        assert old(3) == 3
    # the line of the caller, which is where it is to be changed
    assert met[0].filename == __file__
    with pytest.warns(DeprecationWarning, match=r"Box\(breadth=...\) is deprecated .* use width=\."):
        assert Box(breadth=2).width == 4
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert isinstance(Box(width=2), Box)
        assert (old.__name__, old.__doc__) == ("old", "Doc.")


@pytest.mark.parametrize(("name", "room"), [("CriticalLoad", "stresses"), ("Design", "designs")])
def test_moved_names_warn_and_are_the_same(name, room):
    with pytest.warns(DeprecationWarning, match=f"use flatpunch.{room}.{name}") as met:
        old = getattr(fp, name)
    assert old is getattr(import_module(f"flatpunch.{room}"), name)
    assert met[0].filename == __file__
    assert name not in fp.__all__
