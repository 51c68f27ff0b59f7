"""Whether a tip rises from its apex in every direction: the contact theory needs star-shaped level lines.

Every contact outline a(phi) is single-valued only if f and df/dr are positive along every ray; then ln f has its angular mean and
harmonics at every radius. Measured tips fail this behind side peaks and in noise close to the apex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch.indenters._common import FULL_TURN, RAYS
from flatpunch.indenters.profile import Indenter


@dataclass(frozen=True, slots=True)
class Fall:
    """First place, by its distance from the apex, where a tip stops rising.

    Attributes
    ----------
    radius, angle : float
        Polar coordinates about the apex [m], [rad].
    slope : float
        Radial slope there [-], not positive.
    usable : float
        Largest sampled radius below which the tip rises in every direction [m].
    """

    radius: float
    angle: float
    slope: float
    usable: float


def first_fall(indenter: Indenter, reach: float | None = None) -> Fall | None:
    """First place within `reach` [m] where the height does not rise along one of 360 rays, at 400 radii; flat ends count."""
    end = indenter.reach if reach is None else reach
    if not np.isfinite(end):
        end = 1.0
    phi = FULL_TURN * np.arange(RAYS) / RAYS
    # half as many radii may miss a dip that is 2 % wide
    r = np.linspace(0, end, 401)[1:]
    slope = np.empty((r.size, RAYS))
    for rows in np.array_split(np.arange(r.size), 10):
        slope[rows] = indenter.slope(r[rows, None], phi)
    height = np.asarray(indenter.height(r[:1, None], phi))
    falling = np.less_equal(slope, 0)
    falling[0] |= height[0] <= 0
    if not falling.any():
        return None
    i = int(np.argmax(falling.any(axis=1)))
    j = int(np.argmin(slope[i]))
    return Fall(float(r[i]), float(phi[j]), float(slope[i, j]), float(r[i - 1]) if i else 0.0)
