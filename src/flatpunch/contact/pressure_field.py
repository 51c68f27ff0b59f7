"""Contact pressures at points, with their estimated errors."""

from __future__ import annotations

from dataclasses import dataclass
from warnings import warn

import numpy as np

from flatpunch._support.checks import Array, FlatpunchWarning


@dataclass(frozen=True, slots=True)
class PressureField:
    """Contact pressure at points, and its estimated error there; shape (n,) each [Pa]."""

    pressure: Array
    error: Array


def superposed(field: Array, cells: PressureField) -> PressureField:
    """A pressure superposed from flat punches; its error is the difference to boundary elements. Warns where that is large."""
    difference = np.abs(field - cells.pressure)
    touched = cells.pressure > 0
    if touched.any():
        share = difference[touched] / cells.pressure[touched].mean()
        # median error over the mean pressure above which a superposed pressure is returned with a warning
        if np.median(share) > 0.02:
            warn(
                "First-order pressures under a tip that is not round are those of stretched flat punches: at these points they "
                f"differ from boundary elements by {np.median(share):.0%} of the mean pressure (median; 95 % of the points by "
                f"less than {np.quantile(share, 0.95):.0%}). All other methods take pressures from boundary elements.",
                FlatpunchWarning,
                stacklevel=5,
            )
    return PressureField(field, difference + cells.error)
