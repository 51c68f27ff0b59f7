"""What carries the refined method from one boundary element solution to the next."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid
from threadpoolctl import threadpool_info

import flatpunch as fp
from flatpunch import bem
from flatpunch.bem.resources import fitting_threads
from flatpunch.compliances import compliance
from flatpunch.contact.perturbation.second_order import expansion_of
from flatpunch.contact.refined.interpolation import Interpolation, RoundReference, settled
from flatpunch.contact.refined.refinement import Gap, refinement, shape_difference
from flatpunch.contact.refined.sample import Sample
from flatpunch.indenters import Rounded


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Depths at which the refined method has boundary elements solve a contact."""
    depths: list[float] = []
    solve = bem.solve

    def counted(*args: object, **options: object) -> list[bem.Solution]:
        depths.extend(np.atleast_1d(options["depths"]).tolist())
        return solve(*args, **options)

    monkeypatch.setattr("flatpunch.contact.refined.sample.bem.solve", counted)
    return depths


def test_a_single_step_takes_a_single_solution(solved: list[float]) -> None:
    medium, tip = fp.Medium([fp.Layer(3.0, 0.31, 1.0)], base=fp.HalfSpace(1.0, 0.3)), fp.Pyramid(4, 0.31)
    one = fp.indent(medium, tip, depth=0.2, method=fp.Refined(cells=128))
    assert len(solved) == 1
    around = fp.indent(medium, tip, depth=0.2 * np.exp([-1e-3, 1e-3]), method=fp.BoundaryElements(grid=128))
    slope = float(np.diff(around.force)[0] / np.diff(around.depth)[0])
    # the stiffness is known to a quarter over the number of cells, both grids scatter by 1e-5 of the force
    assert float(one.stiffness[0]) == pytest.approx(slope, rel=0.01)


@pytest.mark.long
def test_a_few_depths_have_solutions_of_their_own(solved: list[float]) -> None:
    """So they are as good as boundary elements, whatever happens between them."""
    film, tip = fp.Medium([fp.Layer(20.0, 0.31, 1.0)], base=fp.HalfSpace(1.0, 0.3)), fp.Pyramid(4, 0.37)
    depth, options = np.array([0.3, 2.7, 1.1, 0.3]), {"method": fp.Refined(cells=96)}
    few = fp.indent(film, tip, depth=depth, **options)
    # narrow lobes on so few cells are solved again on smaller ones
    np.testing.assert_allclose(np.unique(solved), np.unique(depth))
    refinement.cache_clear()
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
        refinement.cache_clear()
    # the estimate is the error of so few cells alone
    assert 0 < few.force_error.min() <= few.force_error.max() < 2e-3
    # a curve over the range interpolates, and takes what is known already
    solved.clear()
    fp.indent(film, tip, depth=np.geomspace(0.3, 2.7, 50), **options)
    assert 0 < len(solved) <= 20
    # a depth inside it costs nothing any more
    solved.clear()
    between = fp.indent(film, tip, depth=[0.5, 1.1], **options)
    assert not solved
    assert float(between.force[1]) == pytest.approx(float(few.force[2]), rel=1e-3)


def test_depths_that_differ_by_rounding_are_the_same(solved: list[float]) -> None:
    film = fp.Medium([fp.Layer(15.0, 0.25, 1.0)], base=fp.HalfSpace(1.0, 0.33))
    tip, depth, options = (
        Rounded(fp.Pyramid(3, 1.1), 0.3),
        np.array([0.1, 0.4, 1.25]),
        {"method": fp.Refined(cells=64)},
    )
    first = fp.indent(film, tip, depth=depth, **options)
    assert len(solved) == 3
    again = fp.indent(film, tip, depth=np.exp(np.log(depth) * (1 + 3e-15)), **options)
    np.testing.assert_allclose(again.stiffness, first.stiffness, rtol=1e-9)
    assert len(solved) == 3
    assert np.diff(np.log(np.sort(solved))).min() > 1e-6


@pytest.mark.long
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
        # narrow lobes are a few of 128 cells wide
        assert abs(float(curve.force[step]) / float(truth.force[0]) - 1) < 2e-3


def test_pressure_of_a_star() -> None:
    """Where the round contacts are far off, superposed punches would be off by many orders; the pressure is a solution's."""
    film, tip = fp.Medium([fp.Layer(100.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)), fp.Pyramid(4, 0.35)
    curve = fp.indent(film, tip, depth=4.0, method=fp.Refined(cells=128))
    r, phi = np.meshgrid(np.linspace(1e-3, 12.0, 1200), np.linspace(0, np.pi / 2, 721))
    p = fp.pressure(film, tip, r * np.cos(phi), r * np.sin(phi), depth=4.0, method=fp.Refined(cells=128))
    force = 4 * trapezoid(trapezoid(p * r, r[0], axis=1), phi[:, 0])
    # narrow lobes are a cell or two wide, between whose centres the pressure is linear
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


@pytest.mark.long
def test_a_step_within_a_known_gap_costs_one_solution_at_most(solved: list[float]) -> None:
    tip, film = fp.Pyramid(3, 0.31), fp.Medium([fp.Layer(7.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    options = {"method": fp.Refined(cells=64)}
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
    options = {"method": fp.Refined(cells=64)}
    for share in (1.0, 1 - 1e-6, 1.0001, 1.001):
        fp.indent(film, tip, depth=0.3 * share, **options)
    for depth in (np.linspace(0.2, 0.45, 20), np.linspace(0.3, 0.3002, 20), [0.3, 0.3003, 0.301]):
        curve = fp.indent(film, tip, depth=depth, **options)
        assert float(curve.force_error.max()) < 5e-3
        assert (np.diff(curve.force.values) > 0).all()


@pytest.mark.long
@pytest.mark.parametrize(
    ("ratio", "width"),
    [(1.0, 1e-3), (20.0, 0.2), *(pytest.param(*each, marks=pytest.mark.slow) for each in ((20.0, 1e-2), (1.0, 3.0)))],
)
def test_stiffness_beside_a_flat_end(ratio: float, width: float) -> None:
    """The flat is a punch, whose force is its stiffness times the depth; from depth to depth cells scatter by some 1e-3 of it."""
    refinement.cache_clear()
    medium = fp.Medium([fp.Layer(ratio, 0.3, 1.0)], fp.HalfSpace(1.0, 0.3))
    depth = 1e-4 * np.geomspace(1.0, 1.0 + width, 30)
    curve = fp.indent(medium, fp.Truncated(fp.Pyramid(4, 0.3), 0.1), depth=depth, method="refined")
    np.testing.assert_allclose(curve.stiffness, curve.force / depth, rtol=5e-3)
    assert np.all(np.diff(curve.force) > 0)


def _samples(x: np.ndarray, force: np.ndarray, growth: np.ndarray, radius: np.ndarray) -> tuple[Sample, ...]:
    return tuple(
        Sample(f, g, np.full(14, r), 1e-5, 1e-2)
        for f, g, r in zip(force.tolist(), growth.tolist(), radius, strict=True)
    )


def test_interpolation_has_values_and_slopes_of_its_samples() -> None:
    film = fp.Medium([fp.Layer(3.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    reference = RoundReference(compliance(film), fp.Pyramid(4, 0.3))
    x = np.linspace(-3.0, 0.0, 5)
    force, growth, radius = reference.at(x)
    samples = _samples(x, force + 0.1 * x**2, growth + 0.2 * x, radius + 0.05 * x)
    curve = Interpolation(reference, x, samples, np.full((4, 2), 1e-3))
    found = curve.at(x)
    np.testing.assert_allclose(found.force, force + 0.1 * x**2, atol=1e-12)
    np.testing.assert_allclose(found.growth, growth + 0.2 * x, atol=1e-10)
    np.testing.assert_allclose(found.force_error, 1e-5)
    # between and below them
    between = np.array([-5.0, -2.9, -0.4])
    found = curve.at(between)
    round_force, round_growth, round_radius = reference.at(between)
    np.testing.assert_allclose(found.force - round_force, 0.1 * np.maximum(between, -3.0) ** 2, atol=1e-9)
    np.testing.assert_allclose(found.growth - round_growth, 0.2 * between * (between > -3), atol=1e-9)
    np.testing.assert_allclose(found.shape[:, 5] - round_radius, 0.05 * np.maximum(between, -3.0), atol=1e-9)
    # the second is 0.1/0.75 of its gap from a solution, and a quarter has the whole error
    np.testing.assert_allclose(found.force_error, [1e-5, 0.1 / 0.75 * 4e-3 + 1e-5, 1e-3 + 1e-5])
    # and back
    for quantity, values in (("force", found.force), ("radius", found.shape[:, 0])):
        np.testing.assert_allclose(curve.positions(quantity, values), between, atol=1e-6)


def test_an_error_that_all_slopes_share_shows_at_the_middle() -> None:
    """Forces at the middle of a gap do not show it; the estimate of both halves covers it."""
    film = fp.Medium([fp.Layer(3.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    reference = RoundReference(compliance(film), fp.Pyramid(4, 0.3))
    x, fine, bias = np.array([-1.2, -0.6, 0.0]), np.linspace(-1.2, 0.0, 101), 3e-3
    force, growth, radius = reference.at(x)
    samples = _samples(x, force, growth + bias, radius)
    wide = Interpolation(reference, x[[0, 2]], (samples[0], samples[2]), np.zeros((1, 2))).at(x[1:2])
    assert abs(float(wide.force[0]) - force[1]) < 1e-12
    slope = abs(float(wide.growth[0]) - samples[1].growth) * 0.6
    curve = Interpolation(reference, x, samples, np.zeros((2, 2))).at(fine)
    true = np.abs(curve.force - reference.at(fine)[0]).max()
    assert true < Gap(-1.2, -0.6, 0.0, slope, 0.0).missed[0] < 10 * true


def test_distance_of_shapes() -> None:
    phi = 2 * np.pi * np.arange(360) / 360
    circle, moved = np.zeros(362), np.concatenate([[0.0, 0.0], np.log(1 + 0.01 * np.cos(3 * phi))])
    assert shape_difference(moved, circle) == pytest.approx(0.01, rel=1e-3)
    # without an outline mean radii count
    apart = np.where(np.arange(362) < 2, 0.2, np.nan)
    assert shape_difference(apart, circle) == pytest.approx(0.2)


def test_close_solutions_that_scatter_do_not_spoil_slopes() -> None:
    nodes, slopes, errors = np.array([0.0, 1e-3, 2e-3]), np.ones(3), np.full(3, 5e-3)
    scattered = nodes + 1e-3 * np.array([1.0, -1.0, 1.0])
    found = settled(nodes, scattered, slopes, errors)
    np.testing.assert_allclose(np.diff(found) / np.diff(nodes), 1.0, atol=0.01)
    assert np.abs(found - scattered).max() < 5e-3 / 3
    # beyond a third of their errors values are not moved, whatever the slopes between them
    kinked = settled(nodes, 1e3 * scattered, slopes, errors)
    assert np.abs(kinked - 1e3 * scattered).max() == pytest.approx(5e-3 / 3, rel=1e-9)
    # what is known stays, and so does what lies far apart
    np.testing.assert_allclose(settled(nodes, scattered, slopes, np.full(3, 1e-9)), scattered, atol=1e-8)
    wide = np.array([0.0, 1.2, 2.4])
    np.testing.assert_allclose(settled(wide, wide**1.5, slopes, np.full(3, 1e-4)), wide**1.5, atol=1e-6)
