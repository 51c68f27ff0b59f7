"""Outlines that edges draw out into points: to a per cent of the mean radius from 256 cells."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliance import compliance
from flatpunch.contact.boundary_elements.outlines import core as star_core
from flatpunch.contact.boundary_elements.outlines import needle as ridges
from flatpunch.contact.boundary_elements.outlines import zoom as closeup
from flatpunch.contact.boundary_elements.outlines.needle import Trace, traced
from flatpunch.indenters import Rounded, Superellipse, Tilted
from flatpunch.indenters.geometry.symmetry import mirrored_about, rotational_symmetry
from support.known_outlines import distance


def _film(ratio: float) -> fp.Medium:
    return fp.Medium([fp.Layer(ratio, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))


def _traced(medium: fp.Medium, tip: fp.Pyramid | Rounded, depth: float, cells: int, rays: int = 360) -> Trace:
    kernel = compliance(medium)
    return traced(kernel, tip, bem.solve(kernel, tip, depths=depth, grid=cells, tolerance=1e-6, angles=rays)[0], rays)


@pytest.mark.parametrize(
    ("medium", "sides", "depth", "reach"),
    [
        # farthest points over the mean radius, from 2048 cells a side: there the last cells in contact are as far to 0.3 %
        (fp.HalfSpace(1.0, 0.3), 3, 0.3, 2.229),
        (_film(10.0), 4, 0.5, 1.819),
        (_film(20.0), 3, 0.5, 3.029),
        (_film(50.0), 4, 1.2, 2.5535),
        (fp.PowerLawHalfSpace(1.0, 1.0, -0.3, 0.3), 3, 0.5, 2.735),
    ],
)
def test_points_from_few_cells(medium: fp.Medium, sides: int, depth: float, reach: float) -> None:
    tip = fp.Pyramid(sides, 0.3)
    coarse, fine = (_traced(medium, tip, depth, cells) for cells in (192, 640))
    assert coarse.contour.max() / coarse.radius == pytest.approx(reach, abs=0.01)
    off = np.abs(coarse.contour - fine.contour)[::5] / fine.radius
    assert off.max() < 0.01
    assert coarse.radius == pytest.approx(fine.radius, rel=5e-3)


@pytest.mark.parametrize(("sides", "depth"), [(3, 0.6), (5, 2.5), (7, 2.5)])
def test_one_sector_of_a_core_stands_for_all(sides: int, depth: float, monkeypatch: pytest.MonkeyPatch) -> None:
    tip, kernel = fp.Pyramid(sides, 0.3), compliance(_film(50.0))
    (solution,) = bem.solve(kernel, tip, depths=depth, grid=192, tolerance=1e-6, angles=360)
    sector = traced(kernel, tip, solution, 360)
    monkeypatch.setattr(star_core, "rotational_symmetry", lambda indenter: 1)
    whole = traced(kernel, tip, solution, 360)
    assert sector.contour.max() > 2.5 * sector.radius
    # cells of a hundredth of the mean radius, known to a third of that
    assert 0 < distance(sector.contour, whole.contour) < 4e-3 * whole.radius
    assert sector.radius == pytest.approx(whole.radius, rel=2e-3)


@pytest.mark.parametrize(
    ("medium", "sides", "radius", "depth"),
    [(fp.HalfSpace(1.0, 0.3), 3, 0.05, 0.2), (_film(4.0), 3, 0.3, 1.0), (fp.HalfSpace(1.0, 0.3), 5, 0.02, 0.3)],
    ids=["half-space", "film", "five sides"],
)
def test_rounded_edges_from_few_cells(medium: fp.Medium, sides: int, radius: float, depth: float) -> None:
    tip, kernel = Rounded(fp.Pyramid(sides, 0.4), radius), compliance(medium)
    coarse, fine = (bem.solve(kernel, tip, depths=depth, grid=n, tolerance=1e-6, angles=360)[0] for n in (160, 768))
    outline, truth = (traced(kernel, tip, solution, 360) for solution in (coarse, fine))
    off, plain = (np.abs(contour - truth.contour).max() for contour in (outline.contour, coarse.outline.contour))
    assert off < 0.01 * truth.radius
    # the cells alone are off by several times as much
    assert plain > 2 * off
    assert outline.area == pytest.approx(truth.area, rel=5e-3)


def test_area_and_radius_of_points_narrower_than_rays_are_apart() -> None:
    """Three needles eight mean radii long and a degree wide; the area by 360 rays is 7 % too large."""
    kernel, tip = compliance(_film(50.0)), fp.Pyramid(3, 0.4)
    coarse, fine, finest = (
        bem.solve(kernel, tip, depths=1.6, grid=n, tolerance=1e-6, angles=1440)[0] for n in (256, 768, 1536)
    )
    # cells covered in part count whole: what they make too much halves with them
    truth = 2 * finest.area - fine.area
    outlines = [traced(kernel, tip, solution, n) for solution, n in ((coarse, 1440), (fine, 1440))]
    few = traced(kernel, tip, bem.solve(kernel, tip, depths=1.6, grid=256, tolerance=1e-6)[0], 360)
    assert few.contour.max() > 8 * few.radius
    for outline in (few, *outlines):
        assert outline.area == pytest.approx(truth, rel=2e-3)
        assert outline.radius == pytest.approx(outlines[1].radius, rel=2e-3)
    assert np.pi * np.mean(few.contour**2) > 1.05 * truth


def test_needles_thinner_at_their_root_than_farther_out() -> None:
    """Rays leave them and meet them again: a(phi) is their farthest point, radius and area count what is in contact."""
    medium, tip = _film(100.0), fp.Pyramid(8, 0.35)
    coarse, fine = _traced(medium, tip, 5.5, 256), _traced(medium, tip, 5.5, 1024, 3600)
    # cells covered in part count whole: what they make too much halves with them
    half, whole = (bem.solve(compliance(medium), tip, depths=5.5, grid=n, tolerance=1e-6)[0].area for n in (1024, 2048))
    cells = 2 * whole - half
    # cells of a twelfth of the mean radius leave necks that wide by a half of a per cent of it
    assert distance(coarse.contour, fine.contour) < 0.006 * fine.radius
    assert coarse.radius == pytest.approx(fine.radius, rel=6e-3)
    assert coarse.area == pytest.approx(fine.area, rel=5e-3)
    # from half as wide ones on it stays
    closer = _traced(medium, tip, 5.5, 512)
    assert closer.radius == pytest.approx(fine.radius, rel=1e-3)
    assert closer.area == pytest.approx(fine.area, rel=1e-3)
    assert fine.area == pytest.approx(cells, rel=2e-3)
    assert np.pi * np.mean(fine.contour**2) > 1.05 * fine.area
    assert fine.contour.mean() > 1.03 * fine.radius


def test_radii_grow_from_an_obtuse_point_on() -> None:
    """Beside the short diagonal of a Knoop tip the outline is farther away than at its end, which had that radius (5 %)."""
    layer, tip = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase()), fp.Knoop()
    (solution,) = bem.solve(compliance(layer), tip, depths=0.73, grid=1024, tolerance=1e-6, angles=360)
    trace = traced(compliance(layer), tip, solution, 360)
    assert trace.contour[90] == pytest.approx(1.9259, rel=1e-3)  # from 2048 cells
    np.testing.assert_allclose(trace.contour[91:94], solution.outline.contour[91:94], rtol=5e-3)
    assert trace.contour[95] < trace.contour[90] < trace.contour[110]


def test_contacts_that_rays_meet_again() -> None:
    """Four needles whose ends are fans: once they touch the core, radius and area go on from those of the parts before."""
    tip, kernel = Superellipse(1.0, 0.6, 0.3, 1.3, 1.0), compliance(_film(30.0))
    depths = [5.25, 5.87, 6.2, 8.0]
    # counted on 1024 cells a side; 256 count up to 2.3 % too many
    areas, radii = [24.272, 47.812, 62.049, 176.03], [1.7631, 2.5536, 2.9628, 5.6489]
    traces = [
        traced(kernel, tip, solution, 360)
        for solution in bem.solve(kernel, tip, depths=depths, grid=256, tolerance=1e-6)
    ]
    assert [trace.area for trace in traces] == pytest.approx(areas, rel=0.01)
    assert [trace.radius for trace in traces] == pytest.approx(radii, rel=0.015)
    assert [bool(np.isfinite(trace.contour).all()) for trace in traces] == [False, True, True, True]
    # a(phi) is the farthest point: its mean is far larger
    assert traces[1].contour.mean() > 1.5 * traces[1].radius
    medium = _film(30.0)
    curve = fp.indent(medium, tip, depth=np.linspace(5.0, 6.5, 60), method="refined")
    assert np.diff(curve.radius).min() > 0
    assert np.abs(np.diff(np.log(curve.radius))).max() < 0.05


# farthest points from 4096 cells
@pytest.mark.parametrize(("depth", "reach"), [(1.0, 1.2087), (1.6, 3.5505)])
def test_the_estimate_holds_on_rays_beside_a_needle(depth: float, reach: float) -> None:
    """Rays one degree beside it meet its flank aslant: at the larger depth 0.08 mean radii off along them, 0.002 across it."""
    medium, tip = _film(50.0), fp.Pyramid(3, 0.4)
    found = fp.indent(medium, tip, depth=depth, method="refined").isel(step=0)
    truth = _traced(medium, tip, depth, 1024, 3600)
    off = np.abs(found.contour.values - truth.contour[::10]) / truth.radius
    assert float(found.contour.max()) == pytest.approx(reach, abs=0.01 * truth.radius)
    assert distance(found.contour.values, truth.contour) < 0.005 * truth.radius
    assert off[::5].max() < 0.01
    # it is read off needles of all tips, of which those known best are known ten times better than those known worst
    assert off.max() < float(found.contour_error) < 40 * off.max()


@pytest.mark.parametrize("angles", [1, 4, 7, 500])
def test_radius_and_area_do_not_depend_on_the_angles_asked_for(angles: int) -> None:
    medium, tip = fp.HalfSpace(1.0, 0.3), fp.EllipticParaboloid(1.0, 0.3)
    usual, found = (fp.indent(medium, tip, depth=0.1, method="bem", grid=64, angles=n) for n in (360, angles))
    assert found.contour.shape == (1, angles)
    assert float(found.radius[0]) == pytest.approx(float(usual.radius[0]), rel=1e-3)
    assert float(found.area[0]) == pytest.approx(float(usual.area[0]), rel=2e-3)
    assert float(found.contour[0, 0]) == pytest.approx(float(usual.contour[0, 0]), rel=1e-3)
    kernel = compliance(medium)
    few = bem.solve(kernel, tip, depths=0.1, grid=64, angles=angles)[0]
    assert few.outline.contour.shape == few.outline.phi.shape == (angles,)
    assert few.area == pytest.approx(float(usual.area[0]), rel=2e-3)


def test_neighbouring_points_are_told_apart() -> None:
    """Few cells and many points: what lies beyond the middle between two edges belongs to the other."""
    coarse, fine = (_traced(_film(15.0), fp.Pyramid(8, 0.3), 2.48, cells) for cells in (64, 256))
    assert coarse.radius == pytest.approx(fine.radius, rel=0.02)
    off = np.abs(coarse.contour - fine.contour)[::5] / fine.radius
    # 64 cells; 0.8 at worst before
    assert np.median(off) < 0.01
    assert off.max() < 0.1


def test_outline_is_as_symmetric_as_the_tip() -> None:
    for sides in (3, 4, 5):
        contour = _traced(_film(20.0), fp.Pyramid(sides, 0.3), 0.5, 128).contour
        np.testing.assert_allclose(contour, np.roll(contour, 360 // sides), rtol=1e-9)


def test_edges_of_a_tip_without_symmetry_are_followed_too() -> None:
    leaning, upright = (fp.Tilted(fp.Pyramid(3, 0.3), angle) for angle in (0.02, 1e-6))
    contours = [_traced(_film(20.0), tip, 0.4, 192).contour for tip in (leaning, upright)]
    far = [np.sort(contour[[60, 180, 300]]) for contour in contours]
    assert np.ptp(far[1]) < 0.02 * far[1].mean()
    # it leans to one side, and the point there reaches farther
    assert np.ptp(far[0]) > 0.03 * far[0].mean()


def test_mirror_images_of_indenters() -> None:
    knoop = fp.Knoop()
    assert mirrored_about(knoop, 0.0)
    assert mirrored_about(knoop, np.pi / 2)
    assert not mirrored_about(knoop, 0.3)
    assert mirrored_about(fp.Pyramid(3, 0.3), np.pi / 3)
    assert not mirrored_about(fp.Pyramid(3, 0.3), np.pi / 2)
    assert rotational_symmetry(knoop) == 2


def test_needles_of_a_tilted_tip_are_counted() -> None:
    """Their edges differ from side to side, so that their load does not tell how far each side reaches."""
    tip = Tilted(fp.Pyramid(4, 0.35), 0.03, 0.02)
    # rays a degree apart would leave the ends of needles to straight lines
    coarse, fine = (_traced(_film(50.0), tip, 3.0, cells, 2520) for cells in (256, 768))
    assert fine.contour.max() > 10 * fine.radius
    assert distance(coarse.contour, fine.contour) < 0.01 * fine.radius
    assert coarse.radius == pytest.approx(fine.radius, rel=3e-3)
    assert coarse.area == pytest.approx(fine.area, rel=5e-3)


@pytest.mark.parametrize(
    ("tip", "off"),
    [
        (Tilted(fp.Pyramid(3, 0.5), 0.1, 0.05), 4e-3),
        (Tilted(fp.Pyramid(4, 0.5), 0.12, 0.05), 4e-3),
        # two of its edges are so near to each other that cells tell what is between them
        (fp.FacetedPyramid((0.1, 1.0, 2.3, 2.95, 4.0, 5.4), (0.31, 0.43, 0.26, 0.37, 0.45, 0.28)), 1e-2),
    ],
)
def test_edges_whose_sides_differ(tip: fp.Tilted | fp.FacetedPyramid, off: float) -> None:
    """Each side of a tongue is followed from where it is narrow itself: it was up to 1.6 % of the mean radius off."""
    coarse, fine = (_traced(fp.HalfSpace(1.0, 0.3), tip, 1.0, cells, 2520) for cells in (256, 768))
    assert distance(coarse.contour, fine.contour) < off * fine.radius
    assert coarse.radius == pytest.approx(fine.radius, rel=1e-3)
    assert coarse.area == pytest.approx(fine.area, rel=2e-3)


def test_looks_along_long_needles_hold_little_else(monkeypatch: pytest.MonkeyPatch) -> None:
    film = fp.Medium([fp.Layer(57.0, 0.45, 1.0)], base=fp.HalfSpace(1.0, 0.2))
    tip = fp.FacetedPyramid((0.21, 2.26, 4.36), (0.44, 0.27, 0.47))
    shares, look = [], ridges.look_closer

    def watched(*arguments: Any, **options: Any) -> Any:
        patch = look(*arguments, **options)
        if patch.grid.nx * patch.grid.stretch > 1000:
            shares.append((patch.pressure > 0).mean())
        return patch

    monkeypatch.setattr(ridges, "look_closer", watched)
    kernel = compliance(film)
    trace = traced(kernel, tip, bem.solve(kernel, tip, depths=4.5, grid=256, tolerance=1e-6)[0], 360)
    # in one step from wide cells to fine ones it is an eighth
    assert len(shares) == 3
    assert min(shares) > 0.2
    # radius and area of 2048 cells
    assert trace.radius == pytest.approx(0.57848, rel=5e-3)
    assert trace.area == pytest.approx(5.8285, rel=1e-2)


@pytest.mark.parametrize(
    ("tip", "depth"),
    [(fp.Pyramid(3, 0.3), 2.0), (fp.FacetedPyramid((0.4, 1.9, 4.3), (0.3, 0.27, 0.33)), 1.0)],
    ids=["even edges", "irregular"],
)
def test_long_cells_along_needles(
    tip: fp.Pyramid | fp.FacetedPyramid, depth: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    stretches, look = [], ridges.look_closer

    def watched(*arguments: Any, **options: Any) -> Any:
        patch = look(*arguments, **options)
        stretches.append(patch.grid.stretch)
        return patch

    monkeypatch.setattr(ridges, "look_closer", watched)
    kernel = compliance(_film(50.0))
    solution = bem.solve(kernel, tip, depths=depth, grid=640, tolerance=1e-6)[0]
    long = traced(kernel, tip, solution, 360)
    # their ends are looked at on square cells
    assert set(stretches) == {1, 3}
    assert stretches[-1] == 1
    monkeypatch.setattr(ridges, "_STRETCH", 1)
    square = traced(kernel, tip, solution, 360)
    assert distance(long.contour, square.contour) < 5e-3 * square.radius
    assert long.radius == pytest.approx(square.radius, rel=1e-3)
    assert long.area == pytest.approx(square.area, rel=1e-3)


@pytest.mark.parametrize(("sides", "depth"), [(4, 3.1), (3, 4.3)])
def test_blunt_ends_of_long_needles(sides: int, depth: float) -> None:
    tip, film = Rounded(fp.Pyramid(sides, 0.35), 1.0), _film(100.0)
    coarse, fine = (_traced(film, tip, depth, cells) for cells in (256, 1024))
    assert fine.contour.max() > 6 * fine.radius
    # from long cells alone the ends of four are off by 0.014
    assert coarse.contour.max() == pytest.approx(fine.contour.max(), abs=0.01 * fine.radius)
    assert coarse.radius == pytest.approx(fine.radius, rel=2e-3)


@pytest.mark.parametrize(
    "tip", [fp.Pyramid(3, np.pi / 9), Rounded(fp.Pyramid(3, np.pi / 9), 0.1)], ids=["sharp", "rounded"]
)
def test_needles_are_found_in_few_steps(tip: fp.Pyramid | Rounded, monkeypatch: pytest.MonkeyPatch) -> None:
    convolutions, solve = [], closeup.solve_contact

    def watched(*arguments: Any, **options: Any) -> Any:
        state = solve(*arguments, **options)
        convolutions.append(state.convolutions)
        return state

    monkeypatch.setattr(closeup, "solve_contact", watched)
    kernel = compliance(_film(100.0))
    for depth in (11.0, 13.0, 15.0):
        traced(kernel, tip, bem.solve(kernel, tip, depths=depth, grid=256, tolerance=1e-6)[0], 360)
    # where all cells that overlap are loaded at once up to 286
    assert max(convolutions) < 150
