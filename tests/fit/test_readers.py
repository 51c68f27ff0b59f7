"""Reading measured files: what is understood, and what is refused with a message that helps."""

import numpy as np
import openpyxl
import pytest

from flatpunch.fit import CurveError, read_curve

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
