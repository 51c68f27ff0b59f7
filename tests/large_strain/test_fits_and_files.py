"""`finite_strain` in fits, case files and the comparison of formulas."""

from dataclasses import replace

import numpy as np
import pytest

import flatpunch as fp
from support.large_strain import GEL, LAW, H, end_of_spheres, large


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("ratio", [0.3, 1.0, 4.0])
def test_fits_find_the_modulus_of_deep_curves(quick, ratio):
    """To the end of the table, noise of 0.2 % of the largest force."""
    tip, deepest = fp.Sphere(H / ratio), 0.999 * end_of_spheres(H / ratio, H)
    position = np.linspace(-0.4, 1, 500) * deepest
    force = np.zeros(500)
    force[position > 0] = fp.indent(GEL, tip, depth=position[position > 0], finite_strain=LAW).force.values
    force += 2e-3 * force.max() * np.random.default_rng(5).normal(size=500)
    curve = fp.Curve(depth=position + 1e-7, force=force)
    start = fp.Medium([fp.Layer(2e3, 0.4999, H)], base=fp.RigidBase())
    found = fp.fit(curve, start, tip, ["layers[0].young"], finite_strain=LAW, quick=quick)
    assert found["layers[0].young"] == pytest.approx(5e3, rel=0.01)
    thin = fp.Medium([fp.Layer(2e3, 0.4999, 0.8 * H)], base=fp.RigidBase())
    cut = fp.fit(curve, thin, fp.Sphere(0.8 * H / ratio), ["layers[0].young"], finite_strain=LAW, quick=quick)
    assert cut.depth.max() <= 1.001 * 0.8 * deepest
    assert any("are left out: the table of finite_strain ends" in note for note in cut.notes)


@pytest.mark.long
@pytest.mark.parametrize("shift", [1.0, 1.0 + 1e-9, 1.3, 1.7])
def test_fits_and_batches_end_with_the_table(shift):
    """Noise moves the contact of a curve that ends with the table; what is deeper is linear, and must not act."""
    tip, deepest = fp.Sphere(H), end_of_spheres(H, H)
    position = np.linspace(-0.4, shift, 700) * deepest
    force, touching = np.zeros(700), position > 0
    force[touching] = fp.indent(GEL, tip, depth=position[touching]).force.values
    at = np.clip(position[touching], 0, deepest)
    force[touching] *= (
        fp.indent(GEL, tip, depth=at, finite_strain=LAW).force.values / fp.indent(GEL, tip, depth=at).force.values
    )
    force *= 1 + 0.5 * np.maximum(position / deepest - 1, 0)
    force += 2e-3 * force.max() * np.random.default_rng(3).normal(size=force.size)
    curve = fp.Curve(depth=position + 1e-7, force=force)
    start = fp.Medium([fp.Layer(2e3, 0.4999, H)], base=fp.RigidBase())
    one = fp.fit(curve, start, tip, ["layers[0].young"], finite_strain=LAW)
    assert one["layers[0].young"] == pytest.approx(5e3, rel=0.01)
    table = fp.fit_batch([curve], start, tip, ["layers[0].young"], finite_strain=LAW, workers=1)
    assert float(table.rows[0]["layers[0].young"]) == pytest.approx(one["layers[0].young"], rel=1e-3)
    joint = fp.fit_together([curve, replace(curve, name="again")], start, tip, ["layers[0].young"], finite_strain=LAW)
    assert joint["layers[0].young"] == pytest.approx(5e3, rel=0.01)


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize("thickness", [np.inf, H])
@pytest.mark.parametrize(
    "tip", [fp.Cone(np.radians(25)), fp.Cone(np.radians(52)), fp.Pyramid(4, np.radians(35)), fp.SpheroCone(0.6, H / 4)]
)
def test_fits_find_the_modulus_under_cones_and_pyramids(quick, tip, thickness):
    """The factor belongs to the true angle, though tables of fits take cones of unit slope where forces scale with it."""
    deepest = 0.42 * H

    def gel(young):
        layer = fp.Layer(young, 0.4999, H)
        return fp.HalfSpace(young, 0.4999) if thickness == np.inf else fp.Medium([layer], base=fp.RigidBase())

    position = np.linspace(-0.4, 1, 500) * deepest
    force = np.zeros(500)
    force[position > 0] = fp.indent(gel(5e3), tip, depth=position[position > 0], finite_strain=LAW).force.values
    force += 2e-3 * force.max() * np.random.default_rng(5).normal(size=500)
    curve, name = (
        fp.Curve(depth=position + 1e-7, force=force),
        "base.young" if thickness == np.inf else "layers[0].young",
    )
    found = fp.fit(curve, gel(2e3), tip, [name], finite_strain=LAW, quick=quick)
    assert found[name] == pytest.approx(5e3, rel=0.01)
    if not isinstance(tip, fp.Rounded):
        with pytest.raises(ValueError, match="whose factor depends on it"):
            fp.fit(curve, gel(2e3), tip, [name, "indenter.inclination"], finite_strain=LAW, quick=quick)


CASE = """
base = { kind = "rigid" }
layers = [{ young = "5 kPa", poisson = 0.4999, thickness = "5 um" }]
indenter = { kind = "sphere", radius = "10 um" }
control = { depth = "2 um" }
[material]
finite_strain = "neo-hookean"
"""


def test_case_files(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    case = fp.read_case(path)
    found = fp.indent(case.medium, case.indenter, **case.arguments)
    assert float(found.strain_factor[0]) == pytest.approx(float(large(0.5, [0.4]).strain_factor[0]))
    path.write_text(CASE.replace('"sphere", radius = "10 um"', '"cone", inclination = "20 deg"'))
    case = fp.read_case(path)
    assert float(fp.indent(case.medium, case.indenter, **case.arguments).strain_factor[0]) == pytest.approx(
        0.98, abs=0.02
    )
    path.write_text(CASE.replace('"sphere", radius = "10 um"', '"pyramid", sides = 4, inclination = "35 deg"'))
    case = fp.read_case(path)
    assert float(fp.indent(case.medium, case.indenter, **case.arguments).force_error[0]) > 0.005
    path.write_text(CASE.replace('"sphere", ', '"paraboloid", '))
    with pytest.raises(ValueError, match="the tip is Paraboloid"):
        fp.read_case(path)
    path.write_text(CASE.replace("neo-hookean", "gent"))
    with pytest.raises(ValueError, match="neo-hookean"):
        fp.read_case(path)


def test_formula_of_long_et_al_is_nearer_to_large_strains_than_hertz():
    gel = fp.Medium([fp.Layer(5e3, 0.5, H)], base=fp.RigidBase())
    found = fp.compare_formulas(gel, fp.Sphere(H), depth=[0.2 * H, 0.4 * H], finite_strain=LAW)
    assert np.abs(found.deviation.sel(formula="Long").values).max() < 0.1
    assert np.abs(found.deviation.sel(formula="Hertz").values).min() > 0.3
