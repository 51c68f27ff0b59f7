"""The convolution: against the direct sum, in other array libraries, and what it costs in memory."""

import tracemalloc

import array_api_compat
import numpy as np
import pytest

from flatpunch import media
from flatpunch.bem.grid import Grid
from flatpunch.bem.operator.convolution import BYTES_PER_CELL, build_operator, compliance_values
from flatpunch.bem.operator.influence import influence_coefficients
from flatpunch.bem.solver.levels import Levels
from flatpunch.bem.solver.nested import solve_depth, solve_force
from flatpunch.compliances import compliance

SOFT = compliance(media.Medium([media.Layer(1e6, 0.5, 1.0)], media.RigidBase()))
HALF_SPACE = compliance(media.HalfSpace(1e9, 0.3))


def paraboloid(grid: Grid) -> np.ndarray:
    return (grid.x**2 + grid.y[:, None] ** 2) / 2


@pytest.mark.parametrize("shape", [(8, 8), (9, 23), (16, 10)])
@pytest.mark.parametrize("kernel", [SOFT, HALF_SPACE], ids=["soft layer", "half-space"])
def test_convolution_is_the_direct_sum(shape, kernel):
    ny, nx = shape
    grid = Grid(nx, ny, 0.3)
    p = np.random.default_rng(1).random(shape)
    g = influence_coefficients(kernel, grid.spacing, shape)
    i, j = np.arange(ny), np.arange(nx)
    rows, columns = np.abs(i[:, None] - i), np.abs(j[:, None] - j)
    direct = np.einsum("abcd,bd->ac", g[rows[:, :, None, None], columns[None, None]], p)
    u = build_operator(kernel, grid).apply(p) * grid.spacing / kernel.modulus
    # the coefficients are tabulated up to the padded grid's corner, so they differ by the rounding of that table
    np.testing.assert_allclose(u, direct, rtol=0, atol=1e-13 * direct.max())


def test_operator_is_symmetric_and_its_approximate_inverse_positive():
    grid = Grid(24, 30, 0.3)
    operator = build_operator(SOFT, grid)
    rng = np.random.default_rng(2)
    p, q = rng.standard_normal((2, 30, 24))
    assert np.vdot(q, operator.apply(p)) == pytest.approx(np.vdot(p, operator.apply(q)), rel=1e-12)
    assert operator.inverse.min() > 0
    assert np.vdot(p, operator.precondition(p)) > 0


GRADED = media.Medium([media.GradedLayer(media.LinearModulus(1e9, 3e9, 1.0), 0.3, 1.0)], base=media.HalfSpace(3e9, 0.3))


@pytest.mark.parametrize(
    "medium",
    [
        media.Medium([media.Layer(1e6, 0.5, 1.0)], media.RigidBase()),
        GRADED,
        media.PowerLawHalfSpace(1e9, 1.0, 0.4, 0.3),
    ],
    ids=["soft layer", "graded", "power law"],
)
@pytest.mark.parametrize(("low", "high"), [(1e-6, 1e-3), (0.3, 0.31), (0.01, 1e7)])
def test_compliances_between_the_wavenumbers_that_operators_share(medium, low, high):
    kernel = compliance(medium)
    k = np.geomspace(low, high, 997)
    # an incompressible layer drains like k^2 there: that changes by 3 % from one of them to the next
    np.testing.assert_allclose(compliance_values(kernel, k.reshape(-1, 1)).ravel(), kernel(k), rtol=1e-4)


def test_array_api_path_gives_the_same_numbers():
    strict = pytest.importorskip("array_api_strict")
    grid = Grid(20, 31, 0.1)
    p = np.random.default_rng(3).random(grid.shape)
    usual, other = build_operator(SOFT, grid), build_operator(SOFT, grid, xp=strict)
    for name in ("apply", "precondition"):
        expected = getattr(usual, name)(p)
        found = np.asarray(getattr(other, name)(strict.asarray(p)))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("library", ["array_api_strict", "torch"])
def test_whole_solve_in_another_array_library(library):
    """Nothing but the array API standard is used, so that a GPU library works alike."""
    module = pytest.importorskip(library)
    xp = module if library == "array_api_strict" else array_api_compat.array_namespace(module.asarray(1.0))
    grid = Grid(64, 64, 2.6 / 64)
    usual, _ = solve_depth(Levels(SOFT, grid), paraboloid, 0.5, 1e-8, 200)
    other, _ = solve_depth(Levels(SOFT, grid, xp), paraboloid, 0.5, 1e-8, 200)
    assert other.converged
    # two solutions with a gap error of 1e-8 of the depth each
    assert other.force == pytest.approx(usual.force, rel=1e-7)


def test_single_precision():
    grid = Grid(64, 64, 2.6 / 64)
    usual, _ = solve_depth(Levels(HALF_SPACE, grid), paraboloid, 1.0, 1e-8, 200)
    single, _ = solve_depth(Levels(HALF_SPACE, grid, single=True), paraboloid, 1.0, 1e-5, 200)
    assert single.pressure.dtype == np.float32
    assert single.converged
    # gap error 1e-5 of the depth; the force answers with dF/F = 1.5 dd/d
    assert single.force == pytest.approx(usual.force, rel=1.5e-5)


def test_memory_per_cell():
    """All arrays of operator and solver, as the allocator of NumPy counts them."""
    # off the centre: a contact that is its own mirror image takes a quarter of this
    grid = Grid(512, 512, 2.6 / 512, (1e-3, 1e-3))
    tracemalloc.start()
    state, _ = solve_depth(Levels(HALF_SPACE, grid), paraboloid, 1.0, 1e-6, 200)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert state.converged
    assert peak < BYTES_PER_CELL * 512**2


@pytest.mark.parametrize("beta", [1, 30])
def test_memory_per_cell_by_force_on_a_layer(beta):
    """The same for a force on a layer."""
    kernel, grid = (
        compliance(media.Medium([media.Layer(1e6, 0.5, 1 / beta)], media.RigidBase())),
        Grid(512, 512, 2.6 / 512, (1e-3, 1e-3)),
    )
    tracemalloc.start()
    state, _ = solve_force(Levels(kernel, grid), paraboloid, 3e6, 0.3, 1e-6, 200)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert state.converged
    assert peak < BYTES_PER_CELL * 512**2
