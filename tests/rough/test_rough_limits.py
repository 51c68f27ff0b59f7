"""Rough contact up to full contact, at tiny loads, on flat surfaces; its notes, refusals and memory."""

import re
import runpy
import tracemalloc

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.rough.solution import required
from support.rough_surfaces import HALF_SPACE, MEDIA, STAR, E, H, layer, wavy


@pytest.mark.long
def test_robust_to_full_contact():
    """99.9 % of the area, bodies ten times stiffer and softer at the surface, in one call without a failure."""
    rough = fp.self_affine(128, H, rms_slope=0.2, roll_off=64 * H, cut_off=4 * H)
    for medium in (*MEDIA.values(), layer(2e-6, 10 * E, base=HALF_SPACE), layer(5e-6, poisson=0.5)):
        full = fp.rough_contact(medium, rough, pressure=1e12)
        assert float(full.area_fraction[0]) == 1
        result = fp.rough_contact(medium, rough, pressure=np.geomspace(1e-3, 4, 12) * STAR * 0.2, limit=300)
        shares = result.area_fraction.values
        assert "not converged" not in result.notes
        assert (np.diff(shares) >= 0).all()
        assert (np.diff(result.mean_gap.values) <= 1e-15).all()
        assert result.gap_error.values.max() <= 1e-7
        assert shares[0] < 0.1


def test_well_resolved_surfaces_have_small_errors_and_no_note():
    x = np.arange(128) * H
    rough = fp.Topography(1e-7 * np.cos(2 * np.pi * x / (64 * H)) * np.cos(2 * np.pi * x[:, None] / (64 * H)), H)
    found = fp.rough_contact(HALF_SPACE, rough, pressure=1e6)
    assert found.area_error < 0.1 * found.area_fraction_corrected
    assert found.mean_gap_error < 0.01 * found.mean_gap
    assert "twice as wide" not in found.notes
    assert np.isnan(fp.rough_contact(HALF_SPACE, fp.self_affine(8, H, rms_height=1e-8), pressure=1e6).area_error).all()


def test_peaks_beyond_what_solids_bear_are_noted():
    notes = [fp.rough_contact(HALF_SPACE, wavy(64, 64, height), pressure=2e7).notes for height in (1e-7, 5e-6)]
    assert ["the largest pressure is up to" in each for each in notes] == [False, True]


def test_no_contact_and_its_fields():
    rough = fp.self_affine(32, H, rms_height=1e-7)
    result = fp.rough_contact(HALF_SPACE, rough, pressure=[0.0, 1e6], fields=True)
    assert result.area.values[0] == 0
    assert result.gap.values[0].min() == 0
    assert float(result.mean_gap[0]) == pytest.approx(rough.heights.max() - rough.heights.mean())
    assert result.pressure.values[1].mean() == pytest.approx(1e6, rel=1e-6)
    assert result.pressure.values.min() == 0
    assert result.gap.values[1].min() > -1e-12


def test_patches_join_across_the_border_where_the_surface_repeats():
    x = np.arange(64) * H
    ridge = np.cos(2 * np.pi * x / (64 * H)) * 1e-6 * np.ones((16, 1))
    joined = fp.rough_contact(layer(5e-6), fp.Topography(ridge, H), pressure=1e6)
    apart = fp.rough_contact(layer(5e-6), fp.Topography(ridge, H, periodic=(False, True)), pressure=1e6)
    assert (int(joined.patches[0]), int(apart.patches[0])) == (1, 2)
    assert "border" in apart.notes
    assert "border" not in joined.notes


@pytest.mark.parametrize("periodic", [True, False, (False, True)])
def test_a_tilted_scan_is_noted_and_levelled(tmp_path, periodic):
    """The tilt of the mount in a measured scan; a wave of the length of the period holds a plane too, and is none."""
    flat, x = fp.self_affine(64, H, rms_height=1e-8, roll_off=30 * H, cut_off=8 * H), np.arange(64) * H
    np.savez(tmp_path / "scan.npz", x=x, y=x, z=flat.heights + 0.002 * x)
    tilted, levelled = (
        fp.read_topography(tmp_path / "scan.npz", periodic=periodic, level=level) for level in (False, True)
    )
    assert re.search(r"A plane of slopes 0.00(20|19)", fp.rough_contact(HALF_SPACE, tilted, pressure=1e5).notes)
    assert "A plane" not in fp.rough_contact(HALF_SPACE, levelled, pressure=1e5).notes
    # the random surface holds a plane of its own, 4 % of its variance
    assert levelled.rms_height == pytest.approx(1e-8, rel=0.03)
    wave = fp.Topography(1e-8 * np.sin(2 * np.pi * x / (64 * H)) * np.ones((64, 1)), H)
    assert "A plane" not in fp.rough_contact(HALF_SPACE, wave, pressure=1e5).notes


def test_the_reported_tilted_scan(cases, tmp_path, monkeypatch, capsys):
    """Its README: a note wherever the plane is most of the rms height, which is at every tilt of the report."""
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(cases / "38_tilted_scan" / "show.py"))
    lines = capsys.readouterr().out.splitlines()
    assert [line.startswith("0.0 ") for line in lines] == ["A plane of slopes" not in line for line in lines]


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({}, ValueError, "exactly one of pressure, force and depth; got none"),
        ({"pressure": 1.0, "force": 1.0}, ValueError, "got pressure and force"),
        ({"pressure": -1.0}, ValueError, "pressure"),
        ({"pressure": [1.0, np.nan]}, ValueError, r"pressure\[1\] = nan"),
        ({"depth": 1e-9}, ValueError, "sinks without limit"),
        ({"pressure": 1.0, "fields": "yes"}, TypeError, "fields"),
        ({"pressure": 1.0, "tolerance": 2.0}, ValueError, "tolerance"),
    ],
)
def test_refusals(arguments, error, words):
    with pytest.raises(error, match=words):
        fp.rough_contact(HALF_SPACE, fp.self_affine(16, H, rms_height=1e-8), **arguments)


def test_wrong_units_are_said():
    rough = fp.Topography(fp.self_affine(16, 1.0, rms_height=0.5).heights, 1e-6)
    assert "Check the units" in fp.rough_contact(HALF_SPACE, rough, pressure=1e6).notes
    with pytest.raises(TypeError, match="topography"):
        fp.rough_contact(HALF_SPACE, rough.heights, pressure=1e6)


@pytest.mark.long
@pytest.mark.parametrize("periodic", [True, (True, False), False])
def test_memory_is_said_before_the_work(periodic, caplog):
    """An upper bound, and not more than twice what is taken."""
    rough = fp.Topography(fp.self_affine(512, H, rms_slope=0.1, roll_off=64 * H, cut_off=8 * H).heights, H, periodic)
    fp.rough_contact(MEDIA["elastic"], rough, pressure=0.02 * STAR, tolerance=1e-2)
    tracemalloc.start()
    with caplog.at_level("INFO", logger="flatpunch.rough"):
        fp.rough_contact(MEDIA["elastic"], rough, pressure=0.02 * STAR)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < required(rough) < 2 * peak
    assert f"at most {required(rough) / 1e6:.0f} MB" in caplog.text


@pytest.mark.parametrize("bonded", [True, pytest.param(False, marks=pytest.mark.long)], ids=["bonded", "sliding"])
def test_incompressible_layers_have_no_depth_beyond_full_contact(bonded):
    rough = fp.self_affine(16, H, rms_height=1e-7)
    full = rough.heights.max()
    body = layer(1e-6, poisson=0.5, bonded=bonded)
    with pytest.raises(ValueError, match="out of reach"):
        fp.rough_contact(body, rough, depth=[1e-8, full])
    near = fp.rough_contact(body, rough, depth=0.999 * full)
    assert near.valid.values[0]
    assert 0.9 < near.area_fraction.values[0] < 1


def test_flat_and_stepped_surfaces():
    """Heights that are all equal, a single spike, and two levels: on every kind of body, at any load."""
    flat = np.zeros((16, 16))
    spike, steps = flat.copy(), np.where(np.random.default_rng(0).random((16, 16)) > 0.5, 1e-7, 0.0)
    spike[5, 7] = 1e-7
    for body in (*MEDIA.values(), fp.PowerLawHalfSpace(E, 1e-6, 0.3, 0.3)):
        for heights in (flat, spike, steps):
            for periodic in (True, False, (True, False)):
                result = fp.rough_contact(body, fp.Topography(heights, H, periodic), pressure=[1e4, 1e8])
                assert result.valid.values.all()
                assert result.mean_pressure.values == pytest.approx([1e4, 1e8], rel=1e-6)
                assert (result.area_fraction.values == 1).all() or heights is not flat


def test_layers_on_rigid_bases_have_an_end():
    rough = fp.self_affine(16, H, rms_height=1e-7)
    result = fp.rough_contact(layer(1e-6), rough, pressure=1e11)
    assert not result.valid.values[0]
    assert "no surface gets there" in result.notes


@pytest.mark.parametrize("cells", [16, 64])
@pytest.mark.parametrize("share", [1e-10, 1e-20, 1e-25])
def test_tiny_loads(cells, share):
    """One cell touches, and displacements are proportional to the load, whatever the heights beside it and on wider cells."""
    rough = fp.self_affine(cells, H, rms_height=1e-7, cut_off=8 * H)
    load = share * fp.full_contact(HALF_SPACE, rough).rms_pressure
    result = fp.rough_contact(HALF_SPACE, rough, pressure=[load, 2 * load])
    assert result.valid.values.all()
    assert result.mean_pressure.values == pytest.approx([load, 2 * load])
    assert result.area_fraction.values == pytest.approx(1 / cells**2)
    assert result.mean_gap.values == pytest.approx(rough.heights.max())


@pytest.mark.parametrize("share", [1e-3, 0.05, 0.5])
def test_thin_gels_converge_as_fast_as_half_spaces(share):
    """Their stiffness grows steeply with the contact, so that the one of a first loose solution is worth little."""
    rough = fp.self_affine(256, H, rms_slope=0.1, roll_off=32 * H, cut_off=8 * H)
    gel = layer(12 * H, poisson=0.5)
    result = fp.rough_contact(gel, rough, pressure=share * fp.full_contact(gel, rough).rms_pressure, limit=100)
    assert "not converged" not in result.notes


@pytest.mark.parametrize(("spacing", "words"), [(1.0, "touches at every step"), (1e-12, "slopes as small"), (H, "")])
def test_spacing_in_a_wrong_unit_is_told(spacing, words):
    heights = fp.self_affine(32, H, rms_slope=0.1).heights
    notes = fp.rough_contact(HALF_SPACE, fp.Topography(heights, spacing), pressure=[0.01 * STAR, 0.02 * STAR]).notes
    assert words in notes
    assert bool(words) == ("units of heights" in notes)
