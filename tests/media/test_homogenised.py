"""One layer in the place of many: long waves, springs, gradings, order of the error, and the numbers of the page."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import kernels
from flatpunch.media.plane import from_plane
from support.propagators import random_material, random_stack

PERIOD = [
    fp.Layer(20.0, 0.25, 0.3),
    fp.Layer(1.0, 0.5, 0.3, bonded=fp.Interface(30.0, 5.0)),
    fp.TransverselyIsotropicLayer(3.0, 1.0, 0.2, 0.3, 0.7, 0.4),
]


def test_coefficients_and_constants_are_inverse():
    rng = np.random.default_rng(0)
    for _ in range(100):
        material = random_material(rng)
        body = fp.TransverselyIsotropicHalfSpace(*material)
        np.testing.assert_allclose(from_plane(body.plane), material, rtol=1e-9)


def test_one_material_is_itself():
    layer = fp.TransverselyIsotropicLayer(3.0, 1.0, 0.2, 0.3, 0.7, 0.5, bonded=False)
    found = fp.homogenised(
        [
            fp.TransverselyIsotropicLayer(3.0, 1.0, 0.2, 0.3, 0.7, 0.25),
            fp.TransverselyIsotropicLayer(3.0, 1.0, 0.2, 0.3, 0.7, 0.25, bonded=False),
        ]
    )
    np.testing.assert_allclose(found.stiffnesses, layer.stiffnesses, rtol=1e-13)
    assert (found.thickness, found.bonded) == (0.5, False)
    isotropic = fp.homogenised([fp.Layer(2.0, 0.5, 1.0), fp.Layer(2.0, 0.5, 3.0)])
    assert isotropic.surface_modulus == pytest.approx(2 / 0.75, rel=1e-14)


def test_long_waves_under_a_cover():
    """All three directions; for waves long against the whole stack the error is of second order in the wavenumber."""
    stack = 8 * PERIOD
    one = fp.homogenised(stack)
    cover = fp.Layer(5.0, 0.3, 2.0)
    real, mean = (fp.Medium([cover, *layers], fp.RigidBase()) for layers in (stack, [one]))
    q = np.array([1e-3, 2e-3])
    ours, theirs = (kernels.surface_compliance(medium, q, 0.0) for medium in (mean, real))
    off = np.abs(ours / np.where(theirs == 0, 1, theirs) - 1)[:, [0, 1, 2], [0, 1, 2]]
    assert off.max() < 2e-4
    np.testing.assert_allclose(np.log2(off[1] / off[0]), 2.0, atol=0.05)
    at_rest = [kernels.surface_compliance(medium, 0.0, 0.0) for medium in (mean, real)]
    np.testing.assert_allclose(at_rest[0], at_rest[1], rtol=1e-12)


def test_graded_layers():
    """A grading is the limit of many sublayers, and its mean that of theirs."""
    law = fp.LinearModulus(1.0, 4.0, 1.0)
    z = (np.arange(400) + 0.5) / 400
    sublayers = [fp.Layer(float(law(np.array([depth]))[0]), 0.3, 1 / 400) for depth in z]
    ours, theirs = fp.homogenised([fp.GradedLayer(law, 0.3, 1.0)]), fp.homogenised(sublayers)
    np.testing.assert_allclose(ours.stiffnesses, theirs.stiffnesses, rtol=1e-5)


def test_any_stack_gives_a_stable_layer():
    rng = np.random.default_rng(3)
    for _ in range(50):
        layers = [layer for layer in random_stack(rng).layers if layer.bonded]
        if layers:
            assert fp.homogenised(layers).surface_modulus > 0


@pytest.mark.parametrize(
    ("ratio", "stiff_on_top", "numbers"),
    [
        (1.8, True, (-0.045, -0.072, -0.088)),
        (1.8, False, (0.042, 0.067, 0.081)),
        (20.0, True, (-0.30, -0.52, -0.64)),
        (20.0, False, (0.15, 0.29, 0.37)),
    ],
)
def test_table_of_the_page(ratio, stiff_on_top, numbers):
    pair = [fp.Layer(ratio, 0.25, 0.5), fp.Layer(1.0, 0.3, 0.5)][:: 1 if stiff_on_top else -1]
    base = fp.HalfSpace(3.0, 0.3)
    media = fp.Medium([fp.homogenised(100 * pair)], base), fp.Medium(100 * pair, base)
    for radius, number in zip((1.0, 10.0, 100.0), numbers, strict=True):
        ours, theirs = (float(fp.indent(m, fp.Cylinder(radius), depth=0.01).force[0]) for m in media)
        assert (ours / theirs - 1) * radius == pytest.approx(number, rel=0.03)


def test_bad_input():
    with pytest.raises(ValueError, match="layers is empty"):
        fp.homogenised([])
    with pytest.raises(TypeError, match="is one layer"):
        fp.homogenised(PERIOD[0])
    with pytest.raises(TypeError, match=r"layers\[1\] = HalfSpace"):
        fp.homogenised([PERIOD[0], fp.HalfSpace(1.0, 0.3)])
    with pytest.raises(ValueError, match=r"layers\[0\] slides on the next one"):
        fp.homogenised([fp.Layer(1.0, 0.3, 1.0, bonded=False), PERIOD[0]])
