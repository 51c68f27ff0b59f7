"""`flat_punch`: honesty of its error estimate, tension, range of radii, moments and edge."""

import warnings

import numpy as np
import pytest
from scipy.integrate import quad

import flatpunch as fp
from flatpunch.compliances import compliance
from flatpunch.punch import matrix, wavenumbers
from flatpunch.punch.matrix import solve_round, sufficient_terms

H = 1e-6


def catalogue():
    rng = np.random.default_rng(20240)
    media = {
        "gel": fp.Medium([fp.Layer(5e3, 0.5, H)], base=fp.RigidBase()),
        "foam": fp.Medium([fp.Layer(5e3, -0.5, H)], base=fp.RigidBase()),
        "sliding": fp.Medium([fp.Layer(5e3, 0.3, H, bonded=False)], base=fp.RigidBase()),
        "soft": fp.Medium([fp.Layer(1e5, 0.4, H)], base=fp.HalfSpace(1e9, 0.3)),
        "hard": fp.Medium([fp.Layer(1e13, 0.3, H)], base=fp.HalfSpace(1e9, 0.3)),
    }
    for i in range(12):
        count = int(rng.integers(1, 8))
        layers = [
            fp.Layer(
                10 ** rng.uniform(7, 11),
                rng.uniform(-0.3, 0.5),
                H * 10 ** rng.uniform(-0.7, 0.7),
                bonded=rng.random() < 0.7,
            )
            for _ in range(count)
        ]
        base = fp.RigidBase() if rng.random() < 0.4 else fp.HalfSpace(10 ** rng.uniform(7, 11), rng.uniform(0, 0.5))
        media[f"random {i}, {count} layers"] = fp.Medium(layers, base=base)
    return media


CATALOGUE = catalogue()
everywhere = pytest.mark.parametrize("medium", CATALOGUE.values(), ids=CATALOGUE)
BETAS = [1e-4, 1e-2, 0.3, 1.0, 5.0, 30.0]


def punch_on(medium, radius):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fp.FlatpunchWarning)
        return fp.flat_punch(medium, radius)


@pytest.fixture
def finer_quadrature(monkeypatch):
    """Twice the Gauss nodes per panel of wavenumbers, and matrices that are sums of positive terms whatever the radius.

    As D + B the matrix of the gel loses 2e-12 of its stiffness at beta = 30. Tables are cached by their size, so the caches are
    emptied around.
    """

    def table(parity, terms, first, needed):
        end = wavenumbers.window_start(parity, terms) + wavenumbers.WINDOW
        return wavenumbers.split_table(parity, terms, first, max(1, int(np.ceil(np.log2(needed / end)))))

    _forget_tables()
    monkeypatch.setattr(wavenumbers, "NODES", 2 * wavenumbers.NODES)
    monkeypatch.setattr(matrix, "_table", table)
    yield
    _forget_tables()


def _forget_tables():
    wavenumbers.bessel_table.cache_clear()
    wavenumbers.split_table.cache_clear()


@pytest.mark.long
def test_true_error_is_at_most_the_reported_one(finer_quadrature, monkeypatch):
    truth = {}
    for name, medium in CATALOGUE.items():
        kernel = compliance(medium)
        for beta in BETAS:
            # half as many terms again: convergence is exponential, so this is the limit to rounding
            finer = solve_round(kernel, np.array([beta]), int(1.5 * sufficient_terms(kernel, beta)) + 4)
            truth[name, beta] = np.pi * finer.flat[0, 0], 1 + np.pi * finer.edge[0, 0]
    monkeypatch.undo()
    _forget_tables()
    for (name, beta), (stiffness, edge) in truth.items():
        punch = punch_on(CATALOGUE[name], beta * compliance(CATALOGUE[name]).length)
        case = f"{name}, beta = {beta}"
        assert abs(punch.normalized_stiffness / stiffness - 1) <= punch.error, case
        assert abs(punch.edge_coefficient / edge - 1) <= punch.error, case
        # and the estimate is no empty promise: 1e-10 is the target up to beta = 30
        assert punch.error < 1e-10, case


@pytest.mark.parametrize("beta", [100.0, 299.0])
def test_up_to_three_hundred_the_error_stays_below_the_reported_one(beta):
    for name in ("gel", "soft", "hard"):
        medium = CATALOGUE[name]
        punch = punch_on(medium, beta * H)
        # 1e-8 is the target at beta = 100; rounding of the thin incompressible layer grows with Kbar ~ beta^3
        assert punch.error < (1e-8 if beta == 100 else 3e-8)


def test_smallest_radii_see_the_surface_alone():
    for medium in CATALOGUE.values():
        kernel = compliance(medium)
        punch = punch_on(medium, 1e-9 * kernel.length)
        # contrasts up to 1e4 over a few thicknesses, times 1e-9
        assert punch.normalized_stiffness == pytest.approx(1, abs=1e-4)
        assert punch.edge_coefficient == pytest.approx(1, abs=1e-4)


@everywhere
def test_warns_exactly_when_some_pressure_is_negative(medium):
    rho = np.concatenate([np.linspace(0, 0.999, 400), [1 - 1e-9]])
    kernel = compliance(medium)
    for beta in np.geomspace(0.05, 20, 9):
        a = beta * kernel.length
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            punch = fp.flat_punch(medium, a)
        said = any(issubclass(w.category, fp.FlatpunchWarning) for w in caught)
        pressure = punch.pressure(rho * a) * np.sqrt(1 - rho**2)
        # a minimum of rounding size around zero may fall to either side
        if abs(pressure.min()) > 1e-6 * abs(pressure).max():
            assert said == (pressure.min() < 0)
        assert (punch.lowest_pressure < 0) == said
        if said:
            assert "negative in part" in str(caught[0].message)


@everywhere
@pytest.mark.parametrize("beta", [0.1, 2.0])
def test_pressure_integrates_to_the_stiffness_and_moments(medium, beta):
    a = beta * compliance(medium).length
    punch = punch_on(medium, a)

    def moment(n):
        # r = a sin(theta) takes out the edge; the field is smooth there
        t, w = np.polynomial.legendre.leggauss(200)
        rho = np.sin(np.pi / 4 * (t + 1))
        smooth = punch.pressure(rho * a) * np.sqrt((1 - rho) * (1 + rho))
        return np.pi / 4 * (w * rho ** (n + 1)) @ smooth

    # Under films 1e4 times stiffer most of the pressure sits at the edge and alternates inside: digits cancel.
    rtol = 3e-10

    # rho near 1 is rounded: sqrt(1 - rho^2) keeps 1e-11 at the nodes next to the edge
    assert 2 * np.pi * a**2 * moment(0) == pytest.approx(punch.stiffness, rel=rtol)
    for n in (0.5, 1, 2, 3.3, 4):
        assert punch.moment(n) == pytest.approx((n + 1) * np.pi * a / punch.modulus * moment(n), rel=rtol)


@everywhere
@pytest.mark.parametrize("beta", [0.2, 1.0, 6.0])
def test_krein_edge_intensity_is_the_growth_of_the_stiffness(medium, beta):
    # e^2 = d(a Kbar)/da by Chebyshev interpolation in ln a: twelve nodes on +-5 % leave 1e-13 and cost 144/0.05 of rounding
    a = beta * compliance(medium).length
    t = np.cos(np.pi * (np.arange(12) + 0.5) / 12)
    radii = a * np.exp(0.05 * t)
    values = np.array([r * punch_on(medium, r).normalized_stiffness for r in radii])
    series = np.polynomial.chebyshev.chebfit(t, values, 11)
    slope = np.polynomial.chebyshev.chebval(0.0, np.polynomial.chebyshev.chebder(series)) / 0.05 / a
    assert punch_on(medium, a).edge_coefficient ** 2 == pytest.approx(slope, rel=1e-9)


def test_edge_coefficient_is_the_limit_of_the_pressure():
    punch = punch_on(CATALOGUE["soft"], 2 * H)
    for gap in (1e-3, 1e-5):
        rho = 1 - gap
        limit = float(punch.pressure(rho * 2 * H)) * np.pi * 2 * H / punch.modulus * np.sqrt((1 - rho) * (1 + rho))
        # the next term of the pressure is linear in the distance to the edge
        assert punch.edge_coefficient == pytest.approx(limit, rel=60 * gap)
    assert np.isinf(punch.pressure(2 * H))
    assert punch.pressure(2.1 * H) == 0


def test_half_space_is_the_closed_form():
    punch = fp.flat_punch(fp.HalfSpace(1e9, 0.3), 3.0)
    assert punch.beta == 0
    assert punch.error == 0
    assert punch.normalized_stiffness == pytest.approx(1, rel=1e-15)
    assert punch.stiffness == pytest.approx(2 * 1e9 / 0.91 * 3, rel=1e-15)
    assert punch.edge_coefficient == 1
    assert punch.lowest_pressure > 0
    for n, kappa in ((1, np.pi / 2), (2, 2.0), (4, 8 / 3)):
        assert punch.moment(n) == pytest.approx(kappa, rel=1e-14)
    value = quad(lambda rho: 2.3 * rho**2.3 / np.sqrt(1 - rho**2), 0, 1)[0]
    assert punch.moment(1.3) == pytest.approx(value, rel=1e-7)


@pytest.mark.parametrize("exponent", [0, -1, float("nan"), float("inf")])
def test_bad_moments_are_refused(exponent):
    with pytest.raises(ValueError, match=r"exponent = .* must be finite and > 0"):
        punch_on(CATALOGUE["gel"], H).moment(exponent)


@pytest.mark.parametrize("r", [-1e-9, float("nan"), [0, float("inf")]])
def test_bad_distances_are_refused(r):
    with pytest.raises(ValueError, match="r must be finite and >= 0"):
        punch_on(CATALOGUE["gel"], H).pressure(r)


def test_pressure_keeps_shapes():
    punch = punch_on(CATALOGUE["gel"], H)
    assert punch.pressure(0.0).shape == ()
    assert punch.pressure(np.zeros((2, 3))).shape == (2, 3)
    assert punch.pressure([]).shape == (0,)
