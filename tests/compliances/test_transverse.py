"""Transversely isotropic layers and half-spaces under load waves: closed forms, multiprecision, limits, derivatives."""

from dataclasses import replace

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances.depth import waves_at
from flatpunch.compliances.derivatives import compliance_derivatives, energy_density
from flatpunch.compliances.response import layered_response
from flatpunch.media.transverse import CONSTANTS
from support.propagators import random_material, random_stack, wave

GRAPHITE = fp.TransverselyIsotropicHalfSpace.from_stiffnesses(1060e9, 180e9, 15e9, 36.5e9, 4.5e9)


def delafargue_ulm(c11, c12, c13, c33, c44):
    """Indentation modulus along the axis of symmetry (Delafargue and Ulm 2004)."""
    return 2 * np.sqrt((c11 * c33 - c13**2) / c11 / (1 / c44 + 2 / (np.sqrt(c11 * c33) + c13)))


def test_indentation_modulus_of_delafargue_and_ulm():
    """Real rates, complex rates and equal ones; a few roundings of the engineering constants."""
    rng = np.random.default_rng(1)
    bodies = [GRAPHITE] + [fp.TransverselyIsotropicHalfSpace(*random_material(rng)) for _ in range(200)]
    checked = 0
    for body in bodies:
        if np.isfinite(body.stiffnesses.c33) and body.stiffnesses.c33 < 1e6 * body.young_axial:
            assert body.surface_modulus == pytest.approx(delafargue_ulm(*body.stiffnesses), rel=1e-12)
            assert fp.compliance(body).modulus == body.surface_modulus
            checked += 1
    assert checked > 100


@pytest.mark.long
def test_response_of_random_stacks_against_multiprecision():
    """Largest error of 180 in a search: 7e-15."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        medium = random_stack(rng)
        k = 10 ** rng.uniform(-3, 1.5)
        ours = layered_response(medium, np.array([k]))[0] * 2 / (medium.surface_modulus * k)
        theirs = wave(medium, k, 0.0, 0, (0, -1))[1] / k
        assert ours == pytest.approx(theirs, rel=1e-12)


@pytest.mark.long
def test_fields_of_random_stacks_against_multiprecision():
    """Displacements and stresses are each judged by their own size; largest error of 80 in a search: 1e-12."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        medium = random_stack(rng)
        elastic = not isinstance(medium.base, fp.RigidBase)
        faces = np.concatenate([[0.0], np.cumsum([layer.thickness for layer in medium.layers])])
        layer = int(rng.integers(0, len(medium.layers) + elastic))
        k = 10 ** rng.uniform(-3, 0.7)
        z = faces[layer] + rng.random() * (medium.layers[layer].thickness if layer < len(medium.layers) else 1 / k)
        waves = waves_at(medium, np.array([k]), np.array([z]), np.array([layer]))
        for found, load in ((waves.normal, (0, -1)), (waves.shear, (1, 0)), (waves.transverse, (1,))):
            exact = wave(medium, k, z, layer, load)
            half = len(exact) // 2
            for ours, theirs in ((found[:half, 0, 0], exact[:half]), (found[half : 2 * half, 0, 0], exact[half:])):
                np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11 * np.abs(theirs).max())


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_isotropic_constants_give_the_isotropic_layer(nu):
    """Rounding only: both propagators are exact."""
    young, k, z = 2.0, np.geomspace(1e-4, 20, 30), np.array([0.0, 0.4, 1.0, 2.0])
    base = fp.HalfSpace(1.0, 0.2)
    one = fp.Medium([fp.Layer(young, nu, 1.0)], base)
    other = fp.Medium([fp.TransverselyIsotropicLayer(young, young, nu, nu, young / (2 * (1 + nu)), 1.0)], base)
    np.testing.assert_allclose(layered_response(other, k), layered_response(one, k), rtol=1e-13)
    layer = np.array([0, 0, 0, 1])
    ours, theirs = waves_at(other, k, z, layer), waves_at(one, k, z, layer)
    for name in ("normal", "shear", "transverse"):
        mine, exact = getattr(ours, name), getattr(theirs, name)
        assert np.all(np.abs(mine - exact) <= 1e-12 * np.abs(exact).max(axis=(1, 2), keepdims=True))


def test_layers_of_one_material_are_one_body():
    material = (3.0, 1.0, 0.2, 0.3, 0.7)
    layers = [fp.TransverselyIsotropicLayer(*material, h) for h in (0.3, 2.0, 1.0, 0.1, 0.7)]
    medium = fp.Medium(layers, fp.TransverselyIsotropicHalfSpace(*material))
    k = np.geomspace(1e-4, 100, 50)
    np.testing.assert_allclose(fp.compliance(medium)(k) * medium.surface_modulus * k / 2, 1.0, rtol=1e-12)


def test_graded_layers_among_anisotropic_ones():
    """A graded layer of constant modulus is a homogeneous one."""
    cover = fp.TransverselyIsotropicLayer(3.0, 1.0, 0.2, 0.3, 0.7, 0.5)
    base = fp.TransverselyIsotropicHalfSpace(2.0, 5.0, 0.1, 0.2, 1.5)
    k = np.geomspace(1e-3, 30, 40)
    one, other = (
        fp.compliance(fp.Medium([cover, middle], base))(k)
        for middle in (fp.Layer(2.0, 0.3, 1.0), fp.GradedLayer(2.0, 0.3, 1.0))
    )
    np.testing.assert_allclose(other, one, rtol=1e-10)


@pytest.mark.parametrize("near", [None, 1e-2, 1e-5, 1e-9])
def test_derivatives_against_differences(near):
    """By all constants and the thickness, also where both rates are nearly equal; differences leave 1e-7."""
    rng = np.random.default_rng(3)
    material = random_material(rng) if near is None else (1 + near, 1.0, 0.3, 0.3, 1 / 2.6)
    film = fp.TransverselyIsotropicLayer(*material, 1.3)
    base = fp.TransverselyIsotropicHalfSpace(2.0, 5.0, 0.1, 0.2, 1.5)
    k = np.array([0.1, 1.0, 5.0])

    def compliance(*changes):
        layers = [replace(film, **changes[0]), fp.Layer(1.0, 0.3, 0.7)]
        medium = fp.Medium(layers, replace(base, **changes[1]))
        return 2 * layered_response(medium, k) / (medium.surface_modulus * k)

    found = compliance_derivatives(fp.Medium([film, fp.Layer(1.0, 0.3, 0.7)], base), k)
    for part, body in ((0, film), (2, base)):
        for name in (*CONSTANTS, "thickness")[: 6 if part == 0 else 5]:
            step = 1e-4 * getattr(body, name)
            samples = []
            for sign in (1, -1):
                change = {name: getattr(body, name) + sign * step}
                samples.append(compliance(change, {}) if part == 0 else compliance({}, change))
            slope = (samples[0] - samples[1]) / (2 * step)
            ours = found[part].thickness if name == "thickness" else found[part].constants[name][0]
            np.testing.assert_allclose(ours, slope, atol=1e-6 * np.abs(slope).max())
            if name != "thickness":
                moduli = [replace(body, **{name: getattr(body, name) + s * step}).surface_modulus for s in (1, -1)]
                assert body.surface_slope(name) == pytest.approx(np.log(moduli[0] / moduli[1]) / (2 * step), rel=1e-4)


def test_energy_density_adds_up():
    """Over the depth of a half-space it is C(k)."""
    k = np.array([1.0, 3.0])
    x, w = np.polynomial.legendre.leggauss(120)
    body = fp.TransverselyIsotropicHalfSpace(2.0, 5.0, 0.1, 0.2, 1.5)
    z = 20 * (1 + x)
    density = energy_density(body, k, z, np.zeros(z.size, dtype=int))
    np.testing.assert_allclose(density @ (20 * w), fp.compliance(body)(k), rtol=1e-9)


def test_many_layers_and_pairs():
    """Interpolated responses of more than four layers are those of the recursion."""
    rng = np.random.default_rng(5)
    layers = [fp.TransverselyIsotropicLayer(*random_material(rng), 10 ** rng.uniform(-0.5, 0.5)) for _ in range(8)]
    medium = fp.Medium(layers, fp.TransverselyIsotropicHalfSpace(2.0, 5.0, 0.1, 0.2, 1.5))
    k = np.geomspace(1e-4, 100, 200)
    kernel = fp.compliance(medium)
    np.testing.assert_allclose(kernel.response(k * kernel.length), layered_response(medium, k), rtol=1e-10)
    pair = fp.compliance(fp.TwoBodies(GRAPHITE, fp.HalfSpace(10e9, 0.3)))
    assert 1 / pair.modulus == pytest.approx(1 / GRAPHITE.surface_modulus + 1 / fp.HalfSpace(10e9, 0.3).surface_modulus)
