"""Identities that every perturbation result keeps, whatever the medium."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import flatpunch as fp
from support.power_law_bodies import HALF_SPACE, INCOMPRESSIBLE, MEDIA, STIFF_FILM, Disguised

ELLIPSE = fp.EllipticParaboloid(0.6, 1.0)
SQUARE = fp.Pyramid(4, 0.3)


LAYERED = ["half-space", "incompressible", "pair", "stiff-film"]


@pytest.mark.parametrize("name", LAYERED)
@pytest.mark.parametrize("exponent", [2.0, None], ids=["power-law", "general"])
def test_round_tip_that_does_not_say_so_is_solved_exactly(name: str, exponent: float | None) -> None:
    depth = np.array([0.01, 0.3, 2.0])
    exact = fp.indent(MEDIA[name], fp.Paraboloid(0.5), depth=depth)
    found = fp.indent(MEDIA[name], Disguised(fp.Paraboloid(0.5), exponent), depth=depth, method="second-order")
    for quantity in ("force", "radius", "area", "stiffness"):
        # the general path interpolates over ln a to 1e-10
        np.testing.assert_allclose(found[quantity], exact[quantity], rtol=1e-10, err_msg=quantity)


@pytest.mark.parametrize("name", LAYERED)
def test_general_path_equals_power_law_path(name: str) -> None:
    depth = np.array([0.02, 0.4, 1.5])
    power = fp.indent(MEDIA[name], ELLIPSE, depth=depth, method="second-order")
    general = fp.indent(MEDIA[name], Disguised(ELLIPSE), depth=depth, method="second-order")
    for quantity in ("force", "radius", "area", "stiffness"):
        # both end at the interpolation over ln a
        np.testing.assert_allclose(general[quantity], power[quantity], rtol=3e-10, err_msg=quantity)
    np.testing.assert_allclose(general.contour, power.contour, rtol=1e-9)


def test_general_path_on_edges() -> None:
    """A pyramid's harmonics fall like 1/m^2: the general path keeps those up to 512, which leaves 2e-5 of the force."""
    power = fp.indent(INCOMPRESSIBLE, SQUARE, depth=0.5, method="second-order")
    general = fp.indent(INCOMPRESSIBLE, Disguised(SQUARE), depth=0.5, method="second-order")
    assert float(general.force[0]) == pytest.approx(float(power.force[0]), rel=4e-5)
    assert float(general.radius[0]) == pytest.approx(float(power.radius[0]), rel=2e-4)


@pytest.mark.parametrize(
    ("tip", "method"),
    [
        (ELLIPSE, "second-order"),
        (ELLIPSE, "fourth-order"),
        (SQUARE, "second-order"),
        (SQUARE, "fourth-order"),
        (Disguised(ELLIPSE), "second-order"),
    ],
)
@pytest.mark.parametrize("name", ["half-space", "incompressible", "stiff-film"])
def test_stiffness_is_the_derivative_of_the_force(tip: object, method: str, name: str) -> None:
    step = 2e-3
    depth = 0.4 * np.exp(step * np.array([-2, -1, 0, 1, 2]))
    result = fp.indent(MEDIA[name], tip, depth=depth, method=method)
    force = result.force.values
    slope = (force[0] - 8 * force[1] + 8 * force[3] - force[4]) / (12 * step) / depth[2]
    # five points leave step^4/30 of the fifth derivative, and 1e-12/step of the interpolation
    assert float(result.stiffness[2]) == pytest.approx(slope, rel=3e-8)


@pytest.mark.parametrize("tip", [ELLIPSE, SQUARE], ids=["ellipse", "square"])
@pytest.mark.parametrize("method", ["second-order", "fourth-order"])
def test_pressure_integrates_to_the_force(tip: object, method: str) -> None:
    angles = 64 if tip is ELLIPSE else 720
    result = fp.indent(INCOMPRESSIBLE, tip, depth=0.5, method=method, angles=2 * angles).isel(phi=slice(1, None, 2))
    outline, phi = result.contour.values[0], result.phi.values
    t, weight = np.polynomial.legendre.leggauss(16)
    theta = np.pi / 4 * (t + 1)
    # r = a(phi) sin(theta) takes the root at the edge out of the integrand
    r = outline[:, None] * np.sin(theta)
    p = fp.pressure(INCOMPRESSIBLE, tip, r * np.cos(phi)[:, None], r * np.sin(phi)[:, None], depth=0.5, method=method)
    rings = (p * np.sin(theta) * np.cos(theta)) @ (np.pi / 4 * weight)
    force = np.mean(rings * outline**2) * 2 * np.pi
    # pressures are those of boundary elements at the same depth: 5e-4 between 256 cells a side, and the same of the area from
    # the cusps at the corners of a pyramid
    assert force == pytest.approx(float(result.force[0]), rel=1e-3 + float(result.force_error[0]))


@pytest.mark.parametrize("tip", [ELLIPSE, SQUARE, Disguised(ELLIPSE)], ids=["ellipse", "square", "general"])
@pytest.mark.parametrize("name", ["half-space", "incompressible"])
def test_force_and_radius_control_return_the_depth(tip: object, name: str) -> None:
    depth = np.array([0.05, 0.2, 0.8])
    first = fp.indent(MEDIA[name], tip, depth=depth, method="second-order")
    by_force = fp.indent(MEDIA[name], tip, force=first.force.values, method="second-order")
    by_radius = fp.indent(MEDIA[name], tip, radius=first.radius.values, method="second-order")
    # Newton's method ends at rounding
    np.testing.assert_allclose(by_force.depth, depth, rtol=1e-11)
    np.testing.assert_allclose(by_radius.depth, depth, rtol=1e-11)


@pytest.mark.long
@settings(max_examples=15, deadline=None, derandomize=True)
@given(
    length=st.floats(1e-9, 1e3),
    modulus=st.floats(1e-3, 1e12),
    slope=st.floats(0.1, 10.0),
    method=st.sampled_from(["second-order", "fourth-order"]),
)
def test_scaling_of_lengths_moduli_and_slopes(length: float, modulus: float, slope: float, method: str) -> None:
    """F(lengths x l, moduli x E, heights x s) = l^2 E s F at s times l times the depth."""
    plain = fp.indent(INCOMPRESSIBLE, fp.PowerLaw(1, lambda phi: 1 + 0.1 * np.cos(3 * phi)), depth=0.3, method=method)
    medium = fp.Medium([fp.Layer(modulus, 0.5, length)], base=fp.RigidBase())
    tip = fp.PowerLaw(1, lambda phi: slope * (1 + 0.1 * np.cos(3 * phi)))
    scaled = fp.indent(medium, tip, depth=0.3 * length * slope, method=method)
    # panels of log(beta) are the same ones, up to rounding of beta
    assert float(scaled.force[0]) == pytest.approx(float(plain.force[0]) * modulus * length**2 * slope, rel=1e-10)
    assert float(scaled.radius[0]) == pytest.approx(float(plain.radius[0]) * length, rel=1e-9)


@dataclass(frozen=True)
class ShiftedParaboloid(fp.indenters.Indenter):
    """Paraboloid of unit radius whose apex lies at x = shift."""

    shift: float
    reach = 10.0

    def height(self, r: np.ndarray, phi: np.ndarray) -> np.ndarray:
        return ((r * np.cos(phi) - self.shift) ** 2 + (r * np.sin(phi)) ** 2) / 2

    def slope(self, r: np.ndarray, phi: np.ndarray) -> np.ndarray:
        return r - self.shift * np.cos(phi)


@pytest.mark.parametrize("name", ["half-space", "incompressible"])
def test_shifted_round_tip_has_the_shifted_contact(name: str) -> None:
    """About a wrong centre the logarithm is singular; there m = 1 enters as a depth, which is exact for a paraboloid."""
    exact = fp.indent(MEDIA[name], fp.Paraboloid(1.0), radius=1.0)
    for shift in (0.1, 0.3):
        found = fp.indent(MEDIA[name], ShiftedParaboloid(shift), depth=exact.depth.values, method="second-order")
        assert float(found.force[0]) == pytest.approx(float(exact.force[0]), rel=1e-11)
        # differentiates a spline of 36 nodes per decade
        assert float(found.stiffness[0]) == pytest.approx(float(exact.stiffness[0]), rel=1e-9)
        phi = found.phi.values
        outline = shift * np.cos(phi) + np.sqrt(1 - (shift * np.sin(phi)) ** 2)
        assert np.abs(found.contour.values[0] - outline).max() < float(found.contour_error[0])


def test_turning_the_tip_turns_the_outline() -> None:
    turn = 0.3
    still = fp.indent(
        STIFF_FILM, fp.PowerLaw(2, lambda phi: 1 + 0.15 * np.cos(2 * phi)), depth=0.5, method="second-order"
    )
    turned = fp.indent(
        STIFF_FILM, fp.PowerLaw(2, lambda phi: 1 + 0.15 * np.cos(2 * (phi - turn))), depth=0.5, method="second-order"
    )
    assert float(turned.force[0]) == pytest.approx(float(still.force[0]), rel=1e-12)
    spectra = [np.fft.rfft(np.log(result.contour.values[0])) for result in (still, turned)]
    np.testing.assert_allclose(spectra[1][2], spectra[0][2] * np.exp(-2j * turn), rtol=1e-9)


@pytest.mark.long
def test_graded_surface_keeps_the_identities() -> None:
    """Stiffness and force control under a graded surface, whose punch matrices are costlier than a layer's."""
    step = 2e-3
    depth = 0.4 * np.exp(step * np.array([-2, -1, 0, 1, 2]))
    result = fp.indent(MEDIA["graded"], SQUARE, depth=depth, method="fourth-order")
    force = result.force.values
    slope = (force[0] - 8 * force[1] + 8 * force[3] - force[4]) / (12 * step) / depth[2]
    assert float(result.stiffness[2]) == pytest.approx(slope, rel=3e-8)
    back = fp.indent(MEDIA["graded"], SQUARE, force=force, method="fourth-order")
    np.testing.assert_allclose(back.depth, depth, rtol=1e-11)


def test_thin_and_thick_layers_are_half_spaces() -> None:
    """A contact far smaller than the layer feels only the layer: the difference falls like beta."""
    thick = fp.Medium([fp.Layer(1.0, 0.3, 1e6)], base=fp.RigidBase())
    for method in ("second-order", "fourth-order"):
        on_layer = float(fp.indent(thick, SQUARE, depth=0.3, method=method).force[0])
        alone = float(fp.indent(HALF_SPACE, SQUARE, depth=0.3, method=method).force[0])
        assert on_layer == pytest.approx(alone, rel=5e-6)
