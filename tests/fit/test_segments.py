"""Approach, hold and retract of files that number or name their segments."""

import numpy as np
import pytest

from flatpunch.fit import read_curve
from flatpunch.fit.measured.approach import approach_of
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace

GEL, TIP = HalfSpace(4e3, 0.5), Paraboloid(4e-6)
RAMP, HOLD, BACK = 600, 300, 500


def hertz(depth):
    """Force on the gel, zero before the contact [N]."""
    return 4 / 3 * GEL.young / (1 - GEL.poisson**2) * np.sqrt(TIP.radius) * np.maximum(depth, 0.0) ** 1.5


def written(path, title, words, control, creep, ways):
    """A file of a ramp, a hold, and retracts to these depths; in the hold tip or force change by this share."""
    ramp, gone = np.linspace(-5e-7, 1e-6, RAMP), 1 - np.exp(-np.linspace(0, 3, HOLD))
    top = hertz(ramp[-1:])[0]
    held = {
        "load": (1e-6 * (1 + creep * gone), np.full(HOLD, top)),
        # the base moves where the depth of the tip is held
        "depth": (np.full(HOLD, 1e-6), top * (1 - abs(creep) * gone)),
    }[control]
    parts = [(ramp, hertz(ramp)), held]
    for depth in ways:
        (begin, force), share = (each[-1] for each in parts[-1]), BACK
        way = np.linspace(begin, depth, share)
        parts.append((way, hertz(way) * (force / hertz(np.array([begin]))[0])))
    depth, force = map(np.concatenate, zip(*parts, strict=True))
    noise = np.random.default_rng(1).normal(size=force.size)
    rows = zip(1e9 * depth, 1e9 * (force + 1e-3 * top * noise), strict=True)
    number = np.repeat(np.arange(len(parts)), [p[0].size for p in parts])
    lines = [f"{d:.4f}\t{f:.6f}\t{words[i]}" for (d, f), i in zip(rows, number, strict=True)]
    path.write_text("\n".join([f"depth (nm)\tforce (nN)\t{title}", *lines]), "utf-8")
    return path


@pytest.mark.parametrize(
    ("title", "words"), [("SegmentID", "0123"), ("Segment ID", "1234"), ("segment", ("a", "b", "c", "d"))]
)
@pytest.mark.parametrize("control", ["load", "depth"])
@pytest.mark.parametrize("creep", [-0.005, 0.0, 0.1])
@pytest.mark.parametrize("spring", [None, 0.05])
@pytest.mark.parametrize("ways", [(), (-5e-7,), (7e-7,), (6e-7, -5e-7)])
def test_a_hold_is_no_retract(tmp_path, title, words, control, creep, spring, ways):
    """Whether or not a retract follows it, and in how many segments."""
    path = written(tmp_path / "curve.txt", title, words, control, creep, ways)
    found = approach_of(read_curve(path, spring_constant=spring))
    assert (found.end, found.leaves) == (RAMP, RAMP + HOLD)
    assert (found.retract is None) == (not ways)
