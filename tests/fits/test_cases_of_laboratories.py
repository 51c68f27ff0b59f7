"""Exports and curves of the kinds that laboratories reported, made here."""

import numpy as np
import pytest

from flatpunch.fits import Curve, fit, fit_batch, read_curve
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace
from support.synthetic_curves import synthetic

BEAD = Paraboloid(5e-6)
BODY, START = HalfSpace(2e3, 0.5), HalfSpace(1e3, 0.5)


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
