"""Prescribed zeros, by themselves and among other values: nothing has happened, whatever tip, medium and method."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact import METHODS

X = np.linspace(-1e-6, 1e-6, 41)
TIPS = {
    "pyramid": fp.Pyramid(4, 0.3),
    "ellipse": fp.EllipticParaboloid(1e6, 5e5),
    "rounded": fp.Rounded(fp.Pyramid(3, 0.3), 1e-7, true_sphere=False),
    "cut off": fp.Truncated(fp.Pyramid(4, 0.3), 3e-8),
    "height map": fp.HeightMap(X, X, 3e5 * X**2 + 4e5 * X[:, None] ** 2),
    "round": fp.Paraboloid(1e-6),
}
MEDIA = {
    "half-space": fp.HalfSpace(1e9, 0.3),
    "film": fp.Medium([fp.Layer(1e10, 0.3, 1e-6)], fp.HalfSpace(1e9, 0.3)),
}
LARGEST = {"depth": 1e-9, "force": 1e-6, "radius": 5e-8}
CASES = [
    (method, tip, quantity)
    for method in METHODS
    for tip in TIPS
    for quantity in LARGEST
    if not (method == "bem" and quantity == "radius")
    and not (method == "fourth-order" and tip not in ("pyramid", "ellipse"))
    and not (method == "exact" and tip != "ellipse")
]


@pytest.mark.parametrize("share", [[0.0], [0.0, 1.0, 0.0]], ids=["alone", "among others"])
@pytest.mark.parametrize("medium", MEDIA)
@pytest.mark.parametrize(("method", "tip", "quantity"), CASES)
def test_nothing_has_happened(method, tip, quantity, medium, share):
    configured = {"refined": fp.Refined(cells=32), "bem": fp.BoundaryElements(grid=32)}.get(method, method)
    values = np.array(share) * LARGEST[quantity]
    if method == "exact" and medium != "half-space":
        with pytest.raises(ValueError, match="method = 'exact' has no solution"):
            fp.indent(MEDIA[medium], TIPS[tip], method=configured, **{quantity: values})
        return
    result = fp.indent(MEDIA[medium], TIPS[tip], method=configured, **{quantity: values})
    for name in ("depth", "force", "radius", "area"):
        np.testing.assert_array_equal(result[name][values == 0], 0.0, err_msg=name)
    np.testing.assert_allclose(result[quantity], values, rtol=1e-6)


def test_the_end_of_a_tip_alone():
    # a power of ten, with which tables over the radius end
    tip = TIPS["height map"]
    result = fp.indent(MEDIA["half-space"], tip, radius=tip.reach, method="first-order")
    before = fp.indent(MEDIA["half-space"], tip, radius=0.9999 * tip.reach, method="first-order")
    assert 1 < float(result.force[0] / before.force[0]) < 1.001
    assert np.isfinite(result.force_error[0])
