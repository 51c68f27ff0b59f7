"""Films from the tables of micromechanics: the fit of this package to the same points."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.fits import Tip, fit_film, oliver_pharr

pytestmark = pytest.mark.filterwarnings("ignore")  # the host's own
FILM = fp.Medium([fp.Layer(20e9, 0.25, 1e-6)], fp.HalfSpace(130e9, 0.28))


@pytest.fixture(scope="module")
def indentation():
    host = pytest.importorskip("micromechanics.indentation", reason="micromechanics is not installed")
    import matplotlib as mpl

    mpl.use("Agg")
    return host.Indentation()


def test_film_of_an_indentation(indentation):
    from flatpunch.plugins.micromechanics import film

    cone = fp.Cone(np.arctan(np.sqrt(np.pi / 24.494)))
    contact = fp.indent(FILM, cone, depth=np.linspace(50e-9, 500e-9, 20))
    depth, force, stiffness = (np.asarray(contact[name]) for name in ("depth", "force", "stiffness"))
    indentation.h, indentation.p, indentation.slope = depth * 1e6, force * 1e3, stiffness * 1e-3
    indentation.valid = np.ones(depth.size, dtype=bool)
    found = film(indentation, FILM, compare=False)
    tip = Tip.from_coefficients([24.494], beta=1.0, material=fp.HalfSpace(1140e9, 0.07))
    curve = fp.Curve(depth=depth, force=force, stiffness=stiffness)
    assert found["layers[0].young"] == pytest.approx(
        fit_film(curve, FILM, tip, compare=False)["layers[0].young"], rel=1e-9
    )


def test_points_are_the_hosts(indentation):
    """The host's example file: contact depth, area and reduced modulus of each point agree with those of the fit."""
    from flatpunch.plugins.micromechanics import curve_of, tip_of

    example = type(indentation)()
    example.analyse()
    points = oliver_pharr(curve_of(example), tip_of(example))
    h = example.h[example.valid] * 1e-6
    of = [int(np.flatnonzero(h == depth)[0]) for depth in points.depth]
    np.testing.assert_allclose(points.contact_depth, example.hc[of] * 1e-6, rtol=1e-9)
    np.testing.assert_allclose(np.pi * points.radius**2, example.Ac[of] * 1e-12, rtol=1e-9)
    found = points.apparent * (1 - example.nuMat**2)
    np.testing.assert_allclose(found, example.modulus[of] * 1e9, rtol=1e-9)
    example.slope = example.slope[:0]
    with pytest.raises(ValueError, match=r"call its `analyse\(\)` first"):
        curve_of(example)
