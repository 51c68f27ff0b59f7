"""Files that laboratories reported, and others of the same kinds: what each must give."""

import numpy as np
import pytest

from flatpunch.fit import Curve, CurveError, fit, fit_batch, read_curve
from flatpunch.fit.case import read_fit_case
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace
from support.synthetic_curves import synthetic

BEAD = Paraboloid(5e-6)
BODY, START = HalfSpace(2e3, 0.5), HalfSpace(1e3, 0.5)


def fitted(folder, name):
    case = read_fit_case(folder / "case.toml")
    curve = read_curve(folder / name, **case.reading)
    return fit(curve, case.medium, case.indenter, case.free, **case.arguments)


@pytest.mark.parametrize(
    ("folder", "name", "tolerance"),
    [
        ("01_force_offset", "offset_0.csv", 0.005),
        ("01_force_offset", "offset_1.csv", 0.005),
        ("01_force_offset", "offset_2.csv", 0.005),
        ("02_tilted_baseline", "tilt_0.2.csv", 0.005),
        ("03_short_contact", "curve.csv", 0.03),
    ],
)
def test_two_kilopascal(cases, folder, name, tolerance):
    """Tolerance: the interval, rounded up."""
    found = fitted(cases / folder, name).estimates["base.young"]
    assert found.value == pytest.approx(2e3, rel=tolerance)
    assert found.low <= 2e3 <= found.high


def test_columns_are_those_of_the_indentation(cases):
    read = " ".join(fitted(cases / "06_wrong_columns", "dma.txt").read)
    assert "'Indent Disp.'" in read
    assert "'Indent Load'" in read


@pytest.mark.parametrize("name", ["results_first.xlsx", "three_tests.xlsx"])
def test_all_tests_of_a_workbook(cases, name):
    """Three tests that begin at the contact, loads as 1 : 2 : 3."""
    case = read_fit_case(cases / "07_workbook" / "case.toml")
    batch = fit_batch([cases / "07_workbook" / name], case.medium, case.indenter, case.free, workers=1)
    assert not batch.failed
    young = sorted(batch.column("base.young"))
    np.testing.assert_allclose(np.array(young) / young[0], [1, 2, 3], rtol=1e-3)


def test_a_dip_of_few_steps(cases):
    with pytest.raises(CurveError, match=r"dips 4e-11 N below .* 4.0% of the largest force and 14 times the noise"):
        fitted(cases / "08_digitised_force", "curve.csv")


@pytest.mark.parametrize("case", ["case.toml", "case_as_advised.toml"])
def test_blocks_are_curves(cases, case):
    folder = cases / "09_blocks"
    loaded = read_fit_case(folder / case)
    batch = fit_batch(
        [folder / "blocks.txt"], loaded.medium, loaded.indenter, loaded.free, workers=1, reading=loaded.reading
    )
    assert len(batch.rows) == 3
    assert not batch.failed


def test_signal_of_a_current(cases):
    result = fitted(cases / "10_current_signal", "curve.txt")
    assert result.used.size == 1000
    assert 100 < result["base.young"] < 1e4


def test_units_behind_underscores(cases):
    result = fitted(cases / "13_underscore_units", "curve.csv")
    assert "(nm)" in result.read[0]
    assert "(uN)" in result.read[0]


@pytest.mark.parametrize("first", ["free", "deep"])
@pytest.mark.parametrize("padding", [0, 40])
def test_ntmdt_exports_of_either_order(tmp_path, first, padding):
    """Height, deflection on approach, on retract; afmformats drops constant readings at the beginning."""
    pytest.importorskip("afmformats")
    clean = synthetic(BODY, BEAD, 4e-7, noise=0.0, points=600)
    k, sensitivity = 0.05, 70.0
    piezo, signal = clean.depth + clean.force / k, clean.force / (k * sensitivity)
    signal = signal + 0.003 * signal.max() * np.random.default_rng(3).normal(size=600) + 1e-9
    if padding and first == "free":
        signal[:padding] = 1e-9
    retract = signal + 0.002 * signal.max()
    height, order = (piezo, slice(None)) if first == "free" else (-piezo, slice(None, None, -1))
    rows = zip(height[order] * 1e9, signal[order] * 1e9, retract[order] * 1e9, strict=True)
    text = "\n".join("\t".join(f"{v:.4f}" for v in row) for row in rows).replace(".", ",")
    (tmp_path / "curve.txt").write_text(text, encoding="latin-1")
    curve = read_curve(tmp_path / "curve.txt", spring_constant=k, sensitivity=sensitivity)
    assert curve.force.size == 1200
    found = fit(curve, START, BEAD, ["base.young"]).estimates["base.young"]
    assert abs(found.value - 2e3) < 4 * found.stderr


def test_curves_that_begin_at_the_contact():
    """Instruments that detect the contact: the first reading is at it, and counts as fitted."""
    depth = np.linspace(0, 4e-7, 300)
    whole = synthetic(BODY, BEAD, 4e-7, noise=0.0, points=600)
    curve = Curve(depth, np.interp(depth, whole.depth, whole.force))
    row = fit_batch([curve], START, BEAD, ["base.young"], workers=1).rows[0]
    assert row["ok"]
    assert "no baseline is seen" in row["notes"]
    deep = Curve(depth[100:], curve.force[100:])
    assert not fit_batch([deep], START, BEAD, ["base.young"], workers=1).rows[0]["ok"]
