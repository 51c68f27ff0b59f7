"""Compliance of one layer against the closed kernels, which are free of cancellation (flatpunch.reference.layers)."""

import numpy as np
import pytest

from flatpunch.compliances import compliance
from flatpunch.compliances.response import layered_response
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase
from flatpunch.reference import layers

KAPPA = np.geomspace(1e-4, 50, 160)
POISSON = (-0.5, 0.0, 0.3, 0.45, 0.4999, 0.5)
# measured: at most 6e-13 over all cases below; the amplification of rounding by the near-cancelling layer
# fields
RTOL = 2e-12


@pytest.mark.parametrize("poisson", POISSON)
def test_bonded_layer_on_a_rigid_base(poisson):
    medium = Medium([Layer(2.0, poisson, 1.0)], RigidBase())
    np.testing.assert_allclose(layered_response(medium, KAPPA), layers.bonded_on_rigid(KAPPA, poisson), rtol=RTOL)


@pytest.mark.parametrize("poisson", POISSON)
def test_sliding_layer_on_a_rigid_base_whatever_its_poisson_ratio(poisson):
    medium = Medium([Layer(2.0, poisson, 1.0, bonded=False)], RigidBase())
    np.testing.assert_allclose(layered_response(medium, KAPPA), layers.frictionless_on_rigid(KAPPA), rtol=RTOL)


@pytest.mark.parametrize("base_young", 10.0 ** np.arange(-4, 5))
@pytest.mark.parametrize("poisson", [-0.5, 0.2, 0.5])
@pytest.mark.parametrize("base_poisson", [0.0, 0.5])
def test_layer_on_a_half_space(poisson, base_young, base_poisson):
    base = HalfSpace(base_young, base_poisson)
    bonded = layered_response(Medium([Layer(1.0, poisson, 1.0)], base), KAPPA)
    burmister = layers.bonded_on_half_space(KAPPA, 1.0, poisson, base_young, base_poisson)
    np.testing.assert_allclose(bonded, burmister, rtol=RTOL)
    top = Layer(1.0, poisson, 1.0, bonded=False)
    sliding = layers.sliding_on_half_space(KAPPA, top.surface_modulus, base.surface_modulus)
    np.testing.assert_allclose(layered_response(Medium([top], base), KAPPA), sliding, rtol=RTOL)


def test_incompressible_bonded_layer_at_long_waves():
    # L -> (2/3) kappa^3 with a relative correction of order kappa^2, 1e-8 at most here
    kappa = np.geomspace(1e-6, 1e-4, 9)
    medium = Medium([Layer(1.0, 0.5, 1.0)], RigidBase())
    np.testing.assert_allclose(layered_response(medium, kappa), 2 / 3 * kappa**3, rtol=5e-8)


def test_kernel_returns_metres_per_pascal():
    medium = Medium([Layer(3e9, 0.3, 2e-6)], HalfSpace(70e9, 0.2))
    k = np.array([1e3, 1e5, 1e7])
    expected = 2 * layers.bonded_on_half_space(k * 2e-6, 3e9, 0.3, 70e9, 0.2) / (3e9 / (1 - 0.3**2) * k)
    np.testing.assert_allclose(compliance(medium)(k), expected, rtol=RTOL)
    np.testing.assert_allclose(compliance(HalfSpace(70e9, 0.2))(k), 2 * (1 - 0.2**2) / (70e9 * k), rtol=1e-15)
