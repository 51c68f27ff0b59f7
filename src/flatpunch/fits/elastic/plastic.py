"""Imprints: the share of the depth that a load cycle does not give back, and what it means for an elastic fit.

An elastic body gives back all of the depth that a load presses it in, along whatever curve it was loaded. Force and depth of the
first loading and of the unloading are each described by depth = d0 + a force^(1/m); what counts is the depth between zero force
and the same largest force on either way. The depth of the hold in between, and the zero of depths, cancel.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.cycles import load_cycles, smoothed
from flatpunch.fits.measured.orientation import Approach
from flatpunch.fits.measured.signal import CLEAR, wander

IMPRINT = 0.2
"""Share of the depth above which an imprint is reported; drift and slow recovery of elastic bodies leave less."""
HARD = 1e8
"""Modulus [Pa] above which bodies yield rather than flow; softer ones keep their depth by viscosity."""
LOWEST, HIGHEST = 0.05, 0.95
"""Shares of the largest force between which the ways are compared: below are noise and adhesion, above are hold and creep."""
LEVELS = 40
"""Force levels at which the depth is averaged, so that a hold counts no more than a ramp."""
FEWEST_LEVELS = 4
"""Levels that a way must have; three numbers of it are fitted."""
EXPONENTS = np.arange(1.0, 3.05, 0.1)
"""Exponents m of force over depth: 1 of flat ends, 2 of cones, more of layers on stiff bases."""
PLASTIC = (
    "an imprint is left, the loading was plastic, and an elastic fit of it gives no modulus. `flatpunch fit-film` (fit_film) "
    "takes the modulus from the unloading or from continuous stiffness."
)


@dataclass(frozen=True, slots=True)
class Imprint:
    """Share of the depth that is left after the unloading.

    Attributes
    ----------
    share, error : float
        Depth that is not given back over the depth that was pressed in, and its standard error [-].
    load : float
        Largest force of the load cycle [N].
    down_to : float
        Share of that force down to which the unloading was measured.
    """

    share: float
    error: float
    load: float
    down_to: float

    @property
    def seen(self) -> bool:
        """Whether the share is above IMPRINT by more than its error."""
        return self.share - self.error > IMPRINT


def imprint(curve: Curve) -> Imprint | None:
    """Judge the load cycle with the largest force of a whole record; None if no load is taken back, or too little of it.

    Parameters
    ----------
    curve : Curve
        Depth that grows into the sample, and force over its background.
    """
    cycles = load_cycles(curve)
    if not cycles:
        return None
    _, peak, end = max(cycles, key=lambda cycle: float(curve.force[cycle[1]]))
    force, depth = smoothed(curve.force), smoothed(curve.depth)
    load, noise = float(force[peak]), wander(curve.force)
    if load <= 0:
        return None
    # unloading begins where the force falls for good, or, at a held position, where the tip goes back
    back = peak + int(np.flatnonzero(force[peak : end + 1] > HIGHEST * load)[-1])
    back += int(np.argmax(depth[back : end + 1]))
    low, high = max(LOWEST * load, CLEAR / 2 * noise), min(HIGHEST * load, float(force[back]))
    highest, lowest = np.maximum.accumulate(force[: peak + 1]), np.minimum.accumulate(force[back : end + 1])
    slack = max(CLEAR * noise, 0.01 * load)
    virgin = np.flatnonzero(_between(highest, low, high) & (force[: peak + 1] > highest - slack))
    falling = np.flatnonzero(_between(lowest, low, high))
    loading = _extent(curve, virgin, highest[virgin], high, noise)
    unloading = _extent(curve, back + falling, lowest[falling], high, noise)
    if loading is None or unloading is None:
        return None
    (pressed, doubt), (returned, error) = loading, unloading
    ratio = returned / pressed
    down_to = max(float(lowest[-1]), 0.0) / load
    return Imprint(1 - ratio, ratio * float(np.hypot(doubt / pressed, error / returned)), load, down_to)


def _between(force: Array, low: float, high: float) -> Flags:
    return (force > low) & (force < high)


def _extent(curve: Curve, at: Indices, smooth: Array, high: float, noise: float) -> tuple[float, float] | None:
    """Depth between zero force and `high` on one way, and its standard error [m]; None from too few readings.

    `smooth` is the force of the readings `at`, in order, without noise.
    """
    level = (LEVELS * smooth / high).astype(int)
    count = np.bincount(level, minlength=1)
    if (there := count > 0).sum() < FEWEST_LEVELS:
        return None
    force, depth = (np.bincount(level, column[at])[there] / count[there] for column in (curve.force, curve.depth))
    force = np.maximum(force / high, 0.0)
    # notation: depth = d0 + a x with x = (P/P_high)^(1/m), a straight line for each exponent
    x = force ** (1 / EXPONENTS[:, None])
    x -= x.mean(axis=1, keepdims=True)
    square = (x**2).sum(axis=1)
    a = x @ depth / square
    misfit = ((depth - depth.mean() - a[:, None] * x) ** 2).sum(axis=1)
    freedom = max(depth.size - 3, 1)
    best = int(np.argmin(misfit))
    variance = max(misfit[best] / freedom, (a[best] * noise / high) ** 2 / count[there].mean())
    # exponents that describe the way as well, within two standard errors
    alike = np.abs(a[misfit <= misfit[best] + 4 * variance] - a[best]).max() / 2
    return (float(a[best]), float(np.hypot(np.sqrt(variance / square[best]), alike))) if a[best] > 0 else None


def _from_zero(read: Array, over: Array) -> Array:
    """Force of a record over its background, as far as the fit of a part of it shows one; else over its lowest force [N]."""
    # a line through the contact is no background
    if np.ptp(over) < np.ptp(read) / 2:
        return np.asarray(read - smoothed(read).min())
    # data that begin in contact leave the zero open, and no force is counted from below all that was measured
    return over - max(float(smoothed(over).min()), 0.0)


def refuse_plastic(
    part: Curve, found: Approach, over: Callable[[Curve], Array], contact: float, young: float
) -> tuple[str, ...]:
    """Load cycles that leave an imprint in a stiff body were plastic on loading; in soft ones that is one of the reasons noted.

    `part` is the approach as it is fitted, `over` gives the force of a curve over its background, `contact` is the contact point
    [m], `young` the largest modulus that is fitted [Pa].
    """
    whole = found.whole
    left = imprint(replace(whole, force=_from_zero(whole.force, over(whole))))
    if left is None and found.turned < 0:
        # the fitted leg may be an unloading, over no background of the loading
        left = imprint(replace(whole.turned(depth=-1.0), force=whole.force - smoothed(whole.force).min()))
    if left is None or not left.seen:
        return ()
    share = left.share
    # the same force over the part of the depth that comes back: the body is that much harder than the loading shows
    if young >= HARD * (1 - share):
        raise CurveError(
            f"{part.name}: the unloading ends {share:.0%} of the depth short of where the loading began: {PLASTIC}"
        )
    return (
        f"The unloading ends {share:.0%} of the depth short of where the loading began: the body is viscous (relaxation= "
        "fits it), liquid drags at the cantilever (drag=), or the body yielded. If it yielded, the modulus is too low by a "
        f"factor of about {1 / (1 - share):.2g}.",
    )
