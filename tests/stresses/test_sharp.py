"""Where stresses are infinite under any load: found on every tip that has such a place, and on no other."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.stresses.failure.tips import singular_place

BODY = fp.HalfSpace(1e9, 0.3)
ALL = [fp.Strength(yield_stress=2e7, tensile=2e7, shear=1e7)]
R = np.linspace(0, 2e-6, 15)

SHARP = {
    "cone": fp.Cone(0.3),
    "pyramid": fp.Pyramid(4, 0.4),
    "tilted cone": fp.Tilted(fp.Cone(0.3), 0.05),
    "truncated pyramid": fp.Truncated(fp.Pyramid(3, 0.4), 1e-7),
    "truncated elliptic paraboloid": fp.Truncated(fp.EllipticParaboloid(1e5, 3e5), 1e-8),
    "tilted truncated cone": fp.Tilted(fp.Truncated(fp.Cone(0.4), 1e-8), 0.05),
    "pointed superellipse": fp.Superellipse(1e-6, 8e-7, 2e-7, 3.0, 1.0),
    "table of a cone": fp.RadialProfile(R, 0.3 * R),
    "area function of a cone": fp.AreaFunction((24.5,), 1000, 1e-9),
    "punch": fp.Cylinder(1e-6),
}
BLUNT = {
    "sphere": fp.Sphere(1e-6),
    "power": fp.PowerLaw(1.2, 1.0),
    "rounded pyramid": fp.Rounded(fp.Pyramid(4, 0.4), 1e-7),
    "tilted ellipsoid": fp.Tilted(fp.Ellipsoid(2e-6, 1e-6, 1e-6), 0.1),
    "table of a sphere": fp.RadialProfile(R, R**2 / 6e-6 * (1 + 0.1 * np.sin(3e6 * R + 1))),
    "area function": fp.AreaFunction((24.5, 300), 1000, 1e-9),
    "map": fp.HeightMap(R - 1e-6, R - 1e-6, ((R[:, None] - 1e-6) ** 2 + 1.5 * (R - 1e-6) ** 2) / 4e-6),
}


@pytest.mark.parametrize("name", SHARP)
def test_place_of_infinite_pressure(name):
    """At any size of the contact; on flat ends at their border, where height and slope begin to rise."""
    tip = SHARP[name]
    for size in (1e-12, 1e-7, 9e-7):
        x, y = singular_place(tip, size)
        if isinstance(tip, fp.Truncated):
            r, phi = np.hypot(x, y), np.arctan2(y, x)
            assert tip.height(r * (1 - 1e-9), phi) == 0 < tip.height(r * (1 + 1e-6), phi)
    assert all(singular_place(each, 1e-7) is None for each in BLUNT.values())


@pytest.mark.long
def test_infinite_stresses_need_shear():
    """Pressure that is infinite on all sides breaks nothing; friction shears, and pulls behind the rim of a punch."""

    def loads(poisson, tip, friction):
        return fp.critical_loads(fp.HalfSpace(1e9, poisson), tip, ALL, friction=friction).force.values

    assert (loads(0.3, SHARP["cone"], 0.0)[[0, 2]] == 0).all()
    assert (loads(0.5, SHARP["cone"], 0.3)[[0, 2]] == 0).all()
    assert (loads(0.5, fp.Cone(0.01), 0.0)[[0, 2]] == np.inf).all()
    assert (loads(0.3, SHARP["punch"], 0.1) == 0).all()
    assert (loads(0.3, SHARP["punch"], 0.0) > 0).tolist() == [False, True, False]


def test_a_table_that_begins_like_a_cone_says_so():
    loads = fp.critical_loads(BODY, SHARP["table of a cone"], ALL)
    assert loads.force[0] == 0
    assert "begins with a slope of 0.3, like a cone" in str(loads.notes[0].values)
    assert "slope" not in str(fp.critical_loads(BODY, SHARP["cone"], ALL).notes[0].values)


def test_kinks_that_come_into_contact_later():
    """What is not reached before fails there, with the load of that contact; what rises and falls fails when it first rises."""
    r = np.linspace(0, 4e-6, 41)
    smooth = r**2 / 40e-6
    tip = fp.RadialProfile(r, np.where(r <= 1e-6, smooth, smooth[10] + 0.2 * (r - 1e-6)), kinks=[1e-6])
    loads = fp.critical_loads(BODY, tip, [fp.Strength(yield_stress=8e7, tensile=8e7)])
    at_the_kink = float(fp.indent(BODY, tip, radius=1e-6).force[0])
    assert float(loads.force[0]) == pytest.approx(at_the_kink, rel=0.02)
    assert loads.place.values[0] == pytest.approx([1e-6, 0, 0])
    assert float(loads.force[1]) == np.inf
