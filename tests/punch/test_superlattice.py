"""A superlattice tends to its homogenised limit as the period goes to zero: a transversely isotropic layer.

Continuity of displacements and tractions averages the layers as Backus did (J. Geophys. Res. 67 (1962) 4427): in-plane strain and
out-of-plane stress are the same in all of them,

    1/C33 = <1/(lambda + 2 mu)>,   C13/C33 = <nu/(1 - nu)>,   1/C44 = <1/mu>,   C11 - C13^2/C33 = <2 mu/(1 - nu)>.

The compliance of the limit is computed here from the field equations of such a layer, carried up in steps of kz = 1/2.
"""

import numpy as np
import pytest
from scipy.linalg import expm, schur

import flatpunch as fp
from flatpunch.compliances import Kernel, compliance
from flatpunch.punch.family import PunchFamily

THICKNESS = 2e-6
GPA = 1e9
STEEL = fp.HalfSpace(210e9, 0.3)
PAIRS = {
    "TiN and NbN": ((450e9, 0.25), (360e9, 0.3)),
    "100 to 1": ((200e9, 0.3), (2e9, 0.4)),
    "incompressible": ((50e9, 0.2), (1e9, 0.5)),
}


def superlattice(pair, periods):
    """Layers of both kinds in turn, equally thick, on steel."""
    kinds = [fp.Layer(*kind, THICKNESS / (2 * periods)) for kind in pair]
    return fp.Medium(kinds * periods, base=STEEL)


def field_matrix(bodies):
    """A of y' = A y over kz, y = (u_r, u_z, s_rz/k, s_zz/k), z downwards, stresses in GPa; averages over equal parts."""
    mu, nu = np.array([(young / GPA / (2 * (1 + nu)), nu) for young, nu in bodies]).T
    soft, ratio, plane = np.mean((1 - 2 * nu) / (2 * mu * (1 - nu))), np.mean(nu / (1 - nu)), np.mean(2 * mu / (1 - nu))
    return np.array([[0, 1, np.mean(1 / mu), 0], [-ratio, 0, 0, soft], [plane, 0, 0, ratio], [0, 0, -1, 0]])


def half_space_flexibility(matrix):
    """H in u = H s of the two solutions that decay downwards."""
    _, vectors, count = schur(matrix, output="real", sort="lhp")
    assert count == 2
    return vectors[:2, :2] @ np.linalg.inv(vectors[2:, :2])


def limit_compliance(pair, k):
    """C(k) of the homogenised layer on steel [m/Pa]."""
    # below kz = 40 nothing is felt at the surface to rounding
    depth = np.minimum(k * THICKNESS, 40.0)
    steps = int(np.ceil(2 * depth.max()))
    up = expm(-field_matrix(pair) * (depth / steps)[:, None, None])
    flexibility = np.broadcast_to(half_space_flexibility(field_matrix([(STEEL.young, STEEL.poisson)])), (k.size, 2, 2))
    for _ in range(steps):
        above = up @ np.concatenate([flexibility, np.broadcast_to(np.eye(2), (k.size, 2, 2))], axis=1)
        flexibility = above[:, :2] @ np.linalg.inv(above[:, 2:])
    return -flexibility[:, 1, 1] / GPA / k


def surface_modulus(pair):
    """M of C = 2/(M k) for a half-space of the homogenised material."""
    return 2 * GPA / -half_space_flexibility(field_matrix(pair))[1, 1]


def test_the_limit_of_equal_layers_is_the_layer():
    body = (5e9, 0.35)
    k = np.geomspace(1e3, 1e8, 12)
    layer = compliance(fp.Medium([fp.Layer(*body, THICKNESS)], base=STEEL))
    np.testing.assert_allclose(limit_compliance((body, body), k), layer(k), rtol=1e-9)


def test_the_modulus_of_the_limit_is_that_of_its_closed_form():
    for pair in PAIRS.values():
        matrix = field_matrix(pair)
        c44, c33, ratio, plane = GPA / matrix[0, 2], GPA / matrix[1, 3], -matrix[1, 0], GPA * matrix[2, 0]
        c13 = ratio * c33
        c11 = plane + c13 * ratio
        closed = 2 * np.sqrt((c11 * c33 - c13**2) / c11 / (1 / c44 + 2 / (np.sqrt(c11 * c33) + c13)))
        assert surface_modulus(pair) == pytest.approx(closed, rel=1e-10)


@pytest.mark.parametrize("name", PAIRS)
def test_compliance_tends_to_the_limit(name):
    k = np.geomspace(1e4, 3e6, 7)
    limit = limit_compliance(PAIRS[name], k)
    found = [compliance(superlattice(PAIRS[name], periods))(k) for periods in (50, 100, 200)]
    errors = np.abs(np.array(found) / limit - 1).max(axis=1)
    # c1 p + c2 p^2 for a period p: halving p leaves a half to a quarter, and without these two terms the limit is left
    ratios = errors[:-1] / errors[1:]
    assert np.all((ratios > 1.95) & (ratios < 4.05))
    extrapolated = (8 * found[2] - 6 * found[1] + found[0]) / 3
    assert np.abs(extrapolated / limit - 1).max() < 0.1 * errors[2]
    assert errors[2] < 0.02


@pytest.mark.filterwarnings("ignore:The pressure under a flat punch")
@pytest.mark.parametrize("name", ["TiN and NbN", "100 to 1"])
def test_flat_punches_tend_to_the_limit(name):
    radius, modulus = 1e-6, surface_modulus(PAIRS[name])

    def response(kappa):
        # above kappa = 40 the layer is its own half-space to rounding
        low = kappa < 40
        result = np.ones_like(kappa)
        result[low] = modulus * kappa[low] / THICKNESS * limit_compliance(PAIRS[name], kappa[low] / THICKNESS) / 2
        return result

    kernel = Kernel(modulus=modulus, length=THICKNESS, response=response, floor=1e-4)
    limit = 2 * np.pi * modulus * radius * PunchFamily(kernel).flat(np.array([radius / THICKNESS]))[0, 0]
    found = np.array([fp.flat_punch(superlattice(PAIRS[name], n), radius).stiffness for n in (50, 100, 200)])
    errors = np.abs(found / limit - 1)
    # the rim feels the single layers: p ln p beside p
    assert np.all(errors[:-1] / errors[1:] > 1.7)
    assert abs((2 * found[2] - found[1]) / limit - 1) < 0.2 * errors[2]
