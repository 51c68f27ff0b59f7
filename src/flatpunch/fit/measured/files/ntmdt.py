"""Text exports of NT-MDT microscopes: height [nm], deflection signal on approach and on retract [nA], no titles.

afmformats takes the first rows for the deep end and drops constant readings there as padding of the export. In files whose
first rows are the free tip, those constant readings are the baseline.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flatpunch._support.checks import Array

_NANO = 1e-9


def begins_free(deflection: Array) -> bool:
    """Whether the first rows of a column are the free tip and the last rows the deepest contact.

    The force of a contact is convex in the depth. Over the last twentieth of the way in it covers more than a twentieth of its
    rise, at the free end less.
    """
    few = max(deflection.size // 20, 1)
    begin, end = (abs(float(part[-1] - part[0])) for part in (deflection[: few + 1], deflection[-few - 1 :]))
    return end > begin and end > few / deflection.size * float(np.ptp(deflection))


def free_tip_first(path: Path, factor: float) -> dict[str, object] | None:
    """Columns of a file whose first rows are the free tip; None for other files.

    Parameters
    ----------
    path : Path
        Text file of three columns, with decimal points or commas.
    factor : float
        Force over signal [N/A]: spring constant times sensitivity.
    """
    rows = [line.replace(",", ".").split() for line in path.read_text(encoding="latin-1").splitlines() if line.strip()]
    height, approach, retract = np.array(rows, dtype=float).T
    if not begins_free(approach):
        return None
    # heights grow away from the sample elsewhere
    away = -np.sign(height[-1] - height[0]) * _NANO * height
    return {
        "height (measured)": np.concatenate([away, away[::-1]]),
        "force": factor * _NANO * np.concatenate([approach, retract[::-1]]),
        "segment": np.repeat([0, 1], height.size),
    }
