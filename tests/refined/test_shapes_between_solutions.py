"""Radius, area and outline between the boundary element solutions of a curve: narrow lobes, contacts that come apart."""

from __future__ import annotations

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact.refined.refinement import refinement
from flatpunch.indenters import Cone, Pyramid
from flatpunch.indenters.geometry.features import place_of, wedges_of
from support.known_outlines import distance


def test_kinds_of_edges() -> None:
    knoop, square = fp.Knoop(), Pyramid(4, 0.3)
    assert wedges_of(Cone(0.3)) == []
    assert len({place_of(square, angle) for angle, *_ in wedges_of(square)}) == 1
    assert len({place_of(knoop, angle) for angle, *_ in wedges_of(knoop)}) == 2


@pytest.mark.long
@pytest.mark.parametrize(
    ("ratio", "sides", "depth", "apart"),
    [
        # round contacts grow by half within this gap
        pytest.param(50.0, 4, 2.25, False, marks=pytest.mark.slow),
        # narrow lobes of five mean radii grow to thirteen within a fifth more depth
        (100.0, 3, 1.72, False),
        # separate parts have just come into contact
        pytest.param(100.0, 3, 7.3, True, marks=pytest.mark.slow),
        (10.0, 4, 3.06, True),
    ],
)
def test_stiff_films_between_solutions(ratio: float, sides: int, depth: float, apart: bool) -> None:
    film = fp.Medium([fp.Layer(ratio, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
    tip = Pyramid(sides, 0.35)
    refinement.cache_clear()
    depths = np.union1d(np.geomspace(depth / 6, 1.5 * depth, 100), depth)
    curve = fp.indent(film, tip, depth=depths, method=fp.Refined(rtol=4.99e-4))
    found = curve.isel(step=int(np.searchsorted(depths, depth)))
    # a single contact has a solution of its own
    refinement.cache_clear()
    own = fp.indent(film, tip, depth=depth, method=fp.Refined(rtol=4.99e-4)).isel(step=0)
    assert float(found.force) == pytest.approx(float(own.force), rel=1e-3)
    assert float(found.radius) == pytest.approx(float(own.radius), rel=0.015)
    assert float(found.area) == pytest.approx(float(own.area), rel=0.03)
    assert ("contour" not in own) == apart
    if not apart:
        # narrow lobes that double their length within a gap are further off, and the estimate says so
        off = distance(found.contour.values, own.contour.values) / float(own.radius)
        assert off < float(found.contour_error) + float(own.contour_error)
