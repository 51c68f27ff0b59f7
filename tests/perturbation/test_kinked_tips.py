"""Second and first order of rounded and truncated tips, whose kinks circles about the apex cross."""

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.contact.perturbation.general_series import GeneralExpansion
from flatpunch.indenters import Rounded, Truncated

TIPS = {
    "rounded": Rounded(fp.Pyramid(4, 0.35), 1.0, true_sphere=False),
    "rounded, three sides": Rounded(fp.Pyramid(3, 0.35), 1.0, true_sphere=False),
    "truncated": Truncated(fp.Pyramid(4, 0.35), 0.02),
    "truncated, three sides": Truncated(fp.Pyramid(3, 0.35), 0.03),
}
MEDIA = {
    "half-space": fp.HalfSpace(1.0, 0.3),
    "film": fp.Medium([fp.Layer(10.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)),
}
tips = pytest.mark.parametrize("tip", TIPS.values(), ids=TIPS)
media = pytest.mark.parametrize("medium", MEDIA.values(), ids=MEDIA)


def beside_rings(tip, radius):
    """Whether radii are within a tenth of one of the tip's rings."""
    return np.any(np.abs(np.log(radius[:, None] / np.array(tip.rings))) < 0.1, axis=1)


@pytest.mark.long
@media
@tips
def test_stiffness_is_the_slope_of_the_force(tip, medium):
    """Between the rings too, where the border of a flat is inside the contact in some directions only."""
    expansion = GeneralExpansion(compliance(medium), tip)
    radius = np.geomspace(1.02 * tip.rings[0], 6 * tip.rings[-1], 83)
    step = 1e-4
    before, here, after = (expansion.loading(radius * np.exp(x)) for x in (-step, 0.0, step))
    growing = here.depth_slope > 0
    assert growing.sum() > 20
    numerical = (after.force - before.force) / (after.depth - before.depth)
    off = np.abs(numerical / here.stiffness - 1)[growing]
    assert off.max() < 1e-2
    assert off[~beside_rings(tip, radius[growing])].max() < 2e-5


@tips
def test_the_table_over_the_radius_is_what_it_samples(tip):
    expansion = GeneralExpansion(compliance(MEDIA["half-space"]), tip)
    radius = np.append(np.geomspace(1.02 * tip.rings[0], 6 * tip.rings[-1], 31), [0.1, 1.0])
    table, direct = expansion._table.at(np.log(radius)), expansion._columns(radius)
    # beside the border of a flat it is less smooth, and still a hundred times better known than the theory is there
    assert np.abs(table - direct)[:, :9].max() < (2e-4 if isinstance(tip, Truncated) else 2e-7)


def test_no_radius_is_different_from_those_around():
    """The slope of the round contact once jumped at powers of ten, by half; and where contacts leave a flat it has a root."""
    tip = TIPS["truncated, three sides"]
    curve = fp.indent(MEDIA["half-space"], tip, depth=np.linspace(0.006, 0.06, 1201), method="second-order")
    radius, within = curve["radius"].values, curve["depth"].values < 0.04
    assert (np.diff(radius[within]) > 0).all()
    assert np.abs(np.diff(radius[within], 2)).max() < 5e-5
    assert np.abs(np.diff(radius) / radius[1:]).max() < 0.15


@tips
def test_first_order_outlines_of_long_curves_and_short_ones_agree(tip):
    """Those of many contacts are read from a table, where they are smooth enough: far within the method's own error."""
    medium, depth = MEDIA["half-space"], np.geomspace(0.05, 0.6, 120)
    many = fp.indent(medium, tip, depth=depth, method="first-order")
    few = fp.indent(medium, tip, depth=depth[::15], method="first-order")
    for name, allowed in (("force", 1e-9), ("area", 2e-3), ("contour", 5e-3)):
        some, all_ = few[name].values, many[name].values[::15]
        known = np.isfinite(some)
        assert (known == np.isfinite(all_)).all()
        np.testing.assert_allclose(all_[known], some[known], rtol=allowed)
