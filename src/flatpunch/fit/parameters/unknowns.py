"""The unknowns of a fit in one vector: x = (theta, contact, baseline, tilt), the last three as far as they are free.

theta are the free parameters in their internal form. contact is in units of the depth range from the first point, baseline and
tilt in units of the force range (tilt over the whole depth range), so that all of x are of order one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch._support.checks import Array

NUISANCE = ("contact", "baseline", "tilt")


@dataclass(frozen=True, eq=False)
class Unknowns:
    """What x stands for in a least-squares problem.

    Parameters
    ----------
    model : object
        Forward model; its `free` names the entries of theta.
    nuisance : tuple of str
        Which of `NUISANCE` are free, in the order of x.
    held : dict of str to float
        The others, SI.
    frame : tuple of float
        First depth [m], depth range [m] and force range [N].
    """

    model: Any
    nuisance: tuple[str, ...]
    held: dict[str, float]
    frame: tuple[float, float, float]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all entries of x."""
        return (*self.model.free, *self.nuisance)

    def scales(self) -> dict[str, tuple[float, float]]:
        """Offset and unit of contact [m], baseline [N] and tilt [N/m]."""
        origin, width, span = self.frame
        return {"contact": (origin, width), "baseline": (0.0, span), "tilt": (0.0, span / width)}

    def split(self, x: Array) -> tuple[Array, dict[str, float]]:
        """Free parameters (internal) and all of contact, baseline, tilt in SI."""
        count = len(self.model.free)
        values = dict(self.held)
        for name, value in zip(self.nuisance, x[count:], strict=True):
            offset, unit = self.scales()[name]
            values[name] = offset + unit * float(value)
        return x[:count], values


def frame_of(depth: Array, force: Array) -> tuple[float, float, float]:
    """First depth, depth range and force range: the units of x."""
    return float(depth.min()), float(np.ptp(depth)), float(np.ptp(force))
