"""Curves as laboratories record them, with known truth: no bias, and intervals that hold it in 95 % of the cases.

Random offset, tilt, noise (0.25 to 2 % of the rise), contact position, layout of segments. 500 of each kind with `-m slow`, the
targets of the project: bias under 0.5 %, coverage 93 to 97 %; a few of each kind otherwise.
"""

import numpy as np
import pytest
from scipy.stats import binom

from flatpunch.fits import fit
from support.laboratory_curves import KINDS, laboratory_curve, truth

BIASED = ("modulus and thickness",)
"""The valley between two parameters is bent: intervals must hold the truth, mean values are no estimate of a bias."""
QUICK = [name for name in KINDS if "stick" not in name and "relaxing" not in name]


def judged(name, count, seed=7):
    """Relative deviations, deviations in standard errors, and how many intervals hold the truth, by parameter."""
    kind, rng = KINDS[name], np.random.default_rng(seed)
    right = truth(kind)
    found = {parameter: [] for parameter in right}
    for _ in range(count):
        curve = laboratory_curve(kind, rng)
        result = fit(curve, kind.start, kind.tip, kind.free, quick=True, baseline="linear", **kind.settings)
        for parameter, value in right.items():
            e = result.estimates[parameter]
            found[parameter].append((e.value / value - 1, (e.value - value) / e.stderr, e.low <= value <= e.high))
    return {parameter: np.array(rows).T for parameter, rows in found.items()}


@pytest.mark.long
@pytest.mark.parametrize("name", QUICK)
def test_a_few(name):
    """20 of a kind: mean within four standard errors of its own, and a coverage that 0.95 has with 1e-4 probability."""
    for parameter, (relative, pulls, covered) in judged(name, 20).items():
        assert abs(pulls.mean()) < 4 / np.sqrt(20), parameter
        assert binom.cdf(covered.sum(), 20, 0.95) > 1e-4, parameter
        assert np.abs(relative).max() < 0.5, parameter


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_five_hundred(name):
    for parameter, (relative, _, covered) in judged(name, 500).items():
        if name not in BIASED:
            assert abs(relative.mean()) < 0.005, parameter
        # one standard error of a share of 0.95 among 500 is 1 %
        assert 0.93 <= covered.mean() <= 0.97, parameter
