"""Derivatives of C(k) by all constants of a body, against differences of order eight of C(k) itself."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances.derivatives import compliance_derivatives, energy_density

K = np.geomspace(1e-3, 60, 25)
ROUNDING = 3e-9
"""Differences of C(k), known to 1e-13, over steps of 2 % leave 1e-11; Poisson ratios are stepped by 0.002 only."""


def difference(function, value, step):
    weights = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
    return sum(w * (function(value + j * step) - function(value - j * step)) for j, w in enumerate(weights, 1)) / step


def random_stack(rng):
    count = rng.integers(1, 5)
    layers = [
        (10 ** rng.uniform(-2, 2), rng.uniform(-0.3, 0.49), 10 ** rng.uniform(-0.5, 0.5), rng.random() > 0.3)
        for _ in range(count)
    ]
    base = fp.RigidBase() if rng.random() < 0.4 else fp.HalfSpace(10 ** rng.uniform(-2, 2), rng.uniform(0, 0.5))
    return [list(each) for each in layers], base


def stack(layers, base):
    return fp.Medium([fp.Layer(e, nu, h, bool(bonded)) for e, nu, h, bonded in layers], base=base)


@pytest.mark.parametrize("seed", range(8))
def test_layers_against_differences(seed):
    layers, base = random_stack(np.random.default_rng(seed))
    medium = stack(layers, base)
    c = fp.compliance(medium)(K)
    found = compliance_derivatives(medium, K)
    for i, layer in enumerate(layers):
        ours = (found[i].constants["young"][0], found[i].constants["poisson"][0], found[i].thickness)
        for column, derivative in enumerate(ours):

            def changed(value, i=i, column=column):
                other = [list(each) for each in layers]
                other[i][column] = value
                return fp.compliance(stack(other, base))(K)

            step, scale = (2e-3, 1.0) if column == 1 else (2e-2 * layer[column], layer[column])
            theirs = difference(changed, layer[column], step)
            np.testing.assert_allclose(derivative * scale / c, theirs * scale / c, atol=ROUNDING)


@pytest.mark.parametrize("seed", range(8))
def test_moduli_add_up(seed):
    """C goes like 1/E: the sum over all of dC/dln E is -C."""
    layers, base = random_stack(np.random.default_rng(100 + seed))
    medium = stack(layers, base)
    found = compliance_derivatives(medium, K)
    young = [layer[0] for layer in layers] + ([base.young] if isinstance(base, fp.HalfSpace) else [])
    total = sum(e * part.constants["young"][0] for e, part in zip(young, found, strict=True))
    np.testing.assert_allclose(total, -fp.compliance(medium)(K), rtol=1e-10)


def test_lengths_add_up():
    """C(k) k depends on k times lengths only, so thicknesses and wavenumber have one derivative together."""
    layers, base = random_stack(np.random.default_rng(5))
    medium = stack(layers, base)
    found = compliance_derivatives(medium, K)
    by_lengths = sum(layer[2] * part.thickness for layer, part in zip(layers, found, strict=False))
    by_k = difference(lambda x: fp.compliance(medium)(K * np.exp(x)) * np.exp(x), 0.0, 1e-2)
    np.testing.assert_allclose(by_lengths, by_k, atol=1e-9 * fp.compliance(medium)(K).max())


GRADED = fp.Medium(
    [
        fp.Layer(2.0, 0.3, 0.5),
        fp.GradedLayer(fp.ExponentialModulus(1.0, 5.0, 1.0), ([0.0, 0.5, 1.0], [0.2, 0.3, 0.45]), 0.8, bonded=False),
        fp.Layer(3.0, 0.2, 0.3),
    ],
    base=fp.RigidBase(),
)


def test_graded_layers_add_up():
    """The integral over a graded layer, with its Gauss points, and the layers around it."""
    found = compliance_derivatives(GRADED, K)
    total = 2.0 * found[0].constants["young"][0] + 3.0 * found[2].constants["young"][0]
    total = total + GRADED.layers[1].young_at(found[1].depths) @ found[1].constants["young"]
    # 1e-9: the steps through graded layers
    np.testing.assert_allclose(total, -fp.compliance(GRADED)(K), rtol=3e-9)


@pytest.mark.long
def test_thickness_of_a_graded_layer():
    def thicker(h):
        middle = fp.GradedLayer(GRADED.layers[1].young, GRADED.layers[1].poisson, h, bonded=False)
        return fp.compliance(fp.Medium([GRADED.layers[0], middle, GRADED.layers[2]], base=GRADED.base))(K)

    ours = compliance_derivatives(GRADED, K)[1].thickness
    theirs = difference(thicker, 0.8, 5e-3)
    np.testing.assert_allclose(ours, theirs, atol=1e-7 * np.abs(theirs).max())


def test_energy_density_adds_up():
    """Over the depth of a half-space it is C(k)."""
    body, k = fp.HalfSpace(2.0, 0.3), np.array([1.0, 3.0])
    x, w = np.polynomial.legendre.leggauss(60)
    z = 10 * (1 + x)
    density = energy_density(body, k, z, np.zeros(z.size, dtype=int))
    np.testing.assert_allclose(density @ (10 * w), fp.compliance(body)(k), rtol=1e-9)
