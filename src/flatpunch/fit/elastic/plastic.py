"""Load cycles that leave an imprint: loading was plastic, and no elastic fit gives a modulus."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.measured.curve import Curve
from flatpunch.fit.measured.cycles import load_cycles

IMPRINT, HARD = 0.2, 1e8
"""Depth left after unloading, over the largest, and modulus [Pa] from which a load cycle is plastic."""
PLASTIC = (
    "an imprint is left, the loading was plastic, and an elastic fit of it gives no modulus. `flatpunch fit-film` (fit_film) "
    "takes the modulus from the unloading or from continuous stiffness."
)


def plastic_cycles(curve: Curve) -> bool:
    """Whether a record of several load cycles does not go back the way it came.

    Of the cycle with the largest load, depths at which half of what is taken back is reached: on the first loading up to it,
    and on the unloading. For elastic bodies they are the same, whatever part of the load is taken back.
    """
    # where a free tip goes on, a force that waves is no load cycle
    there = curve.depth
    cycles = [(a, b, c) for a, b, c in load_cycles(curve.force) if max(there[a], there[c]) < there[b]]
    if len(cycles) < 2:
        return False
    _, peak, end = max(cycles, key=lambda cycle: float(curve.force[cycle[1]]))
    level = (curve.force[peak] + curve.force[end]) / 2
    loaded = float(curve.depth[int(np.argmax(curve.force[: peak + 1] >= level))])
    unloaded = float(curve.depth[peak + int(np.flatnonzero(curve.force[peak : end + 1] >= level)[-1])])
    return unloaded - loaded > IMPRINT * (float(curve.depth[peak]) - loaded)


def imprint(depth: Array, over: Array, rise: float) -> float:
    """Depth at which an unloading ends, from those at a half and a tenth of the largest force [m].

    As many readings lie beyond each of these as have that force. In between the force is taken for that of a paraboloid whose
    contact ends there, (d - d0)^1.5; for that of a cone, d^2, the depth is 11 % of the largest. Nan where all readings have a
    tenth: the tip did not withdraw.
    """
    shares = np.array([0.1, 0.5])
    pressed = [float(np.mean(over > share * rise)) for share in shares]
    if max(pressed) == 1:
        return float("nan")
    low, high = (float(np.quantile(depth, 1 - each)) for each in pressed)
    near, far = shares ** (2 / 3)
    return low - (high - low) * float(near / (far - near))
