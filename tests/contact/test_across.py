"""Half-widths of needles from what their cells carry, against plane contacts that are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from flatpunch.contact.boundary_elements.outlines.needle_width import across

import flatpunch as fp
from flatpunch.compliance import compliance
from flatpunch.indenters import Rounded

KERNEL = compliance(fp.HalfSpace(1.0, 0.3))
ALONG = np.linspace(50.0, 60.0, 40)


def _cells(pressure_beyond: np.ndarray, fine: int) -> tuple[float, float]:
    """Sum of the pressure over cells of width 1 and its second moment, from means over cells `fine` times as narrow."""
    cells = pressure_beyond.reshape(-1, fine).mean(axis=1)
    y = np.arange(cells.size) + 0.5
    return cells.sum(), (cells * y**2).sum()


def _found(tip: object, load: float, moment: float, angle: float) -> tuple[float, float]:
    profile = across(KERNEL, tip, angle, ALONG[[0, -1]], 1.0)
    b = profile.half_widths(ALONG, np.full(ALONG.size, load), np.full(ALONG.size, moment))
    assert np.ptp(b[0]) < 1e-3 * b[0][0]
    return b[0][0], b[1][0]


@pytest.mark.parametrize("bend", [-0.1, 0.0, 0.1])
def test_a_wedge_on_a_bent_surface(bend: float) -> None:
    """p = E*/pi m arccosh(b/y) + E*/2 k sqrt(b^2 - y^2), the curvature of the gap k being `bend` m/b."""
    tip, b, fine = fp.Pyramid(4, 0.3), 20.0, 400
    edge = tip.corners[0]
    m = np.tan(0.3) / np.sqrt(2)
    y = np.minimum((np.arange(30 * fine) + 0.5) / fine, b)
    pressure = KERNEL.modulus * (m * np.arccosh(b / y) / np.pi + bend * m / b * np.sqrt(b**2 - y**2) / 2)
    straight, bent = _found(tip, *_cells(pressure, fine), edge)
    assert straight == pytest.approx(b * (1 + np.pi / 4 * bend), rel=2e-3)
    assert bent == pytest.approx(b, rel=4e-3)


def test_a_rounded_edge_is_a_cylinder_while_the_needle_is_narrow() -> None:
    """b^2 = 4 q R/(pi E*), for edges rounded with R = 2000 cells."""
    tip, b, fine = Rounded(fp.Pyramid(4, 0.3), 2000.0, true_sphere=False), 20.0, 100
    y = np.minimum((np.arange(30 * fine) + 0.5) / fine, b)
    pressure = KERNEL.modulus * np.sqrt(b**2 - y**2) / 2 / 2000.0
    straight, bent = _found(tip, *_cells(pressure, fine), tip.rounded_edges[0])
    assert straight == pytest.approx(b, rel=2e-3)
    assert bent == pytest.approx(b, rel=4e-3)


def test_a_tip_that_is_cut_off_is_a_wedge_beyond_its_flat() -> None:
    """However near the flat the needle begins; on a flat of more than 100 cells no width is told."""
    tip, b = fp.Truncated.across(fp.Pyramid(4, 0.3), 20.0), 0.3
    corner, along = 20 * np.sqrt(2), np.geomspace(5.0, 300.0, 200)
    profile = across(KERNEL, tip, tip.corners[0], along[[0, -1]], 0.05)
    m = np.tan(0.3) / np.sqrt(2)
    load, moment = (np.full(along.size, KERNEL.modulus * m / 2 * value / 0.05) for value in (b, b**3 / 6))
    straight, bent = profile.half_widths(along, load, moment)
    beyond, before = along > 1.15 * corner, along < (corner - 100 * 0.05) / 1.15
    np.testing.assert_allclose(straight[beyond], b, rtol=2e-3)
    np.testing.assert_allclose(bent[beyond], b, rtol=0.02)
    assert before.any()
    assert np.isnan(straight[before]).all()
    assert np.isnan(bent[before]).all()


@pytest.mark.parametrize("cells", [1.8, 3.4, 7.3])
def test_few_cells_carry_a_wedge(cells: float) -> None:
    """The plane problem solved on cells of width 1 at given load: where the wedge's edge lies between them is found."""
    tip = fp.Pyramid(4, 0.3)
    y = np.arange(40) + 0.5

    def under(distance: np.ndarray) -> np.ndarray:
        high, low = distance + 0.5, distance - 0.5
        return high * np.log(np.abs(high)) - low * np.log(np.abs(low) + 1e-300)

    sinking = -2 / np.pi * (under(y[:, None] - y) + under(y[:, None] + y))
    contact = np.ones(y.size, dtype=bool)
    while True:
        n = contact.sum()
        system = np.block(
            [[sinking[np.ix_(contact, contact)], -np.ones((n, 1))], [np.full((1, n), 2.0), np.zeros((1, 1))]]
        )
        p = np.linalg.solve(system, np.append(-y[contact], cells))[:-1]
        if (p >= 0).all():
            break
        contact[np.flatnonzero(contact)[p < 0]] = False
    scale = KERNEL.modulus * np.tan(0.3) / np.sqrt(2)
    straight, bent = _found(tip, scale * p.sum(), scale * (p * y[contact] ** 2).sum(), tip.corners[0])
    assert straight == pytest.approx(cells, rel=1e-3)
    assert bent == pytest.approx(cells, rel=5e-3)
