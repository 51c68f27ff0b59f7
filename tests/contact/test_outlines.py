"""Outlines, mean radii and areas with a closer solution along each edge: against fine cells, and their error estimates."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliances import compliance
from flatpunch.contact.boundary_elements.outlines import Trace, traced
from flatpunch.indenters.profile import Indenter
from flatpunch.reference import elliptic
from support.known_outlines import distance


def film(ratio: float) -> fp.Medium:
    """So many times stiffer than its base."""
    return fp.Medium([fp.Layer(ratio, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))


GEL = fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase())


def trace_of(medium: fp.Medium | fp.HalfSpace, tip: Indenter, depth: float, cells: int, angles: int = 360) -> Trace:
    """Outline from a grid of so many cells a side."""
    kernel = compliance(medium)
    (solution,) = bem.solve(kernel, tip, depths=depth, grid=cells, tolerance=1e-6)
    return traced(kernel, tip, solution, angles)


def test_exact_ellipse() -> None:
    tip = fp.EllipticParaboloid(5e5, 1.5e6)
    exact = elliptic.elliptic_paraboloid(tip.A, tip.B, 1e9 / 0.91, depth=1e-8)
    trace = trace_of(fp.HalfSpace(1e9, 0.3), tip, 1e-8, 128)
    phi = 2 * np.pi * np.arange(360) / 360
    contour = 1 / np.hypot(np.cos(phi) / exact.half_axis_x, np.sin(phi) / exact.half_axis_y)
    off = np.abs(trace.contour - contour).max() / trace.radius
    # a tenth of a cell, of which there are 50 in the mean radius
    assert off < 4e-3
    assert off < trace.error < 0.02
    assert trace.area == pytest.approx(np.pi * exact.half_axis_x * exact.half_axis_y, rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("sides", [3, 4, *(pytest.param(n, marks=pytest.mark.slow) for n in (5, 6)), 8])
@pytest.mark.parametrize("medium", [fp.HalfSpace(1.0, 0.3), GEL, film(5.0)], ids=["half-space", "gel", "film 5"])
def test_pyramids_against_four_times_as_many_cells(sides: int, medium: fp.Medium | fp.HalfSpace) -> None:
    tip = fp.Pyramid(sides, 0.35)
    # all edges lie on rays
    coarse, fine = (trace_of(medium, tip, 0.3, cells, 720) for cells in (128, 512))
    off = distance(coarse.contour, fine.contour) / fine.radius
    assert off < coarse.error < 0.06
    assert coarse.radius == pytest.approx(fine.radius, rel=3e-3)
    assert coarse.area == pytest.approx(fine.area, rel=1e-2)


@pytest.mark.long
@pytest.mark.parametrize(
    ("ratio", "tip", "depth"),
    [
        (50.0, fp.Pyramid(4, 0.35), 1.0),
        pytest.param(100.0, fp.Pyramid(3, 0.35), 0.5, marks=pytest.mark.slow),
        (10.0, fp.Truncated.across(fp.Pyramid(4, 0.35), 0.2), 0.4),
        pytest.param(50.0, fp.Rounded(fp.Pyramid(4, 0.35), 0.5), 1.0, marks=pytest.mark.slow),
    ],
)
def test_long_lobes_under_stiff_films(ratio: float, tip: Indenter, depth: float) -> None:
    coarse, fine = (trace_of(film(ratio), tip, depth, cells) for cells in (256, 1024))
    assert distance(coarse.contour, fine.contour) < coarse.error * fine.radius
    assert coarse.area == pytest.approx(fine.area, rel=1e-2)
    assert coarse.radius == pytest.approx(fine.radius, rel=1e-2)


@pytest.mark.long
@pytest.mark.parametrize("depth", [3.044, pytest.param(6.067, marks=pytest.mark.slow)])
def test_contacts_in_several_parts_have_no_outline_and_an_area(depth: float) -> None:
    """Islands on the faces of a tip with four sides, under films 10 and 50 times stiffer."""
    tip, ratio = fp.Pyramid(4, 0.35), 10.0 if depth < 4 else 50.0
    coarse, fine = (trace_of(film(ratio), tip, depth, cells) for cells in (256, 1024))
    assert np.isnan(coarse.contour).all()
    assert np.isinf(coarse.error)
    # mean radii of ten to twenty cells
    assert coarse.radius == pytest.approx(fine.radius, rel=0.03)
    assert coarse.area == pytest.approx(fine.area, rel=0.03)


def drawn(rng: np.random.Generator) -> tuple[fp.Medium, Indenter, float]:
    """A stiff film on a half-space or on a softer layer, a pyramid, and a depth."""
    ratio, depth = 10 ** rng.uniform(1.0, 3.0), 10 ** rng.uniform(-1.5, 0.7)
    tip: Indenter = fp.Pyramid(int(rng.choice([3, 4, 5])), 0.35)
    kind = rng.integers(4)
    if kind == 1:
        tip = fp.Rounded(tip, depth / 0.35 * 10 ** rng.uniform(-1.7, 0.0))
    elif kind == 2:
        tip = fp.Truncated(tip, height_removed=depth * 10 ** rng.uniform(-1.3, 0.0))
    layers = [fp.Layer(ratio, 0.3, 1.0)]
    if rng.random() < 0.5:
        return fp.Medium(layers, base=fp.HalfSpace(1.0, 0.3)), tip, depth
    return fp.Medium([*layers, fp.Layer(1.0, 0.3, 10 ** rng.uniform(0, 1))], base=fp.RigidBase()), tip, depth


@pytest.mark.long
@pytest.mark.parametrize("count", [5, pytest.param(100, marks=pytest.mark.slow)])
def test_random_contacts_stay_within_the_estimates_of_their_outlines(count: int) -> None:
    rng, off, stated = np.random.default_rng(35), [], []
    for medium, tip, depth in (drawn(rng) for _ in range(count)):
        coarse, fine = (trace_of(medium, tip, depth, cells) for cells in (128, 512))
        if np.isfinite(coarse.error) and np.isfinite(fine.error):
            off.append(distance(coarse.contour, fine.contour) / fine.radius)
            stated.append(coarse.error)
    assert len(off) > count / 2
    assert np.mean(np.array(off) < stated) >= 0.95
    # where one is exceeded, it is by chance and not by a part of the outline that was missed
    assert np.max(np.array(off) / stated) < 1.5


@pytest.mark.long
@pytest.mark.parametrize(
    ("ratio", "sides", "depth", "below"), [(26.3, 4, 1.84, 3.0), (15.8, 3, 0.919, 4.0), (22.6, 5, 1.58, 3.0)]
)
def test_corners_beside_lobes(ratio: float, sides: int, depth: float, below: float) -> None:
    """The rim of the pressure there was up to 1.5 cells off, with an estimate of one cell."""
    base = fp.Layer(1.0, 0.3, below)
    medium, tip = fp.Medium([fp.Layer(ratio, 0.3, 1.0), base], base=fp.RigidBase()), fp.Pyramid(sides, 0.35)
    coarse, fine = (trace_of(medium, tip, depth, cells) for cells in (128, 512))
    assert distance(coarse.contour, fine.contour) < coarse.error * fine.radius


@pytest.mark.long
@pytest.mark.parametrize(("ratio", "angles"), [(17.0, 360), (330.0, 1000), (7000.0, 360), (7000.0, 1440)])
def test_errors_of_slender_outlines_are_those_along_rays(ratio: float, angles: int) -> None:
    """Along a ray that meets a slender contact at a small angle outlines were off by 40 times the stated error."""
    body = fp.Medium([fp.Layer(1.000001, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    tip = fp.EllipticParaboloid(0.5, 0.5 * ratio)
    exact = fp.indent(fp.HalfSpace(1.0, 0.3), tip, depth=0.01, angles=angles)
    found = fp.indent(body, tip, depth=0.01, angles=angles)
    off = float(np.abs(found.contour - exact.contour).max() / exact.radius[0])
    assert off < float(found.contour_error[0]) < 10 * off
    assert bool(found.valid[0]) == (float(found.contour_error[0]) < 1)


@pytest.mark.long
def test_slender_contacts_on_layers_against_four_times_as_many_cells() -> None:
    rng, off, stated = np.random.default_rng(2611), [], []
    for _ in range(5):
        body = film(10 ** rng.uniform(-1.5, 1.5)) if rng.random() < 0.7 else GEL
        slender, power = 10 ** rng.uniform(0.7, 1.4), int(rng.choice([4, 6]))
        tip: Indenter = fp.PowerLaw(
            2.0, lambda p, q=slender, n=power: 0.1 * (np.cos(p) ** n + (q * np.sin(p)) ** n) ** (2 / n)
        )
        depth = 10 ** rng.uniform(-2, 0)
        found, fine = fp.indent(body, tip, depth=depth), trace_of(body, tip, depth, 1024)
        off.append(np.abs(found.contour.values[0] - fine.contour).max() / fine.radius)
        stated.append(float(found.contour_error[0]))
    assert np.max(np.array(off) / stated) < 1.5
