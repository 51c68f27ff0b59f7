"""Load cycles that leave an imprint: loading was plastic, and no elastic fit gives a modulus."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.judge.orientation import Approach
from flatpunch.fit.measured.curve import Curve, CurveError
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


def refuse_plastic(
    part: Curve, found: Approach, over: Callable[[Curve], Array], contact: float, young: float
) -> tuple[str, ...]:
    """Load cycles that leave an imprint in a stiff body were plastic on loading; in soft ones that is one of the reasons noted.

    `part` is the approach as it is fitted, `over` gives the force of a curve over its background, `contact` is the contact point
    [m], `young` the largest modulus that is fitted [Pa].
    """
    if young >= HARD and plastic_cycles(replace(found.whole, force=over(found.whole))):
        raise CurveError(f"{part.name}: the unloading of its load cycles is steeper than the loading: {PLASTIC}")
    if found.behind is None:
        return ()
    left = imprint(found.behind.depth, over(found.behind), float(np.ptp(part.force)))
    deepest = float(found.cycle.depth.max()) - contact
    share = (left - contact) / deepest if deepest > 0 else 0.0
    # the same force over the part of the depth that comes back: the body is that much harder than the loading shows
    # no body keeps more than all of the depth: without an unloading the share shows nothing
    if IMPRINT < share < 1 and young >= HARD * (1 - share):
        raise CurveError(
            f"{part.name}: the unloading ends {share:.0%} of the depth short of where the loading began: {PLASTIC}"
        )
    if not IMPRINT < share < 1:
        return ()
    return (
        f"The unloading ends {share:.0%} of the depth short of where the loading began: the body is viscous (relaxation= "
        "fits it), liquid drags at the cantilever (drag=), or the body yielded. If it yielded, the modulus is too low by a "
        f"factor of about {1 / (1 - share):.2g}.",
    )


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
