"""Exports of instruments of random curves: each is within 1 % of the truth, or is named for what it is."""

import re
import zlib

import numpy as np
import pytest

from flatpunch.fits import CurveError, fit, read_curve, unloading
from flatpunch.fits.case import read_fit_case
from support.commands import run
from support.laboratory_files import FILES

TEXTS = ["load_hold", "breakthrough", "start_backwards", "jpk_text", "nanoscope_text", "words_below"]


def made_in(folder, name, seed):
    """A file of a kind with its case."""
    if name == "exported":
        pytest.importorskip("afmformats")
    made = FILES[name](folder, np.random.default_rng([seed, zlib.crc32(name.encode())]))
    (folder / "case.toml").write_text(made.case, encoding="utf-8")
    return made


def fitted(folder, made):
    """What a fit finds."""
    case = read_fit_case(folder / "case.toml")
    return fit(read_curve(made.path, **case.reading), case.medium, case.indenter, case.free, **case.arguments)


def check(folder, name, seed):
    """Right within 1 %, or named."""
    made = made_in(folder, name, seed)
    if made.film and made.young:
        ran = run("fit-film", made.path, folder / "case.toml", exits=0)
        assert float(re.search(r"Young's modulus of layer 1 +([\d.]+) GPa", ran.output)[1]) * 1e9 == pytest.approx(
            made.young, rel=0.01
        )
    elif made.film:
        assert any(made.words in note for note in unloading(read_curve(made.path)).notes)
    elif made.young is None:
        with pytest.raises(CurveError, match=made.words):
            fitted(folder, made)
    else:
        found = fitted(folder, made)
        # noise of 0.2 to 0.3 % moves these moduli by 0.5 % at most
        assert found["base.young"] == pytest.approx(made.young, rel=0.01)
        assert made.note in " ".join(found.notes)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", FILES)
def test_right_or_named(tmp_path, name, seed):
    check(tmp_path, name, seed)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_right_or_named_of_twenty_five(tmp_path, name):
    for seed in range(100, 125):
        (folder := tmp_path / str(seed)).mkdir()
        check(folder, name, seed)


def _table(text):
    """Lines, which of them are numbers, and the mark between columns."""
    lines = text.split("\n")
    for mark in "\t;, ":
        rows = [i for i, line in enumerate(lines) if mark in line and re.fullmatch(r"[-+.\deE" + mark + "]+", line)]
        if len(rows) > 50:
            return lines, rows, mark
    raise AssertionError("no table")


def _with_commas(text):
    lines, rows, mark = _table(text)
    for i in rows:
        lines[i] = lines[i].replace(mark, ";" if mark == "," else mark).replace(".", ",")
    return "\n".join(line.replace(",", ";") if mark == "," and i not in rows else line for i, line in enumerate(lines))


def _with_empty_rows(text):
    lines, rows, mark = _table(text)
    for i in (rows[-1], rows[len(rows) // 3], rows[len(rows) // 5]):
        lines.insert(i + 1, "" if mark == " " else mark * lines[i].count(mark))
    return "\n".join(lines)


def _with_other_columns(text):
    lines, rows, mark = _table(text)
    count = lines[rows[0]].count(mark) + 1
    order = np.random.default_rng(count).permutation(count)
    turned = []
    for line in lines:
        label, colon, rest = line.partition(": ") if line.startswith(("# columns", "# units")) else ("", "", line)
        cells = rest.split(mark)
        turned.append(label + colon + mark.join(cells[i] for i in order) if len(cells) == count else line)
    return "\n".join(turned)


@pytest.mark.long
@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize(
    ("change", "encoding", "reading"),
    [
        (str, "utf-8-sig", ""),
        (lambda text: text.replace("\n", "\r\n"), "utf-16", ""),
        (_with_commas, "utf-8", 'decimal = ","'),
        (_with_empty_rows, "utf-8", ""),
        (_with_other_columns, "utf-8", ""),
        (lambda text: text[: len(text) - 9], "utf-8", ""),
    ],
    ids=["mark", "unicode", "commas", "empty rows", "columns", "cut off"],
)
def test_other_forms_of_the_same_text(tmp_path, name, change, encoding, reading):
    made = made_in(tmp_path, name, 1)
    raw = made.path.read_bytes()
    text = raw.decode("latin-1" if name == "words_below" else "utf-8")
    made.path.write_bytes(change(text).encode(encoding))
    if reading:
        case = made.case if "[curve]" in made.case else f"{made.case}[curve]\n"
        (tmp_path / "case.toml").write_text(f"{case}{reading}\n", encoding="utf-8")
    assert fitted(tmp_path, made)["base.young"] == pytest.approx(made.young, rel=0.01)
