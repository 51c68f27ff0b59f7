"""Radius, area and outline between the boundary element solutions of a curve: needles that set in, contacts that come apart."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact.refined.kinks import sizes_through
from flatpunch.contact.refined.shape_curve import ShapeCurve, outlines_through, shape_curve
from flatpunch.contact.refined.solutions import correction
from flatpunch.contact.refined.splines import curve_through
from flatpunch.indenters import Cone, Pyramid
from flatpunch.indenters.geometry.edges import place_of, sectors, wedges_of
from support.known_outlines import distance

PHI = 2 * np.pi * np.arange(360) / 360
ONE = np.zeros(4, dtype=np.intp)
NO, YES = np.zeros(1, dtype=bool), np.ones(1, dtype=bool)


def _end(x: np.ndarray, onset: float = 0.0) -> np.ndarray:
    """ln of a needle's length, which more than triples within a quarter of the depth at `onset`."""
    return np.asarray(3 + 0.6 * x + 0.6 * np.tanh((x - onset) / 0.12))


def test_outlines_follow_a_needle_as_it_grows() -> None:
    nodes, x = np.linspace(-1.05, 1.15, 33), np.linspace(-0.5, 0.5, 400)

    def outlines(at: np.ndarray) -> np.ndarray:
        return np.column_stack([_end(at), 0.4 * at, 0.3 * at, 0.5 * at])

    found, plain = outlines_through(nodes, outlines(nodes), ONE), curve_through(nodes, outlines(nodes))
    wrong, unaware = (np.abs(curve(x) - outlines(x)) for curve in (found, plain))
    assert unaware[:, 0].max() > 0.004
    assert wrong[:, 0].max() < 0.35 * unaware[:, 0].max()
    # what moves with the depth alone is off by no more than a thousandth
    assert wrong[:, 1:].max() < 1e-3
    np.testing.assert_allclose(found(nodes), outlines(nodes), atol=1e-12)


def test_needles_of_each_kind_of_edge_are_followed() -> None:
    nodes, x = np.linspace(-1.05, 1.15, 33), np.linspace(-0.5, 0.8, 400)
    kinds = np.array([0, 1, 0, 1])

    def outlines(at: np.ndarray) -> np.ndarray:
        return np.column_stack([2 + _end(at), _end(at, 0.45), 0.3 * at, 0.3 * at])

    both = np.abs(outlines_through(nodes, outlines(nodes), kinds)(x) - outlines(x))
    first = np.abs(outlines_through(nodes, outlines(nodes), ONE)(x) - outlines(x))
    assert both.max() < 1.5e-3
    assert first[:, 1].max() > 3 * both[:, 1].max()


def test_needles_that_appear_at_once_do_not_turn_the_curve_back() -> None:
    nodes = np.arange(8.0)
    outlines = np.repeat(np.where(nodes < 4, 0.0, 3.0)[:, None], 4, axis=1)
    found = outlines_through(nodes, outlines, ONE)(np.linspace(0, 7, 500))
    assert np.all(np.diff(found[:, 0]) >= -1e-9)
    assert found.min() >= -1e-9
    assert found.max() <= 3 + 1e-9


def _apart(x: np.ndarray) -> np.ndarray:
    """Logarithms of radius and area that rise five times faster, and not straight, from x = 0.37 on."""
    after = np.maximum(x - 0.37, 0.0)
    return np.column_stack([0.3 * x + 4 * after - after**2, 0.5 * x + 3 * after - 0.8 * after**2])


def test_sizes_have_a_kink_where_the_contact_comes_apart() -> None:
    nodes, x = np.linspace(-1, 1.6, 14), np.linspace(-1, 1.6, 1000)
    curve = sizes_through(nodes, _apart(nodes), nodes < 0.37)
    wrong = np.abs(curve(x) - _apart(x))
    # parabolas continue exactly, and local curves hold them within a thousandth
    assert wrong[(x > nodes[6]) & (x < nodes[7])].max() < 1e-12
    assert wrong.max() < 1e-3
    gap = int(np.searchsorted(nodes, 0.37)) - 1
    assert curve.kinks[gap] == pytest.approx(0.37, abs=0.01)
    assert np.isnan(np.delete(curve.kinks, gap)).all()
    unaware = np.abs(curve_through(nodes, _apart(nodes))(x) - _apart(x))
    assert unaware.max() > 0.05
    # the rise may still hold something that the next solutions do not show
    rise = _apart(nodes[[gap + 1]]) - [0.3, 0.5] * nodes[[gap + 1]]
    assert curve.error[gap] == pytest.approx(0.1 * rise.max())
    assert np.delete(curve.error, gap).max() < 6e-3


def test_of_a_single_solution_after_a_kink_nothing_is_known() -> None:
    nodes = np.linspace(-1, 0.4, 8)
    curve = sizes_through(nodes, _apart(nodes), nodes < 0.37)
    assert np.isnan(curve.kinks).all()
    np.testing.assert_allclose(curve(nodes), _apart(nodes), atol=1e-12)
    middle = np.array([(nodes[-2] + nodes[-1]) / 2])
    np.testing.assert_allclose(curve(middle)[0], (_apart(nodes[-2:-1]) + _apart(nodes[-1:]))[0] / 2)


def test_contacts_that_join_again_have_no_kink() -> None:
    nodes, x = np.linspace(0, 2, 9), np.linspace(0, 2, 300)
    sizes = np.column_stack([np.sin(nodes), np.cos(nodes)])
    curve = sizes_through(nodes, sizes, nodes > 0.6)
    assert np.isnan(curve.kinks).all()
    np.testing.assert_allclose(curve(x), np.column_stack([np.sin(x), np.cos(x)]), atol=0.01)


def test_outlines_after_parts_have_joined_know_nothing_of_those_before() -> None:
    nodes = np.arange(8.0)
    whole = np.array([True, True, True, False, False, True, True, True])
    rows = np.where(nodes < 4, 0.1 * nodes, 5 + 0.2 * nodes)[:, None] * np.ones(6)
    rows[~whole, 2:] = np.nan
    curve = shape_curve(nodes, rows, 0.5 * nodes, np.zeros(8, dtype=bool), ONE)
    x = np.linspace(5, 7, 50)
    np.testing.assert_allclose(curve.outline(x), (5 + 0.2 * x)[:, None] * np.ones(4), atol=1e-6)


@pytest.mark.parametrize(("missed", "share"), [(1e-3, 1.0), (0.02, 0.5), (0.2, 9.999e-5)])
def test_shapes_do_not_follow_a_round_contact_that_jumps(missed: float, share: float) -> None:
    nodes = np.array([0.0, 1.0])
    curve = ShapeCurve(
        nodes,
        sizes=lambda x: np.zeros((x.size, 2)),
        outline=lambda x: np.zeros((x.size, 3)),
        steady=np.zeros_like,
        weight=np.array([1.0, 0.0]),
        error=np.zeros(1),
        kinks=np.full(1, np.nan),
    )
    x = np.array([0.0, 0.5, 1.0])
    logarithms, error = curve.blended(x, np.full(3, missed))
    np.testing.assert_allclose(logarithms[:, 0], share * missed * np.array([1.0, 0.5, 0.0]), rtol=1e-5)
    # of what following it changes, two fifths
    np.testing.assert_allclose(error, 0.4 * logarithms[:, 0])


def test_kinds_of_edges() -> None:
    knoop, square = fp.Knoop(), Pyramid(4, 0.3)
    assert sectors(square, PHI).max() == 0
    assert sectors(Cone(0.3), PHI).max() == 0
    kinds = sectors(knoop, PHI)
    assert kinds[0] != kinds[90]
    np.testing.assert_array_equal(kinds, np.roll(kinds, 180))
    assert len({place_of(square, angle) for angle, *_ in wedges_of(square)}) == 1
    assert len({place_of(knoop, angle) for angle, *_ in wedges_of(knoop)}) == 2


@pytest.mark.parametrize(
    ("ratio", "sides", "depth", "apart"),
    [
        # round contacts grow by half within this gap, and outlines that followed them were 53 % off, radii 8 %
        (50.0, 4, 2.25, False),
        # needles of five mean radii grow to thirteen within a fifth more depth: 20 %
        (100.0, 3, 1.72, False),
        # islands have just come down: radius 7 and 5 %, area 16 and 13 %
        (100.0, 3, 7.3, True),
        (10.0, 4, 3.06, True),
    ],
)
def test_stiff_films_between_solutions(ratio: float, sides: int, depth: float, apart: bool) -> None:
    film = fp.Medium([fp.Layer(ratio, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    tip = Pyramid(sides, 0.35)
    correction.cache_clear()
    depths = np.union1d(np.geomspace(depth / 6, 1.5 * depth, 100), depth)
    curve = fp.indent(film, tip, depth=depths, method="refined", tables=False)
    found = curve.isel(step=int(np.searchsorted(depths, depth)))
    # a single contact has a solution of its own
    correction.cache_clear()
    own = fp.indent(film, tip, depth=depth, method="refined", tables=False).isel(step=0)
    assert float(found.force) == pytest.approx(float(own.force), rel=1e-3)
    assert float(found.radius) == pytest.approx(float(own.radius), rel=0.015)
    assert float(found.area) == pytest.approx(float(own.area), rel=0.03)
    assert bool(np.isnan(own.contour).all()) == apart
    if not apart:
        assert distance(found.contour.values, own.contour.values) < 0.015 * float(own.radius)
