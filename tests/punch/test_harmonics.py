"""Edge functionals of the harmonics: an identity that needs no sums over the basis, and independence of the matrix's size."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.punch import punch_family
from flatpunch.punch.harmonics import Edges, harmonic_size, solve_edges

MEDIA = {
    "gel": fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase()),
    "sliding": fp.Medium([fp.Layer(1.0, 0.3, 1.0, bonded=False)], base=fp.RigidBase()),
    "film": fp.Medium([fp.Layer(1.0, 0.3, 1.0)], base=fp.HalfSpace(1e-4, 0.3)),
    "soft film": fp.Medium([fp.Layer(1.0, 0.45, 1.0)], base=fp.HalfSpace(1e4, 0.2)),
    "two layers": fp.Medium([fp.Layer(100.0, 0.3, 0.3), fp.Layer(1.0, 0.45, 1.0)], base=fp.HalfSpace(1e2, 0.3)),
}
media = pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA)
# in units of the shortest length
wide = pytest.mark.parametrize("width", [1.0, 20.0, 60.0, 200.0])


def radius(kernel, width):
    return width * 25 / kernel.cutoff


@pytest.mark.long
@media
@wide
def test_edges_stiffen_as_strengths_grow(medium, width):
    # With S_m the edge strength for the displacement r^m cos(m phi), k_(m+1) - k_m = 1/2 - d ln S_m/d ln beta: strengths need
    # no slow sums. Differences of order 4 with step 0.002.
    kernel, step = compliance(medium), 2e-3
    beta = radius(kernel, width) * np.exp(step * np.array([-2.0, -1, 0, 1, 2]))
    # digits that the responses of thin incompressible layers lose
    lost = 20 * np.finfo(float).eps * np.pi * punch_family(kernel).flat(beta[2:3])[0, 0] / step
    lower = np.array([1, 2, 9, 30])
    orders = np.unique([lower, lower + 1])
    edges = solve_edges(kernel, beta, orders)
    k = edges.stiffening(orders)[2]
    for m in lower:
        at = int(np.searchsorted(orders, m))
        strength = np.log(edges.power_edge(float(m), orders)[:, at])
        growth = (8 * (strength[3] - strength[1]) - (strength[4] - strength[0])) / (12 * step)
        assert k[at + 1] - k[at] == pytest.approx(0.5 - growth, rel=2e-9, abs=2e-9 + lost)


@pytest.mark.long
@media
@wide
def test_answers_do_not_depend_on_the_size_of_the_matrix(medium, width, monkeypatch):
    kernel, orders = compliance(medium), np.array([2, 3, 4, 40])
    beta = np.array([radius(kernel, width)])
    small = solve_edges(kernel, beta, orders)
    monkeypatch.setattr("flatpunch.punch.harmonics.SPARE", 100)
    large = solve_edges(kernel, beta, orders)
    assert small.vectors[2].shape < large.vectors[2].shape
    np.testing.assert_allclose(small.stiffening(orders), large.stiffening(orders), rtol=1e-9)
    for n in (1.0, 2.0):
        np.testing.assert_allclose(small.power_edge(n, orders), large.power_edge(n, orders), rtol=1e-10)


@media
def test_beyond_the_last_harmonic_that_feels_the_medium_is_the_half_space(medium):
    kernel = compliance(medium)
    beta = np.array([radius(kernel, 10.0)])
    highest = 2 * harmonic_size(kernel, float(beta[0]))
    orders = np.array([highest - 1, highest + 1])
    edges = solve_edges(kernel, beta, orders)
    assert highest + 1 not in edges.vectors
    last, beyond = edges.stiffening(orders)[0] - (orders - 1) / 2
    assert last == pytest.approx(beyond, abs=1e-8 * highest)
    power = edges.power_edge(2.0, orders)[0]
    np.testing.assert_allclose(power, Edges.half_space(1).power_edge(2.0, orders)[0], rtol=1e-7)
