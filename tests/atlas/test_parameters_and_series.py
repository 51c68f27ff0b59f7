"""Coordinates of parameters, nested grids, and sparse series against NumPy's own Chebyshev polynomials."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.polynomial import chebyshev

from atlas_tables import Family
from atlas_tables.build import lobatto, lobatto_transform, sparse
from atlas_tables.families import layer_on
from atlas_tables.solving import panel_edges
from flatpunch.atlas.panel import Parameter, evaluate
from flatpunch.numerics.chebyshev import NODES, polynomials

SCALES = [
    Parameter("nu", "", 0.0, 0.5),
    Parameter("ratio", "", 1e-3, 1e3, "log"),
    Parameter("nu", "", 0.0, 0.5, "upper", 1e-4),
]


@pytest.mark.parametrize("parameter", SCALES, ids=lambda p: p.scale)
def test_coordinate_there_and_back(parameter):
    x = np.linspace(-1, 1, 41)
    inside = parameter.at(x)
    assert (inside[0], inside[-1]) == (parameter.low, parameter.high)
    assert np.all(np.diff(inside) > 0)
    # 1e-11: near incompressibility the logarithm of 1 - 2 nu + 1e-4 loses four digits
    np.testing.assert_allclose(parameter.unit_coordinate(inside), x, atol=1e-11)


def test_values_outside_are_refused_with_the_range():
    with pytest.raises(ValueError, match=r"ratio = 2000 lies outside the table, which holds 0\.001 \.\.\. 1000"):
        SCALES[1].check(np.array([1.0, 2000.0]))
    with pytest.raises(ValueError, match="nu = nan"):
        SCALES[0].check(np.nan)
    # rounding of what a value was computed from is no reason to refuse it
    assert SCALES[0].check(0.5 + 1e-12) == 0.5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("x", "", 1.0, 1.0), "ascending"),
        (("x", "", 0.0, 1.0, "log"), "above zero"),
        (("x", "", 0.0, 1.0, "upper"), "shift > 0"),
        (("x", "", 0.0, 1.0, "cubic"), "scale = 'cubic'"),
    ],
)
def test_ranges_and_scales_are_checked(arguments, message):
    with pytest.raises(ValueError, match=message):
        Family("x", "", (Parameter(*arguments),), layer_on)


def test_finer_grids_keep_the_points_of_coarser_ones():
    for n in (6, 12, 24):
        assert set(lobatto(n).tolist()) <= set(lobatto(2 * n).tolist())
    x = lobatto(12)
    np.testing.assert_allclose(lobatto_transform(12) @ x**3, [0, 0.75, 0, 0.25, *[0] * 9], atol=1e-14)


def test_panels_cover_the_range_without_gaps():
    found = panel_edges(1e-3, 1e2)
    assert found[0][0] == pytest.approx(1e-3, rel=1e-14)
    assert found[-1][1] == pytest.approx(1e2, rel=1e-14)
    assert all(a[1] == b[0] for a, b in pairwise(found))
    assert panel_edges(0.5, 2.0)[0][0] <= 0.5 <= 2.0 <= panel_edges(0.5, 2.0)[-1][1]


def test_sparse_series_against_numpy():
    rng = np.random.default_rng(3)
    dense = rng.standard_normal((4, NODES, 7, 5)) * 10.0 ** rng.uniform(-6, 0, (4, NODES, 7, 5))
    x, y, z = rng.uniform(-1, 1, (3, 50))
    series = sparse(dense, 0.0)
    expected = np.array([chebyshev.chebval3d(x, y, z, part) for part in dense])
    weights = rng.standard_normal(4)
    # rounding of sums of a thousand terms of order one
    np.testing.assert_allclose(evaluate(series.combined(weights), x, (y, z)), weights @ expected, atol=1e-12)
    one = series.over_beta((y[0], z[0]))
    np.testing.assert_allclose(polynomials(x[:1], NODES - 1).T @ one, expected[:, :1].T, atol=1e-12)


def test_what_is_dropped_is_below_the_cutoff():
    dense = np.random.default_rng(4).standard_normal((2, NODES, 3)) * 1e-3
    series = sparse(dense, 1e-3)
    assert series.value.size == np.count_nonzero(np.abs(dense) >= 1e-3)
    assert np.abs(series.value).min() >= 1e-3
