"""Intervals that mean what they say: synthetic curves with known truth, 1 % noise and unknown contact point.

Measured with 500 curves for each case (`-m slow`): bias at most 0.10 %, the 95 % intervals cover in 95.4 to 98.8 %.
"""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from scipy.stats import binom

from flatpunch.contact import indent
from flatpunch.fits import Curve, fit
from flatpunch.indenters import Cone, Pyramid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase
from support.synthetic_curves import synthetic

H = 1e-6
TIPS = {"sphere": Sphere(3e-6), "cone": Cone(0.35), "pyramid": Pyramid(4, 0.35)}
YOUNG = "layers[0].young"


def _media():
    yield "gel", Medium([Layer(5e3, 0.5, H)], RigidBase()), 0.4e-6
    for ratio in (0.1, 1, 10):
        yield (
            f"film-{ratio}",
            Medium([Layer(2e9 * ratio, 0.35, H)], HalfSpace(2e9, 0.3)),
            0.1e-6 if ratio == 10 else 0.2e-6,
        )


CASES = [(medium, tip, deepest, f"{name}-{shape}") for name, medium, deepest in _media() for shape, tip in TIPS.items()]


def _ratios(medium, tip, deepest, count):
    """Deviations from the truth in standard errors and relative, and whether the interval covers."""
    truth = medium.layers[0].young
    start = Medium([Layer(1.7 * truth, medium.layers[0].poisson, H)], medium.base)
    exact = synthetic(medium, tip, deepest, noise=0)
    rng = np.random.default_rng(20260)
    relative, covered = [], 0
    for _ in range(count):
        noise = 0.01 * exact.force.max() * rng.normal(size=exact.force.size)
        contact, offset = rng.uniform(-0.3, 0.3) * deepest, 0.02 * exact.force.max() * rng.normal()
        curve = type(exact)(exact.depth + contact, exact.force + noise + offset)
        estimate = fit(curve, start, tip, [YOUNG], quick=True).estimates[YOUNG]
        relative.append(estimate.value / truth - 1)
        covered += estimate.low <= truth <= estimate.high
    return np.array(relative), covered


FEW = [case for case in CASES if case[-1] in ("gel-sphere", "gel-pyramid", "film-0.1-cone", "film-10-sphere")]


@pytest.mark.long
@pytest.mark.parametrize(("medium", "tip", "deepest", "name"), FEW, ids=[c[-1] for c in FEW])
def test_coverage_of_a_few(medium, tip, deepest, name):
    """30 curves: no bias beyond 4 standard errors of the mean, and a coverage that 0.95 has with more than 1e-4 probability."""
    relative, covered = _ratios(medium, tip, deepest, 30)
    assert abs(relative.mean()) < 4 * relative.std() / np.sqrt(30)
    assert binom.cdf(covered, 30, 0.95) > 1e-4


_WIDE = pytest.mark.xfail(
    strict=True, reason="intervals of these are too wide, 97.8 to 98.8 %: the mechanism is not known"
)
ALL = [
    pytest.param(*c, id=c[-1], marks=[_WIDE] * (c[-1] in ("gel-cone", "gel-pyramid", "film-10-sphere"))) for c in CASES
]


@pytest.mark.slow
@pytest.mark.parametrize(("medium", "tip", "deepest", "name"), ALL)
def test_coverage_of_five_hundred(medium, tip, deepest, name):
    """The project's targets: bias under 0.5 %, coverage in 93 to 97 %."""
    relative, covered = _ratios(medium, tip, deepest, 500)
    assert abs(relative.mean()) < 0.005
    assert 0.93 <= covered / 500 <= 0.97


@pytest.mark.long
@pytest.mark.parametrize("second", ["layers[0].thickness", "layers[0].poisson"])
@pytest.mark.parametrize("count", [8, pytest.param(200, marks=pytest.mark.slow)])
def test_valleys_of_two_parameters(second, count):
    """A modulus of 3087 Pa beside a thickness or a Poisson ratio that the data hardly determine: correlations above 0.99.

    Intervals come from the likelihood profile, to the end of the parameter where the data do not end them. Of 200 curves
    96.0 % (modulus) and 95.5 % (thickness) cover.
    """
    thickness = 12e-6 if second.endswith("thickness") else 5e-6
    truth, tip, deepest = (
        {YOUNG: 3087.0, "layers[0].thickness": thickness, "layers[0].poisson": 0.45},
        Sphere(5e-6),
        0.4e-6,
    )
    exact = synthetic(Medium([Layer(3087.0, 0.45, thickness)], RigidBase()), tip, deepest, noise=0)
    rng, covered = np.random.default_rng(78), np.zeros(2)
    for _ in range(count):
        force = exact.force + 0.02 * exact.force.max() * rng.normal(size=exact.force.size)
        curve = type(exact)(exact.depth + rng.uniform(-0.2, 0.2) * deepest, force)
        poisson = 0.4 if second.endswith("poisson") else 0.45
        start = Medium([Layer(3087.0 * 10 ** rng.uniform(-0.5, 0.5), poisson, thickness)], RigidBase())
        found = fit(curve, start, tip, [YOUNG, second]).estimates
        covered += [found[name].low <= truth[name] <= found[name].high for name in (YOUNG, second)]
    assert (binom.cdf(covered, count, 0.95) > 1e-3).all()


@pytest.mark.slow
@pytest.mark.parametrize("sides", [3, 4])
@pytest.mark.parametrize("name", ["gel", "film-0.1", "film-1", "film-10"])
def test_curves_made_by_boundary_elements(name, sides):
    """Curves that share no contact theory with the fit: the bias of the default method, at most 0.3 %.

    Measured: four sides -0.12, 0.06, 0.05, 0.06 %, three sides -0.19, 0.06, 0.30, 0.20 % in the order of the names.
    """
    medium, deepest = next((medium, deepest) for label, medium, deepest in _media() if label == name)
    tip, truth = Pyramid(sides, 0.35), medium.layers[0].young
    depth = np.geomspace(1e-2 * deepest, deepest, 10)
    force = indent(medium, tip, depth=depth, method="bem", angles=8)["force"].values
    # F/d^2 is a smooth function of ln d, a constant below the first depth
    smooth = make_interp_spline(np.log(depth), np.log(force / depth**2), k=3)
    z = np.linspace(-0.5 * deepest, deepest, 500)
    touching = z > 0
    curve = np.zeros(500)
    curve[touching] = z[touching] ** 2 * np.exp(smooth(np.log(np.maximum(z[touching], depth[0]))))
    found = fit(Curve(z, curve), medium, tip, [YOUNG], quick=True)[YOUNG]
    assert abs(found / truth - 1) < 0.004
