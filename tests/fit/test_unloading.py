"""Stiffness from unloading curves: exact on power laws, and against the instrument's own on a real test."""

import numpy as np
import pytest

from flatpunch.fit import Curve, CurveError, Tip, fit_film, read_curve, unloading, unloadings
from flatpunch.fit.films.film import normalised_stiffness
from flatpunch.fit.films.oliver_pharr import DIAMOND
from flatpunch.media import HalfSpace, Layer, Medium


def _cycle(depth, force, stiffness, exponent=1.5, noise=0.0, seed=0):
    """Load like h^2, hold, unload along a power law of this stiffness."""
    gap = exponent * force / stiffness
    up = np.linspace(0, 1, 300)
    down = np.linspace(1, 0, 400)
    h = np.concatenate([depth * up, np.full(50, depth), depth - gap * (1 - down)])
    p = np.concatenate([force * up**2, np.full(50, force), force * down**exponent])
    return Curve(h, p + noise * force * np.random.default_rng(seed).normal(size=p.size))


@pytest.mark.parametrize("exponent", [1.2, 1.5, 2.0])
def test_power_law_is_found(exponent):
    found = unloading(_cycle(500e-9, 10e-3, 1e5, exponent))
    # the fit ends when a step is 1e-4 of its standard error; without noise that is rounding
    assert found.stiffness == pytest.approx(1e5, rel=1e-6)
    assert found.exponent == pytest.approx(exponent, rel=1e-6)
    assert found.final_depth == pytest.approx(500e-9 - exponent * 10e-3 / 1e5, rel=1e-6)


def test_noise_is_told():
    """0.5 % noise: within four standard errors, in each of ten curves."""
    for seed in range(10):
        found = unloading(_cycle(500e-9, 10e-3, 1e5, noise=0.005, seed=seed))
        assert abs(found.stiffness - 1e5) < 4 * found.stderr


def test_film_from_unloadings():
    """Cycles to twenty depths instead of a continuous stiffness."""
    tip = Tip.from_coefficients([24.5, 200.0])
    film = Medium([Layer(210e9, 0.25, 500e-9)], HalfSpace(70e9, 0.2))
    h_c = np.linspace(30e-9, 400e-9, 20)
    a = np.sqrt(tip.area(h_c) / np.pi)
    modulus = film.surface_modulus * normalised_stiffness(film, a)
    stiffness = 2 * tip.beta * a / (1 / modulus + 1 / DIAMOND.surface_modulus)
    force = 5e9 * tip.area(h_c)
    depth = h_c + tip.epsilon * force / stiffness
    points = unloadings(_cycle(*values) for values in zip(depth, force, stiffness, strict=True))
    start = Medium([Layer(100e9, 0.25, 500e-9)], HalfSpace(70e9, 0.2))
    assert fit_film(points, start, tip, compare=False)["layers[0].young"] == pytest.approx(210e9, rel=1e-4)


def test_loading_alone_is_refused():
    h = np.linspace(0, 1e-6, 200)
    with pytest.raises(CurveError, match=r"points of unloading between 0\.5 and 0\.98"):
        unloading(Curve(h, h**2))


@pytest.mark.parametrize("sheet", ["Test 001", "Test 002"])
def test_real_unloading_agrees_with_continuous_stiffness(sheet, measured):
    """The instrument's harmonic stiffness at the end of loading and the slope of unloading, 3 % apart at most."""
    curve = read_curve(measured / "micromechanics" / "Example.xls", sheet=sheet)
    found = unloading(curve)
    near = np.isfinite(curve.stiffness) & (curve.depth > 0.97 * found.depth)
    assert found.stiffness == pytest.approx(np.median(curve.stiffness[near]), rel=0.03)
    assert 1.0 < found.exponent < 2.0
