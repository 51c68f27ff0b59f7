"""Where round contact stops being a disc: negative pressure, or a depth that falls while the radius grows (design 2.3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from flatpunch._validation import Array, Flags
from flatpunch.compliance import Kernel
from flatpunch.contact.control import Loading
from flatpunch.contact.curve import first_failure
from flatpunch.contact.history import round_history, superpose
from flatpunch.punch.family import punch_family


class Located(Loading, Protocol):
    """Contacts that know their radius."""

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
    live = contact.radius[contact.radius > 0]
    if kernel.homogeneous or not live.size or punch_family(kernel).lowest_pressure(live / kernel.length) >= 0:
        return ~turning, notes
    limit = _first_tension(kernel, evaluate, live)
    pulling = contact.radius >= limit
    notes += first_failure(pulling, contact.depth, f"the contact pressure is negative in part. {_BEM_HINT}")
    return ~(turning | pulling), notes


def _first_tension(kernel: Kernel, evaluate: Callable[[Array], Loading], radii: Array) -> float:
    """Smallest contact radius within the range of `radii` with tension inside; infinite if there is none."""
    grid = np.geomspace(radii.min(), radii.max(), 48) if radii.size > 1 else radii[:1]
    rho = np.concatenate([[1e-3], np.linspace(0.05, 0.95, 19)])
    zero = np.zeros_like(rho)
    # one history serves all: a smaller contact is an earlier moment of it
    history = round_history(evaluate, float(grid[-1]))
    for a in grid:
        if superpose(kernel, replace(history, radius=float(a)), a * rho, zero).min() < 0:
            return float(a)
    return float("inf")
