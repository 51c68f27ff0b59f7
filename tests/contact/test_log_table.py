"""Tables of costly functions of ln a, smooth and kinked."""

import numpy as np
import pytest
from scipy.special import j0

from flatpunch.numerics.piecewise import log_table

KINK = 0.31


def smooth(a):
    return np.column_stack([a**1.5, j0(np.sqrt(a)), 1 / (1 + a)])


def smooth_slope(a):
    x = 1e-5
    return (smooth(a * np.exp(x)) - smooth(a * np.exp(-x))) / (2 * x)


def kinked(a):
    """What contacts do beyond a ring: a series in the root of the distance from it, which the value may begin with a jump."""
    s = np.sqrt(np.maximum(a / KINK - 1, 0.0))
    return smooth(a)[:, :1] + np.column_stack([s, s**3 + (a > KINK)])


def test_smooth_functions_and_their_slopes():
    table, a = log_table(smooth), np.geomspace(2e-3, 40.0, 701)
    values, slopes = table.with_slope(np.log(a))
    np.testing.assert_allclose(values, smooth(a), rtol=2e-9, atol=1e-10)
    np.testing.assert_allclose(slopes, smooth_slope(a), rtol=1e-6, atol=1e-7)


def test_kinks_cost_nothing():
    table, a = log_table(kinked, kinks=(KINK,)), np.geomspace(2e-3, 40.0, 1001)
    np.testing.assert_allclose(table.at(np.log(a)), kinked(a), rtol=1e-8, atol=1e-8)
    # right up to the kink, from either side
    beside = KINK * (1 + np.array([-1e-9, -1e-6, 1e-9, 1e-6]))
    np.testing.assert_allclose(table.at(np.log(beside)), kinked(beside), rtol=1e-8, atol=1e-7)
    without = log_table(kinked).at(np.log(a))
    assert np.abs(without - kinked(a)).max() > 1e-2


def test_slopes_beyond_a_kink():
    table, a = log_table(kinked, kinks=(KINK,)), KINK * (1 + np.geomspace(0.011, 1.0, 30))
    x = 1e-6
    expected = (kinked(a * np.exp(x)) - kinked(a * np.exp(-x))) / (2 * x)
    np.testing.assert_allclose(table.with_slope(np.log(a))[1], expected, rtol=1e-5)
    # roots begin with infinite slopes
    assert np.abs(table.with_slope(np.log(KINK * (1 + np.array([0.0, 1e-12, 1e-4]))))[1]).max() < 10.0


@pytest.mark.parametrize("reach", [0.4, 1.0, 10 ** (1 / 4), 3.7])
def test_nothing_is_asked_beyond_the_reach(reach):
    asked = []

    def sample(a):
        asked.extend(a)
        return smooth(a)

    table = log_table(sample, reach=reach)
    a = np.geomspace(0.01, reach, 50)
    np.testing.assert_allclose(table.at(np.log(a)), smooth(a), rtol=2e-9, atol=1e-10)
    assert max(asked) <= reach * (1 + 1e-12)


@pytest.mark.parametrize("reach", [0.37, 1.0, 1e-6, 10 ** (1 / 4)])
def test_nothing_but_the_reach(reach):
    """It may be one of the ends of pieces, or next to one by rounding."""
    values, slopes = log_table(lambda a: smooth(a / reach), reach=reach).with_slope(np.log(np.full(2, reach)))
    np.testing.assert_allclose(values, smooth(np.ones(2)), rtol=2e-9)
    np.testing.assert_allclose(slopes, smooth_slope(np.ones(2)), rtol=1e-6, atol=1e-8)


def test_nothing_is_asked_twice_or_far_from_what_is_read():
    asked = []

    def sample(a):
        asked.extend(a)
        return smooth(a)

    table = log_table(sample, kinks=(KINK,))
    table.at(np.log([0.2, 0.3]))
    table.at(np.log(np.geomspace(0.05, 0.9, 100)))
    before = len(asked)
    table.at(np.log(np.geomspace(0.05, 0.9, 33)))
    assert len(asked) == before == len(set(asked))
    # a quarter of a decade
    assert min(asked) > 0.05 / 1.8
    assert max(asked) < 0.9 * 1.8
