"""Curves that are fitted side by side give what they give one by one."""

import dataclasses
import re

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.fit import Curve, fit_batch
from flatpunch.fit.elastic.many import at_once, plain
from flatpunch.fit.fitting import fit_model
from flatpunch.fit.many import plain_rows
from flatpunch.fit.models import model_of
from flatpunch.fit.parameters.sample import Sample
from flatpunch.fit.parameters.settings import Settings, as_free
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace
from support.laboratory_curves import KINDS, laboratory_curve

PLAIN = ["bead on gel", "pyramid on film", "bead on half-space", "soft cantilever", "stiff cantilever"]


def rows_both_ways(name, baseline, count, seed=5):
    kind, rng = KINDS[name], np.random.default_rng(seed)
    tilted = baseline == "linear"
    curves = [laboratory_curve(kind, rng, tilted=tilted) for _ in range(count)]
    settings = Settings(quick=True, baseline=baseline)
    free = as_free(kind.free)
    model = model_of(Sample(kind.start, kind.tip), free, "auto")
    return curves, plain_rows(curves, model, free, settings), model, free, settings


@pytest.mark.parametrize("baseline", ["constant", "linear"])
@pytest.mark.parametrize("name", PLAIN)
def test_the_same_values_intervals_and_notes(name, baseline):
    """Within a twentieth of a standard error, which is what block means cost a single fit; intervals and noise to 2 %.

    Both are judged alike, so that the notes are the same but for their last digits.
    """
    curves, rows, model, free, settings = rows_both_ways(name, baseline, 12)
    assert sum(row is not None for row in rows) >= 10
    for curve, row in zip(curves, rows, strict=True):
        if row is None:
            continue
        alone = fit_model(curve, model, free, settings).row()
        assert set(row) == set(alone)
        assert row["points"] == alone["points"]
        for key in (*model.free, "contact", "baseline"):
            assert abs(row[key] - alone[key]) < 0.05 * alone[f"{key} stderr"]
            assert row[f"{key} stderr"] == pytest.approx(alone[f"{key} stderr"], rel=0.02)
        assert row["noise"] == pytest.approx(alone["noise"], rel=0.02)
        assert row["deepest"] == pytest.approx(alone["deepest"], rel=0.02)
        both = (re.sub(r"\d+%", "", each["notes"].split("(")[0]) for each in (row, alone))
        assert len(set(both)) == 1


def test_a_saturated_curve_is_left_to_the_fit_of_one():
    """Noise hides that its end is flat; correlated residuals show that the model does not describe it."""
    body, tip = HalfSpace(2e3, 0.5), Paraboloid(5e-6)
    way = 4e-7 * np.linspace(-0.7, 1, 207)
    clean = np.zeros(207)
    clean[way > 0] = indent(body, tip, depth=way[way > 0])["force"]
    curves = []
    for seed in range(12):
        noise = 0.03 * clean.max() * np.random.default_rng(seed).normal(size=207)
        curves.append(Curve(way, np.minimum(clean, 0.34 * clean.max()) + noise, name=f"c{seed}"))
    batch = fit_batch(curves, HalfSpace(1e3, 0.5), tip, ["base.young"], workers=1)
    assert len(batch.failed) == 12
    assert all("saturated" in row["reason"] for row in batch.failed)


def test_blocks_lose_nothing():
    """Against the descent on all readings: a hundredth of a standard error."""
    kind, rng = KINDS["bead on gel"], np.random.default_rng(2)
    curves = [laboratory_curve(kind, rng, tilted=False) for _ in range(8)]
    free = as_free(kind.free)
    model = model_of(Sample(kind.start, kind.tip), free, "auto")
    found = at_once([plain(curve).part for curve in curves], model, Settings(quick=True))
    for curve, many in zip(curves, found, strict=True):
        one = fit_model(curve, model, free, Settings()).estimates["layers[0].young"]
        assert abs(np.exp(many.x[0]) - one.value) < 0.01 * one.stderr


def test_what_is_not_plain_is_fitted_alone():
    """A dip, saturation, few readings, a calibration: left out here, and the batch says of each what a fit says."""
    kind, rng = KINDS["bead on half-space"], np.random.default_rng(8)
    some = [laboratory_curve(kind, rng, tilted=False) for _ in range(20)]
    plain = min((c for c in some if c.segment is None), key=lambda c: np.std(c.force[:50]) / np.ptp(c.force))
    top = np.ptp(plain.force)
    n = plain.force.size
    dip = plain.force.copy()
    lowest = int(np.argmax(plain.force > plain.force.min() + 0.3 * top))
    dip[lowest - 60 : lowest] -= 0.3 * top
    odd = {
        "dip": dataclasses.replace(plain, force=dip),
        "saturated": dataclasses.replace(plain, force=np.minimum(plain.force, plain.force.min() + 0.5 * top)),
        "steps": dataclasses.replace(plain, force=np.round(plain.force / (0.05 * top)) * 0.05 * top),
        "turned": dataclasses.replace(plain, depth=-plain.depth),
        "few": plain.taken(slice(None, None, max(n // 100, 1))),
        "calibrated": dataclasses.replace(plain, meta={"calibration": {"spring_constant": 0.1}}),
    }
    free = as_free(kind.free)
    settings = Settings(quick=True)
    model = model_of(Sample(kind.start, kind.tip), free, "auto")
    rows = plain_rows(list(odd.values()), model, free, settings)
    # a sign that is turned, and steps, change nothing else
    assert [row is None for row in rows] == [name not in ("turned", "steps") for name in odd]
    batch = fit_batch([plain, *odd.values()], kind.start, kind.tip, kind.free, workers=1)
    reasons = [row["reason"] for row in batch.rows]
    assert "dips" in reasons[1]
    assert "saturated" in reasons[2]
    assert "sign turned" in batch.rows[4]["notes"]
