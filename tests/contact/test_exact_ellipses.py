"""Elliptic paraboloids on half-spaces and power-law half-spaces: Hertz's closed form, boundary elements, the ways to ask."""

import mpmath
import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact import default_choice


def hertz(flat, steep, depth, modulus):
    """Half-axes and force from complete elliptic integrals in 30 digits."""
    with mpmath.workdps(30):
        ratio = mpmath.mpf(steep) / flat

        def misfit(log_axes):
            k = mpmath.exp(log_axes)
            first, second = mpmath.ellipk(1 - k**2), mpmath.ellipe(1 - k**2)
            return mpmath.log((second / k**2 - first) / (first - second) / ratio)

        k = mpmath.exp(mpmath.findroot(misfit, (-mpmath.log(ratio) * 0.9, -mpmath.log(ratio) * 0.5), solver="anderson"))
        first, second = mpmath.ellipk(1 - k**2), mpmath.ellipe(1 - k**2)
        long = mpmath.sqrt(depth * (first - second) / (flat * (1 - k**2) * first))
        force = 2 * mpmath.pi / 3 * long * depth * modulus / first
        return float(long), float(k * long), float(force)


@pytest.mark.parametrize("ratio", [1.001, 1.5, 20.0, 1e3, 9e3, 1e6])
def test_half_spaces_are_hertzian(ratio):
    long, short, force = hertz(2.0, 2.0 * ratio, 0.01, 1 / 0.91)
    found = fp.indent(fp.HalfSpace(1.0, 0.3), fp.EllipticParaboloid(2.0 * ratio, 2.0), depth=0.01)
    assert found.attrs["method"] == "exact"
    # rounding; the search of the axes near the circle loses some digits of their difference
    assert float(found.force[0]) == pytest.approx(force, rel=1e-12)
    assert float(found.area[0]) == pytest.approx(np.pi * long * short, rel=1e-12)
    phi = found.phi.values
    outline = long * short / np.hypot(short * np.sin(phi), long * np.cos(phi))
    np.testing.assert_allclose(found.contour.values[0], outline, rtol=1e-11)
    assert float(found.force_error[0]) < 1e-9


@pytest.mark.parametrize("exponent", [-0.4, 0.3, 0.8])
@pytest.mark.parametrize("ratio", [1.7, 6.0])
def test_power_law_half_spaces_agree_with_boundary_elements(exponent, ratio):
    body = fp.PowerLawHalfSpace(modulus=1.0, depth=1.0, exponent=exponent, poisson=0.3)
    tip = fp.EllipticParaboloid(0.5, 0.5 * ratio)
    exact, cells = (fp.indent(body, tip, depth=0.1, method=each) for each in ("exact", "bem"))
    # the estimates of 256 cells
    assert float(cells.force[0]) == pytest.approx(float(exact.force[0]), rel=3 * float(cells.force_error[0]) + 1e-6)
    assert float(cells.area[0]) == pytest.approx(float(exact.area[0]), rel=0.01)
    x = np.array([0.0, 0.1, -0.05])
    sampled = fp.pressure(body, tip, x, 0.02, depth=0.1, method="bem")
    np.testing.assert_allclose(fp.pressure(body, tip, x, 0.02, depth=0.1), sampled, rtol=2e-3)


@pytest.mark.parametrize("exponent", [-0.4, 0.0, 0.8])
def test_a_round_paraboloid_is_the_round_contact(exponent):
    body = fp.PowerLawHalfSpace(1.0, 1.0, exponent, 0.3) if exponent else fp.HalfSpace(1.0, 0.3)
    nearly = fp.indent(body, fp.EllipticParaboloid(0.5, 0.5 * (1 + 1e-12)), force=[0.01, 0.3])
    round_ = fp.indent(body, fp.Paraboloid(1.0), force=[0.01, 0.3])
    for name in ("depth", "radius", "area", "stiffness"):
        np.testing.assert_allclose(nearly[name], round_[name], rtol=1e-11)


@pytest.mark.parametrize("control", ["force", "radius"])
def test_every_control_returns_to_the_depth(control):
    body, tip = fp.TwoBodies(fp.HalfSpace(1.0, 0.3), fp.HalfSpace(3.0, 0.2)), fp.EllipticParaboloid(3.0, 0.2)
    start = fp.indent(body, tip, depth=[0.0, 0.02, 0.3])
    back = fp.indent(body, tip, **{control: start[control].values[1:]})
    np.testing.assert_allclose(back.depth, [0.02, 0.3], rtol=1e-13)
    # dF/dd from the curve itself
    around = fp.indent(body, tip, depth=0.3 * (1 + np.array([-1e-5, 1e-5])))
    slope = float(np.diff(around.force)[0] / np.diff(around.depth)[0])
    assert float(start.stiffness[2]) == pytest.approx(slope, rel=1e-9)


def test_exact_is_named_where_it_applies_and_refused_elsewhere():
    layered = fp.Medium([fp.Layer(1.0, 0.3, 1.0)], fp.HalfSpace(2.0, 0.3))
    for tip, control in ((fp.Sphere(5.0), {"depth": 0.1}), (fp.Cylinder(1.0), {"depth": 0.1})):
        assert fp.indent(layered, tip, **control).attrs["method"] == "exact"
        # round contacts are exact by every fast method, and so named
        assert fp.indent(layered, tip, **control, method="first-order").attrs["method"] == "exact"
    assert default_choice(fp.EllipticParaboloid(1.0, 2.0), layered, depth=0.1).method.name != "exact"
    with pytest.raises(ValueError, match=r"method = 'exact' has no solution for Pyramid on this body"):
        fp.indent(fp.HalfSpace(1.0, 0.3), fp.Pyramid(4, 0.3), depth=0.1, method="exact")


@pytest.mark.long
@pytest.mark.parametrize(("ratio", "error"), [(100.0, 0.006), (1000.0, 0.02)])
def test_areas_of_slender_contacts_on_layers(ratio, error):
    """A layer of nearly the modulus of its base: boundary elements, against the half-space."""
    body = fp.Medium([fp.Layer(1.000001, 0.3, 1.0)], fp.HalfSpace(1.0, 0.3))
    tip = fp.EllipticParaboloid(0.5, 0.5 * ratio)
    exact = fp.indent(fp.HalfSpace(1.0, 0.3), tip, depth=0.01)
    found = fp.indent(body, tip, depth=0.01)
    # the contact is few cells wide: their share of the width
    assert float(found.area[0]) == pytest.approx(float(exact.area[0]), rel=error)
    assert float(found.radius[0]) == pytest.approx(float(exact.radius[0]), rel=error)
