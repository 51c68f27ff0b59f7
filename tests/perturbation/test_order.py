"""Exact perturbation theory: known constants, and the order at which its error falls."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.compliances.power_law import stiffness_factor
from flatpunch.contact.perturbation.power_law_terms import PowerPerturbation
from flatpunch.contact.round.profile import PowerProfile
from flatpunch.contact.round.radius_search import radius_for
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.media import PowerLawHalfSpace
from flatpunch.punch.harmonics import solve_edges
from flatpunch.reference.elliptic import elliptic_paraboloid
from support.power_law_bodies import HALF_SPACE, INCOMPRESSIBLE, MEDIA, STIFF_FILM


@pytest.mark.parametrize("name", sorted(set(MEDIA) - {"half-space"}))
def test_first_harmonic_is_a_translation(name: str) -> None:
    """Moving a flat punch aside changes nothing: k_1 = 0."""
    beta = np.array([1e-6, 1.0, 5.0])
    kernel = compliance(MEDIA[name])
    gain = solve_edges(kernel, beta, np.array([1, 2])).stiffening(np.array([1, 2]))
    # both halves of the difference are sums of a hundred terms of order one
    np.testing.assert_allclose(gain[:, 0], 0, atol=1e-11)
    # a small punch feels a half-space, (m - 1)/2, up to beta
    assert gain[0, 1] == pytest.approx(0.5, abs=1e-5)


def test_half_space_constants() -> None:
    """f = r^2 exp(g cos 2 phi): R = 2/3 and chi = 5/24, those of the expansion of Hertz' ellipse."""
    g = 0.1
    tip = fp.PowerLaw(2, lambda phi: np.exp(g * np.cos(2 * phi)))
    values, _ = PowerPerturbation(compliance(HALF_SPACE), tip, 0.0, fourth=False).at(np.ones(1))
    # ln psi has a single harmonic; what is left is rounding
    assert values.swing[0] == pytest.approx(2 / 3 * g, rel=1e-12)
    assert values.x2[0] == pytest.approx(5 / 24 * g**2, rel=1e-11)


ASYMMETRIES = np.array([0.2, 0.25, 0.32, 0.4])


def _order(errors: np.ndarray) -> float:
    return float(np.polyfit(np.log(ASYMMETRIES), np.log(np.abs(errors)), 1)[0])


@pytest.mark.parametrize(("method", "order"), [("second-order", 4), ("fourth-order", 6)])
def test_error_against_exact_ellipses_falls_with_the_next_power(method: str, order: int) -> None:
    """ln F is even in the asymmetry (a turn by 90 degrees), so the next power is two higher."""
    errors = []
    for s in ASYMMETRIES:
        exact = elliptic_paraboloid(1 - s, 1 + s, HALF_SPACE.surface_modulus, depth=0.3)
        force = float(fp.indent(HALF_SPACE, fp.EllipticParaboloid(1 - s, 1 + s), depth=0.3, method=method).force[0])
        errors.append(force / exact.force - 1)
    # the power after next moves the fitted slope by up to a half at these sizes
    assert _order(np.array(errors)) == pytest.approx(order, abs=0.5)


@pytest.mark.parametrize("exponent", [0.4, -0.2])
@pytest.mark.parametrize(("method", "order"), [("second-order", 4), ("fourth-order", 6)])
def test_error_under_power_law_media_falls_as_fast(method: str, order: int, exponent: float) -> None:
    body = PowerLawHalfSpace(modulus=1.0, depth=1.0, exponent=exponent, poisson=0.3)
    constant = stiffness_factor(exponent, 0.3) * body.surface_modulus
    errors = []
    for s in ASYMMETRIES:
        exact = elliptic_paraboloid(1 - s, 1 + s, constant, depth=0.3, exponent=exponent)
        result = fp.indent(body, fp.EllipticParaboloid(1 - s, 1 + s), depth=0.3, method=method)
        errors.append(float(result.force[0]) / exact.force - 1)
        assert abs(errors[-1]) < float(result.force_error[0])
    assert _order(np.array(errors)) == pytest.approx(order, abs=0.5)


def test_outline_of_an_ellipse_is_right_to_second_order() -> None:
    """The logarithm of the outline is known to first order, its error falls with the square of the asymmetry or faster."""
    errors = []
    for s in ASYMMETRIES:
        exact = elliptic_paraboloid(1 - s, 1 + s, HALF_SPACE.surface_modulus, depth=0.3)
        result = fp.indent(HALF_SPACE, fp.EllipticParaboloid(1 - s, 1 + s), depth=0.3, method="second-order")
        errors.append(np.abs(result.contour.values[0] / exact.outline(result.phi.values) - 1).max())
    assert _order(np.array(errors)) > 1.9


def _log_force(medium: object, tip: fp.EllipticParaboloid, lam: float, depth: float) -> float:
    """ln F at a depth by the plain sum of the series in (psi^lam - 1)/lam."""
    kernel = compliance(medium)
    series = PowerPerturbation(kernel, tip, lam, fourth=True)
    base = PowerProfile(2.0, series.angles.mean)
    radius = radius_for(lambda a: round_contact(kernel, base, a), "depth", np.array([depth]), 1.0, np.inf)
    values, _ = series.at(radius)
    force = round_contact(kernel, base, radius).force[0]
    return float(np.log(force) + sum(term[0] for term in (values.x2, values.x3, values.x4)))


@pytest.mark.parametrize(
    "medium", [HALF_SPACE, INCOMPRESSIBLE, STIFF_FILM], ids=["half-space", "incompressible", "film"]
)
def test_both_expansion_variables_agree_to_sixth_order(medium: object) -> None:
    """The logarithm and the square root of psi give the same fourth-order series; they differ by sixth-order terms."""
    gaps = [
        _log_force(medium, tip, 0.0, 1.5) - _log_force(medium, tip, 0.5, 1.5)
        for tip in (fp.EllipticParaboloid(1 - s, 1 + s) for s in ASYMMETRIES)
    ]
    assert _order(np.array(gaps)) > 5.6


PYRAMIDS = {4: (0.737618803, 1.47989), 3: (0.88241, 1.77610)}
"""Sides -> F tan(alpha)/(E* d^2) and area over (d/tan)^2 on a half-space, by boundary elements at 1024 x 1024 cells: 1e-5 of
the force."""


@pytest.mark.parametrize(("sides", "method", "tolerance"), [
    (4, "second-order", 3e-3), (4, "fourth-order", 4e-4), (4, "refined", 1e-4),
    (3, "second-order", 1.2e-2), (3, "fourth-order", 1.8e-3), (3, "refined", 1e-4),
])  # fmt: skip
def test_pyramids_on_a_half_space(sides: int, method: str, tolerance: float) -> None:
    """Tolerances are the methods' own errors on sharp tips, those of refined its grid's."""
    slope = 0.4
    result = fp.indent(HALF_SPACE, fp.Pyramid(sides, np.arctan(slope)), depth=0.3, method=method)
    constant = float(result.force[0]) * slope / (HALF_SPACE.surface_modulus * 0.3**2)
    assert constant == pytest.approx(PYRAMIDS[sides][0], rel=tolerance)
    assert abs(constant / PYRAMIDS[sides][0] - 1) < float(result.force_error[0])
