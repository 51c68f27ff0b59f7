"""Loads under which residual stresses keep a body elastic: published values, another optimiser, limits."""

import numpy as np
import pytest
import scipy.optimize

import flatpunch as fp
from flatpunch.stresses.failure.shakedown import least_of_largest
from flatpunch.stresses.points import von_mises

TIP, STEEL = fp.Paraboloid(1.0), fp.HalfSpace(1.0, 0.3)
YIELD = 3e-3


def peak(force):
    """Largest pressure of Hertz over the shear strength."""
    return (6 * force / (0.91**2 * np.pi**3)) ** (1 / 3) / (YIELD / np.sqrt(3))


@pytest.mark.long
@pytest.mark.parametrize(("friction", "first", "limit", "place"), [(0.0, 2.795, 4.63, 0.36), (0.2, 2.717, 3.687, None)])
def test_sphere_on_a_half_space(friction, first, limit, place):
    found = fp.shakedown_load(STEEL, TIP, fp.Strength(yield_stress=YIELD), friction=friction)
    assert peak(found.first_yield) == pytest.approx(first, rel=2e-3)
    assert peak(found.force) == pytest.approx(limit, rel=2e-3)
    if place:
        assert found.z / found.radius == pytest.approx(place, abs=0.03)
        assert found.residual[0] == pytest.approx(found.residual[1], rel=1e-6)
    assert found.error < 1e-2
    # the limit is a stress, so that loads go like its cube
    twice = fp.shakedown_load(STEEL, TIP, fp.Strength(yield_stress=2 * YIELD, tensile=1e-3), friction=friction)
    assert twice.force / found.force == pytest.approx(8.0, rel=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_least_of_the_largest_is_that_of_another_optimiser(seed):
    stress = np.random.default_rng(seed).normal(size=(6, 40)) * np.array([1, 1, 2, 0.3, 0.5, 1])[:, None]
    size, residual, _ = least_of_largest(stress)

    def largest(r):
        return von_mises(stress + np.array([r[0], r[1], 0, 0, 0, r[2]])[:, None]).max()

    assert largest(residual) == pytest.approx(size, rel=1e-9)
    other = scipy.optimize.minimize(
        lambda x: x[3],
        [0.0, 0.0, 0.0, largest(np.zeros(3)) ** 2],
        constraints={
            "type": "ineq",
            "fun": lambda x: x[3] - von_mises(stress + np.array([x[0], x[1], 0, 0, 0, x[2]])[:, None]) ** 2,
        },
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert size == pytest.approx(np.sqrt(other.x[3]), rel=1e-7)


@pytest.mark.parametrize("across", [3, 21])
@pytest.mark.parametrize("size", [1e-9, 0.2, 1e8])
def test_points_that_decide_alike(across, size):
    """Fields with the symmetry of a disc, where four points and more are equal to rounding: an end, and nothing near is less."""
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-1, 1, across), np.linspace(-1, 1, across)))
    shape = size * np.exp(-2 * (x**2 + y**2))
    stress = shape * np.stack([1 + x**2, 1 + y**2, np.full(x.size, 2.0), y, x, x * y])
    least, residual, _ = least_of_largest(stress)
    for step in size * np.random.default_rng(1).normal(size=(50, 3)) * np.logspace(-6, -1, 50)[:, None]:
        r = residual + step
        assert von_mises(stress + np.array([r[0], r[1], 0, 0, 0, r[2]])[:, None]).max() >= least * (1 - 1e-12)


@pytest.mark.long
def test_layers_of_all_kinds():
    """A film by constants, as a graded and as an anisotropic layer; one that softens downwards, and its eight steps."""
    young, h, strengths = 4e11, 2e-6, [fp.Strength(yield_stress=y) for y in (8e9, 4e9)]
    kinds = [
        fp.Layer(young, 0.25, h),
        fp.GradedLayer(lambda z: young + 0 * z, 0.25, h),
        fp.TransverselyIsotropicLayer(young, young, 0.25, 0.25, young / 2.5, h),
    ]
    base = fp.HalfSpace(2.1e11, 0.3)
    loads = [
        fp.shakedown_load(fp.Medium([k], base), fp.Paraboloid(50e-6), strengths, friction=0.2).force for k in kinds
    ]
    assert loads == pytest.approx([loads[0]] * 3, rel=1e-6)
    softer = fp.Medium([fp.GradedLayer(lambda z: young * (1 - 0.4 * z / h), 0.25, h)], base)
    steps = fp.Medium([fp.Layer(young * (1 - 0.05 * (i + 0.5)), 0.25, h / 8) for i in range(8)], base)
    graded = fp.shakedown_load(softer, fp.Paraboloid(50e-6), strengths, friction=0.2)
    stepped = fp.shakedown_load(steps, fp.Paraboloid(50e-6), [strengths[0]] * 8 + [strengths[1]], friction=0.2)
    assert stepped.force == pytest.approx(graded.force, rel=1e-3)


@pytest.mark.long
@pytest.mark.parametrize("pair", [False, True], ids=["one", "two"])
def test_no_point_between_exceeds_the_limit_on_layers(pair):
    film = fp.Medium([fp.Layer(3.0, 0.2, 0.01), fp.Layer(0.5, 0.4, 0.02)], base=STEEL)
    strengths = [fp.Strength(yield_stress=2e-2), fp.Strength(yield_stress=3e-3), fp.Strength(yield_stress=5e-3)]
    body = fp.TwoBodies(upper=film, lower=fp.HalfSpace(2.0, 0.3)) if pair else film
    found = fp.shakedown_load(body, TIP, [strengths, None] if pair else strengths, friction=0.1)
    assert found.first_yield < found.force
    assert (found.z < 0) == pair
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-2 * found.radius, 2 * found.radius, (2, 3000))
    inside = fp.fields(body, TIP, x, y, found.z, force=found.force, friction=0.1).stress.values
    r = np.array([*found.residual[:2], 0, 0, 0, found.residual[2]])
    inside = inside if inside.shape[0] == 6 else np.moveaxis(inside, -1, 0)
    limit = strengths[found.layer].yield_stress
    assert von_mises(inside + r[:, None]).max() <= limit * (1 + found.error + 2e-3)


def test_sharp_tips_have_no_limit_and_nothing_yields_without_strengths():
    assert fp.shakedown_load(STEEL, fp.Cone(0.2), fp.Strength(yield_stress=YIELD)).force == 0
    with pytest.raises(ValueError, match="strengths has no yield stress"):
        fp.shakedown_load(STEEL, TIP, fp.Strength(tensile=1.0))


@pytest.mark.long
@pytest.mark.parametrize("pair", [False, True], ids=["sliding film", "two bodies"])
def test_lower_faces_of_layers_decide_where_their_stresses_are_largest(pair):
    """Just above the face, with the stresses of the layer: no residual stress keeps them below yield at a larger load."""
    layer = fp.Layer(20.0 if pair else 1.0, 0.3, 0.01, bonded=pair)
    film = fp.Medium([layer], fp.HalfSpace(1.0, 0.3))
    body = fp.TwoBodies(upper=film, lower=fp.HalfSpace(5.0, 0.3)) if pair else film
    strengths = [fp.Strength(yield_stress=0.02 if pair else YIELD), None]
    friction = 0.0 if pair else 0.1
    found = fp.shakedown_load(body, TIP, [strengths, None] if pair else strengths, friction=friction)
    assert abs(found.z) == pytest.approx(0.01, rel=1e-6)
    x, y = (each.ravel() for each in np.meshgrid(*2 * [np.linspace(-3.5, 3.5, 71) * found.radius]))
    inside = fp.fields(body, TIP, x, y, found.z * (1 - 1e-9), force=found.force, friction=friction)
    stress = inside.stress.transpose("component", ...).values.reshape(6, -1)
    least = least_of_largest(stress)[0] / strengths[0].yield_stress
    assert least == pytest.approx(1.0, abs=found.error + 2e-3)


@pytest.mark.long
def test_contacts_beyond_small_strains_have_a_note():
    found = fp.shakedown_load(STEEL, fp.Sphere(1.0), fp.Strength(yield_stress=0.25))
    assert any("strains are no longer small" in line for line in found.notes)
