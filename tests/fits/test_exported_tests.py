"""Several tests in one file, workbook or archive, as instruments export them, and what is around the readings."""

import zipfile

import numpy as np
import openpyxl
import pytest

from flatpunch.fits import CurveError, read_curve
from flatpunch.fits.measured.files.readers import curves_in
from support.exported_curves import (
    APPROACH,
    BACK,
    COLUMNS,
    CYCLE,
    DEFLECTION,
    DEPTH,
    FORCE,
    PIEZO,
    TIME,
    K,
    N,
    holds,
    rows,
    written,
)

TESTS = {
    "numbers behind": ("Depth 1 (nm)\tLoad 1 (nN)\tDepth 2 (nm)\tLoad 2 (nN)\tDepth 3 (nm)\tLoad 3 (nN)", "dfdfdf"),
    "numbers before": (
        "Test 1 Depth (nm)\tTest 1 Load (nN)\tTest 2 Depth (nm)\tTest 2 Load (nN)\tTest 3 Depth (nm)\tTest 3 Load (nN)",
        "dfdfdf",
    ),
    "underscores": ("depth_1_nm\tload_1_nN\tdepth_2_nm\tload_2_nN\tdepth_3_nm\tload_3_nN", "dfdfdf"),
    "same titles": ("Depth (nm)\tLoad (nN)\tDepth (nm)\tLoad (nN)\tDepth (nm)\tLoad (nN)", "dfdfdf"),
    "pandas": ("depth (nm)\tforce (nN)\tdepth (nm).1\tforce (nN).1\tdepth (nm).2\tforce (nN).2", "dfdfdf"),
    "sorted": ("Depth 1 (nm)\tDepth 2 (nm)\tDepth 3 (nm)\tLoad 1 (nN)\tLoad 2 (nN)\tLoad 3 (nN)", "dddfff"),
    "one time": ("Time (s)\tDepth (nm)\tLoad (nN)\tDepth (nm)\tLoad (nN)\tDepth (nm)\tLoad (nN)", "tdfdfdf"),
    "times": ("t (s)\th (nm)\tP (nN)\tt (s)\th (nm)\tP (nN)\tt (s)\th (nm)\tP (nN)", "tdftdftdf"),
    "two rows of titles": (
        "Test 1\t\tTest 2\t\tTest 3\t\nDepth\tLoad\tDepth\tLoad\tDepth\tLoad\nnm\tnN\tnm\tnN\tnm\tnN",
        "dfdfdf",
    ),
    "empty between": (
        "Depth (nm)\tLoad (nN)\t\tDepth (nm)\tLoad (nN)\t\tDepth (nm)\tLoad (nN)",
        ["d", "f", "**", "d", "f", "**", "d", "f"],
    ),
}


@pytest.mark.parametrize("form", ["text", "sheet"])
@pytest.mark.parametrize("ends", [(N, N, N), (N, 40, 55)], ids=["alike", "of different lengths"])
@pytest.mark.parametrize("layout", TESTS)
def test_tests_side_by_side(tmp_path, layout, ends, form):
    """Each is a curve, whatever their lengths."""
    head, letters = TESTS[layout]
    cells = [list(COLUMNS.get(c, [""] * N)) for c in letters]
    seen = {"d": 0, "f": 0, "t": 0}
    for letter, column in zip(letters, cells, strict=True):
        if letter in "df" or (letter == "t" and letters.count("t") > 1):
            end = ends[seen[letter]]
            seen[letter] += 1
            column[end:] = [""] * (N - end)
    lines = [[f"{v:.8g}" if v != "" else "" for v in row] for row in zip(*cells, strict=True)]
    if form == "text":
        path = written(tmp_path / "c.txt", head + "\n" + "\n".join("\t".join(row) for row in lines) + "\n")
    else:
        book = openpyxl.Workbook()
        for row in head.split("\n"):
            book.active.append([c or None for c in row.split("\t")])
        for row in lines:
            book.active.append([float(c) if c else None for c in row])
        path = tmp_path / "c.xlsx"
        book.save(path)
    assert curves_in(path) == 3
    for i, end in enumerate(ends):
        holds(read_curve(path, index=i), DEPTH[:end], FORCE[:end])


BLOCKS = {
    "same titles": "Depth (nm)\tLoad (nN)\n",
    "words": "Test {i}\nDepth (nm)\tLoad (nN)\n",
    "Fischer": "Sample A\nTest {i}\nBlock : {i}\nF\th\nnN\tnm\n",
    "CSM": "----- Indentation {i} -----\nDate: 1.2.2030\n\nPd [nm]\tFn [nN]\n",
    "approaches": "[Approach]\nDepth (nm)\tLoad (nN)\n",
}


@pytest.mark.parametrize("layout", BLOCKS)
@pytest.mark.parametrize("decimal", [".", ","])
def test_tests_one_below_the_other(tmp_path, layout, decimal):
    letters = "fd" if layout == "Fischer" else "df"
    text = "\n".join(BLOCKS[layout].format(i=i) + rows(letters, decimal=decimal) for i in (1, 2, 3))
    path = written(tmp_path / "c.txt", text)
    assert curves_in(path, decimal=decimal) == 3
    for i in range(3):
        holds(read_curve(path, index=i, decimal=decimal), *APPROACH)


def test_a_column_that_numbers_the_tests(tmp_path):
    text = "".join(rows([f"*{i}*", "d", "f"]) for i in (1, 2, 3))
    path = written(tmp_path / "c.csv", "Test\tDepth (nm)\tLoad (nN)\n" + text)
    assert curves_in(path) == 3
    holds(read_curve(path, index=1), *APPROACH)


def test_cycles_one_below_the_other(tmp_path):
    """Trace and retrace of each of three, retraces from free to deepest."""
    head = "# direction: {}\n# columns: height vDeflection\n# units: nm nN\n#\n"
    one = head.format("trace") + rows("zf", " ") + head.format("retrace") + rows("ZF", " ", turned=True)
    path = written(tmp_path / "c.txt", one * 3)
    assert curves_in(path) == 3
    for i in range(3):
        holds(read_curve(path, index=i, spring_constant=K), *CYCLE)


@pytest.mark.parametrize("last", ["Max\t5\t3\n", "END\n", "\n\n", "1.2\t3", "Mean: 7 nm\n"])
def test_what_follows_the_readings_is_none(tmp_path, last):
    path = written(tmp_path / "c.txt", "depth (nm)\tforce (nN)\ttime (s)\n" + rows("dft") + last)
    holds(read_curve(path), *APPROACH)


@pytest.mark.parametrize("turned", [False, True])
def test_a_time_that_counts_rows_does_not_turn_a_retract_into_an_approach(tmp_path, turned):
    """Retraces from free to deepest whose times go on."""
    head = "# direction: {}\n# columns: height vDeflection time\n# units: nm nN s\n#\n"
    lines = rows("ZFT", " ").splitlines()
    if turned:
        cells = [line.split() for line in lines]
        lines = [" ".join([*there[:2], here[2]]) for there, here in zip(cells[::-1], cells, strict=True)]
    path = written(
        tmp_path / "c.txt", head.format("trace") + rows("zft", " ") + head.format("retrace") + "\n".join(lines)
    )
    curve = read_curve(path, spring_constant=K)
    holds(curve, *CYCLE)
    assert (np.diff(curve.time) > 0).all()


def test_a_million_columns_are_refused(tmp_path):
    path = written(tmp_path / "c.csv", ",".join(["depth (nm)"] * 10_000) + "\n" + (",".join("1" * 10_000) + "\n") * 12)
    with pytest.raises(CurveError, match="10000 columns; at most 5000 are read"):
        read_curve(path)


def test_extend_pause_retract(tmp_path):
    head = "# segmentIndex: {}\n# segment: {}\n# columns: verticalTipPosition vDeflection time\n# units: nm nN s\n#\n"
    pause = "".join(f"{DEPTH[-1] * 1e9:.8g} {FORCE[-1] * 1e9:.8g} {0.01 * i:.8g}\n" for i in range(30))
    text = head.format(0, "extend") + rows("dft", " ") + head.format(1, "pause") + pause
    path = written(tmp_path / "c.txt", text + head.format(2, "retract") + rows("DFt", " "))
    assert curves_in(path) == 1
    curve = read_curve(path)
    assert curve.segment.tolist() == [0] * N + [1] * 30 + [2] * N
    np.testing.assert_allclose(curve.force, np.concatenate([FORCE, np.full(30, FORCE[-1]), BACK]), atol=1e-16)


def test_a_nanoscope_text_with_its_header(tmp_path):
    """The header of the binary file stands above the numbers."""
    head = '"\\*File list"\n"\\Version: 0x09700000"\n"\\Spring Constant: 0.05"\n"\\*File list end"\n'
    titles = "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm\tDefl_nm_Ex\tDefl_nm_Rt\n"
    path = written(tmp_path / "c.txt", head + titles + rows("zZcC"))
    holds(read_curve(path), *CYCLE, tolerance=1e-5)
    path = written(tmp_path / "d.txt", head.replace('"', "") + titles + rows("zZcC"))
    holds(read_curve(path), *CYCLE, tolerance=1e-5)


def test_a_depth_that_begins_at_the_contact_is_not_used_before_it(tmp_path):
    """The text of an interferometric nanoindenter: the depth is zero before the contact."""
    text = "k (N/m)\t0.05\n\nTime (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\n"
    columns = [TIME, FORCE * 1e6, np.maximum(DEPTH, 0) * 1e9, DEFLECTION * 1e9, PIEZO * 1e9]
    lines = "\n".join("\t".join(f"{v:.8g}" for v in row) for row in zip(*columns, strict=True))
    holds(read_curve(written(tmp_path / "c.txt", text + lines)), *APPROACH, tolerance=1e-5)


def _workbook(path, results):
    book = openpyxl.Workbook()
    book.remove(book.active)
    if results == "first":
        _results(book)
    for i in (1, 2, 3):
        sheet = book.create_sheet(f"Test {i:03d}")
        sheet.append(["Displacement Into Surface", "Load On Sample", "Time On Sample"])
        sheet.append(["nm", "mN", "s"])
        for row in zip(DEPTH * 1e9, i * FORCE * 1e3, TIME, strict=True):
            sheet.append([float(v) for v in row])
    if results == "last":
        _results(book)
    book.save(path)
    return path


def _results(book):
    sheet = book.create_sheet("Sheet9")
    sheet.append(["Test", "E", "H", "Displacement", "Load"])
    sheet.append([None, "GPa", "GPa", "nm", "mN"])
    for i in range(20):
        sheet.append([i + 1, 70.0 + i, 9.0, 200.0 + i, 1.0 + i])


@pytest.mark.parametrize("results", ["none", "first", "last"])
def test_workbook_of_tests(tmp_path, results):
    path = _workbook(tmp_path / "c.xlsx", results)
    assert curves_in(path) == 3
    for i in range(3):
        holds(read_curve(path, index=i), DEPTH, (i + 1) * FORCE)
    holds(read_curve(path, sheet="Test 002"), DEPTH, 2 * FORCE)


def test_archive_of_workbooks_and_texts(tmp_path):
    with zipfile.ZipFile(tmp_path / "c.zip", "w") as archive:
        archive.write(_workbook(tmp_path / "c.xlsx", "first"), "a.xlsx")
        archive.writestr("b.csv", "depth (nm)\tforce (nN)\n" + rows("df"))
        archive.writestr("notes.txt", "Four tests.\n")
    assert curves_in(tmp_path / "c.zip") == 4
    holds(read_curve(tmp_path / "c.zip", index=3), *APPROACH)


@pytest.mark.parametrize(
    ("titles", "letters", "message"),
    [
        ("Piezo (nm)\tTime (s)", "zt", r"no column of deflection recognised.*\[curve.columns\] deflection = '...'"),
        ("Height (nm)\tPhase (deg)\tTime (s)", "z0t", "no column of deflection"),
        ("Deflection (nm)\tTime (s)", "ct", "no column of piezo"),
        ("Depth (nm)\tTime (s)", "dt", "no column of force"),
        ("Load (nN)\tTime (s)", "ft", "no column of depth"),
    ],
)
def test_what_is_missing_is_named(tmp_path, titles, letters, message):
    path = written(tmp_path / "c.txt", f"{titles}\n{rows(letters)}")
    for k in (K, None):
        with pytest.raises(CurveError, match=message):
            read_curve(path, spring_constant=k)


@pytest.mark.parametrize(
    ("lines", "place"),
    [
        ("# xPosition: 1.5e-5\n# yPosition: -2e-06\n", (1.5e-5, -2e-6)),
        ("Stage X (mm): 3.5\nStage Y (mm): 0\n", (3.5e-3, 0.0)),
        ("Position X\t12.5 um\nPosition Y\t7 um\n", (1.25e-5, 7e-6)),
        ("X position: 3500\nY position: 12\n", None),  # no metres
    ],
)
def test_where_a_curve_was_taken(tmp_path, lines, place):
    path = written(tmp_path / "c.txt", f"{lines}depth (nm)\tforce (nN)\n{rows('df')}")
    known = read_curve(path).meta.get("metadata", {})
    assert (place is None and not known) or np.allclose([known["position x"], known["position y"]], place, rtol=1e-12)
    holds(read_curve(path), DEPTH, FORCE)
