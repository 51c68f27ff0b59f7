"""The search for the first event on searches whose stresses are known."""

import numpy as np
import pytest

from flatpunch.stresses.failure.events import Event, first_event


class _Jump:
    """A search whose grid and refined place give any utilisation of the size."""

    def __init__(self, grid, fine, limits=(1e-9, 1e-6, 1e-3)):
        self.grid, self.fine, self.limits = grid, fine, lambda: limits

    def singular(self, size):
        return []

    def events(self, size):
        return [Event("yield", 0, self.grid(size), (0.0, 0.0, 0.0))]

    def maxima(self, size):
        return self.events(size)

    def turns(self, low, high):
        return []

    def refined(self, events, size):
        return [Event("yield", 0, self.fine(size), (0.0, 0.0, 0.0)) for _ in events]

    def follower(self, event, size):
        return lambda other: Event("yield", 0, self.fine(other), (0.0, 0.0, 0.0))


@pytest.mark.parametrize("at", np.geomspace(3e-9, 3e-4, 6))
@pytest.mark.parametrize("jump", [1.5, 10.0, 1e4])
def test_a_jump_of_the_estimate_is_neither_zero_nor_never(at, jump):
    """A grid that jumps over one leads to the load of the refined place, and a refined place that jumps to that of its jump."""

    def stepped(size):
        return (size / at) ** 0.3 * (jump if size > at else 1 / jump)

    size, worst, _ = first_event(_Jump(stepped, lambda size: size / at))
    assert size == pytest.approx(at, rel=1e-6)
    assert worst.utilisation == pytest.approx(1, rel=1e-6)
    size, worst, _ = first_event(_Jump(stepped, stepped))
    assert size == pytest.approx(at, rel=1e-6)
    assert abs(worst.utilisation - 1) > 0.1  # which is part of the error of a critical load


@pytest.mark.parametrize("factor", [1e-4, 0.1, 10.0, 1e4])
def test_refined_place_far_from_the_grid_has_its_own_load(factor):
    """The load follows the refined place, however far that of the grid is; zero and infinity are decided by it too."""
    size, worst, _ = first_event(_Jump(lambda size: size / 1e-6, lambda size: factor * size / 1e-6, (1e-12, 1e-6, 1.0)))
    assert size == pytest.approx(1e-6 / factor, rel=1e-6)
    assert worst.utilisation == pytest.approx(1, rel=1e-6)
    # the grid is above one everywhere
    size, _, _ = first_event(_Jump(lambda size: 30.0, lambda size: size / 1e-7))
    assert size == pytest.approx(1e-7, rel=1e-6)
    assert first_event(_Jump(lambda size: 30.0, lambda size: 20.0))[0] == 0
    assert first_event(_Jump(lambda size: 0.1, lambda size: 0.1))[0] == np.inf
    assert first_event(_Jump(lambda size: size / 1e-6, lambda size: 0.1))[0] == np.inf
