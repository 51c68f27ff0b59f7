"""Membranes in interfaces: multiprecision, the thin stiff films that they stand for, limits, jumps of tractions, derivatives."""

from dataclasses import replace

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances.depth import waves_at
from flatpunch.compliances.derivatives import compliance_derivatives
from flatpunch.compliances.response import layered_response
from flatpunch.kernels import surface_compliance
from flatpunch.media import paths
from support.propagators import random_stack, wave

K = np.geomspace(1e-3, 20, 13)
BASE = fp.HalfSpace(3.0, 0.2)
MEMBRANE = fp.Membrane(tension=0.7, stretching=2.0, shear=0.8, bending=0.3)
TOPS = {
    "isotropic": fp.Layer(1.0, 0.3, 1.0),
    "incompressible": fp.Layer(1.0, 0.5, 1.0),
    "anisotropic": fp.TransverselyIsotropicLayer(3.0, 1.0, 0.2, 0.3, 0.7, 1.0),
    "graded": fp.GradedLayer(fp.LinearModulus(1.0, 2.0, 1.0), 0.3, 1.0),
}
FACES = {
    "bonded": fp.Interface(membrane=MEMBRANE),
    "sliding": fp.Interface(shear=0.0, membrane=MEMBRANE),
    "springs": fp.Interface(normal=2.0, shear=0.5, membrane=MEMBRANE),
}


def on(face, top=TOPS["isotropic"], base=BASE):
    return fp.Medium([replace(top, bonded=face)], base)


def functions(medium, k):
    """The three functions of the surface under tractions of all directions and their coupling; shape (4, n)."""
    waves = np.zeros((k.size, 2))
    waves[:, 0] = k
    c = surface_compliance(medium, *waves.T)
    return np.stack([c[:, 2, 2].real, c[:, 0, 0].real, c[:, 1, 1].real, c[:, 0, 2].imag])


@pytest.mark.long
def test_stacks_with_membranes_against_multiprecision():
    """Stiffnesses of 1e-3 to 1e3 moduli times lengths, under bonded, sliding and springy layers of all kinds, at all depths."""
    rng = np.random.default_rng(7)
    for _ in range(25):
        medium = random_stack(rng, membranes=True)
        k = 10 ** rng.uniform(-3, 1)
        ours = layered_response(medium, np.array([k]))[0] * 2 / (medium.surface_modulus * k)
        assert ours == pytest.approx(wave(medium, k, 0.0, 0, (0, -1))[1] / k, rel=1e-11)
        layer = int(rng.integers(0, len(medium.layers) + (not medium.base.rigid)))
        faces = np.concatenate([[0.0], np.cumsum([each.thickness for each in medium.layers])])
        thickness = medium.layers[layer].thickness if layer < len(medium.layers) else 1.0
        z = faces[layer] + rng.choice([0.0, rng.random(), 1.0]) * thickness
        waves = waves_at(medium, np.array([k]), np.array([z]), np.array([layer]))
        for found, load in ((waves.normal, (0, -1)), (waves.shear, (1, 0)), (waves.transverse, (1,))):
            exact = wave(medium, k, z, layer, load)
            half = len(exact) // 2
            for mine, theirs in ((found[:half, 0, 0], exact[:half]), (found[half : 2 * half, 0, 0], exact[half:])):
                np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max() + 1e-12)


@pytest.mark.parametrize("contrast", [10.0, 1e3, 1e5])
@pytest.mark.parametrize("top", ["isotropic", "incompressible"])
def test_thin_stiff_film(top, contrast):
    """A film of thickness t acts like a membrane, in all directions, up to t: ten times thinner, ten times nearer."""
    nu, k, errors = 0.3, np.geomspace(0.03, 5, 12), []
    for t in (1e-2, 1e-3):
        stretching, shear = contrast * t / (1 - nu**2), contrast * t / (2 * (1 + nu))
        membrane = fp.Membrane(stretching=stretching, shear=shear, bending=stretching * t**2 / 12)
        film = fp.Medium([TOPS[top], fp.Layer(contrast, nu, t)], BASE)
        ours, exact = functions(on(fp.Interface(membrane=membrane), TOPS[top]), k), functions(film, k)
        # the coupling vanishes on incompressible bodies, so that it is taken over the normal compliance
        errors.append(max(np.abs(ours[:3] / exact[:3] - 1).max(), np.abs((ours[3] - exact[3]) / exact[0]).max()))
    assert errors[0] < 1.2e-2
    assert errors[1] < 0.15 * errors[0]


@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=[pytest.mark.long] if each == "graded" else []) for each in TOPS]
)
@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("base", [BASE, fp.RigidBase()], ids=["elastic", "rigid"])
def test_limits(name, face, base):
    """Without stiffness there is no membrane; on a rigid base it does not move; it makes everything stiffer; stiff ones hold."""
    top, springs = TOPS[name], replace(FACES[face], membrane=None)
    plain = functions(on(springs, top, base), K)
    np.testing.assert_allclose(functions(on(replace(springs, membrane=fp.Membrane()), top, base), K), plain, rtol=1e-12)
    held = functions(on(FACES[face], top, base), K)
    if base.rigid:
        np.testing.assert_allclose(held, plain, rtol=1e-12)
    assert np.all(held[:3] <= plain[:3] * (1 + 1e-9))
    # incompressible layers at long waves are themselves stiff like (k h)^-2
    stiff = replace(springs, membrane=fp.Membrane(*4 * (1e10,)))
    np.testing.assert_allclose(
        functions(on(stiff, top, base), K[K > 0.1]), functions(on(springs, top, fp.RigidBase()), K[K > 0.1]), rtol=1e-5
    )


@pytest.mark.parametrize("name", TOPS)
@pytest.mark.parametrize("face", FACES)
def test_waves_at_depth(name, face):
    """They reach the surface with its compliance, and the tractions jump by what the membrane carries of its displacement."""
    medium = on(FACES[face], TOPS[name])
    waves = waves_at(medium, K, np.array([0.0, 1.0, 1.0]), np.array([0, 0, 1]))
    # steps through graded layers leave 1e-9
    np.testing.assert_allclose(waves.normal[1, :, 0] / K, fp.compliance(medium)(K), rtol=1e-8)
    along, across, normal = MEMBRANE.stiffness(K) / K
    for fields in (waves.normal, waves.shear):
        u_l, u_z, s_lz, s_zz = fields[:4]
        size = np.abs(fields[2:4, :, 1:]).max()
        np.testing.assert_allclose(s_lz[:, 2] - s_lz[:, 1], along * u_l[:, 2], rtol=0, atol=1e-9 * size)
        np.testing.assert_allclose(s_zz[:, 2] - s_zz[:, 1], normal * u_z[:, 2], rtol=0, atol=1e-9 * size)
    u_t, s_tz, _ = waves.transverse
    np.testing.assert_allclose(s_tz[:, 2] - s_tz[:, 1], across * u_t[:, 2], rtol=0, atol=1e-9)


def test_fields_are_in_equilibrium_with_the_tension():
    """Under a sphere the pressure jumps by the tension times the curvature of the interface, by differences over the radius."""
    tension, thickness = 2e-3, 1e-6
    face = fp.Interface(membrane=fp.Membrane(tension=tension))
    medium, tip = fp.Medium([fp.Layer(2e3, 0.5, thickness, bonded=face)], fp.HalfSpace(1e3, 0.5)), fp.Sphere(5e-6)
    h = 0.02e-6
    x = np.array([0.3e-6, 1e-6, 2e-6])[:, None] + h * np.arange(-2, 3)
    above, below = (fp.fields(medium, tip, x.ravel(), 0.0, thickness, radius=1e-6, side=s) for s in ("above", "below"))
    jump = (below.stress - above.stress).sel(component="zz").values.reshape(x.shape)[:, 2]
    w = below.displacement.sel(axis="z").values.reshape(x.shape)
    slope = w @ np.array([1, -8, 0, 8, -1]) / (12 * h)
    bend = w @ np.array([-1, 16, -30, 16, -1]) / (12 * h**2)
    # tension holds the interface back: s_zz below is larger, in tension, by -T times the curvature
    np.testing.assert_allclose(jump, -tension * (bend + slope / x[:, 2]), rtol=0, atol=1e-4 * np.abs(jump).max())
    assert np.abs(jump).max() > 0.1 * np.abs(above.stress.sel(component="zz")).max()


@pytest.mark.parametrize("face", FACES)
def test_derivatives_against_differences(face):
    """By every number of the membrane and all others, at all waves; differences leave 1e-7."""
    layers = [replace(TOPS["isotropic"], bonded=FACES[face]), replace(TOPS["anisotropic"], bonded=FACES["bonded"])]
    medium, k = fp.Medium(layers, BASE), np.array([0.1, 1.0, 3.0])
    found = compliance_derivatives(medium, k)
    for part in paths.layers_and_bases(medium):
        for place in part.places:
            kind = place.path.removeprefix(f"{part.path}.")
            ours = found[part.part].thickness if kind == "thickness" else found[part.part].constants[kind][0]
            ends = [
                layered_response(changed, k) * 2 / (changed.surface_modulus * k)
                for sign in (1, -1)
                for changed in (paths.with_values(medium, None, {place.path: place.value * (1 + sign * 1e-4)})[0],)
            ]
            slope = (ends[0] - ends[1]) / (2e-4 * place.value)
            np.testing.assert_allclose(ours, slope, rtol=1e-6, atol=1e-8 / k.max(), err_msg=place.path)


def test_sensitivities_and_energies():
    """All moduli and stiffnesses together scale the force, lengths too; the energies are the work."""
    layers = [fp.Layer(1e3, 0.4, 1e-6, fp.Interface(1e10, 1e10, fp.Membrane(1e-3, 5e-3, 2e-3, 1e-15)))]
    medium, tip = fp.Medium([*layers, fp.Layer(2e3, 0.3, 1e-6)], fp.HalfSpace(1e3, 0.2)), fp.Sphere(10e-6)
    found = fp.sensitivity(medium, tip, depth=100e-9)
    force = found.force
    values = {str(name): float(force.sel(parameter=name)) for name in force.parameter.values}
    stiff = [
        name
        for name in values
        if name.endswith(("young", "normal", "bonded.shear", "tension", "stretching", "bending"))
    ]
    assert sum(values[name] for name in stiff) == pytest.approx(1.0, abs=1e-9)
    assert values["layers[0].bonded.membrane.shear"] == 0
    of_length = {
        "thickness": 1,
        "radius": 1,
        "normal": -1,
        "bonded.shear": -1,
        "tension": 1,
        "stretching": 1,
        "bending": 3,
    }
    total = sum(
        power * value for end, power in of_length.items() for name, value in values.items() if name.endswith(end)
    )
    # F = E d^2 f(lengths/d): of degree two in all lengths
    steps = [float(fp.indent(medium, tip, depth=100e-9 * factor).force[0]) for factor in (1.01, 1 / 1.01)]
    assert total == pytest.approx(2 - np.log(steps[0] / steps[1]) / np.log(1.01**2), rel=1e-4)
    energies = fp.energy_by_depth(medium, tip, depth=100e-9)
    assert np.all(energies.energy > 0)
    assert float(energies.energy.sum()) == pytest.approx(energies.attrs["total"], rel=1e-6)


@pytest.mark.parametrize("factor", [1e-9, 1e6])
def test_scales(factor):
    """Lengths times a factor and moduli over it: the response is the same to rounding."""
    membrane = fp.Membrane(0.7, 2.0, 0.8, 0.3 * factor**2)
    scaled = fp.Layer(1.0 / factor, 0.3, factor, fp.Interface(membrane=membrane))
    ours = fp.compliance(fp.Medium([scaled], fp.HalfSpace(3.0 / factor, 0.2)))(K / factor)
    np.testing.assert_allclose(ours, fp.compliance(on(FACES["bonded"]))(K) * factor**2, rtol=1e-12)


def test_case_file(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        """
        control = { depth = "100 nm" }
        indenter = { kind = "sphere", radius = "5 um" }
        base = { kind = "half-space", young = "1 kPa", poisson = 0.5 }
        [[layers]]
        young = "2 kPa"
        poisson = 0.5
        thickness = "0.2 um"
        membrane_tension = "1 mN/m"
        membrane_bending = "0.1 aJ"
        """
    )
    case = fp.read_case(path)
    assert case.medium.layers[0].bonded == fp.Interface(membrane=fp.Membrane(tension=1e-3, bending=1e-19))
    assert "on a membrane, tension 1 mN/m, bending 0.1 aJ, on the base" in "\n".join(fp.files.describe(case))
    assert "a membrane, tension 1 mN/m" in str(case.medium)
    text = path.read_text()
    path.write_text(text.replace("membrane_tension", "bonded = false\nmembrane_tension"))
    assert fp.read_case(path).medium.layers[0].bonded.shear == 0
    path.write_text(text.replace("membrane_tension", 'interface_normal = "1 GPa/m"\nmembrane_tension'))
    assert "springs, normal 1 GPa/m, on a membrane" in str(fp.read_case(path).medium)
    for wrong, message in (('"1 kPa"', "force per length"), ('"-1 mN/m"', "must be finite and >= 0")):
        path.write_text(text.replace('"1 mN/m"', wrong))
        with pytest.raises(fp.files.CaseError, match=message):
            fp.read_case(path)


def test_wrong_input():
    with pytest.raises(ValueError, match=r"Membrane.tension = -1"):
        fp.Membrane(tension=-1.0)
    with pytest.raises(TypeError, match=r"Interface.membrane = 0.001 must be a Membrane\(tension=...\), or None"):
        fp.Interface(membrane=1e-3)
    with pytest.raises(ValueError, match=r"layers\[0\].bonded has a membrane"):
        fp.homogenised([replace(TOPS["isotropic"], bonded=FACES["bonded"]), TOPS["isotropic"]])
