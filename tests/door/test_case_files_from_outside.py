"""Case files with any mistake end in a case or in a `CaseError` of readable length, soon."""

import os
import random
import shutil
import time

import pytest

from flatpunch.files import Case, CaseError, read_case
from flatpunch.files.cases import is_fit_case
from flatpunch.fits.case import FitCase, read_fit_case
from support import case_mutations
from support.platforms import PIPES

LONGEST = 1100
"""Characters of a line of a message; texts of the file are cut to 200."""
SOON = 5.0
"""Seconds of this process for one file."""


def read(path):
    """The case, or the message."""
    start = time.process_time()
    message = "read"
    try:
        found = (read_fit_case if is_fit_case(path) else read_case)(path)
        assert isinstance(found, (Case, FitCase))
    except CaseError as error:
        message = str(error)
    assert message
    assert max(map(len, message.splitlines())) < LONGEST, message[:2000]
    assert len(message) < 40 * LONGEST
    assert time.process_time() - start < SOON


@pytest.fixture(params=case_mutations.examples(), ids=lambda path: path.stem)
def example(request, tmp_path):
    """A shipped case file, and a place for mutated ones beside the files that it names."""
    for data in request.param.parent.glob("*.csv"):
        shutil.copy(data, tmp_path)
    return request.param, tmp_path / "mutated.toml"


def test_examples_themselves_are_read(example):
    original, path = example
    path.write_text(
        case_mutations.written(case_mutations.tomllib.loads(original.read_text(encoding="utf-8"))), encoding="utf-8"
    )
    read_fit_case(path) if is_fit_case(path) else read_case(path)


def test_a_byte_order_mark_is_no_text(tmp_path):
    """What spreadsheets ("CSV UTF-8") and editors write before a text."""
    case = (
        'base = { kind = "half-space", young = "1 GPa", poisson = 0.3 }\n'
        'indenter = { kind = "radial-profile", file = "tip.csv" }\ncontrol = { depth = "1 nm" }'
    )
    for mark in ("", "\ufeff"):
        (tmp_path / "tip.csv").write_text(mark + "r [um], f [um]\n0, 0\n1, 0.1\n2, 0.4\n", encoding="utf-8")
        (tmp_path / "case.toml").write_text(mark + case, encoding="utf-8")
        assert read_case(tmp_path / "case.toml").control == "depth"


def test_ten_problems_are_listed_and_the_rest_counted(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text("[[layers]]\nyoung = 1\n" * 40, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        read_case(path)
    *lines, last = str(caught.value).splitlines()
    assert len(lines) == 10
    assert "and 111 more problems" in last  # three of each layer and a missing tip


def test_every_unknown_field_of_a_table_is_a_problem(tmp_path):
    path = tmp_path / "case.toml"
    unknown = "".join(f"colour{i} = 1\n" for i in range(12))
    path.write_text(f"[[layers]]\nyuong = 1\n{unknown}", encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        read_case(path)
    first, *lines, last = str(caught.value).splitlines()
    assert "layers[0].yuong is no known field; did you mean 'young'?" in first
    assert all(f"colour{i}" in line for i, line in enumerate(lines))
    assert "and 4 more problems" in last  # three colours and the missing tip


@pytest.mark.long
def test_every_field_and_every_kind_of_mistake(example):
    original, path = example
    # a part of all; the others are in the slow test
    for label, text in random.Random(original.stem).sample(
        all_of := list(case_mutations.field_mutations(original)), len(all_of) // 10
    ):
        path.write_text(text, encoding="utf-8")
        try:
            read(path)
        except Exception as error:
            raise AssertionError(label) from error


def test_damaged_text(example):
    original, path = example
    for label, data in case_mutations.text_mutations(original, 1, 15):
        path.write_bytes(data)
        try:
            read(path)
        except Exception as error:
            raise AssertionError(label) from error


@pytest.mark.slow
def test_all_fields_and_more_damage(example):
    original, path = example
    for label, text in case_mutations.field_mutations(original):
        path.write_text(text, encoding="utf-8")
        try:
            read(path)
        except Exception as error:
            raise AssertionError(label) from error
    for label, data in case_mutations.text_mutations(original, 2, 1000):
        path.write_bytes(data)
        try:
            read(path)
        except Exception as error:
            raise AssertionError(label) from error


@pytest.mark.long
@pytest.mark.parametrize("name", case_mutations.monsters())
def test_large_deep_and_strange_files(name, tmp_path):
    path = tmp_path / "monster.toml"
    path.write_bytes(case_mutations.monsters()[name])
    read(path)
    with pytest.raises(CaseError):
        read_case(path)


@pytest.mark.parametrize(
    "name",
    [pytest.param("pipe", marks=PIPES), "folder", "/dev/zero", "missing", "null\0", "x" * 5000, "link to itself"],
)
def test_what_is_no_file(name, tmp_path):
    path = tmp_path / name
    if name == "pipe":
        os.mkfifo(path)
    elif name == "folder":
        path.mkdir()
    elif name == "link to itself":
        path.symlink_to(path)
    with pytest.raises(CaseError, match="not readable"):
        read_case(path)
    assert not is_fit_case(path)


def test_an_indenter_without_kind_is_told_which_there_are(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        "[base]\nkind = 'rigid'\n[indenter]\nradius = '1 um'\n[control]\ndepth = '1 nm'\n", encoding="utf-8"
    )
    with pytest.raises(CaseError, match=r"indenter\.kind is missing; it is one of .*'paraboloid'"):
        read_case(path)


@pytest.mark.parametrize(
    ("quantity", "message"),
    [
        ("1e999999999 um", "is not finite"),
        ("-1e999999999 um", "is not finite"),
        ("\u0663 um", "does not start with a number"),
        ("1 " + "u" * 300, "is no quantity, with 302 characters"),
        ("1 um**99999", "unknown unit"),
    ],
)
def test_quantities_of_odd_forms(quantity, message):
    from flatpunch.files import units

    with pytest.raises(ValueError, match=message):
        units.to_si(quantity, units.LENGTH)
