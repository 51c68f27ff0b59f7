"""Where a model ceases to describe the force: steps and bends at every reading, single readings, and a dip before the contact.

All of these are tested at once beside the unknowns of a fit. A step is a constant from a reading on, a bend a force that from a
reading on grows in proportion to that of the contact.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from flatpunch._support.checks import TINY, Array, Flags
from flatpunch.fits.judge.readings import FEWEST, SHARE
from flatpunch.fits.judge.record import Noise, Record
from flatpunch.fits.least_squares.objective import Objective
from flatpunch.fits.measured.signal import CLEAR

_BREAK = 4.0
"""Standard deviations of a step or a bend that ends the range."""
_MANY = 0.1
"""Share of the means that single readings far off can be."""


class Departure(NamedTuple):
    """Where the model ceases to describe the force: index of the mean, whether by a step, how far the force is off [share]."""

    at: int
    step: bool
    off: float


class Departures(NamedTuple):
    """Standard deviations and sizes of a step, a bend (its change of slope over that of the force) and a reading alone."""

    steps: Array
    jump: Array
    bends: Array
    slope: Array
    alone: Array
    off: Array

    def far(self, inside: Flags, force: Array, gone: Flags) -> int | None:
        """The reading farthest off, if it is so alone and by more than the model may be off."""
        alone = np.abs(self.alone) * ~gone
        at = int(np.argmax(alone))
        along = max(np.abs(self.steps[inside]).max(initial=0.0), np.abs(self.bends[inside]).max(initial=0.0))
        enough = gone.sum() > _MANY * gone.size + 1
        return None if enough or alone[at] <= max(CLEAR, along) or abs(self.off[at]) <= 2 * SHARE * force[at] else at

    def broken(self, inside: Flags, force: Array, slack: float) -> tuple[int, bool] | None:
        """Where the force falls below the model by more than a share of its largest value, and whether by a step."""
        least, drop = slack * force[-1], np.maximum(-self.jump, TINY)
        by_step = np.where(inside, np.maximum(drop - least, 0.0) / drop * np.abs(self.steps), 0.0)
        fall = np.maximum(-self.slope * (force[-1] - force), TINY)
        by_bend = np.where(inside, np.maximum(fall - 2 * least, 0.0) / fall * np.abs(self.bends), 0.0)
        by_step[drop <= TINY], by_bend[fall <= TINY] = 0.0, 0.0
        at = int(np.argmax(np.maximum(by_step, by_bend)))
        return (at, bool(by_step[at] >= by_bend[at])) if max(by_step[at], by_bend[at]) > _BREAK else None

    def largest(self, inside: Flags, force: Array) -> tuple[float, bool, float]:
        """The clearest step or bend: standard deviations, whether a step, and its size in the force at the end."""
        i, j = int(np.argmax(np.abs(self.steps) * inside)), int(np.argmax(np.abs(self.bends) * inside))
        step, bend = float(abs(self.steps[i])), float(abs(self.bends[j]))
        if step >= bend:
            return step, True, float(self.jump[i])
        return bend, False, float(self.slope[j] * (force[-1] - force[j]))


def departures(objective: Objective, white: Array, x: Array, force: Array, end: int) -> Departures:
    """Steps and bends at every reading before `end`, and every reading alone, beside all unknowns.

    `force` is that of the contact at all readings.
    """
    residual, jacobian = objective.first(end, white).evaluate(x)
    basis = np.linalg.qr(jacobian.T)[0]
    residual = residual - basis @ (basis.T @ residual)
    p = force[:end, None]

    def later(columns: Array) -> Array:
        return np.cumsum(columns[::-1], axis=0)[::-1]

    def along(columns: Array) -> tuple[Array, Array, Array]:
        """Products of white columns (end, m) with those of a reading alone, a step and a bend at every reading."""
        alone = white[:end, None] * columns if white.ndim == 1 else white[:end, :end].T @ columns
        steps = later(alone)
        return alone, steps, later(alone * p) - p * steps

    found = []
    for square, seen, known in zip(_squares(white, p[:, 0], end), along(-residual[:, None]), along(basis), strict=True):
        left = np.maximum(square - (known**2).sum(axis=1), TINY)
        found.append((seen[:, 0] / np.sqrt(left), seen[:, 0] / left))
    alone, step, bend = found
    return Departures(*step, *bend, *alone)


def _squares(white: Array, p: Array, end: int) -> tuple[Array, Array, Array]:
    """Squares of the white columns of a reading alone, a step and a bend at every reading, each (end,)."""
    if white.ndim == 1:
        alone = white[:end] ** 2
        steps, first, second = (np.cumsum((alone * p**k)[::-1])[::-1] for k in range(3))
        return alone, steps, second - 2 * p * first + p**2 * steps
    rows = white[:end, :end]
    steps = np.cumsum(rows[:, ::-1], axis=1)[:, ::-1]
    bends = np.cumsum((rows * p)[:, ::-1], axis=1)[:, ::-1] - p * steps
    alone, steps, bends = ((columns**2).sum(axis=0) for columns in (rows, steps, bends))
    return alone, steps, bends


def over_background(objective: Objective, x: Array) -> Array:
    """Force over its background without the process [N]."""
    rest = objective.split(x)[1]
    return np.asarray(
        objective.force - rest["baseline"] - objective.background(rest, objective.position, objective.speed)
    )


def off_beyond(objective: Objective, x: Array, force: Array, end: int, span: float) -> float:
    """How far the force beyond the range is off that of the contact, over the range of the force: above it or below it."""
    off = over_background(objective, x) / span - force
    after = off[end : end + max((end - objective.touch(x)) // 2, FEWEST)]
    return float(np.median(after) - np.median(off[max(end - 2 * FEWEST, 0) : end])) if after.size else 0.0


def dip(record: Record, objective: Objective, noise: Noise, x: Array, end: int) -> tuple[float, float, slice]:
    """How far the force dips below its background before it rises: standard deviations, size over the range, and the means."""
    over = median_filter(over_background(objective, x) / record.range, 3, mode="nearest")
    top = int(np.argmax(over[:end]))
    low = int(np.argmin(over[: top + 1]))
    if min(objective.touch(x), low) < FEWEST or over[low] >= 0:
        return 0.0, 0.0, slice(0, 0)
    begin = low - int(np.argmax(over[low::-1] >= 0))
    back = low + int(np.argmax(over[low:] >= 0))
    # the dip is no part of what the force does without contact, where most of that comes before it
    background = record.learnt(begin) if 2 * begin > low else noise.background
    last, places = min(low + 2, top), np.arange(record.size)
    ramps = np.array([np.clip(1 - (low - places) / 2**k, 0, 1) for k in range(1, 6)]).T
    ramps[last:] = 0.0
    made = record.passed(Noise(background), share=False).innovations(np.column_stack([record.y, ramps]))[:last]
    data, columns = made[:, 0], made[:, 1:]
    size = np.linalg.norm(columns, axis=0)
    t = columns.T @ data / size
    j = int(np.argmin(t))
    return -float(t[j]), min(-float(t[j] / size[j]), -float(over[low])), slice(begin, back)
