"""The refined method: boundary elements' accuracy along a whole curve."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliances import compliance
from flatpunch.contact.boundary_elements.outlines import traced
from flatpunch.contact.refined.refinement import refinement
from flatpunch.indenters import Rounded
from flatpunch.media import PowerLawHalfSpace

INCOMPRESSIBLE = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase())
FILM_10 = fp.Medium([fp.Layer(10.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
SOFT = fp.Medium([fp.Layer(0.05, 0.45, 1.0)], base=fp.HalfSpace(1.0, 0.3))
TRIANGLE = fp.Pyramid(3, 0.3)
TABLE_OFF = {"rtol": 4.99e-4, "cells": 128}
"""Coarse solutions, so that the tests stay quick: forces then are good to 1e-4."""


@pytest.mark.long
@pytest.mark.parametrize("medium", [INCOMPRESSIBLE, FILM_10, SOFT], ids=["incompressible", "film", "soft"])
def test_against_boundary_elements_between_its_own(medium: fp.Medium) -> None:
    depth = np.geomspace(0.05, 0.6, 40)
    curve = fp.indent(medium, TRIANGLE, depth=depth, method=fp.Refined(**TABLE_OFF))
    for step in (13, 29):
        truth = fp.indent(medium, TRIANGLE, depth=depth[step], method=fp.BoundaryElements(grid=192))
        force = abs(float(curve.force[step]) / float(truth.force[0]) - 1)
        # the goal of the method, and its own word
        assert force < 1e-3
        assert force < float(curve.force_error[step])
        if np.isfinite(truth.radius[0]) and np.isfinite(curve.contour[step, 0]):
            off = np.abs(curve.contour.values[step] - truth.contour.values[0]).max() / float(truth.radius[0])
            # this truth, not followed along the edges, is known to ten over the number of its cells
            assert off < float(curve.contour_error[step]) + 10 / 192


def test_stiffness_is_the_derivative_of_the_force() -> None:
    depth = np.geomspace(0.05, 0.6, 41)
    middle = 0.2 * np.exp(2e-3 * np.array([-2, -1, 0, 1, 2]))
    both = np.sort(np.concatenate([depth, middle]))
    curve = fp.indent(SOFT, TRIANGLE, depth=both, method=fp.Refined(**TABLE_OFF))
    at = np.searchsorted(both, middle)
    force = curve.force.values[at]
    slope = (force[0] - 8 * force[1] + 8 * force[3] - force[4]) / (12 * 2e-3) / middle[2]
    # exact up to the five points' own error: the stiffness differentiates the spline itself
    assert float(curve.stiffness[at[2]]) == pytest.approx(slope, rel=1e-6)


def test_force_and_radius_control_return_the_depth() -> None:
    depth = np.array([0.1, 0.3])
    first = fp.indent(SOFT, TRIANGLE, depth=depth, method=fp.Refined(**TABLE_OFF))
    # other nodes may carry the curve, so the interpolation's error enters twice; radii of 128 cells scatter by a thousandth
    for control, error in (("force", float(first.force_error.max())), ("radius", 1e-3)):
        again = fp.indent(SOFT, TRIANGLE, method=fp.Refined(**TABLE_OFF), **{control: first[control].values})
        np.testing.assert_allclose(again.depth, depth, rtol=2 * error, err_msg=control)


def test_pressure_integrates_to_the_force() -> None:
    tip = fp.EllipticParaboloid(0.2, 1.0)
    curve = fp.indent(SOFT, tip, depth=0.3, method=fp.Refined(**TABLE_OFF))
    phi = curve.phi.values[::6]
    outline = curve.contour.values[0, ::6]
    t, weight = np.polynomial.legendre.leggauss(16)
    theta = np.pi / 4 * (t + 1)
    r = outline[:, None] * np.sin(theta)
    x, y = r * np.cos(phi)[:, None], r * np.sin(phi)[:, None]
    p = fp.pressure(SOFT, tip, x, y, depth=0.3, method=fp.Refined(**TABLE_OFF))
    force = 2 * np.pi * np.mean((p * np.sin(theta) * np.cos(theta)) @ (np.pi / 4 * weight) * outline**2)
    # the outlines of the history are traced to a tenth of a cell of 128, and the area goes with their square
    assert force == pytest.approx(float(curve.force[0]), rel=5e-3)


@pytest.mark.parametrize("exponent", [0.0, 0.4])
def test_bodies_without_a_length_need_one_solution(exponent: float) -> None:
    body = PowerLawHalfSpace(2.0, 1.0, exponent, 0.3) if exponent else fp.HalfSpace(2.0, 0.3)
    depth = np.geomspace(1e-3, 1e3, 20)
    curve = fp.indent(body, TRIANGLE, depth=depth, method=fp.Refined(cells=128))
    # self-similar: F ~ d^(2 + k) at every depth
    np.testing.assert_allclose(
        curve.force / depth ** (2 + exponent), float(curve.force[0] / depth[0] ** (2 + exponent)), rtol=1e-9
    )
    truth = fp.indent(body, TRIANGLE, depth=3.0, method=fp.BoundaryElements(grid=192))
    alone = fp.indent(body, TRIANGLE, depth=3.0, method=fp.Refined(cells=128))
    assert float(alone.force[0]) == pytest.approx(float(truth.force[0]), rel=3e-4)


def test_tip_far_smaller_than_the_layer() -> None:
    """A rounded tip changes its shape at its own radius, however thin it is against the layer."""
    tip = Rounded(fp.Pyramid(4, 0.4), 1e-4, true_sphere=False)
    curve = fp.indent(INCOMPRESSIBLE, tip, depth=np.array([1e-5, 1e-4]), method=fp.Refined(**TABLE_OFF))
    for step in (0, 1):
        truth = fp.indent(INCOMPRESSIBLE, tip, depth=float(curve.depth[step]), method=fp.BoundaryElements(grid=192))
        assert float(curve.force[step]) == pytest.approx(float(truth.force[0]), rel=1e-3)


def test_solutions_are_kept_on_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    depth = np.array([0.1, 0.2])
    first = fp.indent(SOFT, TRIANGLE, depth=depth, method=fp.Refined(cache=tmp_path, **TABLE_OFF))
    assert [path.suffix for path in tmp_path.iterdir()] == [".npz"]
    refinement.cache_clear()

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("solved again")

    monkeypatch.setattr("flatpunch.bem.solve", refuse)
    # ratios do not depend on the modulus: twice as stiff is the same file
    stiffer = fp.Medium([fp.Layer(0.1, 0.45, 1.0)], base=fp.HalfSpace(2.0, 0.3))
    again = fp.indent(stiffer, TRIANGLE, depth=depth, method=fp.Refined(cache=tmp_path, **TABLE_OFF))
    np.testing.assert_allclose(again.force, 2 * first.force, rtol=1e-9)
    refinement.cache_clear()


def test_damaged_file_is_made_anew(tmp_path: Path) -> None:
    depth = 0.1
    first = fp.indent(fp.HalfSpace(1.0, 0.3), TRIANGLE, depth=depth, method=fp.Refined(cache=tmp_path, **TABLE_OFF))
    refinement.cache_clear()
    (file,) = tmp_path.iterdir()
    file.write_bytes(b"no archive")
    with pytest.warns(fp.FlatpunchWarning, match="set aside, and solved again"):
        again = fp.indent(fp.HalfSpace(1.0, 0.3), TRIANGLE, depth=depth, method=fp.Refined(cache=tmp_path, **TABLE_OFF))
    np.testing.assert_allclose(again.force, first.force, rtol=1e-12)
    refinement.cache_clear()


def test_contacts_without_outline_say_so() -> None:
    """Under a film a hundred times stiffer than its base a wide blunt contact opens: faces begin to touch around its middle."""
    film = fp.Medium([fp.Layer(100.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    curve = fp.indent(film, fp.Pyramid(8, 0.35), depth=12.0, method=fp.Refined(**TABLE_OFF))
    assert "no outline" in curve.attrs["notes"]
    assert "contour" not in curve
    assert np.isinf(curve.contour_error.values[-1])
    assert np.all(np.isfinite(curve.radius))
    assert np.all(np.isfinite(curve.area))


@pytest.mark.long
@pytest.mark.parametrize("sides", [3, 4])
def test_points_of_the_outline_are_known_better_than_by_the_cells(sides: int) -> None:
    """Along its edges a contact is narrower than a cell; there it is solved on finer cells."""
    kernel, tip = compliance(fp.HalfSpace(1.0, 0.3)), fp.Pyramid(sides, 0.3)
    fine, coarse = (
        bem.solve(kernel, tip, depths=1.0, grid=grid, half_widths=(6.0, 6.0), tolerance=1e-6)[0] for grid in (512, 192)
    )
    best, found = traced(kernel, tip, fine, 360), traced(kernel, tip, coarse, 360)
    # half a cell of 192, of which 29 (three sides) to 40 are in the mean radius
    off = np.abs(found.contour - best.contour).max() / best.radius
    assert off < 0.015
    assert off < found.error
    assert np.abs(coarse.outline.contour - best.contour).max() > 0.015 * best.radius
    assert found.area == pytest.approx(best.area, rel=2e-3)


def test_round_tips_are_exact() -> None:
    depth = np.array([0.0, 0.1, 0.5])
    exact = fp.indent(INCOMPRESSIBLE, fp.Paraboloid(0.5), depth=depth, method="first-order")
    refined = fp.indent(INCOMPRESSIBLE, fp.Paraboloid(0.5), depth=depth, method="refined")
    np.testing.assert_array_equal(refined.force, exact.force)
