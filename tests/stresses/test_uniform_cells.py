"""Fields beside and below uniformly loaded squares: against quadrature of point forces."""

import itertools

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.stresses.axisymmetric.radial import NORMAL_ORDERS, under_pressure, under_traction
from flatpunch.stresses.axisymmetric.round_load import layered_part
from flatpunch.stresses.axisymmetric.uniform_disc import UniformDisc
from flatpunch.stresses.bodies import located
from flatpunch.stresses.one_cell import corner

BODY = fp.HalfSpace(1e9, 0.3)
FILM = fp.Medium([fp.Layer(5e9, 0.3, 1e-6)], fp.HalfSpace(1e9, 0.3))
GEL = fp.Medium([fp.Layer(5e3, 0.5, 3e-6)], fp.HalfSpace(50e9, 0.3))
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def boussinesq(x, y, z, mu, nu):
    """Stresses and displacements under a unit normal force."""
    r, s = np.sqrt(x * x + y * y + z * z), 1 - 2 * nu
    plain, bent = 1 / (r * (r + z)), (2 * r + z) / (r**3 * (r + z) ** 2)
    stress = [3 * a * a * z / r**5 - s * (z / r**3 - plain + a * a * bent) for a in (x, y)]
    stress += [3 * z**3 / r**5, 3 * y * z * z / r**5, 3 * x * z * z / r**5, 3 * x * y * z / r**5 - s * x * y * bent]
    moved = [x * z / r**3 - s * x * plain, y * z / r**3 - s * y * plain, z * z / r**3 + 2 * (1 - nu) / r]
    return np.array([-a / (2 * np.pi) for a in stress] + [a / (4 * np.pi * mu) for a in moved])


def cerruti(x, y, z, mu, nu):
    """Stresses and displacements under a unit force along x (Johnson 1985, 3.75 and 3.76)."""
    r, s = np.sqrt(x * x + y * y + z * z), 1 - 2 * nu
    d = r + z

    def bent(a):
        return 1 / (r**3 * d**2) * a + 2 * a / (r**2 * d**3)

    stress = [
        -3 * x**3 / r**5 + s * (x / r**3 - 3 * x / (r * d**2) + bent(x**3)),
        -3 * x * y * y / r**5 + s * (x / r**3 - x / (r * d**2) + bent(x * y * y)),
        -3 * x * z * z / r**5,
        -3 * x * y * z / r**5,
        -3 * x * x * z / r**5,
        -3 * x * x * y / r**5 + s * (-y / (r * d**2) + bent(x * x * y)),
    ]
    moved = [
        1 / r + x * x / r**3 + s * (1 / d - x * x / (r * d**2)),
        x * y / r**3 - s * x * y / (r * d**2),
        x * z / r**3 + s * x / (r * d),
    ]
    return np.array([a / (2 * np.pi) for a in stress] + [a / (4 * np.pi * mu) for a in moved])


def graded_rule(low, high, z):
    """Gauss nodes and weights from low to high, denser towards zero: offsets z sinh(t)."""
    nodes, weights = [], []
    cuts = [low, high] if low * high >= 0 else [low, 0.0, high]
    for a, b in itertools.pairwise(cuts):
        t = np.linspace(*np.arcsinh([a / z, b / z]), int(np.ceil(np.arcsinh(b / z) - np.arcsinh(a / z))) + 2)
        middle, half = (t[1:, None] + t[:-1, None]) / 2, np.diff(t)[:, None] / 2
        nodes.append((z * np.sinh(middle + half * NODES)).ravel())
        weights.append((half * WEIGHTS * z * np.cosh(middle + half * NODES)).ravel())
    return np.concatenate(nodes), np.concatenate(weights)


def in_half_space(load, at, mu, nu):
    """Sum over all cells of the integrals of point forces."""
    (pressure, traction), h, result = load.cells, load.spacing, np.zeros((9, at.shape[1]))
    for n, (x, y, z) in enumerate(at.T):
        for (i, j), p in np.ndenumerate(pressure):
            cx, cy = ((k - (size - 1) / 2) * h for k, size in ((j, pressure.shape[1]), (i, pressure.shape[0])))
            gx, wx = graded_rule(x - cx - h / 2, x - cx + h / 2, z)
            gy, wy = graded_rule(y - cy - h / 2, y - cy + h / 2, z)
            for value, force in ((p, boussinesq), (traction[i, j], cerruti)):
                result[:, n] += value * np.einsum("cij,i,j->c", force(gx[:, None], gy, z, mu, nu), wx, wy)
    return result


def added_by_layers(medium, load, at):
    """Sum over 16 by 16 Gauss points of each cell of small discs."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    h, radius, (ny, nx) = load.spacing, 1e-3 * load.spacing, load.cells[0].shape
    gx, gy = (((np.arange(n)[:, None] - (n - 1) / 2 + nodes / 2) * h).ravel() for n in (nx, ny))
    force = np.outer(np.tile(weights, ny), np.tile(weights, nx)) * (h / radius) ** 2 / (4 * np.pi)
    pressure, traction = ((np.kron(each, np.ones((16, 16))) * force).ravel() for each in load.cells)
    part, result = located(medium, at[2], "below")[0], np.zeros((9, at.shape[1]))
    for n, (x, y, z) in enumerate(at.T):
        dx, dy = (each.ravel() for each in np.meshgrid(x - gx, y - gy))
        places = np.hypot(dx, dy), np.full(dx.size, z), np.full(dx.size, part.layer[n])
        found, theta = layered_part(part.body, UniformDisc(radius), *places, True), np.arctan2(dy, dx)
        normal, sideways = found[: len(NORMAL_ORDERS)], found[len(NORMAL_ORDERS) :]
        result[:, n] = under_pressure(normal, theta) @ pressure + under_traction(sideways, theta) @ traction
    return result


def random_load(h, n, seed):
    rng = np.random.default_rng(seed)
    return fp.PatchLoad(1e6 * rng.random((n, n)), h, traction=0.3e6 * rng.random((n, n)))


@pytest.mark.long
@pytest.mark.parametrize(("medium", "mu", "nu"), [(BODY, 1e9 / 2.6, 0.3), (FILM, 5e9 / 2.6, 0.3), (GEL, 5e3 / 3, 0.5)])
@pytest.mark.parametrize("depth", [1e-3, 1e-2, 0.1, 1.0])
def test_stresses_beside_cells(medium, mu, nu, depth):
    """1e-6 of the largest pressure at random points; the stated error is at least the true one and at most ten times that."""
    load = random_load(0.5e-6, 2, 1)
    x, y = np.random.default_rng(2).uniform(-0.9e-6, 0.9e-6, (2, 4))
    at = np.stack([x, y, np.full(4, depth * 0.5e-6)])
    found, exact = fp.fields(medium, load, *at), in_half_space(load, at, mu, nu)
    if medium is not BODY:
        exact += added_by_layers(medium, load, at)
    off = np.abs(found.stress.values - exact[:6]).max() / load.cells[0].max()
    assert off < 1e-6
    assert off <= found.attrs["stress_error"] <= max(10 * off, 1e-11)
    np.testing.assert_allclose(found.displacement, exact[6:], atol=1e-6 * np.abs(exact[6:]).max())


@pytest.mark.parametrize("shape", [(30, 20)])
def test_many_cells_are_the_sum_of_their_corners(shape):
    """Beside and below them, at all depths; 5e-6 of the largest pressure, and the stated error within ten times the true one."""
    rng, h = np.random.default_rng(3), 1e-7
    load = fp.PatchLoad(1e6 * rng.random(shape), h, traction=0.3e6 * rng.random(shape))
    x, y = rng.uniform(-20 * h, 20 * h, (2, 100))
    z = rng.uniform(0, 20 * h, 100)
    found = fp.fields(BODY, load, x, y, z)
    exact = np.zeros((9, 100))
    gx, gy = ((np.arange(n + 1) - n / 2) * h for n in shape[::-1])
    for each, direction in zip(load.cells, (None, 0.0), strict=True):
        jumps = np.diff(np.diff(np.pad(each, 1), axis=0), axis=1)
        for n in range(100):
            exact[:, n] += (corner(*np.meshgrid(x[n] - gx, y[n] - gy), z[n], 1e9 / 2.6, 0.3, direction) * jumps).sum(
                (1, 2)
            )
    off = np.abs(found.stress.values - exact[:6]).max() / load.cells[0].max()
    assert off < 5e-6
    assert off <= found.attrs["stress_error"] <= 10 * off


def test_points_on_edges_and_corners():
    """The pressure on an edge is the mean of both sides; where a traction jumps stresses are infinite."""
    body, h = fp.HalfSpace(1e9, 0.3), 1e-6
    place = ([0.0, 0.0, -h, 0.5 * h], [0.5 * h, 0.0, 0.0, 0.0], 0.0)
    found = fp.fields(body, fp.PatchLoad([[1e6, 3e6], [1e6, 3e6]], h), *place).stress.sel(component="zz")
    np.testing.assert_allclose(found, [-2e6, -2e6, -0.5e6, -3e6], rtol=1e-9)
    pulled = fp.fields(body, fp.PatchLoad(np.ones((2, 2)), h, traction=1e5), *place)
    np.testing.assert_array_equal(np.isnan(pulled.von_mises), [False, False, True, False])
    assert "1 of 4 points have no stress" in pulled.attrs["notes"]
