"""Nesting of case files is counted outside of texts and comments, in time that grows with the length."""

import tomllib

import pytest

from flatpunch.files.cases import DEEPEST, check_nesting

DEEP = "[" * (DEEPEST + 1) + "]" * (DEEPEST + 1)
TEXTS = (
    "'{}'",
    '"{}"',
    "'''{}'''",
    '"""{}"""',
    "'''{}''''",
    '"""{}"""""',
    r'"\"{}\\"',
    '"""\\"""{}\\\\"""',
    "''#{}",
    '""""""""#{}',
)


@pytest.mark.parametrize("text", TEXTS)
def test_brackets_in_texts_do_not_count(text):
    inside = f"key = {text.format(DEEP)}"
    tomllib.loads(inside)
    check_nesting(inside)


@pytest.mark.parametrize("text", TEXTS)
def test_brackets_after_texts_count(text):
    after = f"key = {text.format('word')}\nnext = {DEEP}"
    tomllib.loads(after)
    with pytest.raises(ValueError, match="line 2 is nested deeper"):
        check_nesting(after)


@pytest.mark.parametrize("unit", [r"\"", '"\n', "'\n", r"\"'", "'''\n''", '"""\n""', "\\"])
@pytest.mark.parametrize("start", ["", '"', "'", '"""', "'''"])
def test_a_million_unclosed_quotes_end(start, unit):
    check_nesting(f"key = {start}{unit * (1_000_000 // len(unit))}")
