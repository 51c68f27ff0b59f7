"""Bursts: a few adjacent readings that jump away from a force and back, as disturbances and lost data do."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch._support.prefixes import text
from flatpunch.fit.measured.curve import FEWEST, Curve
from flatpunch.fit.measured.drops import noise_near
from flatpunch.fit.measured.signal import CLEAR, spread_of, without_spikes

LONGEST = FEWEST - 2
"""Readings of the longest burst: fewer than on either side show where the force goes on."""


def without_bursts(curve: Curve) -> tuple[Curve, tuple[str, ...]]:
    """The curve without bursts of three to LONGEST readings, and a note; one or two readings far off stay, which a fit notes.

    A burst jumps by more than the noise at both ends, unless the record begins or ends with it, and a parabola through FEWEST
    readings on either side describes these within their noise. A snap into contact and a drop jump at one end only, and the force
    goes on elsewhere.
    """
    force = curve.force
    noise = noise_near(force)
    change = np.diff(force)
    if force.size < 4 * FEWEST or not (np.abs(change) > CLEAR * noise).any():
        return curve, ()
    # a steep force changes all the time
    jumps = np.abs(change - without_spikes(change, LONGEST)) > CLEAR * noise
    keep = np.ones(force.size, dtype=bool)
    places = []
    for begin, end in _between(np.flatnonzero(jumps) + 1, force.size):
        if (size := _apart(force, begin, end, noise)) > 0:
            keep[begin:end] = False
            places.append(f"{begin} to {end - 1} (by up to {text(size, 'N')})")
    if not places:
        return curve, ()
    return curve.taken(keep), (
        f"Readings {', '.join(places)}, counted from 0, jump away from the force and back: they are left out.",
    )


def _between(at: Indices, size: int) -> Iterator[tuple[int, int]]:
    """Runs of three to LONGEST readings from a jump to another, or to an end of the record."""
    for run in np.split(at, np.flatnonzero(np.diff(at) > LONGEST) + 1) if at.size else ():
        first, last = int(run[0]), int(run[-1])
        begin = 0 if last <= LONGEST else first
        end = size if size - first <= LONGEST else last
        if 3 <= end - begin <= LONGEST:
            yield begin, end


def _apart(force: Array, begin: int, end: int, noise: float) -> float:
    """Largest distance of readings from the parabola through those around them [N].

    Zero if that does not describe these within their noise, or if half of the readings are not apart from it by more than noise
    and the parabola's own error explain.
    """
    first, last = max(begin - FEWEST, 0), min(end + FEWEST, force.size)
    along = np.arange(first, last) - begin
    around, powers = (along < 0) | (along >= end - begin), np.vander(along / FEWEST, 3)
    known, here = powers[around], force[first:last]
    left = here - powers @ np.linalg.lstsq(known, here[around], rcond=None)[0]
    inside = powers[~around]
    error = noise * np.sqrt(1 + np.einsum("ij,jk,ik->i", inside, np.linalg.inv(known.T @ known), inside))
    apart = np.median(np.abs(left[~around]) / error) > CLEAR
    return float(np.abs(left[~around]).max()) if apart and spread_of(left[around]) < 2 * noise else 0.0
