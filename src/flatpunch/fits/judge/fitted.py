"""A contact over one background: least squares over a range that ends where the model ceases to describe the force.

Steps and bends at every reading, and every reading alone, are tested at once beside the unknowns of a fit. A step is a constant
from a reading on, a bend a force that from a reading on grows in proportion to that of the contact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from flatpunch._support.checks import TINY, Array, Flags
from flatpunch.fits.judge.record import Background, Noise, Record
from flatpunch.fits.least_squares.minimum import Minimum
from flatpunch.fits.least_squares.objective import Objective
from flatpunch.fits.measured.signal import CLEAR, IN_CONTACT, SHARE

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
    after = off[end : end + max((end - objective.touch(x)) // 2, IN_CONTACT)]
    return float(np.median(after) - np.median(off[max(end - 2 * IN_CONTACT, 0) : end])) if after.size else 0.0


SURE = 15.0
"""Gain in log-likelihood from which a contact is one: noise alone gives less in 1e4 records with 1e3 candidates each."""
_LOOKED, _QUIET = 9.0, 4.0
"""Gains of a contact, and of a beginning that is quieter than the whole, over a background of any size; chance gives less.

Of 72 records of drift and waves none gave more than 8 and 3.5.
"""
_BEFORE, _TIMES = 1 / 4, 4.0
"""Share of a record that shows what the force does without contact, and how many times that a contact is that needs no more."""
MOST = 0.7
"""A contact that explains less than this share of the rise that another explains is none."""
FOOT = 0.05
"""Share of the largest fitted force below which nothing ends the range: the soft foot of real contacts is no break."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A contact and its range over one background.

    Attributes
    ----------
    record : Record
        With the sign of the force with which it grows while the tip presses.
    objective : Objective
        Of all means.
    noise : Noise
    x : ndarray
        Unknowns.
    end : int
        Means in the range.
    gone : ndarray of bool, shape (n,)
        Means that are left out.
    force : ndarray, shape (n,)
        Force of the contact over the range of the force.
    worth, gain : float
        Logarithms of the likelihood of the record, and of the contact over none.
    departure : Departure or None
        What ended the range.
    """

    record: Record
    objective: Objective
    noise: Noise
    x: Array
    end: int
    gone: Flags
    force: Array
    worth: float
    gain: float
    departure: Departure | None

    @property
    def most(self) -> float:
        """Rise of the contact in the range, over the range of the force."""
        return float(self.force[self.end - 1] - self.force[0])

    @property
    def touch(self) -> int:
        """The first mean in contact."""
        return self.objective.touch(self.x)

    @property
    def inside(self) -> int:
        """Readings on the rise of the contact in the range; those of a step or a plateau are none."""
        rise = self.force[self.touch : self.end] < (1 - FOOT) * self.force[self.end - 1]
        return int(self.record.counts[self.touch : self.end][rise].sum())

    @property
    def foot(self) -> bool:
        """Whether more of the rise lies beyond the range than in it."""
        return self.departure is not None and self.departure.off > self.most

    @property
    def stands_out(self) -> bool:
        """Whether the record is no straight line, and no background alone.

        Its contact describes more than a background of any size, or it begins quieter than it goes on. A whole record over white
        noise needs no more than `gain`, and one that begins in contact shows it by its bend.
        """
        record, last = self.record, self.end - 1
        if self.worth - record.worths(Noise(Background(tilt=True)))[last] < _LOOKED:
            return False
        # many times what a good part of the record does before it
        much = self.touch > _BEFORE * record.size and min(self.most, MOST) > _TIMES * self.noise.background.size
        if self.departure is None and (self.touch <= 2 or self.noise.white or much):
            return True
        return bool(self.worth - record.alone[last] > _LOOKED or record.quieter > _QUIET)

    @property
    def tested(self) -> Flags:
        """Means of the range at which departures count: behind its foot, the first and the last in contact left out."""
        return tested(self.touch, self.force, self.end)

    @cached_property
    def departures(self) -> Departures:
        """Steps and bends within the range."""
        return departures(self.objective, self.record.white(self.noise, self.gone), self.x, self.force, self.end)

    def whitened(self, noise: Noise) -> Objective:
        """The problem on the means of the range, with residuals as large as the noise of a reading."""
        white = self.record.white(noise, self.gone, share=False)
        return self.objective.first(self.end, white * (self.record.noise / self.record.range))

    def at_the_tip(self, objective: Objective) -> Objective:
        """A problem of readings with the model's own error, one of the force at a depth, which a cantilever makes less."""
        if not self.noise.error or objective.spring is None:
            return objective
        error = self.noise.error * self.record.range / self.record.noise
        return replace(objective, weight=np.sqrt((1 + error**2) / (1 + (error / objective.gives(self.x)) ** 2)))

    @property
    def falls(self) -> bool:
        """Whether the force falls below the model where the range ends: a fault; else only the foot of a contact is described."""
        return self.departure is not None and self.departure.off < -3 * SHARE * self.most


def tested(touch: int, force: Array, end: int) -> Flags:
    """Means before `end` at which departures count, for a force that begins at `touch`."""
    place = np.arange(end)
    return np.asarray((place >= touch + 2) & (place < end - 1) & (force[:end] > FOOT * force[end - 1]))


@dataclass(eq=False)
class Descent:
    """A contact and its range, changed in turns until both stay.

    Parameters
    ----------
    record : Record
        With the sign of the force of this contact.
    objective : Objective
        With or without a tilt, as the background.
    noise : Noise
    limits : tuple of ndarray
        Of the unknowns.
    x : ndarray
        Unknowns at first.
    end : int
        Means in the range at first.
    whole : bool
        The range ends with the record.
    rescan : function
        End of a range -> unknowns of the likeliest contact of the scan in it, if there is one.
    """

    record: Record
    objective: Objective
    noise: Noise
    limits: tuple[Array, Array]
    x: Array
    end: int
    whole: bool
    rescan: Callable[[int], Array | None]
    gone: Flags = field(init=False)
    white: Array = field(init=False)
    departure: Departure | None = None

    def __post_init__(self) -> None:
        self.gone = np.zeros(self.record.size, dtype=bool)
        self.white = self.record.white(self.noise)

    def ended(self) -> Fit | None:
        """The contact and its range."""
        found, strict = self._minimum(), False
        # each turn leaves out a reading, or changes the range
        for turn in range(self.record.size):
            force = self._force()
            if not (turn < 3 and self._longer(force)):
                touch = self.objective.touch(self.x)
                if self.end - touch < 4:
                    break
                seen, inside = (
                    departures(self.objective, self.white, self.x, force, self.end),
                    tested(touch, force, self.end),
                )
                if not self._leaves_out(seen, inside, force):
                    if self.whole:
                        break
                    if self._shorter(seen, inside, force, touch, strict):
                        found = self._minimum()
                        if strict:
                            break
                        continue
                    if strict or self.end == self.record.size:
                        break
                    strict = True
                    continue
            found = self._minimum()
        return self._made(found)

    def _minimum(self) -> Minimum:
        found = self.record.minimum(self.objective, self.x, self.limits, self.end, self.white)
        self.x = found.x
        return found

    def _force(self) -> Array:
        return self.objective.contact_force(self.x) / self.record.range

    def _longer(self, force: Array) -> bool:
        """Let the range end where it is likeliest: the scan's contacts lie apart, and one in between may describe more."""
        if self.whole or self.departure is not None:
            return False
        before, self.end = self.end, max(self.end, int(np.argmax(self.record.worths(self.noise, force))) + 1)
        return self.end > before

    def _leaves_out(self, seen: Departures, inside: Flags, force: Array) -> bool:
        if (far := seen.far(inside, force[: self.end], self.gone[: self.end])) is None:
            return False
        self.gone[far] = True
        self.white = self.record.white(self.noise, self.gone)
        return True

    def _shorter(self, seen: Departures, inside: Flags, force: Array, touch: int, strict: bool) -> bool:
        """End the range where the force falls below the model.

        It falls by more than the model may be off; in the last quarter by any more than noise if `strict`, where the range
        ended by a departure that the model's error let in.
        """
        end, error = self.end, 0.0
        if strict:
            inside = inside & (np.arange(end) > end - (end - touch) // 4)
        elif inside.any():
            give = self.record.risen(self.noise.background.tilt)[1]
            error = SHARE * float(np.median(give[:end][inside])) + self.noise.error
        broken = seen.broken(inside, force[:end], error)
        if broken is None or broken[0] - touch < 3:
            return False
        # a twentieth of the readings before a break may be part of it
        self.end = broken[0] - int(FOOT * (broken[0] - touch))
        if not strict:
            self.departure = Departure(self.end, broken[1], 0.0)
            if (other := self.rescan(self.end)) is not None:
                starts = (self.x, other)
                minima = [self.record.minimum(self.objective, x, self.limits, self.end, self.white) for x in starts]
                self.x = min(minima, key=lambda found: found.cost).x
        return True

    def _made(self, found: Minimum) -> Fit | None:
        record, force, end = self.record, self._force(), self.end
        if not force[end - 1] > 0:
            return None
        worth = float(record.worths(self.noise, np.where(self.gone, record.y, force))[end - 1])
        departure = self.departure or (Departure(end, False, 0.0) if end < record.size else None)
        if departure is not None:
            departure = departure._replace(at=end, off=off_beyond(self.objective, self.x, force, end, record.range))
        gain = 0.5 * (_without(self.objective, self.white, end, self.x) - found.cost)
        return Fit(record, self.objective, self.noise, self.x, end, self.gone, force, worth, gain, departure)


def _without(objective: Objective, white: Array, end: int, x: Array) -> float:
    part = objective.first(end, white)
    rest = part.split(x)[1]
    terms = [n for n in part.nuisance if n != "contact"]
    fixed = rest["baseline"] if "baseline" not in terms else 0.0
    data = part.whitened((part.force - fixed) / part.frame.span)
    if terms:
        columns = part.whitened(np.array([part.column(n) for n in terms])).T
        data = data - columns @ np.linalg.lstsq(columns, data, rcond=None)[0]
    return float(data @ data)
