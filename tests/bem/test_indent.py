"""Boundary elements as a user meets them: `indent` and `pressure` with method="bem"."""

import re

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch._support.checks import FlatpunchWarning
from flatpunch.compliances import compliance
from flatpunch.reference import elliptic

COATED = fp.Medium([fp.Layer(2e9, 0.4, 1e-6)], base=fp.HalfSpace(70e9, 0.22))
TIP = fp.Pyramid(4, 0.3)


def test_curve_by_depth_and_back_by_force():
    depths = np.array([0.0, 1e-7, 1.1e-7, 2e-7])
    curve = fp.indent(COATED, TIP, depth=depths, method=fp.BoundaryElements(grid=64))
    assert curve.valid.all()
    assert curve.force[0] == 0
    assert (np.diff(curve.force) > 0).all()
    assert curve.gap_error.max() <= 1e-6
    assert curve.penetration.min() >= 0
    assert curve.penetration.max() <= 1e-6
    again = fp.indent(COATED, TIP, force=curve.force.values, method=fp.BoundaryElements(grid=64))
    # gap error 1e-6 of the depth, twice; grids of 64 cells that fit to a part in twenty
    np.testing.assert_allclose(again.depth, depths, rtol=1e-3)


def test_fields_on_request():
    curve = fp.indent(COATED, TIP, depth=[1e-7, 2e-7], method=fp.BoundaryElements(grid=64, fields=True))
    assert curve.pressure.dims == ("step", "y", "x")
    assert curve.contact.dtype == bool
    cell = float(np.diff(curve.x)[0]) ** 2
    np.testing.assert_allclose(curve.pressure.sum(("y", "x")) * cell, curve.force, rtol=1e-12)
    # in contact the surface follows the tip
    x, y = np.meshgrid(curve.x, curve.y)
    height = np.tan(0.3) * np.maximum(abs(x), abs(y))
    gap = curve.displacement + height - curve.depth
    assert float(abs(gap).where(curve.contact).max()) <= 1.1e-6 * 2e-7
    assert "pressure" not in fp.indent(COATED, TIP, depth=1e-7, method=fp.BoundaryElements(grid=64))


@pytest.mark.parametrize("cells", [40, 64, 256])
def test_estimates_of_force_and_outline(cells):
    """The exact ellipse: true errors are below their estimates, and these no more than thirty times as large."""
    tip = fp.EllipticParaboloid(5e5, 1.5e6)
    exact = elliptic.elliptic_paraboloid(tip.A, tip.B, 1e9 / 0.91, depth=1e-8)
    curve = fp.indent(fp.HalfSpace(1e9, 0.3), tip, depth=1e-8, method=fp.BoundaryElements(grid=cells))
    phi = curve.phi.values
    contour = 1 / np.hypot(np.cos(phi) / exact.half_axis_x, np.sin(phi) / exact.half_axis_y)
    force = abs(float(curve.force[0]) / exact.force - 1)
    outline = np.abs(curve.contour.values[0] - contour).max() / float(curve.radius[0])
    assert force < float(curve.force_error[0]) < 30 * force
    assert outline < float(curve.contour_error[0]) < 30 * outline


def test_estimates_along_a_curve():
    """Close steps have that of the one they began with; before contact there is nothing to be wrong."""
    curve = fp.indent(COATED, TIP, depth=[0.0, 1e-7, 1.001e-7, 1.002e-7, 3e-7], method=fp.BoundaryElements(grid=64))
    error = curve.force_error.values
    assert error[0] == curve.contour_error[0] == 0
    assert error[1] == error[2] == error[3] != error[4]
    # a contact that fills less of its grid has fewer cells
    wide = fp.indent(COATED, TIP, depth=[1e-7, 3e-7], method=fp.BoundaryElements(grid=64, fields=True))
    assert wide.force_error[0] > 2 * error[1]
    assert wide.contour_error[0] > 1.5 * curve.contour_error[1]


def test_estimates_where_cells_are_too_wide():
    """Between their centres there is a contact that none of them knows of."""
    curve = fp.indent(
        fp.HalfSpace(1.0, 0.3),
        fp.Sphere(1.0),
        depth=[1e-6, 0.3],
        method=fp.BoundaryElements(grid=bem.Grid(64, 64, 0.1)),
    )
    assert curve.force[0] == curve.radius[0] == curve.area[0] == 0
    assert np.isinf(curve.force_error[0])
    assert np.isinf(curve.contour_error[0])
    assert curve.force_error[1] < 0.01


def test_pressure_at_points():
    x = np.array([0.0, 1e-7, 1e-5])
    p = fp.pressure(fp.HalfSpace(1e9, 0.3), fp.Paraboloid(1e-5), x, 0 * x, depth=1e-8, method="bem")
    a = np.sqrt(1e-5 * 1e-8)
    exact = 2 * 1e9 / 0.91 / np.pi * a / 1e-5 * np.sqrt(np.maximum(1 - (x / a) ** 2, 0))
    # linear between 256 cells
    np.testing.assert_allclose(p, exact, rtol=2e-4, atol=1e-12)


def test_single_precision_has_its_own_tolerance():
    one, two = (
        fp.indent(COATED, TIP, depth=1e-7, method=fp.BoundaryElements(grid=64, single=single))
        for single in (True, False)
    )
    assert one.valid.all()
    # gap error 1e-5 of the depth
    np.testing.assert_allclose(one.force, two.force, rtol=3e-5)
    with pytest.raises(ValueError, match="out of reach of single precision"):
        fp.indent(COATED, TIP, depth=1e-7, method=fp.BoundaryElements(single=True, tolerance=1e-8))
    with pytest.raises(ValueError, match="below the rounding of floating point"):
        fp.BoundaryElements(tolerance=1e-17)


def test_too_small_a_grid_says_how_large_it_must_be():
    sphere = fp.Sphere(1e-5)
    with pytest.raises(bem.ContactTouchesEdge, match="It needs about") as failure:
        fp.indent(COATED, sphere, depth=1e-7, method=fp.BoundaryElements(grid=bem.Grid(64, 64, 2e-8)))
    nx, ny = (int(n) for n in re.search(r"(\d+) x (\d+) cells of this size", str(failure.value)).groups())
    assert fp.indent(COATED, sphere, depth=1e-7, method=fp.BoundaryElements(grid=bem.Grid(nx, ny, 2e-8))).valid.all()


def test_not_converged_is_a_result():
    with pytest.warns(FlatpunchWarning, match="not converged after 2 iterations"):
        curve = fp.indent(COATED, TIP, depth=1e-7, method=fp.BoundaryElements(grid=bem.Grid(48, 48, 1.2e-8), limit=2))
    assert not curve.valid.any()
    assert "not converged" in curve.attrs["notes"]
    assert curve.gap_error[0] > 1e-6
    assert curve.force[0] > 0


def test_memory_is_said_before_the_work(caplog):
    seen = []
    with caplog.at_level("INFO", logger="flatpunch.bem"):
        fp.indent(
            COATED,
            TIP,
            depth=1e-7,
            method=fp.BoundaryElements(
                grid=64, progress=lambda done, total: seen.append((done, total, "MB" in caplog.text))
            ),
        )
    assert seen[-1] == (1, 1, True)


def test_close_steps_share_grid_and_operator(monkeypatch):
    from flatpunch.bem.solver import levels

    built = []
    original = levels.build_operator

    def counted(kernel, grid, **options):
        built.append(grid)
        return original(kernel, grid, **options)

    monkeypatch.setattr(levels, "build_operator", counted)
    fp.indent(COATED, TIP, depth=np.linspace(1e-7, 1.02e-7, 5)[::-1], method=fp.BoundaryElements(grid=96))
    # searching for the contact takes coarse grids of its own
    assert len({grid for grid in built if grid.nx * grid.ny > 80**2}) <= 3


@pytest.mark.long
def test_outlines_reach_into_the_points_that_edges_draw():
    """The cells lose the last two or three of a point; along the edge it is followed to a fraction of one."""
    coarse, fine = (
        fp.indent(fp.HalfSpace(1e9, 0.3), TIP, depth=1e-7, method=fp.BoundaryElements(grid=grid), angles=72)
        for grid in (128, 512)
    )
    # 128 cells: 50 to the mean radius
    np.testing.assert_allclose(coarse.contour / coarse.radius, fine.contour / fine.radius, atol=0.5 / 50)
    # square pyramids have square symmetry, and so has what is read off the cells
    contour = fine.contour.values[0]
    np.testing.assert_allclose(contour, np.roll(contour, 18), rtol=1e-9)
    assert float(fine.area[0]) == pytest.approx(np.pi * np.mean(contour**2), rel=2e-3)


def test_an_ellipsoid_is_touched_beyond_its_shorter_half_axis():
    """The contact of (15, 10) half-axes goes on to 11.0 along the longer one; it is no circle cut off at 9.5."""
    tip, soft = fp.Ellipsoid(15.0, 10.0, 10.0), fp.HalfSpace(1.0, 0.3)
    (solution,) = bem.solve(compliance(soft), tip, depths=6.0, grid=128)
    # pressure falls to the rim along both axes: it would be singular at an edge
    for line in (solution.pressure[solution.grid.ny // 2], solution.pressure[:, solution.grid.nx // 2]):
        carried = line[line > 0]
        assert carried[0] < 0.4 * carried.max()
    for method in ("bem", "refined"):
        curve = fp.indent(soft, tip, depth=6.0, method=method)
        assert "reaches the end" not in curve.attrs["notes"]
        assert float(curve.contour[0, 0]) == pytest.approx(11.0, rel=2e-3)


@pytest.mark.long
@pytest.mark.parametrize("method", ["bem", "refined"])
def test_a_contact_that_reaches_the_end_of_a_measured_tip_says_so(method):
    x = np.linspace(-1.0, 1.0, 81)
    tip = fp.HeightMap(x, x, 0.2 * x[None, :] ** 2 + 0.15 * x[:, None] ** 2)
    curve = fp.indent(fp.HalfSpace(1.0, 0.3), tip, depth=[0.1, 0.3], method=method)
    end = "border of the map" if method == "bem" else "end of the indenter's shape"
    assert f"At depths of 300 mm and more: the contact reaches the {end}" in curve.attrs["notes"]
    assert "contact reaches" not in fp.indent(fp.HalfSpace(1.0, 0.3), tip, depth=0.1, method=method).attrs["notes"]
