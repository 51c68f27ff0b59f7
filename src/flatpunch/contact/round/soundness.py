"""Where a round contact is no disc: negative pressure, or a depth that falls while the radius grows (theory page 6)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from flatpunch._support.checks import Array, Flags
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import first_failure
from flatpunch.contact.round.radius_search import PER_DECADE, Loading
from flatpunch.contact.round.superposition import round_history, superpose
from flatpunch.punch.family import punch_family
from flatpunch.punch.matrix import RESOLVED, effective_beta


class Located(Loading, Protocol):
    """Contacts with a radius."""

    @property
    def radius(self) -> Array: ...  # noqa: D102


_BEM_HINT = "The contact is no disc there; solve it with method='bem'."

_SAMPLES = 48
"""Radii, and places under each, at which the sign of a pressure is found; half of them may miss narrow dips and take 0.8 of the
time of a curve, twice 1.3 of it."""


def soundness(kernel: Kernel, evaluate: Callable[[Array], Loading], contact: Located) -> tuple[Flags, tuple[str, ...]]:
    """Which of the contacts are sound, shape (n,), and sentences about those that are not; `evaluate` is of the same profile."""
    # within the flat face of a truncated tip the depth stays zero, which is no failure
    turning = (contact.depth_slope <= 0) & (contact.depth != 0)
    notes = first_failure(
        turning,
        contact.depth,
        f"the depth falls while the contact radius grows (a stiff film bends away). {_BEM_HINT}",
    )
    touching = contact.radius > 0
    live = contact.radius[touching]
    if kernel.homogeneous or not live.size or _all_press(kernel, evaluate, live):
        return ~turning, notes
    pulling = np.zeros_like(turning)
    pulling[touching] = _tension(kernel, evaluate, live)
    notes += first_failure(pulling, contact.depth, f"the contact pressure is negative in part. {_BEM_HINT}")
    return ~(turning | pulling), notes


def _all_press(kernel: Kernel, evaluate: Callable[[Array], Loading], radii: Array) -> bool:
    """Whether no flat punch of the loading history pulls anywhere or is drawn back; then the contact does not pull either."""
    shortest = effective_beta(kernel, 1.0) / kernel.length
    small = 0.1 / max(shortest, 1 / kernel.length)
    start = min(small, radii.min())
    path = np.geomspace(start, radii.max(), 2 + int(PER_DECADE * np.log10(radii.max() / start)))
    # films bend on their own scale, far below a fifth of the largest resolved contacts, whose punches cost seconds
    if (evaluate(path[shortest * path <= RESOLVED / 5]).depth_slope < 0).any():
        return False
    return punch_family(kernel).lowest_pressure(path / kernel.length) >= 0


def _tension(kernel: Kernel, evaluate: Callable[[Array], Loading], radii: Array) -> Flags:
    """At which contact radii the pressure is negative in part, shape of `radii`; decided on a grid over their range."""
    grid = np.geomspace(radii.min(), radii.max(), _SAMPLES) if radii.min() < radii.max() else radii[:1]
    # films bend on the scale of their thickness, which may be near the axis of a large contact
    rho = np.geomspace(1e-3, 1, _SAMPLES, endpoint=False)
    zero = np.zeros_like(rho)
    # one history serves all: a smaller contact is an earlier moment of it
    history = round_history(evaluate, float(grid[-1]), kernel.exponent)
    lowest = [superpose(kernel, replace(history, radius=float(a)), a * rho, zero).min() for a in grid]
    # between a sound and a pulling radius of the grid: pulling
    return np.asarray(np.interp(np.log(radii), np.log(grid), np.array(lowest) < 0) > 0)
