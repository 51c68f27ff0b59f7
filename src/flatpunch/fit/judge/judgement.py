"""What an approach shows: its contact, its background, and the range that the model describes, by one likelihood.

The background is learnt from the readings before the contact, the contact found over it, and so on until both stay; a record
has three beginnings: no process, that of its first third, that of nearly all of it. Inside the contact a step or a bend of the
force downwards ends the range, by more than noise and the model's own error: that of a saturated detector, a breakthrough, a
held load, yield. A contact that leaves much of the rise unexplained is none while another explains more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from flatpunch._support.checks import TINY, Array, Flags
from flatpunch.fit.judge.background import Background
from flatpunch.fit.judge.record import SHARE, Found, Noise, Record
from flatpunch.fit.least_squares.objective import Objective

CLEAR = 4.0
"""Standard deviations of a step or a bend that ends the range."""
_FAR = 6.0
"""Standard deviations of a reading that is left out."""
SURE = 15.0
"""Gain in log-likelihood from which a contact is one: noise alone gives less in 1e4 records with 1e3 candidates each."""
_LOOKED, _QUIET = 9.0, 4.0
"""Gains of a contact, and of a beginning that is quieter than the whole, over a background of any size; chance gives less.

Of 72 records of drift and waves none gave more than 8 and 3.5.
"""
_ERRORS = (0.0, 0.01, 0.03, 0.1)
"""Errors of a model over the largest force; the last only where the others describe little of the rise."""
_MOST = 0.7
"""A contact that explains less than this share of the rise that another explains is none."""
_LITTLE = 0.12
"""Share of the range of the force below which what falls behind it may be part of the background."""
_FOOT = 0.05
"""Share of the largest fitted force below which nothing ends the range: the soft foot of real contacts is no break."""
_STARTS = (0.0, 1 / 3, 0.85)
"""Parts of the record from which the background is learnt first."""
FEWEST = 6
"""Readings in contact."""


class Departure(NamedTuple):
    """Where the model ceases to describe the force: index of the mean, whether by a step, how far the force is off [share]."""

    at: int
    step: bool
    off: float


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
        rise = self.force[self.touch : self.end] < 0.95 * self.force[self.end - 1]
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
        line = record.worths(Noise(Background(tilt=True)), np.zeros(record.size))
        if self.worth - line[last] < _LOOKED:
            return False
        # many times what a quarter of the record or more does before it
        much = self.touch > record.size // 4 and min(self.most, _MOST) > 4 * self.noise.background.size
        if self.departure is None and (self.touch <= 2 or self.noise.white or much):
            return True
        alone, quieter = record.alone()
        return bool(self.worth - alone[last] > _LOOKED or quieter > _QUIET)

    @property
    def falls(self) -> bool:
        """Whether the force falls below the model where the range ends: a fault; else only the foot of a contact is described."""
        return self.departure is not None and self.departure.off < -3 * SHARE * self.most


@dataclass(frozen=True, eq=False)
class Judge:
    """Judges the two signs of one approach.

    Parameters
    ----------
    records : tuple of Record
        As measured, and with the sign of the force turned.
    limits : function
        Objective -> lower and upper limits of its unknowns.
    given : bool or None
        Whether the background is tilted, where the user has chosen it: what departs from it is white.
    whole : bool
        The range ends with the record, as the user has chosen it.
    """

    records: tuple[Record, Record]
    limits: Callable[[Objective], tuple[Array, Array]]
    given: bool | None = None
    whole: bool = False
    _seen: dict[tuple[Background, float, int | None], Found | None] = field(default_factory=dict)

    def best(self) -> Fit | None:
        """The contact that the record shows; None without any."""
        found: list[Fit] = []
        tried: list[Background] = []

        def explained() -> bool:
            """Whether half of the rise is, or a fault ends the range; else the background or the model's error is larger."""
            return any(f.most > 0.5 or (f.falls and f.most > _LITTLE) for f in found)

        for part in (None, *_STARTS):
            if part is not None and part > 0.5 and explained():
                continue
            background = Background(tilt=bool(self.given)) if part is None else self._settled(part)
            if background is None or background in tried:
                continue
            tried.append(background)
            if (own := self._considered(background, _ERRORS[:-1])) is not None:
                found.append(own)
        if not explained():
            found += [f for b in tried if (f := self._considered(b, _ERRORS[-1:])) is not None]
        if not explained():
            found += [f for b in tried if (f := self._considered(b, _ERRORS[-1:], self.records[0].size)) is not None]
        most = max((f.most for f in found), default=0.0)
        return max((f for f in found if f.most >= _MOST * most), key=lambda f: f.worth, default=None)

    def _settled(self, part: float) -> Background | None:
        """The background that the readings before the contact found over it show, beginning with a part of the record."""
        record = self.records[0]
        background = record.learnt(int(np.searchsorted(record.x, part)), given=self.given)
        seen = [background]
        for _ in range(3):
            scans = [self._scan(Noise(background, error)) for error in _ERRORS[1:-1]]
            if not any(scans):
                return None
            first = max((s for s in scans if s is not None), key=lambda s: s.worth)
            background = record.learnt(int(np.searchsorted(record.objective.position, first.place)), given=self.given)
            if background in seen:
                break
            seen.append(background)
        return background

    def _scan(self, noise: Noise, end: int | None = None) -> Found | None:
        """The likeliest contact, with the table of forces at its modulus where that changes their shape."""
        # candidates lie apart, so that none of them describes the force to its noise
        noise = Noise(noise.background, max(noise.error, SHARE))
        key = noise.background, noise.error, end
        if key not in self._seen:
            self._seen[key] = self._scanned(noise, end)
        return self._seen[key]

    def _scanned(self, noise: Noise, end: int | None) -> Found | None:
        record = self.records[0]
        found = record.scan(noise, record.first_candidates, end)
        position = record.objective.position
        if found is not None and found.place < position[0] - 0.9 * np.ptp(position):
            found = record.scan(noise, record.candidates(record.at(record.zero, far=True)), end)
        for _ in range(3):
            if (
                found is None
                or not record.moduli
                or not record.objective.model.bends
                or abs(np.log(found.amplitude)) < 0.5
            ):
                return found
            x = record.start(found, record.zero)
            table = record.at(x, far=found.place < position[0])
            again = record.scan(noise, record.candidates(table), end)
            if again is None:
                return found
            # amplitudes count from the table's own moduli
            factor = found.amplitude * again.amplitude
            done = abs(np.log(again.amplitude)) < 0.5
            found = again._replace(amplitude=factor)
            if done:
                return found
        return found

    def _considered(self, background: Background, errors: tuple[float, ...], end: int | None = None) -> Fit | None:
        """The fit with the smallest error of the model that describes much of what the largest error describes.

        Contacts that describe the record up to an `end` are tried where that is given.
        """
        fits: list[Fit] = []
        for error in errors:
            noise = Noise(background, error)
            first = self._scan(noise, end)
            if first is None:
                continue
            made = self.fit(noise, first, end)
            if made is not None:
                fits.append(made)
                if made.most > _MOST:
                    break
        most = max((f.most for f in fits), default=0.0)
        # the least error of the model that describes this part of what the largest describes
        return next((f for f in fits if f.most >= 0.4 * most or (f.falls and f.most > _FOOT * most)), None)

    def fit(self, noise: Noise, first: Found, end: int | None = None) -> Fit | None:
        """Least squares from a contact of the scan, over a range that ends where the model ceases to describe the force."""
        record = self.records[first.sign < 0]
        objective = record.with_tilt(noise.background.tilt)
        limits = self.limits(objective)
        x = record.start(first, record.zero_of(objective))
        n = record.size
        end = n if self.whole else (first.end if end is None else end)
        gone, departure, slack = np.zeros(n, dtype=bool), None, 1.0
        white = record.white(noise, gone)
        for turn in range(30):
            x = record.minimum(objective, x, limits, end, white).x
            force = objective.contact_force(x) / record.range
            if (
                turn < 3
                and not self.whole
                and departure is None
                and (more := int(np.argmax(record.worths(noise, force))) + 1) > end
            ):
                # the scan's contacts lie apart: the best one in between may describe more
                end = more
                continue
            touch = objective.touch(x)
            if end - touch < 4:
                break
            seen = self._departures(record, objective, white, x, force, end)
            inside = (np.arange(end) >= touch + 2) & (np.arange(end) < end - 1) & (force[:end] > _FOOT * force[end - 1])
            if (far := seen.far(inside, force[:end], gone[:end])) is not None:
                gone[far] = True
                white = record.white(noise, gone)
                continue
            if self.whole:
                break
            if slack == 0:
                # the last quarter, where the range ends by a departure that the slack let in
                inside &= np.arange(end) > end - (end - touch) // 4
            give = float(np.median(record.give[:end][inside])) if inside.any() else 1.0
            broken = seen.broken(inside, force[:end], slack * (SHARE * give + noise.error))
            if broken is None or broken[0] - touch < 3:
                if end == n or slack == 0:
                    break
                slack = 0.0
                continue
            # a twentieth of the readings before a break may be part of it
            end = broken[0] - int(0.05 * (broken[0] - touch))
            if slack == 0:
                break
            departure = Departure(end, broken[1], 0.0)
            if (other := self._scan(noise, end)) is not None and other.sign == first.sign:
                starts = (x, record.start(other, record.zero_of(objective)))
                x = min((record.minimum(objective, s, limits, end, white) for s in starts), key=lambda m: m.cost).x
        found = record.minimum(objective, x, limits, end, white)
        force = objective.contact_force(found.x) / record.range
        if not force[end - 1] > 0:
            return None
        worth = float(record.worths(noise, np.where(gone, record.y, force))[end - 1])
        without = self._without(record, objective, white, end, found.x)
        if departure is not None:
            departure = departure._replace(at=end, off=_off(objective, found.x, end, record.range))
        elif end < n:
            departure = Departure(end, False, _off(objective, found.x, end, record.range))
        return Fit(record, objective, noise, found.x, end, gone, force, worth, 0.5 * (without - found.cost), departure)

    def _without(self, record: Record, objective: Objective, white: Array, end: int, x: Array) -> float:
        """Sum of squares of the background alone."""
        part = objective.first(end, white)
        rest = part.split(x)[1]
        terms = [n for n in part.nuisance if n in ("baseline", "tilt", "drag")]
        fixed = rest["baseline"] if "baseline" not in terms else 0.0
        data = part.whitened((part.force - fixed) / part.frame.span)
        if terms:
            columns = part.whitened(np.array([part.column(n, rest, part.position, part.speed) for n in terms])).T
            data = data - columns @ np.linalg.lstsq(columns, data, rcond=None)[0]
        return float(data @ data)

    def _departures(
        self, record: Record, objective: Objective, white: Array, x: Array, force: Array, end: int
    ) -> Departures:
        """Steps and bends at every reading, and every reading alone, beside all unknowns."""
        residual, jacobian = objective.first(end, white).evaluate(x)
        basis = np.linalg.qr(jacobian.T)[0]
        residual = -(residual - basis @ (basis.T @ residual))
        rows, p = np.diag(white[:end]) if white.ndim == 1 else white[:end, :end], force[:end]

        def tested(columns: Array) -> tuple[Array, Array]:
            columns = columns - basis @ (basis.T @ columns)
            square = np.maximum((columns * columns).sum(axis=0), TINY)
            along = columns.T @ residual
            return along / np.sqrt(square), along / square

        steps = np.cumsum(rows[:, ::-1], axis=1)[:, ::-1]
        bends = np.cumsum((rows * p)[:, ::-1], axis=1)[:, ::-1] - p * steps
        return Departures(*tested(steps), *tested(bends), *tested(rows))

    def noted(self, fit: Fit) -> tuple[float, bool, float] | None:
        """The largest departure that stays within the range: standard deviations, whether a step, share of the largest force."""
        white = fit.record.white(fit.noise, fit.gone)
        seen = self._departures(fit.record, fit.objective, white, fit.x, fit.force, fit.end)
        p, places = fit.force[: fit.end], np.arange(fit.end)
        inside = (places > fit.touch + 1) & (places < fit.end - 1) & (p > _FOOT * p[-1])
        if not inside.any():
            return None
        i, j = int(np.argmax(np.abs(seen.steps) * inside)), int(np.argmax(np.abs(seen.bends) * inside))
        step = abs(seen.steps[i]) >= abs(seen.bends[j])
        size = float(seen.jump[i]) if step else float(seen.slope[j] * (p[-1] - p[j]))
        return float(abs(seen.steps[i]) if step else abs(seen.bends[j])), bool(step), size / fit.most


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
        enough = gone.sum() > 0.1 * gone.size + 1
        return None if enough or alone[at] <= max(_FAR, along) or abs(self.off[at]) <= 2 * SHARE * force[at] else at

    def broken(self, inside: Flags, force: Array, slack: float) -> tuple[int, bool] | None:
        """Where the force falls below the model by more than a share of its largest value, and whether by a step."""
        least, drop = slack * force[-1], np.maximum(-self.jump, TINY)
        by_step = np.where(inside, np.maximum(drop - least, 0.0) / drop * np.abs(self.steps), 0.0)
        fall = np.maximum(-self.slope * (force[-1] - force), TINY)
        by_bend = np.where(inside, np.maximum(fall - 2 * least, 0.0) / fall * np.abs(self.bends), 0.0)
        by_step[drop <= TINY], by_bend[fall <= TINY] = 0.0, 0.0
        at = int(np.argmax(np.maximum(by_step, by_bend)))
        return (at, bool(by_step[at] >= by_bend[at])) if max(by_step[at], by_bend[at]) > CLEAR else None


def _off(objective: Objective, x: Array, end: int, span: float) -> float:
    """How far the force beyond the range is off the model, over the range of the force: above it or below it."""
    rest = objective.split(x)[1]
    over = objective.force - rest["baseline"] - objective.background(rest, objective.position, objective.speed)
    off = (over - objective.contact_force(x)) / span
    touch = objective.touch(x)
    after = off[end : end + max((end - touch) // 2, 5)]
    return float(np.median(after) - np.median(off[max(end - 12, 0) : end])) if after.size else 0.0


def dip(fit: Fit) -> tuple[float, float, slice]:
    """How far the force dips below its background before it rises: standard deviations, size over the range, and the means."""
    record, objective, n = fit.record, fit.objective, fit.record.size
    rest = objective.split(fit.x)[1]
    over = objective.force - rest["baseline"] - objective.background(rest, objective.position, objective.speed)
    over = median_filter(over / record.range, 3, mode="nearest")
    top = int(np.argmax(over[: fit.end]))
    low = int(np.argmin(over[: top + 1]))
    if fit.touch < 6 or low < 6 or over[low] >= 0:
        return 0.0, 0.0, slice(0, 0)
    last, places = min(low + 2, top), np.arange(n)
    ramps = np.array([np.clip(1 - (low - places) / width, 0, 1) for width in (2, 4, 8, 16, 32)]).T
    ramps[last:] = 0.0
    made = record.innovations(replace(fit.noise, error=0.0), np.column_stack([record.y, ramps]), share=False)[0][:last]
    data, columns = made[:, 0], made[:, 1:]
    size = np.linalg.norm(columns, axis=0)
    t = columns.T @ data / size
    j = int(np.argmin(t))
    begin = low - int(np.argmax(over[low::-1] >= 0))
    back = low + int(np.argmax(over[low:] >= 0))
    return -float(t[j]), min(-float(t[j] / size[j]), -float(over[low])), slice(begin, back)
