"""Notes of the perturbation methods name the cause; results stay finite where the series ends."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from support.power_law_bodies import HALF_SPACE, INCOMPRESSIBLE, Disguised

FILM_10 = fp.Medium([fp.Layer(10.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
FILM_100 = fp.Medium([fp.Layer(100.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))


def _notes(medium: object, tip: object, **control: float) -> str:
    return str(fp.indent(medium, tip, method="second-order", **control).attrs["notes"])


def test_mild_tips_have_no_notes() -> None:
    assert _notes(INCOMPRESSIBLE, fp.EllipticParaboloid(0.5, 1.0), depth=0.03) == ""
    # of a sharp tip the force is well known, and the outline less so
    assert _notes(INCOMPRESSIBLE, fp.Pyramid(4, 0.3), depth=0.3) == (
        "At depths of 300 mm and more: the outline is expected to be off by up to 31 % of the mean radius."
    )


def test_strong_asymmetry_and_edges() -> None:
    note = _notes(HALF_SPACE, fp.Pyramid(3, 0.3), depth=0.3)
    assert "strongly asymmetric" in note
    assert "sharp edges" in note
    assert "film" not in note


def test_stiff_film() -> None:
    assert "a stiff film" in _notes(FILM_10, fp.Pyramid(4, 0.3), radius=1.0)


def test_negative_pressure() -> None:
    # the cone of this film pulls inside from a/h = 2 on
    assert "pressure is negative" in _notes(
        FILM_100, fp.PowerLaw(1, lambda phi: 0.3 + 1e-3 * np.cos(2 * phi)), radius=3.0
    )


@pytest.mark.long
@pytest.mark.parametrize("method", ["first-order", "second-order", "fourth-order", "refined", "bem"])
def test_steep_faces(method: str) -> None:
    configured = fp.BoundaryElements(grid=32) if method == "bem" else method
    for inclination, steep in ((50, True), (20, False)):
        # in the table of large strains a number takes the place of the slope
        for poisson, words in ((0.3, "inclined by up to"), (0.5, "a neo-Hookean solid takes")):
            medium = fp.HalfSpace(young=1.0, poisson=poisson)
            curve = fp.indent(medium, fp.Pyramid(4, np.radians(inclination)), depth=0.3, method=configured)
            assert (words in curve.attrs["notes"]) == steep


@pytest.mark.long
@pytest.mark.parametrize("method", ["second-order", "fourth-order"])
@pytest.mark.parametrize("tip", [fp.Pyramid(4, 0.3), fp.EllipticParaboloid(0.1, 1.0)])
def test_results_stay_finite_through_the_turning_point(tip: object, method: str) -> None:
    """Under a film 100 times stiffer the depth turns back, where the outline response has a pole."""
    radius = np.geomspace(0.1, 3.0, 24)
    result = fp.indent(FILM_100, tip, radius=radius, method=method)
    np.testing.assert_allclose(result.radius, radius, rtol=1e-10)
    for name in ("depth", "force", "area", "stiffness", "contour", "force_error", "contour_error"):
        assert np.all(np.isfinite(result[name])), name


def test_general_profile_within_a_flat_end_is_finite() -> None:
    tip = fp.indenters.Truncated(fp.Pyramid(4, 0.35), 0.05)
    result = fp.indent(HALF_SPACE, tip, depth=np.array([1e-4, 0.01, 0.1]), method="second-order")
    assert np.all(np.isfinite(result.force))
    assert np.all(np.diff(result.force) > 0)
    # at the flat itself the contact is a square punch, which the series does not know: the estimate says so
    assert float(result.contour_error[0]) > 0.3


def test_fourth_order_asks_for_a_power_law() -> None:
    with pytest.raises(ValueError, match="needs a power-law shape"):
        fp.indent(HALF_SPACE, Disguised(fp.EllipticParaboloid(0.5, 1.0)), depth=0.1, method="fourth-order")


def test_radius_that_no_contact_has() -> None:
    tip = fp.indenters.Ellipsoid(2.0, 1.5, 1.0)
    with pytest.raises(ValueError, match="beyond this indenter"):
        fp.indent(HALF_SPACE, tip, radius=1.5, method="second-order")


def test_no_medium_enlarges_circles():
    # within the sphere of a rounded pyramid outlines are circles on any medium: how far they deviate is rounding
    gel = fp.Medium([fp.Layer(5e3, 0.5, 1e-6)], fp.RigidBase())
    tip = fp.Rounded(fp.Pyramid(4, 0.3), 3e-7)
    curve = fp.indent(gel, tip, depth=np.linspace(1e-9, 2e-8, 20), method="first-order", angles=1)
    np.testing.assert_allclose(curve.force_error, curve.force_error[0], rtol=1e-12)
    assert curve.valid.all()
