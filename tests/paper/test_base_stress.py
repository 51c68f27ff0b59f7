"""Stress at the base of a sliding layer: the layered system, the limit, and two roads to the same tension."""

import numpy as np
import pytest
from scipy.linalg import expm

from flatpunch import bem
from flatpunch.contact import indent
from flatpunch.indenters import Paraboloid
from paper import base_stress
from paper.cases import kernel, medium


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.49])
@pytest.mark.parametrize("x", [0.05, 0.7, 3.0, 9.0])
def test_transfer_against_the_layered_system(x, poisson):
    """Propagate (u_r, u_z, s_rz, s_zz) through the layer and slide on the base: T does not depend on the Poisson ratio."""
    nu, mu, k = poisson, 1.0, x
    system = np.array(
        [
            [0, k, 1 / mu, 0],
            [-k * nu / (1 - nu), 0, 0, (1 - 2 * nu) / (2 * mu * (1 - nu))],
            [2 * mu / (1 - nu) * k**2, 0, 0, k * nu / (1 - nu)],
            [0, 0, -k, 0],
        ]
    )
    through = expm(system)
    # surface: s_rz = 0, s_zz = -1; base: u_z = 0, s_rz = 0
    surface = np.linalg.solve(through[1:3, :2], through[1:3, 3])
    stress = through @ np.array([*surface, 0.0, -1.0])
    # expm holds terms of e^x beside a result of e^-x: 1e-14 e^(2x) of it is lost
    assert -stress[3] == pytest.approx(float(base_stress.transfer(x)), rel=1e-13 * np.exp(2 * x) + 1e-13)


def test_transfer_at_both_ends():
    # T = 1 - x^4/45 + ..., and 2 (1 + x) e^-x far out
    assert base_stress.transfer(0.0) == 1.0
    assert base_stress.transfer(1e-9) == pytest.approx(1.0, abs=1e-15)
    assert base_stress.transfer(40.0) == pytest.approx(2 * 41 * np.exp(-40.0), rel=1e-12)


@pytest.mark.parametrize("radius", [0.5, 3.0])
def test_two_roads(radius):
    """Hankel transforms of the exact round contact, and Fourier transforms of a boundary element pressure."""
    exact = base_stress.under_round(radius)
    depth = float(indent(medium("unbonded"), Paraboloid(1.0), radius=radius).depth[0])
    (solution,) = bem.solve(kernel("unbonded"), Paraboloid(1.0), depths=[depth], grid=128, tolerance=1e-6)
    found = base_stress.under_cells(solution.pressure, solution.grid.spacing)
    # cells: peak and radius to 0.3 %, and the place to a block of cells
    assert found["base_tension"] == pytest.approx(exact.tension, rel=5e-3)
    assert found["base_pull"] == pytest.approx(exact.pull, rel=1e-2)
    assert found["base_where"] == pytest.approx(exact.where, abs=0.15)


def test_wide_contacts_hand_their_pressure_through():
    """Deep inside a wide contact the base carries what presses on the surface: T(0) = 1."""
    found = base_stress.under_round(10.0)
    # the stress at the first node (r = 0.01 h) differs from that at r = 0 by (r/a)^2 = 1e-6
    assert found.stress[0] == pytest.approx(1.0, abs=2e-6)
