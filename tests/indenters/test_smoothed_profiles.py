"""Noise of measured profiles, and kinks that matter."""

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.indenters import Cone, HeightMap, Paraboloid, RadialProfile, Sphere
from flatpunch.media import HalfSpace

BODY = HalfSpace(1e9, 0.3)


def _force(tip, depth):
    return indent(BODY, tip, depth=[depth], angles=8)["force"].values[0]


@pytest.mark.parametrize("tip", [Cone(0.3), Paraboloid(1.5e-6), Sphere(2e-6)], ids=["cone", "paraboloid", "sphere"])
def test_smoothing_makes_a_noisy_profile_usable(tip):
    """0.5 nm noise at 300 points: refused as it is, and within 2 % of the true force once smoothed, at 80 nm."""
    r = np.linspace(0, 1.1e-6, 300)
    f = tip.height(r, 0.0) + 5e-10 * np.random.default_rng(5).normal(size=r.size)
    with pytest.raises(ValueError, match="RadialProfile"):
        RadialProfile(r, f)
    with pytest.raises(ValueError, match="smoothing = some spacings"):
        RadialProfile(r, np.maximum(f - f[0], 0) * (r > 0))
    smooth = RadialProfile(r, f, smoothing=6e-8)
    # the apex is known to a third of a nanometre, of 80, and the force goes with a power of up to 2
    assert _force(smooth, 8e-8) == pytest.approx(_force(tip, 8e-8), rel=0.02)
    (note,) = smooth.notes
    rms = float(note.split("changed by ")[1].split()[0])
    # what is taken out is the noise
    assert rms * (1e-12 if " pm rms" in note else 1e-9) == pytest.approx(5e-10, rel=0.1)
    assert note in indent(BODY, smooth, depth=[8e-8]).attrs["notes"]


@pytest.mark.parametrize("seed", range(10))
def test_smoothing_leaves_no_flat(seed):
    """Noise as high as the tip is at the width of the Gaussian: heights rise from one radius to the next, at the apex as well."""
    r = np.linspace(0, 5e-7, 101)
    noise = 1.5e-9 * np.random.default_rng(seed).normal(size=r.size)
    for tip in (Paraboloid(3e-7), Cone(0.35), Sphere(6e-7)):
        assert (np.diff(RadialProfile(r, tip.height(r, 0.0) + noise, smoothing=2.5e-8).f) > 0).all()


def test_smoothing_leaves_a_clean_profile_as_it_is():
    r = np.linspace(0, 1e-6, 80)
    for tip in (Cone(0.3), Paraboloid(2e-6)):
        f = tip.height(r, 0.0)
        # local parabolas reproduce lines and parabolas, to rounding
        np.testing.assert_allclose(RadialProfile(r, f, smoothing=5e-8).f, f, atol=1e-12 * f[-1])
    kinked = np.where(r < r[30], 0.1 * r, 0.1 * r[30] + 0.6 * (r - r[30]))
    kept = RadialProfile(r, kinked, [r[30]], smoothing=5e-8)
    np.testing.assert_allclose(kept.f, kinked, atol=1e-12 * kinked[-1])


@pytest.mark.parametrize("given", [False, True])
def test_kinks_that_change_the_force_are_noted(given):
    """A coarse table of a worn cone, whose edge lies between chords; the note's change is that of the contact."""
    r = np.linspace(0, 1e-6, 14)
    edge = r[5]
    f = np.where(r < edge, 0.15 * r, 0.15 * edge + 0.7 * (r - edge))
    plain, kinked = RadialProfile(r, f), RadialProfile(r, f, [edge])
    (note,) = (kinked if given else plain).notes
    change, depth = (float(note.split(word)[1].split()[0]) for word in ("by up to", "a depth of"))
    true = _force(kinked, depth * 1e-9) / _force(plain, depth * 1e-9) - 1
    # printed with one digit, and both forces from midpoints
    assert 100 * true == pytest.approx(change, abs=0.15)
    assert abs(change) > 1


@pytest.mark.parametrize("tip", [Cone(0.3), Paraboloid(1.5e-6), Sphere(1.2e-6)])
@pytest.mark.parametrize("count", [9, 40, 300])
def test_smooth_profiles_have_no_notes(tip, count):
    r = np.linspace(0, 1e-6, count)
    assert RadialProfile(r, tip.height(r, 0.0)).notes == ()


def test_smoothing_of_a_map_says_what_it_changed():
    x = np.linspace(-1e-6, 1e-6, 61)
    z = (x[:, None] ** 2 + x**2) / 4e-6 + 5e-10 * np.random.default_rng(6).normal(size=(61, 61))
    assert "smoothed over 70 nm: heights changed by" in HeightMap(x, x, z, smoothing=7e-8, reach=8e-7).notes[0]
    assert HeightMap(x, x, (x[:, None] ** 2 + x**2) / 4e-6).notes == ()
