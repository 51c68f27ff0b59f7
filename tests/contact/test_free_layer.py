"""A layer that lifts off: numbers of an independent prototype, limits, and refusals."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact import receding

SHEET = fp.FreeLayer(young=1e6, poisson=0.3, thickness=1e-3)
HELD = fp.Medium([fp.Layer(1e6, 0.3, 1e-3, bonded=False)], base=fp.RigidBase())
TIP = fp.Paraboloid(5e-3)
TABLE = [(0.1, 1.0972, -0.18), (0.3, 1.1286, -0.57), (1.0, 1.4549, -1.14), (2.0, 2.2529, -0.60), (4.0, 4.1332, -0.15)]
"""Contact radius and radius on the base over the thickness; force at equal depth against the layer that is held down [%]."""


@pytest.mark.long
def test_radius_on_the_base_and_force():
    """Printed digits."""
    a, b, less = np.transpose(TABLE)
    curve = fp.indent(SHEET, TIP, radius=a * 1e-3)
    assert curve.base_radius.values * 1e3 == pytest.approx(b, abs=2e-4)
    held = fp.indent(HELD, TIP, depth=curve.depth.values)
    assert 100 * (curve.force.values / held.force.values - 1) == pytest.approx(less, abs=0.006)
    # the tip through the sheet on its rigid base
    assert curve.valid.values.tolist() == [True] * 4 + [False]
    assert curve.notes.count("pressed through") == 1


@pytest.mark.long
def test_controls_agree_and_stiffness_is_the_slope():
    by_radius = fp.indent(SHEET, TIP, radius=[0.5e-3, 1e-3])
    for name in ("depth", "force"):
        again = fp.indent(SHEET, TIP, **{name: by_radius[name].values})
        for other in ("depth", "force", "radius", "base_radius"):
            assert again[other].values == pytest.approx(by_radius[other].values, rel=2e-5)
    near = fp.indent(SHEET, TIP, depth=float(by_radius.depth[1]) * np.array([0.999, 1.001]))
    slope = np.diff(near.force.values)[0] / np.diff(near.depth.values)[0]
    assert slope == pytest.approx(float(by_radius.stiffness[1]), rel=1e-4)


@pytest.mark.parametrize("tip", [TIP, fp.Cone(0.2), fp.Cylinder(0.5e-3)], ids=lambda tip: type(tip).__name__)
def test_softer_than_the_layer_that_is_held_down(tip):
    free, held = (fp.indent(body, tip, depth=[0.0, 5e-5]) for body in (SHEET, HELD))
    assert free.force.values[0] == 0
    assert 0.98 < float(free.force[1] / held.force[1]) < 1


@pytest.mark.long
def test_bases():
    """A stiff base is a rigid one; on a soft one the sheet bends, and lies on a larger disc."""
    rigid, stiff, soft = (
        fp.indent(fp.FreeLayer(1e6, 0.3, 1e-3, base), TIP, radius=0.5e-3)
        for base in (fp.RigidBase(), fp.HalfSpace(1e12, 0.3), fp.HalfSpace(1e5, 0.3))
    )
    assert stiff.base_radius.values == pytest.approx(rigid.base_radius.values, rel=1e-4)
    assert stiff.force.values == pytest.approx(rigid.force.values, rel=1e-4)
    assert float(soft.base_radius[0]) > 2 * float(rigid.base_radius[0])
    assert float(soft.depth[0]) > 1.5 * float(rigid.depth[0])


@pytest.mark.parametrize(
    ("act", "error", "words"),
    [
        (lambda: fp.indent(SHEET, fp.Pyramid(4, 0.3), depth=1e-5), ValueError, "Pyramid is not round"),
        (lambda: fp.indent(SHEET, TIP, depth=1e-5, method="bem"), ValueError, "held down"),
        (lambda: fp.indent(SHEET, TIP, depth=1e-5, work_of_adhesion=0.1), ValueError, "work_of_adhesion"),
        (lambda: fp.indent(SHEET, TIP, radius=1.0), ValueError, "hardly lifts off"),
        (lambda: fp.indent(SHEET, fp.Cylinder(1e-3), radius=1e-3), ValueError, "radius cannot control"),
        (lambda: fp.pressure(SHEET, TIP, 0.0, 0.0, depth=1e-5), ValueError, "lifts off its base"),
        (lambda: fp.flat_punch(SHEET, 1e-3), ValueError, "lifts off its base"),
        (lambda: fp.fields(SHEET, TIP, 0.0, 0.0, 1e-4, depth=1e-5), ValueError, "lifts off its base"),
        (lambda: fp.FreeLayer(1e6, 0.3, 1e-3, base=HELD), TypeError, r"FreeLayer\.base"),
        (lambda: fp.FreeLayer(1e6, 0.7, 1e-3), ValueError, "poisson"),
    ],
)
def test_refusals(act, error, words):
    with pytest.raises(error, match=words):
        act()


@pytest.mark.long
@pytest.mark.parametrize("base", [fp.RigidBase(), fp.HalfSpace(1e5, 0.2)], ids=["rigid", "soft"])
@pytest.mark.parametrize(
    "tip",
    [TIP, fp.Cone(0.2), fp.Truncated(TIP, 2e-5), fp.Truncated(fp.Cone(0.2), 1e-4), fp.Cylinder(3e-4)],
    ids=["paraboloid", "cone", "cut-paraboloid", "cut-cone", "cylinder"],
)
def test_stated_error_of_the_force(tip, base):
    """Against many more terms and nodes, solved at the very contacts; a profile with a ring has slowly falling terms."""
    sheet = fp.FreeLayer(1e6, 0.3, 1e-3, base)
    curve = fp.indent(sheet, tip, depth=[1e-5, 3e-5])
    softness = sheet.surface_modulus / base.surface_modulus if isinstance(base, fp.HalfSpace) else 0.0
    finest = receding._Plate(softness, 24)
    if isinstance(tip, fp.Cylinder):
        depth = curve.depth.values
        force = finest.contact(tip.radius / 1e-3, None)[2] * sheet.surface_modulus * 1e-3 * depth
    else:
        held = fp.indent(fp.Medium([fp.Layer(1e6, 0.3, 1e-3, bonded=False)], base), tip, radius=curve.radius.values)
        _, depth, force, _ = receding._contacts(finest, sheet, tip, np.log(held.depth.values))
    slope = curve.stiffness.values * curve.depth.values / curve.force.values
    error = np.abs(np.log(curve.force.values / force) - slope * np.log(curve.depth.values / depth))
    assert (error < 3 * curve.force_error.values + 1e-12).all()
    assert curve.force_error.values.max() < 2e-5


@pytest.mark.long
def test_wide_contacts_hardly_lift_off():
    """Beyond five thicknesses the layer lies on the base as far as under the tip; the force is that of the layer held down."""
    curve = fp.indent(SHEET, TIP, radius=[5e-3, 8e-3])
    beyond = (curve.base_radius - curve.radius).values
    assert (beyond > 0).all()
    assert (beyond < 0.2e-3).all()
    held = fp.indent(HELD, TIP, depth=curve.depth.values)
    assert curve.force.values == pytest.approx(held.force.values, rel=1e-3)
