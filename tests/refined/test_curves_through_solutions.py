"""What carries the refined method from one boundary element solution to the next."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.interpolate import CubicHermiteSpline
from threadpoolctl import threadpool_info

import flatpunch as fp
from flatpunch import bem
from flatpunch.bem.resources import fitting_threads
from flatpunch.compliance import compliance
from flatpunch.contact.curve import Control
from flatpunch.contact.perturbation.second_order import expansion_of
from flatpunch.contact.perturbation.series_method import controlled
from flatpunch.contact.refined.force_curve import ForceCurve, ForcePart
from flatpunch.contact.refined.method import RefinedExpansion
from flatpunch.contact.refined.reference import BASE, NOTHING
from flatpunch.contact.refined.solutions import correction
from flatpunch.contact.refined.spacing import Spacing
from flatpunch.contact.refined.splines import (
    continued,
    curve_through,
    leading,
    left_out,
    left_out_of_hermite,
    off_smoother,
    runs_of,
    settled_slopes,
)
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.indenters import Rounded, Truncated

NODES = np.array([-2.0, -1.3, -0.7, 0.1, 0.8, 1.5])


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Depths at which the refined method has boundary elements solve a contact."""
    depths: list[float] = []
    solve = bem.solve

    def counted(*args: object, **options: object) -> list[bem.Solution]:
        depths.extend(np.atleast_1d(options["depths"]).tolist())
        return solve(*args, **options)

    monkeypatch.setattr("flatpunch.contact.refined.one_solution.bem.solve", counted)
    return depths


def _bend(x: np.ndarray) -> np.ndarray:
    """A slope that goes from one to two over unit length, as force over depth does."""
    return np.log(np.exp(x) + np.exp(2 * x))


def _rate(x: np.ndarray) -> np.ndarray:
    return 1 + 1 / (1 + np.exp(-x))


def test_estimate_covers_the_error_of_curves_through_values_and_slopes() -> None:
    values, slopes = _bend(NODES), _rate(NODES)
    wrong = left_out_of_hermite(NODES, values, slopes, np.zeros(NODES.size))
    x = np.linspace(NODES[0], NODES[-1], 500)
    true = np.abs(CubicHermiteSpline(NODES, values, slopes)(x) - _bend(x))
    upper = np.clip(np.searchsorted(NODES, x), 1, NODES.size - 1)
    told = 2 * np.maximum(wrong[upper - 1], wrong[upper])
    assert np.all(true <= told)
    assert told.max() < 20 * true.max()


def test_two_solutions_tell_nothing() -> None:
    assert np.all(np.isinf(left_out_of_hermite(NODES[:2], NODES[:2], np.ones(2), np.zeros(2))))


@pytest.mark.parametrize("noise", [1e-5, 1e-3, 1e-1])
def test_slopes_count_by_how_well_they_are_known(noise: float) -> None:
    given = _rate(NODES) + noise * np.array([1, -1, 1, -1, 1, -1])
    settled, doubt = settled_slopes(NODES, _bend(NODES), given, noise)
    off = np.abs(settled - _rate(NODES))
    # no worse than the given ones, and far better where the values alone tell more
    assert off.max() <= 1.001 * noise
    assert np.all(doubt <= noise)
    if noise == 1e-1:
        assert off.max() < 0.3 * noise


def test_slopes_that_contradict_the_values_are_believed() -> None:
    """Five values through which a cubic happens to fit tell nothing of what lies between them; their slopes do."""
    nodes = np.arange(5.0)
    bump = 0.01 * np.sin(np.pi * nodes) ** 2
    slopes = 0.01 * np.array([0.0, 1.0, -1.0, 1.0, 0.0])
    settled, doubt = settled_slopes(nodes, bump, slopes, 1e-3)
    np.testing.assert_allclose(settled, slopes, atol=2e-4)
    assert np.all(doubt <= 1e-3)


def test_difference_to_a_smoother_curve_is_the_error_of_the_cubic_one() -> None:
    def quintic(x: np.ndarray) -> np.ndarray:
        return np.asarray(x - 0.3 * x**3 + 0.05 * x**5)

    # the smoother curve is exact, and a gap's error largest near its middle
    slopes = 1 - 0.9 * NODES**2 + 0.25 * NODES**4
    told = off_smoother(NODES, quintic(NODES), slopes)
    x = NODES[:-1, None] + np.diff(NODES)[:, None] * np.linspace(0, 1, 101)
    true = np.abs(CubicHermiteSpline(NODES, quintic(NODES), slopes)(x) - quintic(x)).max(axis=1)
    np.testing.assert_allclose(told, true, rtol=0.05)
    np.testing.assert_allclose(off_smoother(NODES[:3], quintic(NODES[:3]), slopes[:3]), true[:2], rtol=0.05)
    assert np.all(np.isinf(off_smoother(NODES[:2], quintic(NODES[:2]), slopes[:2])))


def test_a_bump_between_solutions_is_told() -> None:
    """Where leaving a solution out changes nothing by chance, the smoother curve still sees the bump."""
    nodes = np.linspace(0.0, 4.0, 5)
    values, slopes = np.zeros(5), 0.01 * np.array([0.0, 0.0, 0.0, 1.0, -1.0])
    bump = abs(CubicHermiteSpline(nodes, values, slopes)(3.5))
    assert off_smoother(nodes, values, slopes)[3] > 0.1 * bump


def test_a_rough_stretch_does_not_reach_far() -> None:
    nodes = np.arange(10.0)
    table = np.where(nodes < 6, 0.0, (-1.0) ** nodes)[:, None]
    x = np.linspace(0, 4, 41)
    assert not curve_through(nodes, table)(x).any()
    assert not left_out(nodes, table)[:3].any()
    assert np.abs(left_out(nodes, table)[7:9]).min() > 0.1


def test_estimate_covers_the_error_of_local_curves() -> None:
    nodes = np.linspace(-2, 3, 9)
    x = np.linspace(nodes[1], nodes[-2], 500)
    for function in (_bend, np.sin, lambda x: np.exp(x / 2)):
        told = np.abs(left_out(nodes, function(nodes)[:, None])[:, 0])
        upper = np.clip(np.searchsorted(nodes, x), 1, nodes.size - 1)
        assert np.all(
            np.abs(curve_through(nodes, function(nodes))(x) - function(x))
            <= 2 * np.maximum(told[upper - 1], told[upper])
        )


def test_each_gap_has_the_theory_that_is_trusted_there() -> None:
    nodes = np.arange(5.0)
    # the first theory is right up to 2 and has nothing to say beyond 3, the other is off by a little everywhere
    first = ForcePart(
        0,
        CubicHermiteSpline(nodes[:4], np.zeros(4), np.zeros(4)),
        *np.array([2 * [1e-6, 1e-6, 1e-2, np.inf]]).reshape(2, 4),
    )
    other = ForcePart(1, CubicHermiteSpline(nodes, np.zeros(5), np.zeros(5)), *np.full((2, 4), 1e-4))
    curve = ForceCurve.of(nodes, [first, other])
    # beside a gap where it errs much a theory is not trusted either
    np.testing.assert_array_equal(curve.chosen, [[0, 1, 1, 1], [1, 0, 0, 1]])
    x = np.array([0.5, 1.5, 3.5])
    theory = np.column_stack([np.full(3, 7.0), np.full(3, 7.003)])
    np.testing.assert_allclose(curve.at(x, theory), [7.0, 7.003, 7.003])
    # where two theories speak their difference counts, where one does its own estimate
    np.testing.assert_allclose(curve.estimate(x, theory), [0.7 * 0.003, 0.7 * 0.003, 1.3e-4])
    # a depth that turns back between solutions
    theory[0, 0] = np.nan
    assert curve.at(x, theory)[0] == pytest.approx(7.003)
    assert curve.estimate(x, theory)[0] == np.inf


def test_a_theory_does_not_vouch_for_itself() -> None:
    """Curves by way of the round contact and without it are the two opinions in every gap."""
    film = compliance(fp.Medium([fp.Layer(3.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)))
    depth = np.geomspace(0.1, 0.5, 12)
    for tip in (Rounded(fp.Pyramid(4, 0.5), 0.3, true_sphere=False), fp.Pyramid(4, 0.5)):
        expansion = RefinedExpansion(film, tip, 5e-4, 48)
        refined = expansion.correction
        contact = controlled(film, tip, expansion, Control("depth", depth))
        refined.at(contact, 5e-4)
        curve = refined._force_curve(tuple(sorted(refined.known)))
        assert {part.form for part in curve.parts} == {BASE, NOTHING}
        assert np.all(curve.chosen[0] != curve.chosen[1])


def test_theories_hold_up_to_the_first_gap_that_is_not_good() -> None:
    good = np.ones(5, dtype=bool)
    assert leading(good, good[1:]) == 5
    assert leading(good, np.array([True, True, False, True])) == 3
    assert leading(np.array([True, True, False, True, True]), good[1:]) == 2
    assert leading(~good, good[1:]) == 0


@pytest.mark.parametrize(
    "tip",
    [
        fp.Pyramid(4, 0.3),
        fp.EllipticParaboloid(0.4, 1.0),
        Rounded(fp.Pyramid(3, 0.4), 0.3, true_sphere=False),
        Truncated(fp.Pyramid(4, 0.4), 0.1),
    ],
    ids=["pyramid", "ellipse", "rounded", "truncated"],
)
def test_no_gap_is_wider_than_the_spacing(tip: object) -> None:
    kernel = compliance(fp.Medium([fp.Layer(1.0, 0.45, 1.0)], base=fp.RigidBase()))
    spacing = Spacing(kernel, tip, mean_profile(tip))
    first = spacing.missing(np.empty(0), -4.0, 1.0)
    assert (first[0], first[-1]) == (-4.0, 1.0)
    assert np.all(spacing.between(first) < 1.01)
    # nothing is wanted twice, nor between neighbours
    assert spacing.missing(first, -4.0, 1.0).size == 0
    inside = (first[0] + first[1]) / 2
    assert spacing.missing(first, inside, inside).size == 0
    wider = np.union1d(first, spacing.missing(first, -4.0, 2.0))
    assert set(first) < set(wider)
    assert np.all(spacing.between(wider) < 1.01)


def test_a_single_step_takes_a_single_solution(solved: list[float]) -> None:
    medium, tip = fp.Medium([fp.Layer(3.0, 0.31, 1.0)], base=fp.HalfSpace(1.0, 0.3)), fp.Pyramid(4, 0.31)
    one = fp.indent(medium, tip, depth=0.2, method=fp.Refined(cells=128))
    assert len(solved) == 1
    around = fp.indent(medium, tip, depth=0.2 * np.exp([-1e-3, 1e-3]), method=fp.BoundaryElements(grid=128))
    slope = float(np.diff(around.force)[0] / np.diff(around.depth)[0])
    # the stiffness is known to a quarter over the number of cells, both grids scatter by 1e-5 of the force
    assert float(one.stiffness[0]) == pytest.approx(slope, rel=0.01)


def test_a_few_depths_have_solutions_of_their_own(solved: list[float]) -> None:
    """So they are as good as boundary elements, whatever happens between them."""
    film, tip = fp.Medium([fp.Layer(20.0, 0.31, 1.0)], base=fp.HalfSpace(1.0, 0.3)), fp.Pyramid(4, 0.37)
    depth, options = np.array([0.3, 2.7, 1.1, 0.3]), {"method": fp.Refined(cells=96)}
    few = fp.indent(film, tip, depth=depth, **options)
    # needles on so few cells are solved anew on smaller ones
    np.testing.assert_allclose(np.unique(solved), np.unique(depth))
    correction.cache_clear()
    for step in range(3):
        alone = fp.indent(film, tip, depth=depth[step], **options)
        # the solver ends at a gap of a millionth of the depth; slopes and outlines scatter, and are evened out
        for name, scatter in (
            ("force", 1e-5),
            ("stiffness", 0.8 / 96),
            ("radius", 2e-3),
            ("area", 4e-3),
            ("contour", 4e-3),
        ):
            np.testing.assert_allclose(few[name][step], alone[name][0], rtol=scatter, err_msg=name)
        correction.cache_clear()
    # what is told is the error of the cells alone
    np.testing.assert_allclose(few.force_error, 1.2 * few.contour.max("phi") / few.radius / 96**2, rtol=1e-3)
    # a curve over the range interpolates, and takes what is known already
    solved.clear()
    fp.indent(film, tip, depth=np.geomspace(0.3, 2.7, 50), **options)
    # fourteen, and two closer ones where tongues set in
    assert 0 < len(solved) <= 16
    # a depth inside it costs nothing any more
    solved.clear()
    between = fp.indent(film, tip, depth=[0.5, 1.1], **options)
    assert not solved
    assert float(between.force[1]) == pytest.approx(float(few.force[2]), rel=1e-3)


def test_depths_that_differ_by_rounding_are_the_same(solved: list[float]) -> None:
    film = fp.Medium([fp.Layer(15.0, 0.25, 1.0)], base=fp.HalfSpace(1.0, 0.33))
    tip, depth, options = (
        Rounded(fp.Pyramid(3, 1.1), 0.3, true_sphere=False),
        np.array([0.1, 0.4, 1.25]),
        {"method": fp.Refined(cells=64)},
    )
    first = fp.indent(film, tip, depth=depth, **options)
    assert len(solved) == 3
    again = fp.indent(film, tip, depth=np.exp(np.log(depth) * (1 + 3e-15)), **options)
    np.testing.assert_allclose(again.stiffness, first.stiffness, rtol=1e-9)
    assert len(solved) == 3
    assert np.diff(np.log(np.sort(solved))).min() > 1e-6


def test_where_the_round_base_turns_back() -> None:
    """Under a film a hundred times stiffer than its base one depth belongs to several round contacts; the force has no jump."""
    film, tip = fp.Medium([fp.Layer(100.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)), fp.Pyramid(4, 0.35)
    assert expansion_of(compliance(film), tip).descent(np.geomspace(0.3, 3.0, 200)).depth_slope.min() < 0
    depth = np.geomspace(1.2, 5.0, 30)
    curve = fp.indent(film, tip, depth=depth, method=fp.Refined(cells=128))
    growth = np.diff(np.log(curve.force.values)) / np.diff(np.log(depth))
    assert growth.min() > 1.0
    assert growth.max() < 1.9
    assert np.abs(np.diff(growth)).max() < 0.15
    for step in (8, 17):
        truth = fp.indent(film, tip, depth=depth[step], method=fp.BoundaryElements(grid=256))
        # tongues are a few of 128 cells wide
        assert abs(float(curve.force[step]) / float(truth.force[0]) - 1) < 2e-3


def test_pressure_of_a_star() -> None:
    """Where the round contacts are far off, superposed punches would be off by many orders; the pressure is a solution's."""
    film, tip = fp.Medium([fp.Layer(100.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)), fp.Pyramid(4, 0.35)
    curve = fp.indent(film, tip, depth=4.0, method=fp.Refined(cells=128))
    r, phi = np.meshgrid(np.linspace(1e-3, 12.0, 1200), np.linspace(0, np.pi / 2, 721))
    p = fp.pressure(film, tip, r * np.cos(phi), r * np.sin(phi), depth=4.0, method=fp.Refined(cells=128))
    force = 4 * trapezoid(trapezoid(p * r, r[0], axis=1), phi[:, 0])
    # tongues are a cell or two wide, between whose centres the pressure is linear
    assert force == pytest.approx(float(curve.force[0]), rel=0.02)


def test_small_grids_take_one_thread_of_linear_algebra() -> None:
    def threads() -> list[int]:
        return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]

    before = threads()
    with fitting_threads(256**2):
        assert set(threads()) <= {1}
    with fitting_threads(1024**2):
        assert threads() == before
    assert threads() == before


def test_a_step_within_a_known_gap_costs_one_solution_at_most(solved: list[float]) -> None:
    tip, film = fp.Pyramid(3, 0.31), fp.Medium([fp.Layer(7.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    options = {"method": fp.Refined(cells=64, tables=False)}
    fp.indent(film, tip, depth=np.geomspace(0.01, 1.0, 30), **options)
    solved.clear()
    step = fp.indent(film, tip, depth=0.0771, **options)
    assert len(solved) <= 1
    close = fp.indent(film, tip, depth=[0.0771, 0.0772, 0.0773], **options)
    assert len(solved) <= 3
    assert float(close.force[0]) == pytest.approx(float(step.force[-1]), rel=2e-3)


def test_solutions_next_to_each_other_do_no_harm_to_curves() -> None:
    """Curves through them followed what they scatter by: estimates grew from 3e-5 to 0.1, on stiff films beyond all bounds."""
    tip, film = fp.Pyramid(4, 0.33), fp.Medium([fp.Layer(6.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    options = {"method": fp.Refined(cells=64, tables=False)}
    for share in (1.0, 1 - 1e-6, 1.0001, 1.001):
        fp.indent(film, tip, depth=0.3 * share, **options)
    for depth in (np.linspace(0.2, 0.45, 20), np.linspace(0.3, 0.3002, 20), [0.3, 0.3003, 0.301]):
        curve = fp.indent(film, tip, depth=depth, **options)
        assert float(curve.force_error.max()) < 5e-3
        assert (np.diff(curve.force.values) > 0).all()


def test_missing_outlines_are_carried_on_smoothly() -> None:
    nodes = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    table = np.column_stack([nodes, nodes, nodes**2, 1 - nodes])
    good = np.array([True, True, False, True, False])
    holes = np.where(good[:, None] | (np.arange(4) < 2), table, np.nan)
    filled = continued(nodes, holes, good)
    # three good ones tell the parabola between them, and the tangent at the last of them beyond
    np.testing.assert_allclose(filled[2], table[2])
    np.testing.assert_allclose(filled[4], [4, 4, 9 + 6, -3], rtol=1e-12)
    assert np.isfinite(continued(nodes, holes, np.array([True, False, False, False, False]))).all()


def test_runs_of_nodes() -> None:
    runs = runs_of(np.array([True, True, False, True]))
    assert [run.tolist() for run in runs] == [[0, 1], [2], [3]]
    assert [run.tolist() for run in runs_of(np.ones(3, dtype=bool))] == [[0, 1, 2]]


def test_missing_outlines_far_from_two_close_ones_stay_finite() -> None:
    nodes = np.array([0.0, 1e-3, 5.0])
    table = np.array([[0.0, 0.0], [1.0, 0.1], [np.nan, np.nan]])
    filled = continued(nodes, table, np.array([True, True, False]))
    assert np.isfinite(np.exp(filled)).all()
    assert filled[2, 0] > filled[1, 0]


@pytest.mark.parametrize("width", [1e-3, 1e-2, 0.2, 3.0])
@pytest.mark.parametrize("ratio", [1.0, 20.0])
def test_stiffness_beside_a_flat_end(ratio: float, width: float) -> None:
    """The flat is a punch, whose force is its stiffness times the depth; from depth to depth cells scatter by some 1e-3 of it."""
    correction.cache_clear()
    medium = fp.Medium([fp.Layer(ratio, 0.3, 1.0)], fp.HalfSpace(1.0, 0.3))
    depth = 1e-4 * np.geomspace(1.0, 1.0 + width, 30)
    curve = fp.indent(medium, fp.Truncated(fp.Pyramid(4, 0.3), 0.1), depth=depth, method="refined")
    np.testing.assert_allclose(curve.stiffness, curve.force / depth, rtol=5e-3)
    assert np.all(np.diff(curve.force) > 0)
