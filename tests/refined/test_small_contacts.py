"""Contacts much smaller than the layers: forces of `refined` against boundary elements at that very depth."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import bem
from flatpunch.compliances import compliance

HALF_SPACE = fp.HalfSpace(1.0, 0.3)
MEDIA = {
    "film 10": fp.Medium([fp.Layer(10.0, 0.3, 1.0)], base=HALF_SPACE),
    "film 1000": fp.Medium([fp.Layer(1000.0, 0.2, 1.0)], base=HALF_SPACE),
    "gel": fp.Medium([fp.Layer(1.0, 0.5, 1.0)], base=fp.RigidBase()),
    "slides": fp.Medium([fp.Layer(5.0, 0.3, 1.0), fp.Layer(0.5, 0.4, 2.0, bonded=False)], base=HALF_SPACE),
}
TIPS = {
    "pyramid": fp.Pyramid(3, 0.3),
    "ellipse": fp.EllipticParaboloid(0.05, 0.5),
    "needle": fp.EllipticParaboloid(0.05, 40.0),
    "slender": fp.PowerLaw(2.0, lambda p: (np.cos(p) ** 6 + (15 * np.sin(p)) ** 6) ** (1 / 3)),
}


@pytest.mark.long
@pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA)
@pytest.mark.parametrize("tip", TIPS.values(), ids=TIPS)
def test_small_contacts_feel_the_layers(tip, medium):
    """Forces were off by up to 22 % below a hundredth of the thickness: ratios to the round contact depend on the base there."""
    rng = np.random.default_rng(len(repr(tip)))
    depth = float(10 ** rng.uniform(-8, -2))
    found = fp.indent(medium, tip, depth=depth, method="refined")
    (fine,) = bem.solve(compliance(medium), tip, depths=depth, grid=256, tolerance=1e-6)
    # a third of the factor allowed for estimates; the cells of both leave about 1e-5
    off = abs(float(found.force[0]) / fine.extrapolated_force - 1)
    assert off < 2 * float(found.force_error[0]) + 1e-5
