"""Constants of transversely isotropic bodies: conversions, stability, what a fit varies, case files."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.files.cases import CaseError
from flatpunch.fits import ForwardModel
from flatpunch.media import paths
from flatpunch.media.plane import Plane, plane_slopes
from support.propagators import random_material

CASE = """
control = { depth = "100 nm" }
indenter = { kind = "sphere", radius = "5 um" }
base = { kind = "half-space", young = "210 GPa", poisson = 0.3 }

[[layers]]
young = "250 GPa"
poisson = 0.25
young_axial = "400 GPa"
poisson_axial = 0.2
shear = "110 GPa"
thickness = "2 um"
"""


def test_stiffnesses_and_engineering_constants_are_inverse():
    given = (1060e9, 180e9, 15e9, 36.5e9, 4.5e9)
    layer = fp.TransverselyIsotropicLayer.from_stiffnesses(*given, thickness=1e-6)
    np.testing.assert_allclose(layer.stiffnesses, given, rtol=1e-14)
    # Hooke's law inverted as a matrix
    c11, c12, c13, c33, _ = given
    compliance = np.linalg.inv([[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]])
    assert layer.young_in_plane == pytest.approx(1 / compliance[0, 0], rel=1e-13)
    assert layer.young_axial == pytest.approx(1 / compliance[2, 2], rel=1e-13)
    assert layer.poisson_in_plane == pytest.approx(-compliance[0, 1] / compliance[0, 0], rel=1e-13)
    assert layer.poisson_axial == pytest.approx(-compliance[0, 2] / compliance[2, 2], rel=1e-13)


def test_isotropic_and_incompressible_constants():
    body = fp.TransverselyIsotropicHalfSpace(2.0, 2.0, 0.5, 0.5, 2 / 3)
    assert body.plane.oedometric == 0
    assert np.isinf(body.stiffnesses.c33)
    assert body.surface_modulus == pytest.approx(fp.HalfSpace(2.0, 0.5).surface_modulus, rel=1e-14)


@pytest.mark.parametrize(
    ("constants", "message"),
    [
        ((1.0, 0.1, 0.3, 0.3, 1.0), r"poisson_axial = 0.3 makes the body unstable.* give 0.03"),
        ((1.0, 1.0, 1.0, 0.0, 1.0), r"poisson_in_plane = 1.0 must lie in -1"),
        ((1.0, 1.0, 0.3, 0.3, 0.0), r"TransverselyIsotropicHalfSpace.shear"),
        ((-1.0, 1.0, 0.3, 0.3, 1.0), r"TransverselyIsotropicHalfSpace.young_in_plane"),
        ((1.0, 1.0, 0.3, float("nan"), 1.0), r"TransverselyIsotropicHalfSpace.poisson_axial"),
    ],
)
def test_unstable_bodies_are_refused(constants, message):
    with pytest.raises(ValueError, match=message):
        fp.TransverselyIsotropicHalfSpace(*constants)


def test_unstable_stiffnesses_are_refused_exactly_where_the_tensor_is_not_positive():
    rng, refused = np.random.default_rng(2), 0
    for _ in range(300):
        c11, c12, c13, c33, c44 = rng.normal(size=5)
        tensor = np.array([[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]])
        if c44 > 0 and np.linalg.eigvalsh(tensor).min() > 0:
            assert fp.TransverselyIsotropicHalfSpace.from_stiffnesses(c11, c12, c13, c33, c44).surface_modulus > 0
        else:
            refused += 1
            with pytest.raises(ValueError, match="is not stable"):
                fp.TransverselyIsotropicHalfSpace.from_stiffnesses(c11, c12, c13, c33, c44)
    assert 100 < refused < 300


def test_slopes_of_the_coefficients():
    body = fp.TransverselyIsotropicHalfSpace(*random_material(np.random.default_rng(1)))
    for name, slope in plane_slopes(body.constants).items():
        step = 1e-6 * getattr(body, name)
        ends = [paths.with_values(body, None, {f"base.{name}": getattr(body, name) + s * step})[0] for s in (1, -1)]
        difference = (np.array(ends[0].plane) - np.array(ends[1].plane)) / (2 * step)
        np.testing.assert_allclose(difference, Plane(*slope), rtol=1e-7, atol=1e-9 * np.abs(difference).max())


def test_young_varies_all_moduli_at_their_ratios():
    film = fp.TransverselyIsotropicLayer(250e9, 400e9, 0.25, 0.2, 110e9, thickness=2e-6)
    medium, _ = paths.with_values(fp.Medium([film], fp.HalfSpace(1e9, 0.3)), None, {"layers[0].young": 500e9})
    (other,) = medium.layers
    assert (other.young_in_plane, other.young_axial, other.shear) == (500e9, 800e9, 220e9)
    assert other.surface_modulus == pytest.approx(2 * film.surface_modulus)


def test_fit_of_one_modulus():
    film = fp.TransverselyIsotropicLayer(250e9, 400e9, 0.25, 0.2, 110e9, thickness=2e-6)
    coated, tip = fp.Medium([film], fp.HalfSpace(210e9, 0.3)), fp.Sphere(10e-6)
    start, _ = paths.with_values(coated, None, {"layers[0].young": 200e9})
    depth = np.linspace(10e-9, 300e-9, 10)
    force = ForwardModel(start, tip, ("layers[0].young",)).force(depth, {"layers[0].young": 250e9})
    # tables of the force leave 1e-7
    np.testing.assert_allclose(force, fp.indent(coated, tip, depth=depth).force, rtol=1e-6)
    wood = fp.TransverselyIsotropicHalfSpace(1e9, 12e9, 0.4, 0.4, 0.8e9)
    depth = np.linspace(0, 1e-6, 30)
    curve = fp.Curve(depth=depth, force=2 * fp.indent(wood, tip, depth=depth).force.values)
    assert fp.fit(curve, wood, tip, ["base.young"], quick=True)["base.young"] == pytest.approx(2e9, rel=1e-6)


def test_case_file(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    case = fp.read_case(path)
    assert case.medium.layers == (fp.TransverselyIsotropicLayer(250e9, 400e9, 0.25, 0.2, 110e9, 2e-6),)
    assert "young_axial 400 GPa" in "\n".join(fp.files.describe(case))
    assert "250 GPa in plane, 400 GPa axial, shear 110 GPa" in str(case.medium)
    path.write_text(CASE.replace('shear = "110 GPa"\n', ""))
    with pytest.raises(CaseError, match="young_axial, poisson_axial and shear belong together"):
        fp.read_case(path)
    path.write_text(CASE.replace("poisson_axial = 0.2", "poisson_axial = 0.9"))
    with pytest.raises(CaseError, match=r"poisson_axial.*0.9"):
        fp.read_case(path)
    path.write_text(CASE.replace("poisson = 0.25", "poisson = 1.25"))
    with pytest.raises(CaseError, match=r"layers\[0\].poisson = 1.25 must lie in -1"):
        fp.read_case(path)
    path.write_text(
        CASE.replace(
            "poisson = 0.3 }", 'poisson = 0.3, young_axial = "100 GPa", poisson_axial = 0.2, shear = "50 GPa" }'
        )
    )
    assert fp.read_case(path).medium.base == fp.TransverselyIsotropicHalfSpace(210e9, 100e9, 0.3, 0.2, 50e9)
