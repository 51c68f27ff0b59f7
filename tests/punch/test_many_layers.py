"""Many layers and thin skins: interpolated recursion, smooth half of the far integrals, limits of what is resolved."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliance import compliance
from flatpunch.compliance.layered import layered_response
from flatpunch.punch import matrix
from flatpunch.punch.harmonics import solve_edges
from flatpunch.punch.wavenumbers import bessel_table


def random_stack(rng, layers):
    """Layers of modulus ratios up to 100, some sliding, on an elastic or rigid base."""
    stack = [
        fp.Layer(
            young=float(10 ** rng.uniform(-1, 1)),
            poisson=float(rng.uniform(0, 0.5)),
            thickness=float(rng.uniform(0.5, 2)),
            bonded=bool(rng.uniform() < 0.85),
        )
        for _ in range(layers)
    ]
    return fp.Medium(stack, base=fp.HalfSpace(1.0, 0.3) if rng.uniform() < 0.6 else fp.RigidBase())


@pytest.mark.parametrize("layers", [5, 20, 100])
def test_interpolated_response_is_that_of_the_recursion(layers):
    medium = random_stack(np.random.default_rng(layers), layers)
    kernel = compliance(medium)
    kappa = np.geomspace(1e-5 / layers, 40.0, 400)
    # 1e-10: the target of C(k) for any number of layers; pieces end at 2e-12
    np.testing.assert_allclose(kernel.response(kappa), layered_response(medium, kappa / kernel.length), rtol=1e-10)


@pytest.mark.parametrize(("layers", "beta"), [(1, 50.0), (3, 100.0), (30, 60.0)])
def test_the_smooth_half_of_far_integrals_is_enough(layers, beta, monkeypatch):
    kernel = compliance(random_stack(np.random.default_rng(7 * layers), layers))
    radii, orders = np.array([beta]), np.array([1, 2, 3, 4, 12, 40])
    terms = matrix.sufficient_terms(kernel, beta)
    assert matrix._table(0, terms, 0, kernel.cutoff * beta).split

    def solved():
        answers, edges = matrix.solve_round(kernel, radii, terms), solve_edges(kernel, radii, orders)
        flat = answers.flat / answers.flat[0, 0]
        return flat, answers.edge, answers.slope, edges.stiffening(orders), edges.power_edge(1.0, orders)

    split = solved()
    monkeypatch.setattr(matrix, "_table", lambda parity, n, first, needed: bessel_table(parity, n, first, needed))
    # rounding; the slope functional has weights of x = 25 beta in its integrand
    for one, other, rtol in zip(split, solved(), [1e-11, 1e-11, 1e-9, 1e-11, 1e-11], strict=True):
        np.testing.assert_allclose(one, other, rtol=rtol, atol=rtol * np.abs(other).max())


def test_a_stack_of_equal_layers_is_one_body():
    body = {"young": 2.0, "poisson": 0.3}
    medium = fp.Medium([fp.Layer(**body, thickness=0.01) for _ in range(100)], base=fp.HalfSpace(**body))
    # 1e-10: log L is interpolated to 2e-12
    assert fp.flat_punch(medium, 1.0).normalized_stiffness == pytest.approx(1.0, rel=1e-10)


def test_thin_skins_vanish_within_their_stated_error():
    base = fp.HalfSpace(1.0, 0.3)
    bare, shares = fp.flat_punch(base, 1.0).stiffness, []
    for thickness in (1e-3, 1e-4, 1e-5):
        punch = fp.flat_punch(fp.Medium([fp.Layer(0.2, 0.25, thickness)], base=base), 1.0)
        shares.append((1 - punch.stiffness / bare) / thickness)
        assert punch.error < 1e-5
        # more terms change the stiffness by no more than the stated error
        kernel, beta = compliance(fp.Medium([fp.Layer(0.2, 0.25, thickness)], base=base)), np.array([1 / thickness])
        finer = matrix.solve_round(kernel, beta, 340).flat[0, 0] / np.pi**-1
        assert abs(punch.normalized_stiffness / finer - 1) <= punch.error
    # the share of a skin is its thickness, but for the logarithm that the singular rim adds
    assert 1 < shares[1] / shares[0] < 1.5
    assert 1 < shares[2] / shares[1] < 1.5


@pytest.mark.parametrize("quantity", ["depth", "force"])
def test_ball_on_a_skin_a_hundred_thousand_times_thinner_is_a_ball_on_its_base(quantity):
    base, ball = fp.HalfSpace(1.0, 0.3), fp.Paraboloid(1.0)
    bare = fp.indent(base, ball, **{quantity: 1.0})
    thickness = 1e-5 * float(bare.radius[0])
    coated = fp.indent(fp.Medium([fp.Layer(3.0, 0.25, thickness)], base=base), ball, **{quantity: 1.0})
    # a film's share is h/a times a contrast of order 1
    np.testing.assert_allclose(coated.force[0] / bare.force[0], 1.0, atol=3e-5)
    np.testing.assert_allclose(coated.depth[0] / bare.depth[0], 1.0, atol=3e-5)
