"""Fourth order passes over to second without a jump, whatever else is on the curve."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.perturbation.fourth_order import BlendedExpansion

CASES = {
    "square, film 5": (fp.Pyramid(4, 0.3), 5.0, 0.02, 2.0),
    "hexagon, film 10": (fp.Pyramid(6, 0.3), 10.0, 0.05, 3.0),
    "triangle, film 3": (fp.Pyramid(3, 0.3), 3.0, 0.02, 1.0),
    "ellipse, film 8": (fp.EllipticParaboloid(0.1, 0.5), 8.0, 0.02, 2.0),
}


def film(ratio: float) -> fp.Medium:
    return fp.Medium([fp.Layer(ratio, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))


@pytest.mark.long
@pytest.mark.parametrize(("tip", "ratio", "start", "stop"), CASES.values(), ids=CASES)
def test_force_and_stiffness_do_not_jump(tip: object, ratio: float, start: float, stop: float) -> None:
    """Where one order takes over from the other at one depth the force jumps by up to 1.4 %."""
    depth = np.geomspace(start, stop, 1500)
    curve = fp.indent(film(ratio), tip, depth=depth, method="fourth-order", angles=8)
    assert "passes over to second order" in curve.attrs["notes"]
    x, force = np.log(depth), np.log(curve.force.values)
    slope = curve.stiffness.values * depth / curve.force.values
    # the force is the integral of the stiffness: Simpson's rule over pairs of steps leaves 1e-7
    step = x[1] - x[0]
    integral = step / 3 * (slope[:-2:2] + 4 * slope[1:-1:2] + slope[2::2])
    np.testing.assert_allclose(np.diff(force[::2])[: integral.size], integral, atol=1e-6)
    # 0.3 % of depth between two steps
    assert np.abs(np.diff(slope)).max() < 0.002 * slope.mean()


@pytest.mark.long
@pytest.mark.parametrize(("tip", "ratio", "start", "stop"), CASES.values(), ids=CASES)
def test_a_step_does_not_depend_on_the_others(tip: object, ratio: float, start: float, stop: float) -> None:
    depth = np.geomspace(start, stop, 12)
    curve = fp.indent(film(ratio), tip, depth=depth, method="fourth-order")
    for step in range(0, 12, 3):
        alone = fp.indent(film(ratio), tip, depth=depth[step], method="fourth-order").isel(step=0)
        for name in ("force", "stiffness", "radius", "area", "force_error"):
            np.testing.assert_allclose(alone[name], curve[name][step], rtol=1e-9, err_msg=name)
    for name in ("force", "radius"):
        back = fp.indent(film(ratio), tip, **{name: curve[name].values[::4]}, method="fourth-order", angles=8)
        np.testing.assert_allclose(back.depth, depth[::4], rtol=1e-9)


@pytest.mark.long
def test_outline_in_between() -> None:
    """Mean radius and area are those of the outline."""
    tip, medium = fp.EllipticParaboloid(0.1, 0.5), film(8.0)
    depth = np.geomspace(0.02, 2.0, 40)
    curve = fp.indent(medium, tip, depth=depth, method="fourth-order", angles=720)
    series = BlendedExpansion(compliance(medium), tip)
    weight = series.parts(np.geomspace(0.1, 5.0, 200))[2]
    assert ((weight > 0.1) & (weight < 0.9)).any()
    np.testing.assert_allclose(curve.contour.mean("phi"), curve.radius, rtol=1e-9)
    np.testing.assert_allclose(np.pi * (curve.contour**2).mean("phi"), curve.area, rtol=1e-9)
