"""Reading measured files: what is understood, and what is refused with a message that helps."""

import zipfile

import numpy as np
import openpyxl
import pytest

from flatpunch.fits import CurveError, read_curve
from flatpunch.fits.measured.files.readers import curves_in

DEPTH = np.linspace(-50, 200, 40)
FORCE = np.clip(DEPTH, 0, None) ** 1.5 / 100 + 0.01


def _write(path, header, rows=None, sep=",", decimal="."):
    rows = zip(DEPTH, FORCE, strict=True) if rows is None else rows
    lines = [
        sep.join(f"{v:.6g}".replace(".", decimal) if isinstance(v, float) else str(v) for v in row) for row in rows
    ]
    path.write_text("\n".join([*header, *lines]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("header", "sep", "options"),
    [
        (["depth (nm),force (nN)"], ",", {}),
        (["Indentation [nm]\tLoad [nN]"], "\t", {}),
        (["# a comment", "depth;force", "nm;nN"], ";", {}),
        (["h / nm,F / nN"], ",", {}),
        (["depth,force"], ",", {"units": {"depth": "nm", "force": "nN"}}),
        (["a (nm),b (nN)"], ",", {"columns": {"depth": "a", "force": 1}}),
        (["depth (nm) force (nN)".replace(" (", "(")], " ", {}),
    ],
    ids=["comma", "tab", "unit-row", "slash", "units", "columns", "blanks"],
)
def test_text(tmp_path, header, sep, options):
    curve = read_curve(_write(tmp_path / "c.csv", header, sep=sep), **options)
    # six digits are written
    np.testing.assert_allclose(curve.depth, DEPTH * 1e-9, rtol=1e-5, atol=1e-14)
    np.testing.assert_allclose(curve.force, FORCE * 1e-9, rtol=1e-5)
    assert curve.name == "c"


def test_decimal_commas(tmp_path):
    path = _write(tmp_path / "c.txt", ["depth (nm)\tforce (nN)"], sep="\t", decimal=",")
    # six digits are written
    np.testing.assert_allclose(read_curve(path, decimal=",").depth, DEPTH * 1e-9, rtol=1e-5, atol=1e-14)
    with pytest.raises(CurveError, match=r"decimal commas. Read the file with decimal=','"):
        read_curve(path)


def test_piezo_and_deflection(tmp_path):
    k = 0.05
    piezo = DEPTH + FORCE / k
    rows = list(zip(piezo, FORCE / k, strict=True))
    path = _write(tmp_path / "c.csv", ["Piezo (nm),Deflection (nm)"], rows)
    # piezo positions of 500 nm are written to six digits
    curve = read_curve(path, spring_constant=k)
    np.testing.assert_allclose(curve.depth, DEPTH * 1e-9, atol=3e-12)
    np.testing.assert_allclose(curve.force, FORCE * 1e-9, rtol=1e-5)
    assert curve.spring_constant == k
    with pytest.raises(CurveError, match="needs the cantilever's spring constant"):
        read_curve(path)
    flipped = _write(tmp_path / "f.csv", ["Height (nm),Force (nN)"], zip(-piezo, FORCE, strict=True))
    np.testing.assert_allclose(read_curve(flipped, spring_constant=k, flip=True).depth, DEPTH * 1e-9, atol=3e-12)


def test_excel(tmp_path):
    book = openpyxl.Workbook()
    book.active.append(["nothing", "here"])
    sheet = book.create_sheet("Test 1")
    sheet.append(["Displacement Into Surface", "Load On Sample", "Harmonic Contact Stiffness"])
    sheet.append(["nm", "mN", "N/m"])
    for row in zip(DEPTH.tolist(), FORCE.tolist(), [1e3] * 39 + [1.797e308], strict=True):
        sheet.append(list(row))
    sheet.append(["END"])
    path = tmp_path / "c.xlsx"
    book.save(path)
    curve = read_curve(path)
    np.testing.assert_allclose(curve.force, FORCE * 1e-3)
    assert curve.stiffness[0] == 1e3
    assert np.isnan(curve.stiffness[-1])
    with pytest.raises(CurveError, match="there is no sheet 'Test 2'; there are 'Sheet', 'Test 1'"):
        read_curve(path, sheet="Test 2")


def test_what_is_wrong_is_said(tmp_path):
    good = _write(tmp_path / "c.csv", ["depth (nm),force (nN)"])
    cases = [
        (tmp_path / "none.csv", {}, "no such file"),
        (tmp_path, {}, "is a folder; fit_batch reads its files"),
        (_write(tmp_path / "c.xyz", ["depth (nm),force (nN)"]), {}, "the ending '.xyz' is none of those that are read"),
        (good, {"columns": {"force": "Lod"}}, "there is no column 'Lod' for force; there are 'depth', 'force'"),
        (good, {"columns": {"strain": "depth"}}, "'strain' is no kind of column"),
        (_write(tmp_path / "u.csv", ["depth,force"]), {}, r"has no unit. Write it into the header, 'depth \(nm\)'"),
        (
            _write(tmp_path / "w.csv", ["depth (nm),force (nm)"]),
            {},
            r"column 'force' \(force\) has the dimension of a length",
        ),
        (_write(tmp_path / "m.csv", ["depth (nm),temperature (K)"]), {}, "no column of force recognised"),
        (_write(tmp_path / "t.csv", ["only words"], [("a", "b")]), {}, "no rows of numbers found"),
        (
            _write(
                tmp_path / "n.csv",
                ["depth (nm),force (nN)"],
                [*zip(DEPTH, FORCE, strict=True), (1.0, "nan"), (2.0, 3.0)],
            ),
            {},
            "rows 40",
        ),
    ]
    for path, options, message in cases:
        with pytest.raises(CurveError, match=message):
            read_curve(path, **options)
    assert read_curve(tmp_path / "n.csv", skip_nan=True).force.size == 41


def test_damaged_files(tmp_path):
    for name in ("c.xlsx", "c.xls"):
        (tmp_path / name).write_bytes(b"no workbook at all")
        with pytest.raises(CurveError, match="damaged, or no Excel file"):
            read_curve(tmp_path / name)
    (tmp_path / "c.zip").write_bytes(b"no archive")
    with pytest.raises(CurveError, match="damaged"):
        read_curve(tmp_path / "c.zip")


@pytest.mark.parametrize("words", [False, True])
def test_segments_of_a_table(tmp_path, words):
    """A column of segments, numbers or words, is used; blank separation of title and unit costs nothing."""
    cycle = [*DEPTH, *DEPTH[::-1]]
    names = ("approach", "retract") if words else (1, 2)
    rows = [(d, max(d, 0.0) / 10, names[i // 40]) for i, d in enumerate(cycle)]
    curve = read_curve(_write(tmp_path / "c.csv", ["depth (nm),force (nN),Segment Type"], rows))
    assert curve.segment.tolist() == [0] * 40 + [1] * 40
    assert "segments from 'Segment Type'" in curve.meta["read"][0]
    np.testing.assert_allclose(curve.depth, np.array(cycle) * 1e-9, rtol=1e-5, atol=1e-14)
    # a number of each reading is no segment
    rows = [(d, f, i) for i, (d, f) in enumerate(zip(DEPTH, FORCE, strict=True))]
    assert read_curve(_write(tmp_path / "d.csv", ["depth (nm),force (nN),segment"], rows)).segment is None


def _below(records, sep):
    """Rows of several records, with blank lines where `sep` says so."""
    text = "\n".join("\n".join(" ".join(f"{v:.6g}" for v in row) for row in rows) + sep for rows in records)
    return [*text.split("\n")]


APPROACH = list(zip(DEPTH, FORCE, strict=True))
CYCLE = [*APPROACH, *APPROACH[::-1]]


@pytest.mark.parametrize(
    ("records", "sep", "points"),
    [
        ([APPROACH, APPROACH, APPROACH], "", [40, 40, 40]),
        ([APPROACH, APPROACH], "\n", [40, 40]),
        ([CYCLE, CYCLE], "\n", [80, 80]),
        # one cycle, and two, whose approach and retract are set apart
        ([APPROACH, APPROACH[::-1]], "\n", [80]),
        ([APPROACH, APPROACH[::-1]] * 2, "\n", [80, 80]),
        ([APPROACH, [APPROACH[-1]] * 20, APPROACH[::-1]] * 2, "\n", [100, 100]),
        ([APPROACH[:20], APPROACH[20:]], "\n", [40]),
        # without anything between them cycles are one record
        ([CYCLE, CYCLE], "", [160]),
        # blank lines here and there, where the tip goes on as before
        ([CYCLE[:13], CYCLE[13:52], CYCLE[52:]], "\n", [80]),
        # lines set apart for the eye
        ([APPROACH[i : i + 5] for i in range(0, 40, 5)], "\n", [40]),
    ],
)
def test_records_one_below_the_other(tmp_path, records, sep, points):
    path = _write(tmp_path / "c.dat", ["# depth (nm) force (nN)", *_below(records, sep)], [])
    assert curves_in(path) == len(points)
    found = [read_curve(path, index=i if len(points) > 1 else None).depth.size for i in range(len(points))]
    assert found == points


def test_time_that_begins_again(tmp_path):
    """With times a jump of the position is a fast step; a new record is where time begins again."""
    step = [(0.1 * i, 200.0 * (20 <= i < 60), 1.0) for i in range(80)]
    header = ["time (s),depth (nm),force (nN)"]
    assert curves_in(_write(tmp_path / "one.csv", header, step)) == 1
    assert curves_in(_write(tmp_path / "two.csv", header, step * 2)) == 2
    # times of approach and retract by themselves
    way = [(0.1 * i, d, f) for i, (d, f) in enumerate(APPROACH)]
    back = [(0.1 * i, d, f) for i, (d, f) in enumerate(APPROACH[::-1])]
    assert curves_in(_write(tmp_path / "cycle.csv", header, way + back)) == 1
    assert curves_in(_write(tmp_path / "cycles.csv", header, (way + back) * 2)) == 2
    assert curves_in(_write(tmp_path / "approaches.csv", header, way * 3)) == 3


def test_archive_of_tables(tmp_path):
    """Tables that the library of microscope files does not know, beside a text that is no curve."""
    pytest.importorskip("afmformats")
    _write(tmp_path / "c.csv", ["depth (nm),force (nN)"])
    with zipfile.ZipFile(tmp_path / "map.zip", "w") as archive:
        for i in range(3):
            archive.write(tmp_path / "c.csv", f"row {i}/c.csv")
        archive.writestr("readme.txt", "Three curves.\n")
    assert curves_in(tmp_path / "map.zip") == 3
    assert read_curve(tmp_path / "map.zip", index=2).depth.size == 40


@pytest.mark.parametrize(("unit", "scale"), [("V", 1.0), ("mV", 1e3), ("nA", 1e9)])
def test_deflection_as_a_signal(tmp_path, unit, scale):
    """The sensitivity makes it a length, as in files of microscopes."""
    k, sensitivity = 0.05, 70e-9
    rows = list(zip(DEPTH + FORCE / k, FORCE * 1e-9 / k / sensitivity * scale, strict=True))
    path = _write(tmp_path / "c.csv", [f"Z (nm),Deflection ({unit})"], rows)
    curve = read_curve(path, spring_constant=k, sensitivity=sensitivity)
    # six digits are written
    np.testing.assert_allclose(curve.force, FORCE * 1e-9, rtol=1e-5)
    assert "sensitivity 7e-08 m/V or m/A (given)" in curve.meta["read"]
    with pytest.raises(CurveError, match=r"is a signal .* sensitivity = \"70 nm/"):
        read_curve(path, spring_constant=k)


@pytest.mark.parametrize(
    ("header", "options"),
    [
        ("% depth (nm)   force (nN)", {"sep": "   "}),
        ("time,depth,force\n[s],[nm],[nN]", {}),
        ("Extension (nm),Deflection (nm)", {"spring_constant": 0.05}),
        ("Height Sensor (nm),Deflection Error (nm)", {"spring_constant": 0.05}),
    ],
)
def test_further_titles(tmp_path, header, options):
    sep, k = options.pop("sep", ","), options.get("spring_constant")
    rows = list(zip(DEPTH, FORCE, strict=True))
    if k is not None:
        rows = [(d + f / k, f / k) for d, f in rows]
    if header.startswith("time"):
        rows = [(0.1 * i, *row) for i, row in enumerate(rows)]
    curve = read_curve(_write(tmp_path / "c.txt", header.split("\n"), rows, sep=sep), **options)
    # positions of 200 nm with deflections taken off, six digits each
    np.testing.assert_allclose(curve.depth, DEPTH * 1e-9, rtol=1e-5, atol=3e-12)
    np.testing.assert_allclose(curve.force, FORCE * 1e-9, rtol=1e-5)


def test_what_spreadsheets_write(tmp_path):
    """UTF-16, marks between thousands, numbers stored as text, blank rows, the same titles again."""
    (tmp_path / "u.txt").write_text("depth (nm)\tforce (nN)\n" + "1,000.5\t2\n" * 20, encoding="utf-16")
    np.testing.assert_allclose(read_curve(tmp_path / "u.txt").depth, 1000.5e-9)
    (tmp_path / "c.txt").write_text("depth (nm)\tforce (nN)\n" + "1.000,5\t2\n" * 20, encoding="utf-8")
    np.testing.assert_allclose(read_curve(tmp_path / "c.txt", decimal=",").depth, 1000.5e-9)
    book = openpyxl.Workbook()
    for test in (1, 2):
        book.active.append([f"Test {test}"])
        book.active.append(["Depth", "Force"])
        book.active.append(["(nm)", "(nN)"])
        for i, (d, f) in enumerate(zip(DEPTH, FORCE, strict=True)):
            book.active.append([f"{d:.6g}", float(f)])
            if i == 20:
                book.active.append([])
    book.save(tmp_path / "c.xlsx")
    assert curves_in(tmp_path / "c.xlsx") == 2
    np.testing.assert_allclose(read_curve(tmp_path / "c.xlsx", index=1).depth, DEPTH * 1e-9, rtol=1e-5, atol=1e-14)


def test_columns_of_one_name_are_chosen_by_number(tmp_path):
    rows = [(d, f, d, 2 * f) for d, f in zip(DEPTH, FORCE, strict=True)]
    path = _write(tmp_path / "c.csv", ["depth (nm),force (nN),depth (nm),force (nN)"], rows)
    # two tests side by side, of which columns by their number choose one
    assert curves_in(path) == 2
    with pytest.raises(CurveError, match="holds 2 curves"):
        read_curve(path)
    assert read_curve(path, columns={"depth": 2, "force": 3}).force[-1] == pytest.approx(2e-9 * FORCE[-1], rel=1e-5)
    path = _write(tmp_path / "s.csv", ["depth (nm),depth (nm),force (nN)"], [(d, d, 0.1) for d in DEPTH])
    with pytest.raises(CurveError, match="depth = 0 or depth = 1"):
        read_curve(path)
    # two positions of the piezo, and no depth
    path = _write(tmp_path / "d.csv", ["Ramp Ex (nm),Ramp Rt (nm),Deflection (nm)"], [(d, d, 0.0) for d in DEPTH])
    with pytest.raises(CurveError, match=r'several columns could be the piezo: .* piezo = "Ramp Ex" or'):
        read_curve(path, spring_constant=0.05)
