"""Series over panels that are made where they are read."""

import numpy as np

from flatpunch.numerics.chebyshev import tail
from flatpunch.numerics.piecewise import PiecewiseChebyshev


def series_of(function):
    """Panels of width 1 that are halved until their tail is below 1e-12, and the number of samples they took."""
    samples = []

    def sample(x):
        samples.append(x.size)
        return function(x)[:, None]

    panels = PiecewiseChebyshev(
        sample,
        lambda x: np.arange(np.floor(x.min()), np.floor(x.max()) + 2),
        lambda low, high: 16,
        judge=tail,
        rough=lambda piece: piece.error > 1e-12 and piece.high - piece.low > 1e-6,
    )
    return panels, samples


def test_panels_are_halved_until_their_series_ends():
    panels, samples = series_of(lambda x: 1 / (1 + 400 * (x - 0.3) ** 2))
    x = np.linspace(0, 0.99, 300)
    # sixteen nodes for a pole at a distance of 0.05: four to six halvings
    assert np.abs(panels.at(x)[:, 0] - 1 / (1 + 400 * (x - 0.3) ** 2)).max() < 1e-11
    assert 10 < len(samples) < 60


def test_noise_is_not_halved():
    rng = np.random.default_rng(3)
    panels, samples = series_of(lambda x: np.exp(x) + 1e-8 * rng.normal(size=x.size))
    x = np.linspace(0, 0.99, 300)
    assert np.abs(panels.at(x)[:, 0] - np.exp(x)).max() < 1e-7
    # one halving shows that it does not help; without that the floor of the width, 1e-6, is reached after 20
    assert len(samples) < 10
