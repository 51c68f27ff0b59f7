"""Every public docstring has an example that runs and prints what it says, and names other things to see that exist."""

import doctest
import inspect
import re
from importlib import import_module
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

import flatpunch as fp

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
NAMES = re.findall(r"^   ([\w.]+)$", REFERENCE, re.MULTILINE)


def found(name):
    """A public object by its name in the API reference: "indent", "fits.FitResult", the module "reference.layers"."""
    if name.startswith("reference."):
        return import_module(f"flatpunch.{name}")
    part, _, rest = name.rpartition(".")
    return getattr(import_module(f"flatpunch.{part}") if part else fp, rest)


def section(name, title):
    """Text of a section of a docstring, empty if there is none."""
    text = inspect.getdoc(found(name)) or ""
    match = re.search(rf"^{title}\n-+\n(.*?)(?=^\w[\w ]*\n--+\n|\Z)", text, re.DOTALL | re.MULTILINE)
    return match[1] if match else ""


def test_the_reference_names_its_objects():
    assert len(NAMES) > 150


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_example(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("agg")
    text = section(name, "Examples")
    assert ">>>" in text, f"{name} has no example"
    example = doctest.DocTestParser().get_doctest(text, {"fp": fp, "np": np}, name, None, 0)
    printed: list[str] = []
    result = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(example, out=printed.append)
    assert not result.failed, "".join(printed)


@pytest.mark.parametrize("name", NAMES)
def test_what_else_to_see(name):
    """`See Also` names public objects: as `fp.name`, or with the part of the package in front."""
    lines = [line for line in section(name, "See Also").splitlines() if line and not line.startswith(" ")]
    assert lines, f"{name} has no See Also"
    for other in (word for line in lines for word in line.partition(" : ")[0].split(", ")):
        other = other.removeprefix("flatpunch.")
        assert other in NAMES or other.rpartition(".")[0] in NAMES, (name, other)
