"""Where a round contact is no disc: negative pressure, or a depth that falls while the radius grows (theory page 6)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from flatpunch._support.checks import Array, Flags
from flatpunch.compliance import Kernel
from flatpunch.contact.curve import first_failure
from flatpunch.contact.round.radius_search import Loading
from flatpunch.contact.round.superposition import round_history, superpose
from flatpunch.punch.family import punch_family
from flatpunch.punch.matrix import effective_beta


class Located(Loading, Protocol):
    """Contacts with a radius."""

    @property
    def radius(self) -> Array: ...  # noqa: D102


_BEM_HINT = "The contact is no disc there; solve it with method='bem'."


def soundness(kernel: Kernel, evaluate: Callable[[Array], Loading], contact: Located) -> tuple[Flags, tuple[str, ...]]:
    """Which of the contacts are sound, and sentences about those that are not.

    Parameters
    ----------
    kernel : Kernel
        The medium.
    evaluate : callable
        Radii, shape (n,) -> contacts of the same (mean) profile.
    contact : RoundContact or the like
        The contacts to judge, with their radii.

    Returns
    -------
    valid : ndarray of bool, shape (n,)
    notes : tuple of str
    """
    # within the flat face of a truncated tip the depth stays zero, which is no failure
    turning = (contact.depth_slope <= 0) & (contact.depth != 0)
    notes = first_failure(
        turning,
        contact.depth,
        f"the depth falls while the contact radius grows (a stiff film bends away). {_BEM_HINT}",
    )
    touching = contact.radius > 0
    live = contact.radius[touching]
    if kernel.homogeneous or not live.size or _punches_press(kernel, live):
        return ~turning, notes
    pulling = np.zeros_like(turning)
    pulling[touching] = _tension(kernel, evaluate, live)
    notes += first_failure(pulling, contact.depth, f"the contact pressure is negative in part. {_BEM_HINT}")
    return ~(turning | pulling), notes


def _punches_press(kernel: Kernel, radii: Array) -> bool:
    """Whether the pressure of all flat punches of the loading history is nowhere negative; then that of the contact is not.

    Punches that are small against every length of the medium press like those on a half-space.
    """
    small = 0.1 * kernel.length / max(effective_beta(kernel, 1.0), 1.0)
    start = min(small, radii.min())
    path = np.geomspace(start, radii.max(), 2 + int(8 * np.log10(radii.max() / start)))
    return punch_family(kernel).lowest_pressure(path / kernel.length) >= 0


def _tension(kernel: Kernel, evaluate: Callable[[Array], Loading], radii: Array) -> Flags:
    """At which contact radii the pressure is negative in part, shape of `radii`; decided on a grid of 48 over their range."""
    grid = np.geomspace(radii.min(), radii.max(), 48) if radii.min() < radii.max() else radii[:1]
    # films bend on the scale of their thickness, which may be near the axis of a large contact
    rho = np.concatenate([np.geomspace(1e-3, 0.45, 32), np.linspace(0.5, 0.95, 10)])
    zero = np.zeros_like(rho)
    # one history serves all: a smaller contact is an earlier moment of it
    history = round_history(evaluate, float(grid[-1]), kernel.exponent)
    lowest = [superpose(kernel, replace(history, radius=float(a)), a * rho, zero).min() for a in grid]
    # between a sound and a pulling radius of the grid: pulling
    return np.asarray(np.interp(np.log(radii), np.log(grid), np.array(lowest) < 0) > 0)
