"""Energy by layer: the work of the contact, closed forms and the limit of one material."""

import numpy as np
import pytest

import flatpunch as fp

STEEL = fp.HalfSpace(210e9, 0.3)
FILM = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
STIFF = fp.Medium([fp.Layer(300e9, 0.25, 2e-6), fp.Layer(100e9, 0.25, 1e-6)], base=fp.HalfSpace(3e9, 0.3))


@pytest.mark.parametrize("medium", [STEEL, FILM, STIFF, fp.Medium([fp.Layer(1e9, 0.5, 2e-6)], fp.RigidBase())])
@pytest.mark.parametrize("tip", [fp.Sphere(20e-6), fp.Cone(0.2)])
def test_energy_is_the_work_of_the_contact(medium, tip):
    a = 1.5e-6
    found = fp.energy_by_depth(medium, tip, radius=a, z=np.array([0.5e-6, 1.9e-6]))
    x, w = np.polynomial.legendre.leggauss(30)
    steps = a * ((x + 1) / 2) ** 2
    curve = fp.indent(medium, tip, radius=steps)
    end = fp.indent(medium, tip, radius=a)
    # int F dd = F d - int d dF with dF = K dd, as an integral over the radius: d as a function of a is smooth
    slope = np.array(
        [
            (
                fp.indent(medium, tip, radius=s * (1 + 1e-4)).depth[0]
                - fp.indent(medium, tip, radius=s * (1 - 1e-4)).depth[0]
            )
            / (2e-4 * s)
            for s in steps
        ],
        dtype=float,
    )
    work = float(np.sum(w / 2 * a * (x + 1) * curve.force.values * slope))
    assert found.attrs["total"] == pytest.approx(work, rel=1e-6)  # differences of step 1e-4
    assert float(found.energy.sum()) == pytest.approx(found.attrs["total"], rel=1e-9)
    assert np.all(found.energy >= -1e-12 * work)
    assert float(end.force[0]) > 0
    assert float(found.energy_below[0]) > float(found.energy_below[1]) > 0


GRADED = fp.Medium([fp.GradedLayer(fp.LinearModulus(1e9, 9e9, 2e-6), 0.3, 2e-6)], fp.HalfSpace(9e9, 0.3))
POWER = fp.PowerLawHalfSpace(1e9, 1e-6, 0.3, 0.3)


@pytest.mark.long
@pytest.mark.parametrize(
    ("medium", "tip", "tolerance"),
    [
        # the integral for the whole body ends at k a = 2048
        (GRADED, fp.Paraboloid(20e-6), 3e-6),
        (POWER, fp.Paraboloid(20e-6), 1e-8),
        # boundary elements of 192 cells along a side, whose edges are sharp, against the curve by default
        (FILM, fp.Pyramid(4, 0.2), 1e-3),
    ],
    ids=["graded", "power-law", "pyramid"],
)
def test_energy_where_there_is_no_closed_form(medium, tip, tolerance):
    depth = 1e-7
    found = fp.energy_by_depth(medium, tip, depth=depth, z=[2e-6])
    x, w = np.polynomial.legendre.leggauss(20)
    forces = fp.indent(medium, tip, depth=depth * ((x + 1) / 2) ** 2).force.values
    # int F dd with d = depth s^2, for F goes like a power of d
    assert found.attrs["total"] == pytest.approx(float(np.sum(w / 2 * depth * (x + 1) * forces)), rel=tolerance)
    assert float(found.energy.sum()) == pytest.approx(found.attrs["total"], rel=1e-9)
    if medium is not POWER:
        # the base begins at that depth
        assert float(found.energy_below[0]) == pytest.approx(float(found.energy[1]), rel=1e-9)


@pytest.mark.parametrize("medium", [FILM, POWER])
def test_energy_on_cells(medium):
    """An ellipse that is all but round: 1e-4 of the energy of the exact round contact."""
    close = fp.EllipticParaboloid((1 + 1e-9) / 40e-6, 1 / 40e-6)
    cells, exact = (fp.energy_by_depth(medium, t, depth=5e-8, z=[0.5e-6, 2e-6]) for t in (close, fp.Paraboloid(20e-6)))
    np.testing.assert_allclose(cells.energy, exact.energy, rtol=1e-4)
    np.testing.assert_allclose(cells.energy_below, exact.energy_below, rtol=1e-4)


def test_energy_of_one_material_does_not_know_interfaces():
    parts = fp.Medium([fp.Layer(210e9, 0.3, 1e-6), fp.Layer(210e9, 0.3, 2e-6)], fp.HalfSpace(210e9, 0.3))
    found = fp.energy_by_depth(parts, fp.Sphere(20e-6), radius=1e-6)
    whole = fp.energy_by_depth(STEEL, fp.Sphere(20e-6), radius=1e-6, z=[1e-6, 3e-6])
    assert found.attrs["total"] == pytest.approx(whole.attrs["total"], rel=1e-10)
    below = whole.energy_below.values
    np.testing.assert_allclose(found.energy[1:], [below[0] - below[1], below[1]], rtol=1e-9)
