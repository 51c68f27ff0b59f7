"""Gauss-Legendre rules of any number of points."""

import numpy as np
import pytest
from mpmath import mp
from numpy.polynomial import legendre

from flatpunch.numerics.gauss import gauss


@pytest.mark.parametrize("nodes", [1, 2, 99, 100, 101, 102, 257, 500, 1501, 10_000])
def test_rules_are_exact_for_their_polynomials(nodes):
    x, w = gauss(nodes)
    assert x.shape == w.shape == (nodes,)
    assert (np.diff(x) > 0).all()
    np.testing.assert_array_equal(x, -x[::-1])
    for power in {0, (nodes - 1) // 2 * 2, 2 * nodes - 2}:
        # rounding of the points, which a power multiplies
        assert x**power @ w == pytest.approx(2 / (power + 1), rel=1e-15 * (power + 300))
    # a pole as near to the end as this number of points resolves
    d = 300 / nodes**2
    assert nodes < 90 or (1 / (1 + d - x)) @ w == pytest.approx(np.log((2 + d) / d), rel=1e-11)


@pytest.mark.parametrize("nodes", [101, 128, 301])
def test_points_and_weights_to_the_last_digits(nodes):
    x, w = gauss(nodes)
    np.testing.assert_allclose(x, legendre.leggauss(nodes)[0], atol=3e-16)
    with mp.workdps(40):
        for i in (0, 1, nodes // 3):
            node = mp.findroot(lambda t: mp.legendre(nodes, t), mp.mpf(float(x[i])))
            weight = 2 * (1 - node**2) / (nodes * mp.legendre(nodes - 1, node)) ** 2
            assert w[i] == pytest.approx(float(weight), rel=1e-12)


def test_far_too_many_points_are_refused():
    with pytest.raises(ValueError, match=r"its integrals need 1e\+06 points; 10 000 are the most"):
        gauss(1_000_000)
