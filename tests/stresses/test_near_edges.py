"""Close to an edge at which the pressure is not smooth: the rim, and corners of the tip, on surfaces whose modulus varies."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.stresses.axisymmetric import panels
from flatpunch.stresses.axisymmetric.contact_load import contact_load

GRADED = fp.Medium([fp.GradedLayer(fp.LinearModulus(1.0, 4.0, 1.0), 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
ADHESIVE = {"radius": 1.0, "work_of_adhesion": 1e-3}
TIPS = [(fp.Cylinder(1.0), {"depth": 0.01}), (fp.Paraboloid(10.0), ADHESIVE), (fp.Paraboloid(10.0), {"radius": 1.0})]


def graded(exponent):
    return fp.PowerLawHalfSpace(1.0, 1.0, exponent, 0.3)


@pytest.mark.long
@pytest.mark.parametrize(("tip", "given"), TIPS)
@pytest.mark.parametrize("body", [graded(0.02), graded(0.3), graded(0.8), GRADED], ids=["0.02", "0.3", "0.8", "layer"])
def test_the_surface_follows_the_tip_up_to_the_rim(body, tip, given):
    """The pressure of an adhesive contact is infinite at the rim: displacements were off there by a fourth of the depth."""
    r = np.array([0.9, 0.99, 0.996])
    found = fp.fields(body, tip, r, 0.0, 0.0, **given)
    height = 0.0 if isinstance(tip, fp.Cylinder) else tip.height(r, np.zeros(1))
    # graded layers have a pressure of 1e-6
    tolerance = (2e-9 if body is not GRADED else 2e-7) * found.attrs["depth"]
    np.testing.assert_allclose(found.displacement.values[2], found.attrs["depth"] - height, atol=tolerance)


CORNER = fp.Truncated(fp.Cone(0.2), 0.6 * np.tan(0.2))
PROFILE = fp.RadialProfile([0.0, 0.6, 2.0], [0.0, 0.02, 0.3])


@pytest.mark.long
@pytest.mark.parametrize("exponent", [-0.3, 0.15, 0.6])
@pytest.mark.parametrize(
    ("tip", "given", "edge"),
    [
        (fp.Cylinder(1.0), {"depth": 0.01}, 1.0),
        (fp.Paraboloid(10.0), ADHESIVE, 1.0),
        (fp.Paraboloid(10.0), {"radius": 1.0}, 1.0),
        (CORNER, {"radius": 1.0}, 0.6),
        (PROFILE, {"radius": 1.0}, 0.6),
    ],
)
def test_stated_errors_beside_an_edge(exponent, tip, given, edge, monkeypatch):
    """Each point by itself against shorter waves on other panels; the last two are closer than what is resolved."""
    body = graded(exponent)
    away, angle = np.array([3e-2, 8e-3, 3.1e-3, 1.2e-3, 6e-4]), np.array([0.4, 1.3, 2.4, 2.0, 1.0])
    x, z = edge + away * np.cos(angle), away * np.sin(angle)
    every = [fp.fields(body, tip, *point, friction=0.2, **given) for point in zip(x, 0 * x, z, strict=True)]
    monkeypatch.setattr(panels, "SHORTEST", panels.SHORTEST / 2.5)
    monkeypatch.setattr(panels, "_HALVED", 7)
    finer = fp.fields(body, tip, x, 0.0, z, friction=0.2, **given).stress.values
    off = np.array([np.abs(each.stress.values - one).max() for each, one in zip(every, finer.T, strict=True)])
    stated = np.array([each.attrs["stress_error"] for each in every])
    infinite = isinstance(tip, fp.Cylinder) or "work_of_adhesion" in given
    load = contact_load(compliance(body), tip, every[0].attrs["radius"], every[0].attrs["depth"], edge=infinite)
    assert (off < 3 * stated * load.scale).all()
    if tip is not PROFILE:
        assert (off[:3] < 1e-9 * np.abs(finer).max(axis=0)[:3]).all()


def test_what_is_left_out_grows_like_the_pressure():
    """Beside an infinite edge without limit, beside a regular one not; on homogeneous surfaces nothing is left out."""

    class Load:
        radius, shallow = 1.0, 1.0 / 12

        def __init__(self, power):
            self.edges = (panels.Edge(1.0, power),)

    r, z = 1 - np.array([0.1, 1e-3, 1e-6, 0.0]), np.zeros(4)
    assert (panels.missing(GRADED.base, Load(-0.5), r, z) == 1).all()
    infinite = panels.missing(graded(0.3), Load(-0.35), r, z)
    assert infinite[0] == 1
    assert infinite[1] > 1
    assert infinite[2] == pytest.approx((1e-6 * 2**5 * 12) ** -0.35 / (1 - 1.2**-0.35), rel=0.1)
    assert infinite[3] == np.inf
    regular = panels.missing(graded(0.3), Load(0.65), r, z)
    assert regular[3] == pytest.approx(1 / (1.2**0.65 - 1))
