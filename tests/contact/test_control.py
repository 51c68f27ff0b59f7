"""Radii that belong to depths and forces."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from flatpunch._support.checks import Array
from flatpunch.compliances import compliance
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.profile import PowerProfile
from flatpunch.contact.round.radius_search import Quantity, radius_for
from flatpunch.contact.round.round_contact import RoundContact, round_contact

BODIES = {
    "half-space": fp.HalfSpace(1.0, 0.3),
    "stiff film": fp.Medium([fp.Layer(100.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)),
    "layer": fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase()),
}


@pytest.mark.parametrize("quantity", ["depth", "force"])
@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("exponent", [1.0, 2.0], ids=["cone", "paraboloid"])
def test_radii_hardly_larger_than_wanted_are_looked_at(exponent: float, body: str, quantity: Quantity) -> None:
    kernel, profile, asked = compliance(BODIES[body]), PowerProfile(exponent, 0.3), list[float]()

    def evaluate(radius: Array) -> RoundContact:
        asked.extend(radius)
        return round_contact(kernel, profile, radius)

    wanted = np.array([0.3, 4.0, 17.9])
    aimed_at = getattr(round_contact(kernel, profile, wanted), quantity)
    radius = radius_for(evaluate, quantity, aimed_at, 0.7, np.inf)
    np.testing.assert_allclose(radius, wanted, rtol=1e-10)
    # wide contacts cost most: a decade above the guess in steps, and no step beyond the last
    assert max(asked) < 1.1 * wanted.max()


@pytest.mark.parametrize(
    "tip", [fp.Paraboloid(2.0), fp.PowerLaw(3.5, 0.2), fp.Pyramid(4, 0.3), fp.Sphere(2.0)], ids=repr
)
def test_slopes_of_mean_profiles_are_those_of_their_heights(tip: fp.indenters.Indenter) -> None:
    profile, r, step = mean_profile(tip), np.array([0.1, 0.4, 0.9]), 1e-5
    assert profile.slope(r) == pytest.approx(
        (profile.height(r + step) - profile.height(r - step)) / (2 * step), rel=1e-8
    )
