"""Largest stresses by search, against brute force on fine points; every criterion's own load."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.indenters import Cylinder
from flatpunch.stresses.failure.critical_load import search_of


def _stack(rng, layers, thickest=0.2):
    return fp.Medium(
        [
            fp.Layer(10 ** rng.uniform(-0.7, 0.7), rng.uniform(0.1, 0.45), 10 ** rng.uniform(-0.7, thickest))
            for _ in range(layers)
        ],
        fp.HalfSpace(1.0, 0.3),
    )


def _brute(body, tip, i, friction):
    """Largest von Mises stress, tension and shear in one layer on about 10 000 points, with both sides of its faces."""
    faces = np.concatenate([[0.0], np.cumsum([layer.thickness for layer in body.layers])])
    bottom = faces[i + 1] if i < len(body.layers) else faces[i] + 4 * (1 + faces[i])
    z = faces[i] + (bottom - faces[i]) * (1 - np.cos(np.pi * np.linspace(0, 1, 33))) / 2
    beside = np.geomspace(1e-5, 0.1, 12)
    x = np.concatenate([np.linspace(0, 0.88, 24), 1 - beside[::-1], [1.0], 1 + beside, np.linspace(1.12, 3, 26)])
    x = np.concatenate([-x[:0:-1], x]) if friction else x
    largest = np.zeros(3)
    for side, depths in (("below", z[:-1]), ("above", z[-1:])):
        if side == "above" and i == len(body.layers):
            continue
        found = fp.fields(body, tip, x[:, None], 0.0, depths, radius=1.0, friction=friction, side=side)
        values = (found.von_mises.values, found.principal.values[0], found.max_shear.values)
        largest = np.maximum(largest, [each.max() for each in values])
    return largest


@pytest.mark.long
@pytest.mark.parametrize(("layers", "friction"), [(1, 0.0), (1, 0.4), (3, 0.0), (2, 0.2)])
@pytest.mark.parametrize("tip", [fp.Sphere(5.0), fp.Rounded(fp.Cone(0.4), radius=0.8)], ids=["sphere", "rounded"])
def test_no_point_has_more(tip, layers, friction):
    body = _stack(np.random.default_rng([layers, int(10 * friction), isinstance(tip, fp.Sphere)]), layers, thickest=0.5)
    peaks = fp.peak_stresses(body, tip, radius=1.0, friction=friction)
    for i in range(layers + 1):
        brute = _brute(body, tip, i, friction)
        for name, least in zip(("von_mises", "tension", "shear"), brute, strict=True):
            # the search may miss the place, never the value there
            assert float(peaks[name][i]) >= (1 - 1e-3) * least, (name, i)
            x, y, z = peaks[f"{name}_place"].values[i]
            side = (
                "above"
                if z > np.sum([layer.thickness for layer in body.layers[: i + 1]]) - 1e-9 and i < layers
                else "below"
            )
            there = fp.fields(body, tip, x, y, z, radius=1.0, friction=friction, side=side)
            value = {"von_mises": there.von_mises, "tension": there.principal[0], "shear": there.max_shear}[name]
            # the search ends its integrals early; the place has the value to 1e-4
            assert float(value.values.ravel()[0]) == pytest.approx(float(peaks[name][i]), rel=1e-3, abs=1e-4 * brute[0])


def test_tension_far_below_a_soft_layer():
    """Bending leaves no tension at the interface; the largest is twice the thickness below it, beyond the grid of the search."""
    body, depth = (
        fp.Medium([fp.Layer(40e9, 0.13, 15e-6)], base=fp.HalfSpace(200e9, 0.31)),
        np.linspace(16e-6, 90e-6, 100),
    )
    peaks = fp.peak_stresses(body, fp.Sphere(11e-6), radius=5.4e-6)
    axis = fp.fields(body, fp.Sphere(11e-6), 0.0, 0.0, depth, radius=5.4e-6).principal[0]
    assert 40e-6 < peaks.tension_place.values[1, 2] < 60e-6
    assert float(peaks.tension[1]) == pytest.approx(float(axis.max()), rel=1e-3)


@pytest.mark.long
def test_direction_turns_the_places():
    body = _stack(np.random.default_rng(5), 1)
    along, across = (
        fp.peak_stresses(body, fp.Sphere(5.0), radius=1.0, friction=0.3, direction=a) for a in (0, np.pi / 2)
    )
    np.testing.assert_allclose(across.tension, along.tension)
    np.testing.assert_allclose(across.tension_place[:, 1], along.tension_place[:, 0], atol=1e-12)


@pytest.mark.long
def test_edges_are_infinite_and_said_to_be():
    body = fp.HalfSpace(1.0, 0.3)
    for tip in (fp.Cone(0.3), Cylinder(1.0), fp.Truncated(fp.Cone(0.3), 0.1), fp.Vickers()):
        peaks = fp.peak_stresses(body, tip, depth=0.3)
        assert np.isinf(peaks.von_mises.values[0])
        assert np.isinf(peaks.shear.values[0])
        assert np.isfinite(peaks.tension.values[0])


def test_layers_of_two_bodies_and_rigid_bases():
    film = fp.Medium([fp.Layer(2.0, 0.3, 0.4)], fp.HalfSpace(1.0, 0.3))
    two = fp.peak_stresses(fp.TwoBodies(fp.HalfSpace(3.0, 0.2), film), fp.Paraboloid(5.0), radius=1.0)
    assert two.body.values.tolist() == ["upper", "lower", "lower"]
    assert two.layer.values.tolist() == [0, 0, 1]
    assert two.von_mises_place.values[0, 2] < 0 < two.von_mises_place.values[2, 2]
    rigid = fp.peak_stresses(fp.Medium([fp.Layer(1.0, 0.4, 0.5)], fp.RigidBase()), fp.Sphere(5.0), radius=1.0)
    assert rigid.sizes["layer"] == rigid.sizes["interface"] == 1


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_every_criterion_has_its_own_load(friction):
    body, tip = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], fp.HalfSpace(210e9, 0.3)), fp.Sphere(50e-6)
    strengths = [fp.Strength(yield_stress=8e9, tensile=2e9, interface_shear=0.5e9), fp.Strength(yield_stress=1.5e9)]
    loads = fp.critical_loads(body, tip, strengths, friction=friction)
    first = fp.critical_load(body, tip, strengths, friction=friction)
    assert float(loads.force.min()) == pytest.approx(first.force, rel=1e-6)
    assert loads.attrs["first"] == f"layers[{first.layer}].{first.kind}"
    alone = {
        "layers[0].yield": [fp.Strength(yield_stress=8e9)],
        "layers[0].tensile": [fp.Strength(tensile=2e9)],
        "layers[0].interface shear": [fp.Strength(interface_shear=0.5e9)],
        "layers[1].yield": [None, fp.Strength(yield_stress=1.5e9)],
    }
    assert set(loads.criterion.values) == set(alone)
    for name, own in alone.items():
        wanted = fp.critical_load(body, tip, own, friction=friction).force
        # loads are refined to about 1e-4
        assert float(loads.force.sel(criterion=name)) == pytest.approx(wanted, rel=3e-4)


def test_what_is_never_reached_is_infinite_without_a_place():
    loads = fp.critical_loads(fp.HalfSpace(1e9, 0.5), fp.Sphere(1e-3), [fp.Strength(yield_stress=1e12, tensile=1e6)])
    never = loads.sel(criterion="layers[0].yield")
    assert np.isinf(never.force)
    assert np.isnan(never.place).all()
    # the contact is as wide as the tip, and its pressure that of the ideal strength
    found = fp.critical_load(fp.HalfSpace(1e9, 0.3), fp.Sphere(0.2e-3), [fp.Strength(yield_stress=3e8)])
    assert any("mean pressure" in note for note in found.notes)


@pytest.mark.long
def test_places_beside_the_plane_of_sliding_are_found():
    body, tip = _stack(np.random.default_rng(5), 2), fp.Sphere(5.0)
    peaks = fp.peak_stresses(body, tip, radius=1.0, friction=0.5)
    assert peaks.tension_place.values[1, 1] > 0.4
    top, bottom = body.layers[0].thickness, body.thickness
    r, theta = np.linspace(0, 2, 41)[:, None, None], np.linspace(0, np.pi, 19)[:, None]
    for i, depths in enumerate(np.linspace((0, top, bottom), (top, bottom, bottom + 2), 9)[:-1].T):
        found = fp.fields(body, tip, r * np.cos(theta), r * np.sin(theta), depths, radius=1.0, friction=0.5)
        values = found.von_mises, found.principal[0], found.max_shear
        for name, each in zip(("von_mises", "tension", "shear"), values, strict=True):
            assert float(peaks[name][i]) >= (1 - 1e-3) * float(each.max()), (name, i)


@pytest.mark.long
@pytest.mark.parametrize("tilt", [0.03, 0.1])
def test_tension_beside_a_tilted_cone_is_what_fields_tend_to(tilt):
    """Stresses beside cells, from half a cell to three cells from the rim, extrapolated to it."""
    film, tip = fp.Medium([fp.Layer(3.0, 0.25, 1.0)], base=fp.HalfSpace(2.1, 0.3)), fp.Tilted(fp.Cone(0.2), tilt)
    (cells,) = bem.solve(fp.compliance(film), tip, grid=384, depths=0.1, tolerance=1e-5)
    load = fp.PatchLoad(cells.pressure, cells.grid.spacing, center=cells.grid.center)
    away = cells.grid.spacing * np.array([0.5, 1.0, 2.0, 3.0])
    beside = fp.fields(film, load, cells.outline.contour[0] + away, 0.0, 0.0).principal.values[0]
    at_rim = np.polyval(np.polyfit(away, beside, 2), 0.0)
    peak = fp.peak_stresses(film, tip, depth=0.1)
    assert peak.tension.values[0] == pytest.approx(at_rim, rel=peak.stress_error)
    assert peak.stress_error < 0.03


def test_traction_of_cells_is_friction_times_their_pressure():
    for friction in (0.0, 0.3):
        search, _ = search_of(fp.HalfSpace(1.0, 0.3), fp.Pyramid(4, 0.2), fp.Strength(yield_stress=1.0), friction, None)
        cells = search._cells(1.0, 32)
        assert cells.pressure.max() > 0
        assert np.array_equal(cells.traction, friction * cells.pressure)
