"""The family over the radius against direct solves, at random radii and at the seams of its panels."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.punch import punch_family
from flatpunch.punch.matrix import solve_round, sufficient_terms

H = 1e-6
MEDIA = {
    "gel": fp.Medium([fp.Layer(5e3, 0.5, H)], base=fp.RigidBase()),
    "sliding": fp.Medium([fp.Layer(5e3, 0.3, H, bonded=False)], base=fp.RigidBase()),
    "soft": fp.Medium([fp.Layer(1e5, 0.4, H)], base=fp.HalfSpace(1e9, 0.3)),
    "hard": fp.Medium([fp.Layer(1e13, 0.3, H)], base=fp.HalfSpace(1e9, 0.3)),
    "equal": fp.Medium([fp.Layer(1e9, 0.3, H)], base=fp.HalfSpace(1e9, 0.3)),
    "seven": fp.Medium(
        [fp.Layer(10.0 ** (8 + i % 3), 0.08 * i, H * (1 + i % 2), bonded=i != 3) for i in range(7)],
        base=fp.HalfSpace(5e9, 0.2),
    ),
}
media = pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA)


def compare(medium, betas):
    kernel = compliance(medium)
    responses = punch_family(kernel).at(betas)
    for i, beta in enumerate(betas):
        terms = sufficient_terms(kernel, beta)
        direct = solve_round(kernel, np.array([beta]), terms)
        stiffness = np.pi * direct.flat[0, 0]
        # target 1e-10; rounding of thin incompressible layers, eps Kbar, on top
        allowed = 1e-10 + 20 * np.finfo(float).eps * stiffness
        assert np.pi * responses.flat[i, 0] == pytest.approx(stiffness, rel=allowed)
        strength = 1 + np.pi * direct.edge[0, 0]
        assert 1 + np.pi * responses.edge[i, 0] == pytest.approx(strength, rel=allowed)
        size = np.abs(direct.flat).max()
        short = min(terms, responses.flat.shape[1])
        np.testing.assert_allclose(responses.flat[i, :short], direct.flat[0, :short], rtol=0, atol=allowed * size)


@media
def test_family_at_random_radii_equals_direct_solves(medium):
    compare(medium, 10 ** np.random.default_rng(5).uniform(-5, 1.5, 24))


@pytest.mark.long
@media
def test_family_at_the_seams_of_its_panels(medium):
    # panels end at half decades; for small contacts at decades, for large ones at eighths of a decade
    seams = 10.0 ** np.concatenate([np.arange(-8, 0) / 2, np.arange(20) / 8])
    betas = np.concatenate([seams * (1 - 1e-13), seams, seams * (1 + 1e-13)])
    compare(medium, betas)
    responses = punch_family(compliance(medium)).at(betas).flat[:, 0].reshape(3, -1)
    # both sides of a seam agree to what the panels leave and the medium's rounding
    kbar = np.pi * responses[1].max()
    np.testing.assert_allclose(responses[0], responses[2], rtol=1e-10 + 20 * np.finfo(float).eps * kbar)


@media
def test_order_and_company_of_radii_do_not_matter(medium):
    family = punch_family(compliance(medium))
    betas = np.array([3.0, 1e-3, 0.0, 20.0, 0.5, 1e-20])
    together = family.at(betas)
    for i, beta in enumerate(betas):
        alone = family.at(np.array([beta]))
        width = alone.flat.shape[1]
        np.testing.assert_allclose(together.flat[i, :width], alone.flat[0], rtol=1e-14, atol=1e-18)
        # padded with zeros: contacts that need fewer terms
        assert not together.flat[i, width:].any()


@media
def test_the_passage_to_the_half_space_is_smooth(medium):
    # Below beta = 1e-16 the family returns the half-space; Kbar - 1 is of the order of the contrast times beta.
    kbar = np.pi * punch_family(compliance(medium)).at(np.array([0.9e-16, 1.1e-16, 1e-12])).flat[:, 0]
    assert kbar[0] == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(kbar[1], 1, rtol=0, atol=1e-12)
    np.testing.assert_allclose(kbar[2], 1, rtol=0, atol=1e-8)


@media
def test_reported_interpolation_error_is_honest(medium):
    kernel = compliance(medium)
    family = punch_family(kernel)
    for beta in (0.02, 0.7, 4.0, 25.0):
        radii = beta * np.exp(np.linspace(-0.3, 0.3, 5))
        error = family.error(radii)[0]
        assert error < 1e-10
        direct = np.array([solve_round(kernel, np.array([b]), sufficient_terms(kernel, b)).flat[0, 0] for b in radii])
        worst = np.abs(family.at(radii).flat[:, 0] / direct - 1).max()
        # the tail is relative to the largest coefficient on the panel, and K varies by 30 over half a decade (beta^3)
        kbar = np.pi * direct.max()
        assert worst <= 30 * error + 20 * np.finfo(float).eps * max(kbar, 10)


def test_refuses_what_it_cannot_resolve_and_says_why():
    kernel = compliance(MEDIA["gel"])
    punch_family(kernel)
    with pytest.raises(ValueError, match=r"3e\+05 times the shortest length of the medium; up to 200000 of them"):
        punch_family(kernel).at(np.array([0.1, 3e5]))
