"""Interfaces far below a small contact, where its load acts like one at a point."""

import numpy as np
import pytest

import flatpunch as fp

DEPTH, SHEAR = 30e-6, 1e3
MEDIUM = fp.Medium([fp.Layer(1e9, 0.3, DEPTH)], base=fp.HalfSpace(1e9, 0.3))
# Boussinesq: 3 F/(2 pi) r z^2/(r^2 + z^2)^(5/2), largest at r = z/2
FORCE = SHEAR * 2 * np.pi * DEPTH**2 / 3 / (0.5 / 1.25**2.5)


@pytest.mark.long
@pytest.mark.parametrize(
    "tip",
    [fp.Sphere(20e-6), fp.Cone(0.5), fp.EllipticParaboloid(2.5e4, 5e4), fp.Pyramid(4, 0.5)],
    ids=lambda tip: type(tip).__name__,
)
def test_shear_of_a_point_load(tip):
    """At half the depth beside the axis; contacts are 1/70 of the depth and less, cells are joined to 0.1 %."""
    loads = fp.critical_loads(MEDIUM, tip, [fp.Strength(interface_shear=SHEAR)])
    assert float(loads.force[0]) == pytest.approx(FORCE, rel=1e-3 if tip.round else 5e-3)
    peaks = fp.peak_stresses(MEDIUM, tip, force=0.1 * FORCE)
    assert float(peaks.interface_shear[0]) == pytest.approx(0.1 * SHEAR, rel=1e-3)
    assert np.hypot(*peaks.interface_shear_place.values[0, :2]) == pytest.approx(DEPTH / 2, rel=0.05)


@pytest.mark.long
def test_rim_does_not_hide_the_lower_face():
    """Tension at the rim, which coarse cells overestimate, came first; a stiff film cracks at its lower face before."""
    film = fp.Medium([fp.Layer(1e11, 0.25, 4e-7)], base=fp.HalfSpace(1e10, 0.3))
    tip = fp.EllipticParaboloid(1 / 4e-6, 1 / 1.2e-6)
    loads = fp.critical_loads(film, tip, [fp.Strength(tensile=1e9)])
    assert loads.place.values[0] == pytest.approx([0, 0, 4e-7], abs=2e-8)
    below = fp.fields(film, tip, 0.0, 0.0, 4e-7, side="above", force=float(loads.force[0]))
    assert float(below.principal[0]) == pytest.approx(1e9, rel=5e-3)


@pytest.mark.long
def test_tension_in_a_base_under_a_sharp_tip_is_reached():
    """The mean pressure is the same at all sizes, but the base feels contacts as large as the film is thick alone."""
    body, tip = fp.Medium([fp.Layer(15e3, 0.3, 4e-6)], base=fp.HalfSpace(5e3, 0.3)), fp.Pyramid(4, 0.5)
    strengths = [fp.Strength(yield_stress=1e6), fp.Strength(tensile=60.0)]
    loads = fp.critical_loads(body, tip, strengths, friction=0.45)
    (load,) = loads.force.sel(criterion=["layers[1].tensile"]).values
    x, z = np.meshgrid(np.linspace(-8e-6, 8e-6, 41), np.linspace(4e-6, 12e-6, 9) * (1 + 1e-9))
    largest = fp.fields(body, tip, x, 0.0, z, force=float(load), friction=0.45).principal[0].max()
    assert float(largest) == pytest.approx(60.0, rel=0.05)


@pytest.mark.long
@pytest.mark.parametrize("stiffness", [0.02, 1e-3])
@pytest.mark.parametrize("tip", [fp.Paraboloid(10.0), fp.EllipticParaboloid(0.05, 0.06)], ids=["round", "elliptic"])
def test_layers_on_springs_bend_over_many_thicknesses(tip, stiffness):
    """A plate on springs lifts off its foundation several lengths beside a load, where the base is in tension as well."""
    springs = fp.Interface(normal=stiffness, shear=stiffness / 2)
    plate = fp.Medium([fp.Layer(2.0, 0.3, 1.0, bonded=springs)], base=fp.HalfSpace(1.0, 0.2))
    loads = fp.critical_loads(plate, tip, [fp.Strength(interface_tension=1e-4), fp.Strength(tensile=5e-4)])
    r = np.linspace(0, 60, 241)
    x, y = np.append(r, 0 * r), np.append(0 * r, r)
    above, below = (
        fp.fields(plate, tip, x, y, 1.0, force=float(force), side=side).stress.values
        for force, side in zip(loads.force.values, ("above", "below"), strict=True)
    )
    assert 0.97 < above[2].max() / 1e-4 < 1.01
    xx, yy, zz, yz, xz, xy = below
    tensor = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), -1, 0)
    assert 0.97 < np.linalg.eigvalsh(tensor).max() / 5e-4 < 1.01
