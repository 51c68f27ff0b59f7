"""Every number of every kind of medium and tip by one name: fitted to a curve with noise, differentiated, designed."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.designs.statement import variables
from flatpunch.fits import parameter_names
from flatpunch.fits.parameters.sample import Scale, ends, numbers_in
from flatpunch.fits.report.table import label
from flatpunch.media.paths import with_values
from flatpunch.sweeps.axes import axes_of

UM = 1e-6
DEEP = 0.4 * UM
BASE = fp.HalfSpace(5e3, 0.3)
SPHERE = fp.Sphere(5 * UM)


def graded(young, **more):
    return fp.Medium([fp.GradedLayer(young=young, **{"poisson": 0.4, "thickness": UM, **more})], base=BASE)


MEDIA = {
    "half-space": BASE,
    "layer": fp.Medium([fp.Layer(5e3, 0.45, UM)], base=fp.RigidBase()),
    "springs": fp.Medium([fp.Layer(5e3, 0.4, UM, bonded=fp.Interface(normal=1e10, shear=1e10))], base=BASE),
    "membrane": fp.Medium(
        [
            fp.Layer(
                5e3,
                0.4,
                UM / 4,
                bonded=fp.Interface(membrane=fp.Membrane(tension=5e-3, stretching=2e-2, bending=1e-15)),
            )
        ],
        base=BASE,
    ),
    "two layers": fp.Medium([fp.Layer(5e3, 0.45, UM / 2), fp.Layer(2e4, 0.3, UM / 2, bonded=False)], base=BASE),
    "anisotropic half-space": fp.TransverselyIsotropicHalfSpace(1e4, 2e4, 0.3, 0.2, 5e3),
    "anisotropic layer": fp.Medium([fp.TransverselyIsotropicLayer(1e4, 2e4, 0.3, 0.2, 5e3, UM)], base=BASE),
    "linear": graded(fp.LinearModulus(2e3, 1e4, UM)),
    "exponential": graded(fp.ExponentialModulus(2e3, 1e4, UM)),
    "power": graded(fp.PowerModulus(2e3, 1e4, UM, exponent=2.0)),
    "table": graded(fp.DepthTable([0, UM / 2, UM], [3e3, 7e3, 9e3])),
    "anisotropic graded": graded(5e3, poisson=0.3, young_axial=([0, UM], [1e4, 5e3]), poisson_axial=0.2, shear=3e3),
    "power-law half-space": fp.PowerLawHalfSpace(5e3, UM, 0.3, 0.4),
    "two bodies": fp.TwoBodies(upper=fp.HalfSpace(2e4, 0.4), lower=fp.Medium([fp.Layer(5e3, 0.4, UM)], base=BASE)),
}
TIPS = {
    "sphere": SPHERE,
    "paraboloid": fp.Paraboloid(5 * UM),
    "cone": fp.Cone(0.3),
    "cylinder": fp.Cylinder(UM),
    "pyramid": fp.Pyramid(4, 0.3),
    "power law": fp.PowerLaw(2.5, 1e8),
    "rounded cone": fp.SpheroCone(0.4, UM),
    "rounded pyramid": fp.Berkovich(tip_radius=0.3 * UM),
    "ellipsoid": fp.Ellipsoid(10 * UM, 6 * UM, 5 * UM),
    "elliptic paraboloid": fp.EllipticParaboloid(1e5, 5e4),
    "crowned roller": fp.Roller(5 * UM, 20 * UM, crown=100 * UM),
    "Knoop": fp.Knoop(),
    "blunt cone": fp.Truncated(fp.Cone(0.3), 0.1 * UM),
    "blunt paraboloid": fp.Truncated(fp.Paraboloid(5 * UM), 0.05 * UM),
    "area function": fp.AreaFunction([24.5, 500.0], limit=5 * UM, unit=1e-9),
    "profile": fp.RadialProfile([0, UM, 2 * UM, 4 * UM], [0, 0.1 * UM, 0.4 * UM, 2 * UM]),
    "superellipse": fp.Superellipse(10 * UM, 6 * UM, UM),
    "tilted": fp.Tilted(fp.Pyramid(4, 0.4), 0.05, 0.03),
}
NONE = {("crowned roller", "indenter.length")}
"""Numbers on which the force does not depend."""


QUICK = {"base.young", "base.young_axial", "base.exponent", "indenter.exponent", "indenter.angular.value", "indenter.A"}


def cases(media, tips):
    for kind, medium in media.items():
        for tip_kind, tip in tips.items():
            for name in numbers_in(medium, tip):
                of_tip = name.startswith("indenter.")
                if (of_tip and medium is not BASE) or (not of_tip and tip is not SPHERE) or (tip_kind, name) in NONE:
                    continue
                simple = kind in ("half-space", "power-law half-space", "anisotropic half-space")
                marks = [] if simple and name in QUICK else [pytest.mark.long]
                yield pytest.param(medium, tip, name, id=f"{tip_kind if of_tip else kind}-{name}", marks=marks)


def measured(medium, tip, method):
    z = np.linspace(-0.4 * DEEP, DEEP, 300)
    force = np.zeros(z.size)
    force[z > 0] = fp.indent(medium, tip, depth=z[z > 0], method=method).force
    return fp.Curve(z, force + 5e-3 * force.max() * np.random.default_rng(1).normal(size=z.size))


@pytest.mark.parametrize(
    ("medium", "tip", "name"), [*cases(MEDIA, {"sphere": SPHERE}), *cases({"half-space": BASE}, TIPS)]
)
def test_fit_of_each_number(medium, tip, name):
    """Noise of 0.5 % of the force; the truth is within three standard errors, and the model exact to 1e-6."""
    method = "exact" if tip.round else "second-order"
    true = numbers_in(medium, tip)[name].value
    # away from the truth, on the side on which there is such a body
    for share in (1.04, 0.96):
        try:
            start = with_values(medium, tip, {name: share * true})
            break
        except ValueError:
            continue
    result = fp.fit(measured(medium, tip, method), *start, [name], method=method)
    found = result.estimates[name]
    assert abs(found.value - true) < 3 * found.stderr < 3 * abs(true)
    assert result.model_error(4) < 1e-6
    assert not any("the table of forces is off" in note for note in result.notes)


PAIRS = [pytest.param(each, SPHERE, id=name) for name, each in MEDIA.items()]
PAIRS += [pytest.param(BASE, each, id=name) for name, each in TIPS.items()]


@pytest.mark.long
@pytest.mark.parametrize(("medium", "tip"), PAIRS)
def test_names_of_sensitivities(medium, tip):
    plain = {
        name: each for name, each in numbers_in(medium, tip).items() if name not in numbers_in(medium, tip).members
    }
    found = fp.sensitivity(medium, tip, depth=0.05 * UM, method=None if tip.round else "first-order")
    assert {name: each.number.unit or "1" for name, each in plain.items()} == dict(
        zip(found.parameter.values, found.unit.values, strict=True)
    )


@pytest.mark.parametrize(("medium", "tip"), PAIRS)
def test_names_of_designs(medium, tip):
    """Fits and designs have the same names; fits the groups of moduli besides. Internal values are those of the declaration."""
    numbers = numbers_in(medium, tip)
    assert parameter_names(medium, tip) == list(numbers)
    plain = [name for name in numbers if name not in numbers.members]
    for name in plain:
        value = numbers[name].value
        assert variables(medium, tip, {name: tuple(sorted((0.999999 * value, value)))}).names == (name,)
        assert label(numbers[name])
    with pytest.raises(ValueError) as refused:
        variables(medium, tip, {"nothing": (1.0, 2.0)})
    assert str(refused.value).partition(" It has ")[2].strip("'.") == ", ".join(plain)
    for name, each in numbers.items():
        scale, (low, high) = Scale.of(each), ends(each)
        x = scale.internal(each.value)
        assert low < x <= high
        assert scale.external(x) == pytest.approx(each.value, rel=1e-12)
        step = 1e-6 * (scale.external(x + 1) - scale.external(x))
        near = (scale.internal(each.value + step) - scale.internal(each.value - step)) / (2 * step)
        assert float(scale.slope(x)) * near == pytest.approx(1, rel=1e-4), name


def test_names_of_sweeps():
    """Paths of a case file are those of the numbers, in both spellings."""
    data = {
        "layers": [{"young": "5 kPa", "poisson": 0.4, "thickness": "1 um"}],
        "base": {"kind": "half-space", "young": "5 kPa", "poisson": 0.3},
        "indenter": {"kind": "sphere", "radius": "5 um"},
    }
    medium = fp.Medium([fp.Layer(5e3, 0.4, UM)], base=BASE)
    for name, each in numbers_in(medium, SPHERE).items():
        (axis,) = axes_of(data, {name: [each.value, 0.9 * each.value]})
        assert axis.unit == (each.number.unit or "")


@pytest.mark.parametrize(
    ("medium", "group", "member"),
    [
        (MEDIA["anisotropic half-space"], "base.young", "base.shear"),
        (MEDIA["linear"], "layers[0].surface_modulus", "layers[0].young.bottom"),
    ],
)
def test_groups_exclude_their_members(medium, group, member):
    curve = fp.Curve(np.linspace(-1, 1, 50), np.zeros(50))
    with pytest.raises(ValueError, match="exclude each other"):
        fp.fit(curve, medium, SPHERE, [group, member])


@pytest.mark.long
def test_a_group_beside_what_is_no_modulus():
    """The surface modulus of a law is that of the fitted medium, whatever else of the law is free."""
    medium = MEDIA["linear"]
    values = {"layers[0].surface_modulus": 3e3, "layers[0].poisson": 0.2}
    changed, _ = with_values(medium, SPHERE, values)
    assert changed.layers[0].surface_modulus == pytest.approx(3e3, rel=1e-12)
    assert changed.layers[0].poisson(np.zeros(1)) == pytest.approx(0.2)
    found = fp.fit(measured(changed, SPHERE, "exact"), medium, SPHERE, list(values)[:1])
    assert found.case[0].layers[0].surface_modulus == pytest.approx(found["layers[0].surface_modulus"], rel=1e-9)


BASIC = """
title = "any number"
layers = [{ young = "5 kPa", poisson = 0.4, thickness = "1 um" }]
base = { kind = "half-space", young = "5 kPa", poisson = 0.3 }
indenter = { kind = "cone", half_opening_angle = { fit = "70 deg", min = "60 deg", max = "80 deg" } }
"""


def read(tmp_path, text):
    path = tmp_path / "case.toml"
    path.write_text(text)
    return fp.fits.read_fit_case(path)


def test_a_value_of_a_case_file_is_fitted_as_the_number_that_it_changes(tmp_path):
    (name, free), *others = read(tmp_path, BASIC).free.items()
    assert (name, others) == ("indenter.inclination", [])
    assert np.rad2deg([free.minimum, free.maximum]) == pytest.approx([10, 30])


@pytest.mark.parametrize(
    ("tip", "name", "limits"),
    [
        (
            'kind = "cone", inclination = "20 deg", tip_radius = { fit = "1 um", min = "0.5 um" }',
            "indenter.radius",
            (5e-7, None),
        ),
        (
            'kind = "elliptic-paraboloid", radius_x = { fit = "5 um", min = "2 um" }, radius_y = "9 um"',
            "indenter.A",
            (None, 2.5e5),
        ),
    ],
)
def test_limits_go_with_the_value(tmp_path, tip, name, limits):
    lines = BASIC.splitlines()[:-1]
    found = read(tmp_path, "\n".join([*lines, f"indenter = {{ {tip} }}"])).free
    assert list(found) == [name]
    for each, limit in zip((found[name].minimum, found[name].maximum), limits, strict=True):
        assert each == (limit if limit is None else pytest.approx(limit))


def test_a_table_that_is_off_is_noted(monkeypatch):
    """By 0.1 % of the force; a batch solves one contact for fits that are near each other."""
    from flatpunch.fits.elastic.model import ForwardModel
    from flatpunch.fits.fitting import forget_models

    curve, solved, exact = measured(BASE, SPHERE, "exact"), [], ForwardModel.exact

    def off(model, depth, values):
        solved.append(values)
        found = exact(model, depth, values)
        return found._replace(force=1.001 * found.force)

    forget_models()
    monkeypatch.setattr(ForwardModel, "exact", off)
    assert any(
        "the table of forces is off by 0.1 %" in note for note in fp.fit(curve, BASE, SPHERE, ["base.young"]).notes
    )
    solved.clear()
    batch = fp.fit_batch([curve] * 5, BASE, SPHERE, ["base.young"], workers=1)
    assert all("the table of forces is off" in row["notes"] for row in batch.rows)
    assert len(solved) == 1
