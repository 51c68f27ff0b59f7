"""Graded transversely isotropic layers under load waves: isotropic limit, stacks, collocation, contacts, derivatives."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances.depth import waves_at
from flatpunch.compliances.derivatives import compliance_derivatives
from flatpunch.compliances.response import layered_response, stack_flexibility, surface_flexibility
from flatpunch.media import paths
from flatpunch.sensitivities.parameters import medium_parameters
from flatpunch.sensitivities.round import Spectrum, by_medium
from support.collocation import flexibility, solve, system
from support.propagators import random_material

PRESSURE = np.array([[0], [-1], [0]])
KAPPA = np.geomspace(1e-3, 60, 31)
FACES = [True, False, fp.Interface(2.0, 3.0), fp.Interface(2.0, 0.0)]
BASES = [fp.RigidBase(), fp.HalfSpace(3.0, 0.2), fp.TransverselyIsotropicHalfSpace(2.0, 5.0, 0.1, 0.2, 1.5)]
COLUMNS = fp.GradedLayer(
    young=fp.LinearModulus(1.0, 3.0, 1.0),
    poisson=lambda z: 0.2 + 0.3 * z,
    thickness=1.0,
    young_axial=fp.ExponentialModulus(4.0, 1.0, 1.0),
    poisson_axial=0.25,
    shear=fp.PowerModulus(0.2, 2.0, 1.0, 2.0),
)


def sampled(layer, z):
    return [float(each) for each in layer.constants_at(np.array(z))]


def flexibility_of(base):
    """Of a base, by the invariant subspace of its matrix."""
    if isinstance(base, fp.RigidBase):
        return np.zeros((3, 3))
    layer = fp.GradedLayer(base.young, base.poisson, 1.0) if isinstance(base, fp.HalfSpace) else None
    if layer is not None:
        young, nu = sampled(layer, 0.0)
        return flexibility(system([young, young, nu, nu, young / (2 * (1 + nu))]))
    names = ("young_in_plane", "young_axial", "poisson_in_plane", "poisson_axial", "shear")
    return flexibility(system([getattr(base, name) for name in names]))


def random_layer(rng, decades):
    """Laws over so many decades up or down, stable at all depths, and one of all kinds of lower faces."""
    h = 10 ** rng.uniform(-0.5, 0.5)
    young, axial, shear = (
        [fp.LinearModulus, fp.ExponentialModulus, lambda *ends: fp.PowerModulus(*ends, 2.0)][rng.integers(0, 3)](
            top, top * 10 ** rng.uniform(-decades, decades), h
        )
        for top in 10 ** rng.uniform(-decades, decades, 3)
    )
    nu = fp.LinearModulus(*rng.uniform(0.05, 0.6, 2), h)
    z = np.linspace(0, h, 500)
    limit = np.sqrt(np.min((1 - nu(z)) / 2 * axial(z) / young(z)))
    nu_axial = fp.LinearModulus(*(limit * rng.uniform(0.05, 0.95, 2)), h)
    bonded = [True, False, fp.Interface(*10 ** rng.uniform(-1, 1, 2))][rng.integers(0, 3)]
    return fp.GradedLayer(young, nu, h, bonded, axial, nu_axial, shear)


@pytest.mark.long
@pytest.mark.parametrize("bonded", FACES, ids=str)
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_isotropic_constants_give_the_isotropic_layer(nu, bonded):
    """The integrator is the same; the coefficients differ by rounding."""
    young = fp.LinearModulus(1.0, 5.0, 1.0)
    shear = fp.LinearModulus(0.5 / (1 + nu), 2.5 / (1 + nu), 1.0)
    z, where = np.array([0.0, 0.2, 0.7, 1.0]), np.zeros(4, dtype=int)
    for base in BASES:
        one = fp.Medium([fp.GradedLayer(young, nu, 1.0, bonded)], base)
        other = fp.Medium([fp.GradedLayer(young, nu, 1.0, bonded, young, nu, shear)], base)
        assert other.surface_modulus == pytest.approx(one.surface_modulus, rel=1e-15)
        np.testing.assert_allclose(layered_response(other, KAPPA), layered_response(one, KAPPA), rtol=1e-12)
        ours, theirs = waves_at(other, KAPPA, z, where), waves_at(one, KAPPA, z, where)
        for name in ("normal", "shear", "transverse"):
            mine, exact = getattr(ours, name), getattr(theirs, name)
            np.testing.assert_allclose(mine, exact, rtol=0, atol=1e-11 * np.abs(exact).max())


@pytest.mark.long
def test_constant_laws_give_the_homogeneous_layer():
    """Real and complex rates on all bases and faces; tolerance of the integrator."""
    rng = np.random.default_rng(0)
    for trial in range(30):
        young, axial, nu, nu_axial, shear = random_material(rng)
        # constants that are incompressible up to rounding only differ in what is rounding
        nu_axial = min(nu_axial, 0.99 * np.sqrt((1 - nu) / 2 * axial / young))
        face, base = FACES[trial % 4], BASES[trial % 3]
        graded = fp.Medium([fp.GradedLayer(young, nu, 1.0, face, axial, nu_axial, shear)], base)
        plain = fp.Medium([fp.TransverselyIsotropicLayer(young, axial, nu, nu_axial, shear, 1.0, face)], base)
        np.testing.assert_allclose(layered_response(graded, KAPPA), layered_response(plain, KAPPA), rtol=1e-11)
        along, across = surface_flexibility(graded, KAPPA)
        exact_along, exact_across = surface_flexibility(plain, KAPPA)
        np.testing.assert_allclose(across, exact_across, rtol=1e-9)
        np.testing.assert_allclose(along, exact_along, rtol=0, atol=1e-9 * np.abs(exact_along).max())


@pytest.mark.parametrize("base", BASES, ids=["rigid", "isotropic", "anisotropic"])
def test_stacks_of_constant_layers_converge_to_it_like_n_to_the_minus_two(base):
    medium, kappa, values = fp.Medium([COLUMNS], base), np.array([0.05, 0.5, 2.0, 6.0]), []
    exact = layered_response(medium, kappa)
    for n in (64, 128, 256):
        rows = zip(*COLUMNS.constants_at((np.arange(n) + 0.5) / n), strict=True)
        thin = fp.Medium([fp.TransverselyIsotropicLayer(*map(float, row), 1 / n) for row in rows], base)
        values.append(layered_response(thin, kappa) * medium.surface_modulus / thin.surface_modulus)
    error = np.abs(np.array(values) / exact - 1)
    # midpoint constants: the error is a series in n^-2
    np.testing.assert_allclose(np.log2(error[1] / error[2]), 2, atol=0.05)
    first = (4 * np.array(values[1:]) - np.array(values[:-1])) / 3
    # what two eliminations leave at n = 256: (slope/256)^6
    np.testing.assert_allclose((16 * first[1] - first[0]) / 15, exact, rtol=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("decades", [0.7, 1.5])
def test_random_gradings_against_collocation(decades):
    """Surface displacement and all fields; worst of 130 in a search: 2e-13, and 9e-9 of the largest value."""
    rng = np.random.default_rng(4)
    for _ in range(12):
        layer = random_layer(rng, decades)
        base = BASES[rng.integers(0, 3)]
        medium, face = fp.Medium([layer], base), layer.bonded
        k = 10 ** rng.uniform(-1.5, 1.2) / layer.thickness
        springs = face.softness if isinstance(face, fp.Interface) else (0.0, 0.0)
        z, exact = solve(
            lambda z, layer=layer: sampled(layer, z),
            layer.thickness,
            k,
            np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
            flexibility_of(base),
            springs,
            not face,
        )
        ours = layered_response(medium, np.array([k]))[0] * 2 / medium.surface_modulus
        assert ours == pytest.approx(exact[0, 1, 0], rel=1e-11)
        some = rng.integers(0, z.size, 12)
        waves = waves_at(medium, np.array([k]), z[some], np.zeros(12, dtype=int))
        for load, name, parts in (
            (0, "normal", ([0, 1], [2, 3])),
            (1, "shear", ([0, 1], [2, 3])),
            (2, "transverse", ([4], [5])),
        ):
            found = iter(getattr(waves, name)[:, 0])
            for part in parts:
                size = np.abs(exact[:, part, load]).max()
                for row in part:
                    np.testing.assert_allclose(next(found), exact[some, row, load], rtol=0, atol=2e-8 * size)


def test_an_isotropic_depth_inside_the_layer():
    """Both rates are equal there, complex above it and real below it."""
    layer = fp.GradedLayer(
        fp.LinearModulus(1.0, 3.0, 1.0), 0.3, 1.0, True, fp.LinearModulus(3.0, 1.0, 1.0), 0.3, 2 / 2.6
    )
    medium = fp.Medium([layer], fp.RigidBase())
    for k in (0.1, 1.0, 10.0):
        _, exact = solve(lambda z: sampled(layer, z), 1.0, k, PRESSURE, np.zeros((3, 3)))
        ours = layered_response(medium, np.array([k]))[0] * 2 / medium.surface_modulus
        assert ours == pytest.approx(exact[0, 1, 0], rel=1e-11)


@pytest.mark.long
@pytest.mark.parametrize("ends", [(1.0, 1e-3), (1e-3, 1.0)])
@pytest.mark.parametrize("face", FACES, ids=str)
def test_fields_in_steep_isotropic_gradings_against_collocation(ends, face):
    """Steps follow the law: with 24 of equal length the error was 1e-4 of the largest value."""
    layer = fp.GradedLayer(fp.LinearModulus(*ends, 1.0), 0.3, 1.0, face)
    medium = fp.Medium([layer], fp.RigidBase())

    def constants(z):
        young, nu = sampled(layer, z)
        return young, young, nu, nu, young / (2 * (1 + nu))

    springs = face.softness if isinstance(face, fp.Interface) else (0.0, 0.0)
    # a panel resolves an e-fold
    z, exact = solve(
        constants,
        1.0,
        1.0,
        PRESSURE,
        np.zeros((3, 3)),
        (0.0 if not face else springs[0], springs[1]),
        not face,
        panels=24,
    )
    some = np.arange(0, z.size, 13)
    found = waves_at(medium, np.ones(1), z[some], np.zeros(some.size, dtype=int)).normal[:4, 0].T
    for part in (slice(0, 2), slice(2, 4)):
        np.testing.assert_allclose(
            found[:, part], exact[some, part, 0], rtol=0, atol=1e-8 * np.abs(exact[:, part]).max()
        )


@pytest.mark.parametrize("anisotropic", [False, True])
@pytest.mark.parametrize("face", FACES, ids=str)
def test_both_roads_to_the_surface_agree(anisotropic, face):
    """The Riccati equation and the states of the fields; springs are at the lower face alone."""
    axial = (fp.ExponentialModulus(4.0, 1.0, 1.0), 0.25, 0.5) if anisotropic else ()
    layer = fp.GradedLayer(fp.LinearModulus(1.0, 5.0, 1.0), 0.3, 1.0, face, *axial)
    medium, k = fp.Medium([fp.Layer(2.0, 0.2, 0.3), layer], BASES[1]), np.geomspace(0.01, 10, 7)
    waves = waves_at(medium, k, np.zeros(1), np.zeros(1, dtype=int))
    along, across = surface_flexibility(medium, k)
    np.testing.assert_allclose(-waves.normal[1, :, 0], along[1, 1], rtol=1e-10)
    np.testing.assert_allclose(waves.shear[0, :, 0], along[0, 0], rtol=1e-10)
    np.testing.assert_allclose(waves.transverse[0, :, 0], across, rtol=1e-9)
    # reciprocity: a pressure moves the surface sideways as a shear traction moves it down
    np.testing.assert_allclose(waves.normal[0, :, 0], -waves.shear[1, :, 0], rtol=1e-8, atol=1e-12)


@pytest.mark.long
def test_a_cut_through_the_grading_changes_nothing():
    def below(law, top):
        return lambda z: law(z + top)

    laws = [COLUMNS.young, COLUMNS.poisson, COLUMNS.young_axial, COLUMNS.poisson_axial, COLUMNS.shear]
    parts = []
    for top, h in ((0.0, 0.37), (0.37, 0.63)):
        young, poisson, *axial = (below(law, top) for law in laws)
        parts.append(fp.GradedLayer(young, poisson, h, True, *axial))
    for base in BASES:
        one, two = fp.Medium([COLUMNS], base), fp.Medium(parts, base)
        np.testing.assert_allclose(layered_response(two, KAPPA), layered_response(one, KAPPA), rtol=2e-11)


def test_small_contacts_feel_the_surface_and_large_ones_the_base():
    """Modulus of Delafargue and Ulm with the constants of the surface; approached like a ln a, for L - 1 falls like 1/k."""
    medium = fp.Medium([COLUMNS], BASES[2])
    young, axial, nu, nu_axial, shear = sampled(COLUMNS, 0.0)
    surface = fp.TransverselyIsotropicHalfSpace(young, axial, nu, nu_axial, shear)
    c11, _, c13, c33, c44 = surface.stiffnesses
    modulus = 2 * np.sqrt((c11 * c33 - c13**2) / c11 / (1 / c44 + 2 / (np.sqrt(c11 * c33) + c13)))
    assert medium.surface_modulus == pytest.approx(modulus, rel=1e-12)
    for radius in (1e-3, 1e-5):
        stiffness = fp.flat_punch(medium, radius).stiffness
        assert stiffness / (2 * radius) == pytest.approx(modulus, rel=-2 * radius * np.log(radius))
    for radius in (1e2, 1e4):
        stiffness = fp.flat_punch(medium, radius).stiffness
        assert stiffness / (2 * radius) == pytest.approx(BASES[2].surface_modulus, rel=3 / radius)


@pytest.mark.long
def test_derivatives_against_differences():
    """By every number of every law, and the thickness; differences leave 1e-7."""
    film = fp.GradedLayer(
        fp.LinearModulus(1.0, 3.0, 0.7),
        0.3,
        0.7,
        fp.Interface(5.0, 3.0),
        ([0, 0.7], [4.0, 1.0]),
        fp.LinearModulus(0.2, 0.3, 0.7),
        fp.ExponentialModulus(0.4, 2.0, 0.7),
    )
    medium = fp.Medium([film], BASES[2])
    kernel, k, wanted = fp.compliance(medium), np.array([0.1, 1.0, 5.0]), medium_parameters(medium)
    assert {each.kind for each in wanted if each.part == 0} == {
        *film.numbers,
        "thickness",
        "bonded.normal",
        "bonded.shear",
    }
    found = by_medium(medium, kernel, Spectrum(k, np.eye(3), kernel(k)), wanted)
    for each, slope in zip(wanted, found.T, strict=True):
        step, ends = 1e-4 * each.value, []
        for sign in (1, -1):
            changed, _ = paths.with_values(medium, None, {each.path: each.value + sign * step})
            ends.append(layered_response(changed, k) * 2 / (changed.surface_modulus * k))
        np.testing.assert_allclose(slope, (ends[0] - ends[1]) / (2 * step), rtol=1e-6, atol=1e-9 * slope.max())


def test_all_moduli_together_are_a_factor():
    """Derivatives of ln C by ln E, ln E_z and ln G over all depths add up to -1."""
    k = np.array([0.1, 1.0, 10.0])
    for base in BASES[::2]:
        medium, total = fp.Medium([COLUMNS], base), np.zeros(3)
        for part, body in zip(compliance_derivatives(medium, k), (COLUMNS, base), strict=False):
            for name, change in part.constants.items():
                if name.startswith(("young", "shear")):
                    value = getattr(body, name)
                    total += (value(part.depths) if body is COLUMNS else np.array([value])) @ change
        np.testing.assert_allclose(total / fp.compliance(medium)(k), -1, rtol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("ratio", [1e-3, 1e3])
def test_extreme_anisotropy(ratio):
    """The interpolant, which only samples, and the Riccati equation of both parts of a cut layer."""
    axial, nu_axial = fp.ExponentialModulus(ratio, 3 * ratio, 1.0), 0.5 * np.sqrt(0.35 * ratio)
    young, shear = fp.LinearModulus(1.0, 3.0, 1.0), fp.LinearModulus(1.0, 0.5, 1.0)
    medium = fp.Medium([fp.GradedLayer(young, 0.3, 1.0, True, axial, nu_axial, shear)], fp.HalfSpace(2.0, 0.3))
    kernel = fp.compliance(medium)
    np.testing.assert_allclose(kernel.response(KAPPA), layered_response(medium, KAPPA), rtol=1e-11)
    k = np.array([0.5])
    _, exact = solve(lambda z: sampled(medium.layers[0], z), 1.0, 0.5, PRESSURE, flexibility_of(medium.base), panels=20)
    assert -stack_flexibility(medium, k, 1.0)[1, 1, 0] == pytest.approx(exact[0, 1, 0], rel=1e-10)
