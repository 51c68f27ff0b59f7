"""Fields per wavenumber: closed forms, a second road in 32 digits, continuity, equilibrium, graded layers."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances.depth import waves_at
from support.airy import solve, state


def random_stack(rng):
    layers = [
        fp.Layer(
            young=10.0 ** rng.uniform(-2, 2),
            poisson=rng.choice([0.5, rng.uniform(0, 0.49)]),
            thickness=10.0 ** rng.uniform(-1, 0.5),
            bonded=bool(rng.random() < 0.7),
        )
        for _ in range(rng.integers(1, 6))
    ]
    base = fp.RigidBase() if rng.random() < 0.4 else fp.HalfSpace(10.0 ** rng.uniform(-2, 2), rng.uniform(0, 0.5))
    return fp.Medium(layers, base)


@pytest.mark.long
def test_second_road_at_five_hundred_random_points():
    """100 random stacks, five points each; rounding grows with the contrast of moduli, up to 1e4 here."""
    rng = np.random.default_rng(4)
    worst = 0.0
    for _ in range(100):
        medium = random_stack(rng)
        elastic = isinstance(medium.base, fp.HalfSpace)
        tops = np.concatenate([[0.0], np.cumsum([layer.thickness for layer in medium.layers])])
        which = rng.integers(0, len(medium.layers) + elastic, 5)
        thickness = np.array([layer.thickness for layer in medium.layers] + [1.0])
        inside = rng.random(5) * thickness[which]
        k = 10.0 ** rng.uniform(-2.5, 0.8)
        layers = [(m.young / (2 * (1 + m.poisson)), m.poisson, m.thickness, m.bonded) for m in medium.layers]
        base = (medium.base.young / (2 * (1 + medium.base.poisson)), medium.base.poisson) if elastic else None
        waves = waves_at(medium, np.array([k]), tops[which] + inside, which)
        for found, load in ((waves.normal, (0, -1)), (waves.shear, (1, 0))):
            constants = solve(layers, base, k, load)
            for i in range(5):
                u_l, u_z, s_lz, s_zz, mean, difference = found[:, 0, i]
                exact = state(constants, layers, base, k, int(which[i]), inside[i])
                # displacements and stresses are each judged by their own size at that depth
                for mine, theirs in (([u_l, u_z], exact[:2]), ([s_lz, s_zz, mean + difference], exact[2:])):
                    worst = max(worst, float(np.max(np.abs(np.array(mine) - theirs)) / np.max(np.abs(theirs))))
    assert worst < 1e-9


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_half_space_closed_form(nu):
    body = fp.HalfSpace(3.0, nu)
    mu = 3.0 / (2 * (1 + nu))
    k, z = np.geomspace(1e-4, 30, 20), np.array([0, 0.1, 1, 3.0])
    x = k[:, None] * z
    decay = np.exp(-x)
    waves = waves_at(body, k, z, np.zeros(4, dtype=int))
    normal = [-(1 - 2 * nu - x) / (2 * mu), (2 * (1 - nu) + x) / (2 * mu), -x, -(1 + x)]
    shear = [(x - 2 * (1 - nu)) / (2 * mu), (1 - 2 * nu + x) / (2 * mu), 1 - x, -x]
    np.testing.assert_allclose(waves.normal[:4], np.array(normal) * decay, atol=1e-15)
    np.testing.assert_allclose(waves.shear[:4], np.array(shear) * decay, atol=1e-15)
    np.testing.assert_allclose(waves.transverse[:2], np.array([-decay / mu, decay]), atol=1e-15)


def test_equal_layers_are_one_body():
    k, z = np.geomspace(1e-3, 30, 15), np.array([0, 0.3, 1.2, 3.0])
    stack = fp.Medium([fp.Layer(3.0, 0.3, 0.5), fp.GradedLayer(3.0, 0.3, 1.5)], fp.HalfSpace(3.0, 0.3))
    one = waves_at(fp.HalfSpace(3.0, 0.3), k, z, np.zeros(4, dtype=int))
    many = waves_at(stack, k, z, np.array([0, 0, 1, 2]))
    for name in ("normal", "shear", "transverse"):
        np.testing.assert_allclose(getattr(many, name), getattr(one, name), atol=1e-12)


def test_continuity_and_free_sliding():
    """u and tractions agree on both sides; at a sliding interface u_z and s_zz do, and the shear traction is zero."""
    graded = fp.GradedLayer(fp.ExponentialModulus(1.0, 9.0, 1.0), 0.35, 1.0)
    stack = fp.Medium(
        [fp.Layer(5.0, 0.2, 0.3), graded, fp.Layer(100.0, 0.5, 0.2, bonded=False)], fp.HalfSpace(0.1, 0.4)
    )
    k = np.geomspace(1e-3, 30, 25)
    z = np.repeat([0.3, 1.3, 1.5], 2)
    waves = waves_at(stack, k, z, np.array([0, 1, 1, 2, 2, 3]))
    for found in (waves.normal, waves.shear):
        np.testing.assert_allclose(found[:4, :, 0], found[:4, :, 1], atol=1e-12 * np.abs(found).max())
        np.testing.assert_allclose(found[:4, :, 2], found[:4, :, 3], atol=1e-12 * np.abs(found).max())
        np.testing.assert_allclose(found[[1, 3], :, 4], found[[1, 3], :, 5], atol=1e-12 * np.abs(found).max())
        np.testing.assert_allclose(found[2, :, 4:], 0, atol=1e-12)
    np.testing.assert_allclose(waves.transverse[:2, :, 2], waves.transverse[:2, :, 3], atol=1e-12)
    np.testing.assert_allclose(waves.transverse[1, :, 4:], 0, atol=1e-13)


def test_equilibrium_of_slabs():
    """ds_zz/dz = -k s_lz and ds_lz/dz = k s_ll, by central differences of step 1e-4: their error is 1e-8."""
    stack = fp.Medium([fp.Layer(5.0, 0.2, 0.5), fp.GradedLayer(lambda z: 1 + z**2, 0.3, 1.0)], fp.HalfSpace(2.0, 0.4))
    k, step = np.array([0.3, 1.0, 4.0]), 1e-4
    for middle, i in ((0.2, 0), (0.9, 1), (2.0, 2)):
        z = middle + step * np.array([-1, 0, 1])
        for _, _, s_lz, s_zz, mean, difference in (
            waves_at(stack, k, z, np.full(3, i)).normal,
            waves_at(stack, k, z, np.full(3, i)).shear,
        ):
            np.testing.assert_allclose((s_zz[:, 2] - s_zz[:, 0]) / (2 * step), -k * s_lz[:, 1], atol=1e-6)
            along = (mean + difference)[:, 1]
            np.testing.assert_allclose((s_lz[:, 2] - s_lz[:, 0]) / (2 * step), k * along, atol=1e-6)


def test_graded_layer_against_thin_homogeneous_ones():
    """Layers of 1/n approach the graded one like n^-2."""
    law = fp.ExponentialModulus(1.0, 9.0, 1.0)
    graded = fp.Medium([fp.GradedLayer(law, 0.35, 1.0)], fp.HalfSpace(2.0, 0.4))
    k, z = np.geomspace(0.01, 10, 8), np.array([0.0, 0.5, 1.0, 1.5])
    exact = waves_at(graded, k, z, np.array([0, 0, 0, 1])).normal[:4]
    errors = []
    for n in (40, 80):
        middles = (np.arange(n) + 0.5) / n
        layers = [fp.Layer(float(law(np.array([m]))[0]), 0.35, 1 / n) for m in middles]
        thin = waves_at(fp.Medium(layers, fp.HalfSpace(2.0, 0.4)), k, z, np.array([0, n // 2, n - 1, n]))
        errors.append(float(np.abs(thin.normal[:4] - exact).max()))
    assert errors[0] < 1e-3
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_surface_displacement_is_the_compliance():
    stack = fp.Medium([fp.Layer(5.0, 0.2, 0.3), fp.Layer(0.1, 0.5, 1.0, bonded=False)], fp.RigidBase())
    k = np.geomspace(1e-2, 50, 30)
    found = waves_at(stack, k, np.zeros(1), np.zeros(1, dtype=int)).normal[1, :, 0] / k
    np.testing.assert_allclose(found, fp.compliance(stack)(k), rtol=1e-11)


@pytest.mark.parametrize("thickness", [0.1, 1.0, 1e3])
def test_below_a_thin_layer_a_very_thick_one_is_a_half_space(thickness):
    """Counted from the lower face, heights a million times the wavelength cost all digits."""
    thin = fp.Layer(5e3, 0.4, 1e-7)
    thick = fp.Medium([thin, fp.Layer(5e3, 0.4, thickness)], fp.RigidBase())
    load, z = fp.DiscLoad(1e3, 1e-6), np.array([5e-8, 5e-7, 2e-6])
    found, wanted = (fp.fields(body, load, 5e-7, 0.0, z, friction=0.3) for body in (thick, fp.HalfSpace(5e3, 0.4)))
    # the rigid base under it acts like (radius/thickness)^2: 2e-10 at 0.1 m
    np.testing.assert_allclose(found["von_mises"], wanted["von_mises"], rtol=1e-9)
