"""Graded transversely isotropic layers as data: ranges and stability over the depth, case files, fits, what refuses them."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.files.cases import CaseError
from flatpunch.media import paths

H = 2e-6
FILM = fp.GradedLayer(
    young=fp.LinearModulus(20e3, 60e3, H),
    poisson=0.45,
    thickness=H,
    young_axial=([0, H / 2, H], [80e3, 60e3, 100e3]),
    poisson_axial=0.3,
    shear=lambda z: 6e3 + 2e9 * z,
)
CASE = """
control = { depth = "100 nm" }
indenter = { kind = "sphere", radius = "5 um" }
base = { kind = "half-space", young = "210 GPa", poisson = 0.3 }

[[layers]]
young = "250 GPa"
poisson = 0.25
young_axial = { law = "linear", top = "400 GPa", bottom = "210 GPa" }
poisson_axial = { depths = ["0 um", "2 um"], values = [0.2, 0.25] }
shear = { formula = "110 - 10*z", unit = "GPa", depth_unit = "um" }
thickness = "2 um"
"""


@pytest.mark.parametrize(
    ("axial", "message"),
    [
        ({"young_axial": 1.0}, r"GradedLayer\.poisson_axial = None is missing.*all three or none"),
        ({"young_axial": 1.0, "poisson_axial": 0.1}, r"GradedLayer\.shear = None is missing"),
        ({"young_axial": fp.Formula("1 - 2*z"), "poisson_axial": 0.1, "shear": 1.0}, r"young_axial = 0 at depth z = 500 mm"),
        ({"young_axial": 1.0, "poisson_axial": 0.1, "shear": 0.0}, r"GradedLayer\.shear = 0 at depth z = 0"),
        ({"young_axial": 1.0, "poisson_axial": np.nan, "shear": 1.0}, r"GradedLayer\.poisson_axial"),
        ({"young_axial": 1.0, "poisson_axial": 0.6, "shear": 1.0}, r"poisson_axial = 0\.6.*at depth z = 0 m makes the body unst"),
        (
            {"young_axial": fp.LinearModulus(1.0, 0.1, 1.0), "poisson_axial": 0.3, "shear": 1.0},
            r"poisson_axial = 0\.3 at depth z = 1 m makes the body unstable.*0\.035 there",
        ),
    ],
)  # fmt: skip
def test_what_is_not_stable_at_every_depth_is_refused(axial, message):
    with pytest.raises(ValueError, match=message):
        fp.GradedLayer(1.0, 0.3, 1.0, **axial)


def test_instability_between_the_depths_checked_is_found():
    """A peak narrower than their distance, between two of them: its top is searched where they come closest to the limit."""
    with pytest.raises(ValueError, match=r"poisson_axial = 0\.59\d* at depth z = 500\.1 mm makes"):
        fp.GradedLayer(
            1.0,
            0.3,
            1.0,
            young_axial=1.0,
            poisson_axial=lambda z: 0.3 + 0.2935 * np.exp(-(((z - 0.50012) / 5e-4) ** 2)),
            shear=1.0,
        )


def test_incompressible_laws_are_incompressible_at_every_depth():
    """The rounding of the laws is none of the material's: C falls like k^2 on a rigid base."""
    layer = fp.GradedLayer(
        fp.ExponentialModulus(1.0, 50.0, 1.0),
        0.5,
        1.0,
        young_axial=fp.ExponentialModulus(4.0, 200.0, 1.0),
        poisson_axial=1.0,
        shear=1.0,
    )
    assert np.all(layer.plane_at(np.linspace(0, 1, 500)).oedometric == 0)
    k = np.array([1e-6, 1e-5])
    compliance = fp.compliance(fp.Medium([layer], fp.RigidBase()))(k)
    assert compliance[1] / compliance[0] == pytest.approx(100, rel=1e-6)


def test_it_is_shown_with_what_it_has():
    assert "axial" not in repr(fp.GradedLayer(1.0, 0.3, 1.0))
    assert "poisson_axial=Constant(value=0.3)" in repr(FILM)
    assert "axial" in str(fp.Medium([FILM], fp.RigidBase()))
    assert FILM.breaks == (H / 2,)


def test_case_file(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    case = fp.read_case(path)
    (layer,) = case.medium.layers
    assert layer.young_at(np.array(1e-6)) == 250e9
    np.testing.assert_allclose(
        [float(each) for each in layer.constants_at(np.array(1e-6))], [250e9, 305e9, 0.25, 0.225, 100e9], rtol=1e-12
    )
    assert "young_axial (LinearModulus top 400 GPa" in "\n".join(fp.files.describe(case))
    path.write_text(CASE.replace("[0.2, 0.25]", "[0.2, 0.7]"))
    with pytest.raises(CaseError, match=r"poisson_axial.*unstable"):
        fp.read_case(path)
    path.write_text(CASE.replace("110 - 10*z", "10 - 10*z"))
    with pytest.raises(CaseError, match=r"shear.*must be finite and > 0"):
        fp.read_case(path)
    path.write_text(CASE.replace('young_axial = { law = "linear", top = "400 GPa", bottom = "210 GPa" }\n', ""))
    with pytest.raises(CaseError, match="belong together"):
        fp.read_case(path)


@pytest.mark.long
@pytest.mark.parametrize("film", [FILM, fp.GradedLayer(FILM.young, 0.5, H)])
def test_a_fit_takes_all_moduli_along(film):
    """The curve is that of a film 2.5 times as stiff, as a factor of all laws: tables, functions and named ones."""
    name, tip = "layers[0].surface_modulus", fp.Sphere(5e-6)
    sample = fp.Medium([film], fp.RigidBase())
    stiff, _ = paths.with_values(sample, None, {name: 2.5 * film.surface_modulus})
    z = np.linspace(0, H, 7)
    for law, times in zip(film.constants_at(z), stiff.layers[0].constants_at(z), strict=True):
        np.testing.assert_allclose(times, law if law.max() < 1 else 2.5 * law, rtol=1e-14)
    depth = np.linspace(0, 3e-7, 40)
    curve = fp.Curve(depth=depth, force=fp.indent(stiff, tip, depth=depth).force.values)
    found = fp.fit(curve, sample, tip, [name], quick=True)
    # on a rigid base the force scales with the modulus; the contact point is free as well
    assert found[name] == pytest.approx(2.5 * film.surface_modulus, rel=1e-8)


def test_relaxation_of_single_layers_refuses_it():
    with pytest.raises(TypeError, match="belongs to a GradedLayer"):
        fp.indent(
            fp.Medium([FILM], fp.HalfSpace(1e3, 0.3)),
            fp.Sphere(5e-6),
            depth=[0, 1e-8],
            time=[0, 1],
            relaxation=[fp.StandardLinearSolid(0.5, 1.0), None],
        )


def test_the_mean_layer_of_slices_is_that_of_the_whole():
    """Backus: means over depth of the plane-strain coefficients."""
    whole = fp.homogenised([FILM])
    slices = []
    for top in np.linspace(0, H, 40, endpoint=False):
        x, w = np.polynomial.legendre.leggauss(4)
        young, axial, nu, nu_axial, shear = FILM.constants_at(top + H / 40 * (1 + x) / 2)
        slices += [
            fp.TransverselyIsotropicLayer(*map(float, row), float(weight) / 2 * H / 40)
            for *row, weight in zip(young, axial, nu, nu_axial, shear, w, strict=True)
        ]
    theirs = fp.homogenised(slices)
    for name in ("young_in_plane", "young_axial", "poisson_in_plane", "poisson_axial", "shear"):
        assert getattr(whole, name) == pytest.approx(getattr(theirs, name), rel=1e-9)


@pytest.mark.long
def test_contacts_of_other_kinds():
    """Two bodies, adhesion and boundary elements see C(k) alone: against the isotropic layer of the same constants."""
    young = fp.LinearModulus(20e3, 60e3, H)
    other = fp.GradedLayer(young, 0.3, H, True, young, 0.3, fp.LinearModulus(20e3 / 2.6, 60e3 / 2.6, H))
    one, two = (fp.Medium([each], fp.RigidBase()) for each in (fp.GradedLayer(young, 0.3, H), other))
    tip = fp.Sphere(5e-6)
    for contact in (
        lambda body: fp.indent(fp.TwoBodies(body, fp.HalfSpace(30e3, 0.4)), tip, depth=2e-7).force,
        lambda body: fp.indent(fp.TwoBodies(body, body), tip, depth=2e-7).force,
        lambda body: fp.indent(body, tip, depth=2e-7, work_of_adhesion=1e-4).force,
        lambda body: fp.indent(body, tip, depth=2e-7, method="bem").force,
        lambda body: fp.indent(body, fp.Vickers(), depth=2e-7).force,
    ):
        assert float(contact(two)[0]) == pytest.approx(float(contact(one)[0]), rel=1e-9)
