"""The examples in the docstrings of public names run and print what they say."""

import doctest
from types import ModuleType

import numpy as np
import pytest

import flatpunch as fp

NAMES = [name for name in fp.__all__ if not isinstance(getattr(fp, name), (ModuleType, str))]
EXAMPLES = [name for name in NAMES if ">>>" in (getattr(fp, name).__doc__ or "")]


@pytest.mark.parametrize("name", EXAMPLES)
def test_example(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    example = doctest.DocTestParser().get_doctest(getattr(fp, name).__doc__, {"fp": fp, "np": np}, name, None, 0)
    said: list[str] = []
    found = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(example, out=said.append)
    assert found.attempted > 0
    assert not found.failed, "".join(said)
