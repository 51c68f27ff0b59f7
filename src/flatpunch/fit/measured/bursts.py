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
"""Readings of the longest burst; two that overlap have up to twice as many."""


def without_bursts(curve: Curve) -> tuple[Curve, tuple[str, ...]]:
    """The curve without bursts of three to LONGEST readings, and a note; one or two readings far off stay, which a fit notes.

    A burst, or two that overlap or follow each other, jumps by more than the noise at both ends, unless the record begins or ends
    with it, and a parabola through more readings on either side describes these within their noise. A snap into contact and a
    drop jump at one end only, and the force goes on elsewhere.
    """
    force = curve.force
    noise = noise_near(force)
    change = np.diff(force)
    if force.size < 4 * FEWEST or not (np.abs(change) > CLEAR * noise).any():
        return curve, ()
    # a steep force changes all the time
    jumps = np.abs(change - without_spikes(change, 2 * LONGEST)) > CLEAR * noise
    keep = np.ones(force.size, dtype=bool)
    places = []
    for begin, end in _between(np.flatnonzero(jumps) + 1, force.size):
        if (bad := begin + (apart := _apart(force, begin, end, noise)).nonzero()[0]).size:
            # at an end of the record the parabola is uncertain
            bad = np.arange(begin if begin == 0 else bad[0], end if end == force.size else bad[-1] + 1)
            keep[bad] = False
            places.append(f"{bad[0]} to {bad[-1]} (by up to {text(float(apart.max()), 'N')})")
    if not places:
        return curve, ()
    ends = "" if keep[-1] else " At the end of a record they may be a drop of the force (breakthrough, slip or pop-in)."
    back = "jump away from the force around them"
    return curve.taken(keep), (f"Readings {', '.join(places)}, counted from 0, {back}: they are left out.{ends}",)


def _between(at: Indices, size: int) -> Iterator[tuple[int, int]]:
    """Runs of three to twice LONGEST readings from a jump to another, or to an end of the record."""
    for run in np.split(at, np.flatnonzero(np.diff(at) > LONGEST) + 1) if at.size else ():
        first, last = int(run[0]), int(run[-1])
        begin = 0 if last <= LONGEST else first
        end = size if size - first <= LONGEST else last
        if 3 <= end - begin <= 2 * LONGEST:
            yield begin, end


def _apart(force: Array, begin: int, end: int, noise: float) -> Array:
    """Distances of readings from the parabola through those around them [N], zero where noise and its own error explain them.

    All are zero if the parabola does not describe those around them within their noise, or if fewer than three are apart.
    """
    # more readings on either side than between them
    side = max(FEWEST, end - begin + 2)
    first, last = max(begin - side, 0), min(end + side, force.size)
    along = np.arange(first, last) - begin
    around, powers = (along < 0) | (along >= end - begin), np.vander(along / side, 3)
    known, here = powers[around], force[first:last]
    left = here - powers @ np.linalg.lstsq(known, here[around], rcond=None)[0]
    inside = powers[~around]
    error = noise * np.sqrt(1 + np.einsum("ij,jk,ik->i", inside, np.linalg.inv(known.T @ known), inside))
    apart = np.where((size := np.abs(left[~around])) > CLEAR * error, size, 0.0)
    return apart if np.count_nonzero(apart) >= 3 and spread_of(left[around]) < 2 * noise else np.zeros(end - begin)
