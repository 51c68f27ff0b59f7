"""Stresses in and below transversely isotropic layers: closed form at the surface, continuity, isotropic limit, first failure."""

import numpy as np
import pytest
from scipy.special import jv

import flatpunch as fp
from flatpunch.stresses.axisymmetric.radial import NORMAL_ORDERS, SHEAR_ORDERS, AnisotropicPart, SurfacePart
from flatpunch.stresses.axisymmetric.ring_sources import sampled
from flatpunch.stresses.axisymmetric.uniform_disc import UniformDisc
from support.propagators import random_material

STIFFNESSES = 1060e9, 180e9, 15e9, 36.5e9, 4.5e9
GRAPHITE = fp.TransverselyIsotropicHalfSpace.from_stiffnesses(*STIFFNESSES)
COLUMNS = fp.TransverselyIsotropicLayer(250e9, 400e9, 0.25, 0.2, 110e9, thickness=2e-6)
COMPLEX = fp.TransverselyIsotropicLayer(10e9, 10e9, 0.2, 0.2, 40e9, thickness=1e-6)
FLAKE = fp.TransverselyIsotropicLayer.from_stiffnesses(*STIFFNESSES, thickness=0.5e-6)
STEEL = fp.HalfSpace(210e9, 0.3)
BODIES = {
    "graphite": GRAPHITE,
    "columns on steel": fp.Medium([COLUMNS], STEEL),
    "complex rates on steel": fp.Medium([COMPLEX], STEEL),
    "glass on graphite": fp.Medium([fp.Layer(70e9, 0.2, 1e-6)], GRAPHITE),
    "flake on columns on graphite": fp.Medium([FLAKE, COLUMNS], GRAPHITE),
}
TIP, RADIUS = fp.Sphere(10e-6), 1e-6
LOADS = UniformDisc(1.0), sampled(lambda t: 1 - t * t, np.array([0, 0.5, 1.0]), 1e-12)


@pytest.mark.long
@pytest.mark.parametrize("load", LOADS, ids=["disc", "rings"])
def test_surface_part_against_quadrature(load):
    """Real and complex rates; the quadrature is exact to rounding."""
    rng = np.random.default_rng(0)
    r, z = np.array([0.3, 1.2, 2.0]), np.array([0.5, 0.3, 1.0])
    x, w = np.polynomial.legendre.leggauss(40)
    kinds = set()
    for _ in range(8):
        part = AnisotropicPart(fp.TransverselyIsotropicHalfSpace(*random_material(rng)).plane)
        kinds.add(part._solid.square > 0)
        last = 60 / (min(part._solid.slowest, part._solid.sideways[0]) * z.min())
        edges = np.linspace(0, last, int(last / 3) + 5)
        half = np.diff(edges)[:, None] / 2
        k, weight = (edges[:-1, None] + half * (1 + x)).ravel(), (half * w).ravel()
        waves, strength = part.amplitudes(k, z, True), weight * k * load.transform(k)
        exact = np.array(
            [
                [strength @ (jv(m, k * r[i]) * waves[f][:, i]) for i in range(3)]
                for f, m in enumerate(NORMAL_ORDERS + SHEAR_ORDERS)
            ]
        )
        error = np.abs(part.of_load(load, r, z, True) - exact)
        assert np.all(error <= 1e-11 * np.abs(exact).max(axis=1, keepdims=True))
    assert kinds == {True, False}


@pytest.mark.parametrize("load", LOADS, ids=["disc", "rings"])
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_surface_part_of_isotropic_material(load, nu):
    """Equal rates: the sum over the circle leaves 1e-13; nearly equal ones differ by their distance."""
    rng = np.random.default_rng(1)
    r, z = rng.uniform(0, 3, 30), rng.uniform(0, 2, 30)
    r[:5], z[:5] = (0.0, 0.5, 1.5, 0.9999, 0.0), (1.0, 0.0, 0.0, 1e-4, 0.0)
    exact = SurfacePart(fp.HalfSpace(2.0, nu)).of_load(load, r, z, True)
    for near, error in ((0.0, 1e-12), (1e-9, 1e-8), (1e-5, 1e-4)):
        body = fp.TransverselyIsotropicHalfSpace(
            2 * (1 + near), 2.0, nu * (1 - 2 * near), nu * (1 - 2 * near), 1 / (1 + nu)
        )
        np.testing.assert_allclose(AnisotropicPart(body.plane).of_load(load, r, z, True), exact, atol=error, rtol=0)


@pytest.mark.parametrize("name", BODIES)
def test_contact_under_friction(name):
    """At the surface the stresses are pressure and traction, the surface follows the tip, and interfaces carry no jump."""
    body, x = BODIES[name], np.linspace(-2e-6, 2e-6, 21)
    pressure = fp.pressure(body, TIP, x, 0.0, radius=RADIUS)
    surface = fp.fields(body, TIP, x, 0.0, 0.0, radius=RADIUS, friction=0.3)
    scale = float(pressure.max())
    assert surface.attrs["stress_error"] < 1e-9
    np.testing.assert_allclose(surface.stress.sel(component="zz"), -pressure, atol=1e-9 * scale)
    np.testing.assert_allclose(surface.stress.sel(component="xz"), -0.3 * pressure, atol=1e-9 * scale)
    inside = np.abs(x) < RADIUS
    contact = fp.indent(body, TIP, radius=RADIUS)
    plain = fp.fields(body, TIP, x[inside], 0.0, 0.0, radius=RADIUS).displacement.sel(axis="z")
    depth = float(contact.depth[0])
    np.testing.assert_allclose(plain, depth - TIP.height(np.abs(x[inside]), 0 * x[inside]), atol=1e-10 * depth)
    for face in np.cumsum([layer.thickness for layer in getattr(body, "layers", ())]):
        above, below = (
            fp.fields(body, TIP, x, 0.3e-6, face, radius=RADIUS, friction=0.3, side=side) for side in ("above", "below")
        )
        jump = np.abs(above - below)
        assert float(jump.stress.sel(component=["zz", "yz", "xz"]).max()) < 1e-10 * scale
        assert float(jump.displacement.max()) < 1e-10 * depth


def test_force_through_a_plane():
    """The stress on a plane in a layer below carries the force."""
    body = BODIES["flake on columns on graphite"]
    x, w = np.polynomial.legendre.leggauss(60)
    t = (1 + x) / 2
    r, weight = 1e-6 * t / (1 - t * 0.995), w / 2 * 1e-6 / (1 - t * 0.995) ** 2
    found = fp.fields(body, TIP, r, 0.0, 1.2e-6, radius=RADIUS)
    force = float(fp.indent(body, TIP, radius=RADIUS).force[0])
    missing = float(np.sum(weight * 2 * np.pi * r * found.stress.sel(component="zz")))
    # what flows through the plane beyond 200 um is a thousandth
    assert -missing == pytest.approx(force, rel=5e-3)


@pytest.mark.long
def test_pyramid_on_isotropic_constants():
    """Cells: discs take the place of squares on an anisotropic surface; the estimate of the error covers the difference."""
    bodies = (
        fp.Medium([fp.TransverselyIsotropicLayer(10e9, 10e9, 0.3, 0.3, 10e9 / 2.6, 1e-6)], STEEL),
        fp.Medium([fp.Layer(10e9, 0.3, 1e-6)], STEEL),
    )
    points = ([0.1e-6, 0.3e-6], 0.05e-6, [[0.0], [0.2e-6], [0.8e-6]])
    ours, theirs = (fp.fields(body, fp.Vickers(), *points, depth=1e-7, friction=0.2) for body in bodies)
    scale = float(np.abs(theirs.stress).max())
    assert float(np.abs(ours.stress - theirs.stress).max()) < 2e-3 * scale


@pytest.mark.long
def test_energy_sensitivity_and_failure():
    """Energies of the layers add up to the work; derivatives by all moduli to one; isotropic constants fail alike."""
    body = BODIES["flake on columns on graphite"]
    energy = fp.energy_by_depth(body, TIP, radius=RADIUS)
    half = fp.indent(body, TIP, depth=np.linspace(0, float(fp.indent(body, TIP, radius=RADIUS).depth[0]), 201))
    assert float(energy.energy.sum()) == pytest.approx(float(np.trapezoid(half.force, half.depth)), rel=1e-4)
    found = fp.sensitivity(body, TIP, radius=RADIUS)
    moduli = [name for name in found.parameter.values if name.split(".")[-1].startswith(("young", "shear"))]
    assert len(moduli) == 9
    assert float(found.force.sel(parameter=moduli).sum()) == pytest.approx(1.0, abs=1e-9)
    film = fp.TransverselyIsotropicLayer(10e9, 10e9, 0.3, 0.3, 10e9 / 2.6, 1e-6)
    strengths = [fp.Strength(yield_stress=3e9, interface_shear=1e9), fp.Strength(yield_stress=2e9)]
    ours = fp.critical_load(fp.Medium([film], STEEL), TIP, strengths, friction=0.2)
    theirs = fp.critical_load(fp.Medium([fp.Layer(10e9, 0.3, 1e-6)], STEEL), TIP, strengths, friction=0.2)
    assert (ours.kind, ours.layer) == (theirs.kind, theirs.layer)
    assert ours.force == pytest.approx(theirs.force, rel=1e-6)


GRADED = {
    "columns": fp.GradedLayer(
        fp.LinearModulus(250e9, 210e9, 1e-6),
        0.25,
        1e-6,
        True,
        fp.ExponentialModulus(500e9, 210e9, 1e-6),
        0.2,
        fp.LinearModulus(60e9, 100e9, 1e-6),
    ),
    # the slower rate is 0.1 at the surface and 0.85 at the base, so that the surface's own half-space reaches ten times as deep
    "slow at the surface": fp.GradedLayer(
        fp.LinearModulus(5e9, 50e9, 1e-6),
        0.25,
        1e-6,
        True,
        fp.ExponentialModulus(100e9, 50e9, 1e-6),
        0.2,
        fp.LinearModulus(1e9, 20e9, 1e-6),
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("name", GRADED)
@pytest.mark.parametrize("radius", [0.05e-6, 1e-6])
def test_graded_anisotropic_surface_under_friction(name, radius):
    """Pressure and traction at the surface, and no jump at the base, under contacts much smaller than the layer too."""
    body, x = fp.Medium([GRADED[name]], STEEL), np.linspace(-2, 2, 9) * radius
    pressure = fp.pressure(body, TIP, x, 0.0, radius=radius)
    surface = fp.fields(body, TIP, x, 0.0, 0.0, radius=radius, friction=0.3)
    scale = float(pressure.max())
    # waves shorter than 1/500 of the radius fade out under a graded surface
    np.testing.assert_allclose(surface.stress.sel(component="zz"), -pressure, atol=5e-5 * scale)
    np.testing.assert_allclose(surface.stress.sel(component="xz"), -0.3 * pressure, atol=2e-5 * scale)
    above, below = (
        fp.fields(body, TIP, x, 0.3 * radius, 1e-6, radius=radius, friction=0.3, side=side)
        for side in ("above", "below")
    )
    jump = np.abs(above - below)
    assert float(jump.stress.sel(component=["zz", "yz", "xz"]).max()) < 3e-9 * scale
    depth = float(fp.indent(body, TIP, radius=radius).depth[0])
    assert float(jump.displacement.max()) < 3e-9 * depth


@pytest.mark.long
def test_first_failure_of_a_graded_layer_with_isotropic_constants():
    young, strengths = (
        fp.LinearModulus(10e9, 30e9, 1e-6),
        [fp.Strength(yield_stress=3e9), fp.Strength(yield_stress=2e9)],
    )
    shear = fp.LinearModulus(10e9 / 2.6, 30e9 / 2.6, 1e-6)
    ours, theirs = (
        fp.critical_load(fp.Medium([film], STEEL), TIP, strengths, friction=0.2)
        for film in (fp.GradedLayer(young, 0.3, 1e-6, True, young, 0.3, shear), fp.GradedLayer(young, 0.3, 1e-6))
    )
    assert (ours.kind, ours.layer) == (theirs.kind, theirs.layer)
    assert ours.force == pytest.approx(theirs.force, rel=1e-6)
