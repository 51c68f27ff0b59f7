"""Kernels for other codes: closed forms, symmetry, signs, interpolation, q = 0, plain tuples, and what importing them loads."""

import subprocess
import sys

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import kernels

GRADED = fp.GradedLayer(fp.LinearModulus(1.0, 5.0, 1.0), 0.3, 1.0)
ANISOTROPIC = fp.TransverselyIsotropicLayer(3.0, 1.0, 0.2, 0.3, 0.7, 1.0)
WOOD = fp.TransverselyIsotropicHalfSpace(1.0, 12.0, 0.4, 0.4, 0.8)
FILM = fp.Medium([fp.Layer(1.0, 0.3, 0.5), fp.Layer(0.1, 0.5, 2.0, bonded=False)], fp.HalfSpace(10.0, 0.2))
MEDIA = {
    "half-space": fp.HalfSpace(1.0, 0.3),
    "film": FILM,
    "gel": fp.Medium([fp.Layer(1.0, 0.5, 1.0)], fp.RigidBase()),
    "graded": fp.Medium([GRADED], fp.HalfSpace(5.0, 0.3)),
    "anisotropic": fp.Medium([ANISOTROPIC], WOOD),
    "springs": fp.Medium([fp.Layer(1.0, 0.3, 1.0, bonded=fp.Interface(2.0, 0.5))], fp.RigidBase()),
    "power law": fp.PowerLawHalfSpace(1.0, 1.0, 0.4, 0.3),
    "pair": fp.TwoBodies(FILM, WOOD),
    "many layers": fp.Medium([fp.Layer(1.0 + i % 2, 0.3, 0.1) for i in range(20)], fp.RigidBase()),
}
RNG = np.random.default_rng(0)
QX, QY = RNG.normal(size=(2, 40)) * 10 ** RNG.uniform(-2, 1, 40)


def test_half_space():
    """Boussinesq's and Cerruti's solutions, transformed."""
    young, nu = 2.0, 0.3
    c = kernels.surface_compliance(fp.HalfSpace(young, nu), QX, QY)
    k = np.hypot(QX, QY)
    x, y = QX / k, QY / k
    np.testing.assert_allclose(c[:, 2, 2], 2 * (1 - nu**2) / (young * k), rtol=1e-13)
    np.testing.assert_allclose(c[:, 0, 0], 2 * (1 + nu) * (1 - nu * x**2) / (young * k), rtol=1e-12)
    np.testing.assert_allclose(c[:, 0, 1], -2 * nu * (1 + nu) * x * y / (young * k), rtol=0, atol=1e-12 / k.min())
    np.testing.assert_allclose(c[:, 0, 2], 1j * (1 + nu) * (1 - 2 * nu) * x / (young * k), rtol=1e-12)
    assert np.all(c[:, 0, 2].imag * QX > 0)  # beside a pressure the surface moves towards it


@pytest.mark.parametrize("bonded", [True, False])
def test_wavy_surface_of_a_layer_pressed_flat(bonded):
    """Westergaard's full contact on a layer on a rigid base: the pressure amplitude is the height over C(k)."""
    nu, k = 0.3, np.geomspace(1e-3, 20, 60)
    sinh, cosh = np.sinh(k), np.cosh(k)
    if bonded:
        response = ((3 - 4 * nu) * sinh * cosh - k) / ((3 - 4 * nu) * cosh**2 + k**2 + (1 - 2 * nu) ** 2)
    else:
        response = 2 * sinh**2 / (np.sinh(2 * k) + 2 * k)
    exact = k / (2 * response * (1 - nu**2))
    # the closed forms cancel at long waves
    far = k > 0.02
    s = kernels.surface_stiffness(([(1.0, nu, 1.0, bonded)], None), k, 0 * k)
    c = kernels.surface_compliance(([(1.0, nu, 1.0, bonded)], None), k, 0 * k)
    np.testing.assert_allclose(1 / c[far, 2, 2].real, exact[far], rtol=1e-10)
    np.testing.assert_allclose(s @ c, np.broadcast_to(np.eye(3), c.shape), rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        kernels.normal_compliance(([(1.0, nu, 1.0, bonded)], None), k), c[:, 2, 2].real, rtol=1e-12
    )


@pytest.mark.parametrize("name", MEDIA)
def test_symmetry(name):
    """Reciprocity, reality in space, positive energy, and the inverse."""
    c = kernels.surface_compliance(MEDIA[name], QX, QY)
    np.testing.assert_allclose(c, np.conj(np.swapaxes(c, -1, -2)), rtol=0, atol=0)
    np.testing.assert_allclose(kernels.surface_compliance(MEDIA[name], -QX, -QY), np.conj(c), rtol=0, atol=0)
    assert np.all(np.linalg.eigvalsh(c) > 0)
    product = kernels.surface_stiffness(MEDIA[name], QX, QY) @ c
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(3), c.shape), rtol=0, atol=1e-8)


@pytest.mark.parametrize("name", [name for name in MEDIA if name != "pair"])
def test_interior_begins_at_the_surface(name):
    """There it has the surface compliance, both halves of its coupling computed apart, and the traction."""
    c = kernels.surface_compliance(MEDIA[name], QX, QY)
    displacement, stress = kernels.interior(MEDIA[name], QX, QY, [0.0])
    size = np.abs(c).max(axis=(1, 2), keepdims=True)
    # power laws are splines of 1e-10; the steps through graded layers leave 3e-9
    assert np.all(np.abs(displacement[:, 0] - c) <= (1e-8 if name == "graded" else 1e-9) * size)
    faces = stress[:, 0][:, [4, 3, 2]]
    np.testing.assert_allclose(faces, np.broadcast_to(-np.eye(3), faces.shape), rtol=0, atol=1e-9)


@pytest.mark.parametrize("body", [fp.HalfSpace(2.0, 0.3), fp.Medium([fp.Layer(2.0, 0.3, 1.0)], WOOD)])
def test_signs_of_the_interior(body):
    """Stresses are Hooke's of the displacements, and in equilibrium; differences in depth of order four leave 1e-8."""
    young, nu, h = 2.0, 0.3, 1e-3
    mu, lame = young / (2 * (1 + nu)), young * nu / ((1 + nu) * (1 - 2 * nu))
    qx, qy = np.array([0.7, -1.1]), np.array([0.4, 0.9])
    z = 0.5 + h * np.arange(-2, 3)
    u, s = kernels.interior(body, qx, qy, z)
    rule = np.array([1, -8, 0, 8, -1]) / (12 * h)
    du, ds = (np.einsum("z,qz...->q...", rule, field) for field in (u, s))
    u, s = u[:, 2], s[:, 2]
    gradient = np.stack([1j * qx[:, None, None] * u, 1j * qy[:, None, None] * u, du])  # along x, y, z
    strain = (np.moveaxis(gradient, 0, 1) + np.moveaxis(gradient, 0, 1).swapaxes(1, 2)) / 2
    hooke = 2 * mu * strain
    for i in range(3):
        hooke[:, i, i] += lame * (strain[:, 0, 0] + strain[:, 1, 1] + strain[:, 2, 2])
    tensor, slope = (np.empty((2, 3, 3, 3), dtype=complex) for _ in range(2))
    for whole, parts in ((tensor, s), (slope, ds)):
        for component, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
            whole[:, i, j] = whole[:, j, i] = parts[:, component]
    np.testing.assert_allclose(tensor, hooke, rtol=0, atol=1e-8)
    balance = 1j * (qx[:, None, None] * tensor[:, 0] + qy[:, None, None] * tensor[:, 1]) + slope[:, 2]
    np.testing.assert_allclose(balance, np.zeros_like(balance), rtol=0, atol=1e-8)


@pytest.mark.parametrize("name", MEDIA)
@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_interpolation(name, rtol):
    """Its error is below rtol on a grid of more wave vectors than are computed one by one."""
    q = 2 * np.pi * np.fft.fftfreq(128, d=0.05)
    table = kernels.surface_compliance(MEDIA[name], q[:, None], q, rtol=rtol)
    some = RNG.integers(0, 128, (2, 60))
    some = some[:, (some != 0).any(axis=0)]
    exact = kernels.surface_compliance(MEDIA[name], q[some[0]], q[some[1]], rtol=0)
    size = np.abs(np.einsum("nii->ni", exact))
    off = np.abs(table[some[0], some[1]] - exact) / np.sqrt(size[:, :, None] * size[:, None, :])
    assert float(off.max()) < 2 * rtol  # entries xx and yy are sums of two


def test_uniform_traction():
    """q = 0: layers on a rigid base are in uniaxial strain, springs in series; elastic bases do not determine it."""
    layers = [fp.Layer(1.0, 0.3, 0.5, bonded=fp.Interface(2.0, 0.5)), GRADED]
    c = kernels.surface_compliance(fp.Medium(layers, fp.RigidBase()), 0.0, 0.0)
    soft = (1 + 0.3) * (1 - 2 * 0.3) / (1 - 0.3)
    modulus = np.log(5) / 4  # int dz/E over the graded layer
    assert c[2, 2] == pytest.approx(soft * (0.5 + modulus) + 1 / 2.0, rel=1e-12)
    assert c[0, 0] == c[1, 1] == pytest.approx(2.6 * (0.5 + modulus) + 1 / 0.5, rel=1e-12)
    assert np.count_nonzero(c) == 3
    assert kernels.surface_compliance(FILM, [0.0, 1.0], 0.0, undetermined=7.0)[0].tolist() == (7 * np.eye(3)).tolist()
    assert not kernels.surface_stiffness(FILM, 0.0, 0.0).any()
    gel = kernels.surface_stiffness(MEDIA["gel"], 0.0, 0.0, undetermined=np.inf)
    assert gel[2, 2] == np.inf
    assert gel[0, 0] == pytest.approx(1 / 3)
    assert kernels.normal_compliance(MEDIA["gel"], 0.0) == 0.0
    # the limit of long waves has the same shear compliance
    wave = kernels.surface_compliance(fp.Medium(layers, fp.RigidBase()), 0.0, 1e-5)
    assert wave[0, 0].real == pytest.approx(c[0, 0].real, rel=1e-8)


def test_tuples():
    objects = fp.Medium([fp.Layer(1.0, 0.3, 1.0, bonded=False), ANISOTROPIC], WOOD)
    tuples = ([(1.0, 0.3, 1.0, False), (3.0, 1.0, 0.2, 0.3, 0.7, 1.0)], (1.0, 12.0, 0.4, 0.4, 0.8))
    ours, theirs = (kernels.surface_compliance(medium, QX, QY) for medium in (tuples, objects))
    np.testing.assert_array_equal(ours, theirs)
    assert kernels.surface_compliance(([], (1.0, 0.3)), QX[:, None], QY).shape == (40, 40, 3, 3)
    with pytest.raises(TypeError, match="layer 0 is"):
        kernels.surface_compliance(([(1.0, 0.3)], None), 1.0, 0.0)
    with pytest.raises(TypeError, match="the base is"):
        kernels.surface_compliance(([(1.0, 0.3, 1.0)], (1.0,)), 1.0, 0.0)
    with pytest.raises(TypeError, match="A medium as tuples"):
        kernels.surface_compliance((1.0, 0.3), 1.0, 0.0)


def test_bad_input():
    with pytest.raises(ValueError, match=r"qx\[0\] = nan must be finite"):
        kernels.surface_compliance(FILM, [np.nan], 0.0)
    with pytest.raises(ValueError, match="both zero"):
        kernels.interior(FILM, 0.0, 0.0, 1.0)
    with pytest.raises(ValueError, match="inside the rigid base"):
        kernels.interior(MEDIA["gel"], 1.0, 0.0, 1.5)
    with pytest.raises(TypeError, match="each of them by itself"):
        kernels.interior(MEDIA["pair"], 1.0, 0.0, 0.5)
    with pytest.raises(ValueError, match=r"`normal_compliance` exists"):
        kernels.surface_compliance(fp.PowerLawHalfSpace(1.0, 1.0, 1.0, 0.5), 1.0, 0.0)


def test_importing_loads_numpy_alone():
    code = """
import sys, time
import numpy
before, start = set(sys.modules), time.perf_counter()
from flatpunch import kernels
kernels.surface_compliance
took = time.perf_counter() - start
names = {name for name in set(sys.modules) - before}
print(sorted(n for n in names if n.startswith("flatpunch") and not n.startswith(("flatpunch.kernels", "flatpunch._support"))))
print(sorted(n for n in names if n.split(".")[0] in ("scipy", "xarray", "pandas", "matplotlib")), took)
"""
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.splitlines()
    assert out[0] == "['flatpunch']"
    assert out[1].startswith("[] ")
    assert float(out[1].split()[-1]) < 0.3  # 10 to 20 ms on an idle machine


@pytest.mark.parametrize("magnitude", [2e-50, 1e-20, 1e6, 1e30, 9e49])
@pytest.mark.parametrize("medium", [fp.HalfSpace(1e9, 0.3), ([(5e3, 0.3, 2e-6)], None)], ids=["half-space", "layer"])
def test_all_wave_vectors_that_are_accepted(medium, magnitude):
    """The compliance of `normal_compliance`, and a stiffness that is its inverse, without a warning of NumPy."""
    q = 0.6 * magnitude, 0.8 * magnitude
    c, s = kernels.surface_compliance(medium, *q), kernels.surface_stiffness(medium, *q)
    assert c[2, 2].real == pytest.approx(float(kernels.normal_compliance(medium, np.hypot(*q))), rel=1e-12)
    np.testing.assert_allclose(s @ c, np.eye(3), atol=1e-12)


@pytest.mark.parametrize("magnitude", [1e-170, 1e-51, 1e51, 1e155])
def test_wave_vectors_out_of_range(magnitude):
    body = fp.HalfSpace(1e9, 0.3)
    for refused in (
        kernels.surface_compliance,
        kernels.surface_stiffness,
        lambda m, x, y: kernels.interior(m, x, y, 1e-6),
    ):
        with pytest.raises(ValueError, match=r"qx and qy = .* must be a wave vector of 1e-50 to 1e\+50 1/m"):
            refused(body, magnitude, 0.0)
    with pytest.raises(ValueError, match=r"q = .* must be a wave vector"):
        kernels.normal_compliance(body, magnitude)
