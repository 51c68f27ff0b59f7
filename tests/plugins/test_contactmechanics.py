"""Substrates of ContactMechanics: its own half-spaces, layer and anisotropic body, and contacts of this package."""

import numpy as np
import pytest

import flatpunch as fp

host = pytest.importorskip("ContactMechanics", reason="ContactMechanics is installed in environments of its own only")
plugin = pytest.importorskip("flatpunch.plugins.contactmechanics")

STEEL = fp.HalfSpace(200e9, 0.3)
LAYER = fp.Medium([fp.Layer(1.0, 0.3, 0.2)], fp.RigidBase())
FILM = fp.Medium([fp.Layer(1.0, 0.3, 0.2)], fp.HalfSpace(10.0, 0.2))


@pytest.mark.parametrize("points", [(16, 16), (15, 12), (16, 9), (12,), (13,)])
@pytest.mark.parametrize("stiffness", [None, 0.0, 3e15])
def test_periodic_half_space_is_the_hosts(points, stiffness):
    sizes = tuple(1e-6 * n for n in points)
    if len(points) == 1 and stiffness == 0.0:
        pytest.skip(
            "ContactMechanics 1.8.3 has no half-space in one dimension with stiffness_q0=0 to compare with: it raises"
        )
    own = plugin.PeriodicMedium(points, STEEL, sizes, stiffness_q0=stiffness)
    theirs = host.PeriodicFFTElasticHalfSpace(points, STEEL.surface_modulus, sizes, stiffness_q0=stiffness)
    for name in ("greens_function", "surface_stiffness"):
        np.testing.assert_allclose(getattr(own, name), getattr(theirs, name), rtol=1e-14)


def test_periodic_layer_is_the_hosts():
    own = plugin.PeriodicMedium((16, 12), LAYER, (1.0, 1.0))
    theirs = host.PeriodicFFTElasticHalfSpace((16, 12), 1.0, (1.0, 1.0), thickness=0.2, poisson=0.3)
    np.testing.assert_allclose(own.greens_function, theirs.greens_function, rtol=1e-13)


@pytest.mark.parametrize("periodicity", [None, (False, True), (True, False), (True, True), (False, False)])
@pytest.mark.parametrize("points", [(16, 16), (15, 12)])
def test_free_and_semi_periodic_half_spaces_are_the_hosts(points, periodicity):
    kind, options = ("Free", {}) if periodicity is None else ("SemiPeriodic", {"periodicity": periodicity})
    own = getattr(plugin, f"{kind}Medium")(points, STEEL, points, **options)
    theirs = getattr(host, f"{kind}FFTElasticHalfSpace")(points, STEEL.surface_modulus, points, **options)
    scale = np.abs(theirs.greens_function).max()
    np.testing.assert_allclose(own.greens_function, theirs.greens_function, rtol=0, atol=1e-11 * scale)


@pytest.mark.parametrize("medium", [STEEL, LAYER, FILM], ids=["half-space", "layer", "film"])
def test_contact_on_a_layer(medium):
    """A paraboloid, pressed in without repetition: force to 1e-3."""
    from SurfaceTopography import Topography

    n, depth = 64, 0.08
    x = np.arange(n) / n - 0.5
    surface = Topography(-(x[:, None] ** 2 + x**2) / 2, (1.0, 1.0))
    system = host.make_system(substrate=plugin.FreeMedium((n, n), medium, (1.0, 1.0)), surface=surface)
    assert system.minimize_proxy(offset=depth, pentol=1e-9 * medium.surface_modulus).success
    force = float(fp.indent(medium, fp.Paraboloid(1.0), depth=depth).force[0])
    assert system.compute_normal_force() == pytest.approx(force, rel=1e-3)
    smaller = system.substrate.spawn_child((16, 16))
    assert smaller.medium is medium
    assert smaller.physical_sizes == (0.25, 0.25)


def test_greens_function_of_an_isotropic_half_space():
    from ContactMechanics.GreensFunctions import IsotropicGreensFunction

    qx, qy = np.random.default_rng(0).normal(size=(2, 20)) * 1e6
    own, theirs = plugin.MediumGreensFunction(STEEL), IsotropicGreensFunction(200e9 / 2.6, 0.3)
    for name in ("greens_function", "stiffness", "__call__"):
        found, wanted = getattr(own, name)(qx, qy), getattr(theirs, name)(qx, qy)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-14 * np.abs(wanted).max())


@pytest.mark.parametrize("thickness", [None, 0.7])
def test_cubic_greens_function_is_approached_by_a_transversely_isotropic_one(thickness):
    """Averaged over the direction in the surface, a cubic body is transversely isotropic to first order in its anisotropy."""
    from ContactMechanics.GreensFunctions import AnisotropicGreensFunction

    phi = np.pi * np.arange(8) / 8
    qx, qy = np.cos(phi), np.sin(phi)
    along = np.array([[qx, qy, 0 * qx], [-qy, qx, 0 * qx], [0 * qx, 0 * qx, 0 * qx + 1]]).transpose(2, 0, 1)
    errors = []
    for anisotropy in (0.08, 0.04, 0.02):
        c12, c44 = 1.0, 1.0
        c11 = c12 + 2 * c44 - anisotropy
        cubic = AnisotropicGreensFunction(c11, c12, c44, thickness=thickness).greens_function(qx, qy)
        mean = (along @ cubic @ along.swapaxes(1, 2)).mean(axis=0)
        # stiffnesses averaged over rotations about z
        in_plane = (3 * c11 + c12 + 2 * c44) / 4, (c11 + 3 * c12 - 2 * c44) / 4
        kind = fp.TransverselyIsotropicHalfSpace if thickness is None else fp.TransverselyIsotropicLayer
        body = kind.from_stiffnesses(*in_plane, c12, c11, c44, *([] if thickness is None else [thickness]))
        body = body if thickness is None else fp.Medium([body], fp.RigidBase())
        found = plugin.MediumGreensFunction(body).greens_function(np.ones(1), np.zeros(1))[0]
        errors.append(np.abs(found - mean).max() / np.abs(mean).max())
    assert errors[-1] < 3e-5
    # second order
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.2)


def test_what_is_no_part_of_a_medium_is_refused():
    with pytest.raises(TypeError, match="thickness is a part of the medium"):
        plugin.PeriodicMedium((8, 8), STEEL, thickness=1.0)
    with pytest.raises(plugin.FreeMedium.Error, match="square cells"):
        plugin.FreeMedium((8, 8), STEEL, (1.0, 2.0))
