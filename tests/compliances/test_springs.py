"""Interfaces with springs: multiprecision, limits, the thin interphase that they stand for, sensitivities, case files, fits."""

from dataclasses import replace

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances.depth import waves_at
from flatpunch.compliances.response import layered_response
from flatpunch.fits import ForwardModel
from support.propagators import random_stack, wave

K = np.geomspace(1e-3, 20, 40)
BASE = fp.HalfSpace(3.0, 0.2)
TOPS = {
    "isotropic": fp.Layer(1.0, 0.3, 1.0),
    "incompressible": fp.Layer(1.0, 0.5, 1.0),
    "anisotropic": fp.TransverselyIsotropicLayer(3.0, 1.0, 0.2, 0.3, 0.7, 1.0),
    "graded": fp.GradedLayer(fp.LinearModulus(1.0, 2.0, 1.0), 0.3, 1.0),
}


def response(top, face, base=BASE):
    return fp.compliance(fp.Medium([replace(top, bonded=face)], base))(K)


@pytest.mark.long
def test_stacks_with_springs_against_multiprecision():
    """Stiffnesses of 1e-3 to 1e3 moduli over a thickness, on all kinds of layers."""
    rng = np.random.default_rng(4)
    for _ in range(25):
        medium = random_stack(rng, springs=True)
        k = 10 ** rng.uniform(-3, 1)
        ours = layered_response(medium, np.array([k]))[0] * 2 / (medium.surface_modulus * k)
        assert ours == pytest.approx(wave(medium, k, 0.0, 0, (0, -1))[1] / k, rel=1e-11)
        layer = int(rng.integers(0, len(medium.layers)))
        faces = np.concatenate([[0.0], np.cumsum([each.thickness for each in medium.layers])])
        z = faces[layer] + rng.random() * medium.layers[layer].thickness
        waves = waves_at(medium, np.array([k]), np.array([z]), np.array([layer]))
        for found, load in ((waves.normal, (0, -1)), (waves.shear, (1, 0)), (waves.transverse, (1,))):
            exact = wave(medium, k, z, layer, load)
            half = len(exact) // 2
            for mine, theirs in ((found[:half, 0, 0], exact[:half]), (found[half : 2 * half, 0, 0], exact[half:])):
                np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max() + 1e-12)


@pytest.mark.parametrize("name", TOPS)
@pytest.mark.parametrize("base", [BASE, fp.RigidBase()], ids=["elastic", "rigid"])
def test_limits(name, base):
    """Stiff springs stick, soft ones slide: linear in what is left of the stiffness; no springs are no difference."""
    top = TOPS[name]
    bonded, sliding = response(top, True, base), response(top, False, base)
    np.testing.assert_allclose(response(top, fp.Interface(), base), bonded, rtol=1e-12)
    np.testing.assert_allclose(response(top, fp.Interface(np.inf, np.inf), base), bonded, rtol=1e-12)
    np.testing.assert_allclose(response(top, fp.Interface(shear=0.0), base), sliding, rtol=1e-12)
    # at long waves k h the stiffness counts beside E (k h)^2, on rigid bases even a large one
    some = K > 0.1
    np.testing.assert_allclose(response(top, fp.Interface(1e8, 1e8), base)[some], bonded[some], rtol=1e-4)
    np.testing.assert_allclose(response(top, fp.Interface(shear=1e-8), base)[some], sliding[some], rtol=1e-4)
    softer = [response(top, fp.Interface(shear=value), base) for value in (10.0, 1.0, 0.1)]
    for one, other in zip([bonded, *softer], [*softer, sliding], strict=True):
        assert np.all(other >= one * (1 - 1e-9))


def test_long_waves_on_a_rigid_base_feel_the_normal_spring():
    """C(0) is the oedometric compliance of the layer and that of the spring in series."""
    nu, spring = 0.3, 0.5
    oedometric = (1 + nu) * (1 - 2 * nu) / (1 - nu)
    medium = fp.Medium([fp.Layer(1.0, nu, 1.0, bonded=fp.Interface(normal=spring))], fp.RigidBase())
    assert fp.compliance(medium)(1e-6)[()] == pytest.approx(oedometric + 1 / spring, rel=1e-9)


def test_thin_interphase():
    """A soft layer of thickness t acts like springs C33/t and G/t, up to t."""
    young, nu = 1e-3, 0.3
    mu, c33 = young / (2 * (1 + nu)), young * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    k = np.geomspace(1e-2, 5, 20)
    errors = []
    for t in (1e-3, 1e-5):
        soft = fp.Medium([fp.Layer(1.0, 0.3, 1.0), fp.Layer(young, nu, t)], BASE)
        springs = fp.Medium([fp.Layer(1.0, 0.3, 1.0, bonded=fp.Interface(c33 / t, mu / t))], BASE)
        errors.append(np.abs(fp.compliance(springs)(k) / fp.compliance(soft)(k) - 1).max())
    assert errors[0] < 2e-4
    assert errors[1] < 0.05 * errors[0]


def test_jumps_of_the_displacement():
    """Across the interface the displacement jumps by the traction over the stiffness."""
    face, thickness = fp.Interface(2e15, 5e14), 1e-6
    medium, tip = fp.Medium([fp.Layer(10e9, 0.3, thickness, bonded=face)], fp.HalfSpace(100e9, 0.2)), fp.Sphere(10e-6)
    x = np.linspace(0.1e-6, 2e-6, 7)
    above, below = (fp.fields(medium, tip, x, 0.0, thickness, radius=1e-6, side=side) for side in ("above", "below"))
    jump = (below.displacement - above.displacement).values
    stress = above.stress.sel(component=["xz", "zz"]).values
    axes = list(above.axis.values)
    along, across = (np.moveaxis(jump, list(above.displacement.dims).index("axis"), 0)[axes.index(a)] for a in "xz")
    traction = np.moveaxis(stress, list(above.stress.dims).index("component"), 0)
    np.testing.assert_allclose(along, traction[0] / 5e14, rtol=0, atol=1e-9 * np.abs(traction).max() / 5e14)
    np.testing.assert_allclose(across, traction[1] / 2e15, rtol=0, atol=1e-9 * np.abs(traction).max() / 2e15)


def test_sensitivity_to_the_springs():
    """Against differences; all moduli and stiffnesses together scale the force."""
    layers = [fp.Layer(10e9, 0.3, 1e-6, bonded=fp.Interface(2e15, 5e14)), fp.Layer(20e9, 0.3, 1e-6)]
    medium, tip = fp.Medium(layers, fp.HalfSpace(100e9, 0.2)), fp.Sphere(10e-6)
    found = fp.sensitivity(medium, tip, depth=100e-9)
    for kind in ("normal", "shear"):
        forces = []
        for factor in (1.01, 1 / 1.01):
            face = replace(layers[0].bonded, **{kind: factor * getattr(layers[0].bonded, kind)})
            changed = fp.Medium([replace(layers[0], bonded=face), layers[1]], medium.base)
            forces.append(float(fp.indent(changed, tip, depth=100e-9).force[0]))
        slope = np.log(forces[0] / forces[1]) / np.log(1.01**2)
        assert float(found.force.sel(parameter=f"layers[0].bonded.{kind}")) == pytest.approx(slope, rel=1e-3)
    stiff = [name for name in found.parameter.values if name.endswith(("young", "normal", "shear"))]
    assert len(stiff) == 5
    assert float(found.force.sel(parameter=stiff).sum()) == pytest.approx(1.0, abs=1e-9)


def test_case_file_and_fit(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        """
        control = { depth = "100 nm" }
        indenter = { kind = "sphere", radius = "5 um" }
        base = { kind = "rigid" }
        layers = [{ young = "5 GPa", poisson = 0.3, thickness = "2 um", interface_shear = "500 MPa/um" }]
        """
    )
    case = fp.read_case(path)
    (layer,) = case.medium.layers
    assert layer.bonded == fp.Interface(shear=5e14)
    assert "on springs, shear 500 TPa/m, on the base" in "\n".join(fp.files.describe(case))
    assert "springs, shear 500 TPa/m" in str(case.medium)
    path.write_text(path.read_text().replace("interface_shear", "bonded = false, interface_shear"))
    with pytest.raises(fp.files.CaseError, match="leave bonded out"):
        fp.read_case(path)
    depth = np.linspace(10e-9, 100e-9, 10)
    start = fp.Medium([replace(layer, bonded=fp.Interface(shear=1e14))], case.medium.base)
    name = "layers[0].bonded.shear"
    force = ForwardModel(start, case.indenter, (name,)).force(depth, {name: 5e14})
    # tables of the force leave 1e-7
    np.testing.assert_allclose(force, fp.indent(case.medium, case.indenter, depth=depth).force, rtol=1e-6)


def test_bad_input():
    with pytest.raises(ValueError, match=r"Interface.normal = 0"):
        fp.Interface(normal=0.0)
    with pytest.raises(ValueError, match=r"Interface.shear = -1"):
        fp.Interface(shear=-1.0)
    with pytest.raises(TypeError, match=r"Layer.bonded = 'yes' must be True, False or an Interface"):
        fp.Layer(1.0, 0.3, 1.0, bonded="yes")


@pytest.mark.parametrize("name", TOPS)
@pytest.mark.parametrize("face", [True, False, fp.Interface(shear=0.3), fp.Interface(0.5, 2.0)], ids=str)
@pytest.mark.parametrize("base", [BASE, fp.RigidBase()], ids=["elastic", "rigid"])
def test_waves_at_depth_reach_the_surface_with_its_compliance(name, face, base):
    """By two roads: states that are swept up and down, and the flexibility of all that lies below."""
    medium = fp.Medium([replace(TOPS[name], bonded=face)], base)
    waves = waves_at(medium, K, np.array([0.0, 0.4]), np.zeros(2, dtype=int))
    # steps through graded layers leave 1e-9
    np.testing.assert_allclose(waves.normal[1, :, 0] / K, fp.compliance(medium)(K), rtol=1e-8)
