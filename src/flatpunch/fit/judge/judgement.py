"""What an approach shows: its contact, its background, and the range that the model describes, by one likelihood.

The background is learnt from the readings before the contact, the contact found over it, and so on until both stay; a record
has three beginnings: no process, that of its first third, that of nearly all of it. Inside the contact a step or a bend of the
force downwards ends the range, by more than noise and the model's own error: that of a saturated detector, a breakthrough, a
held load, yield. A contact that leaves much of the rise unexplained is none while another explains more.
"""

from __future__ import annotations

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
_ERRORS = (0.0, 0.01, 0.03, 0.1)
"""Errors of a model over the largest force; the last only where the others describe little of the rise."""
_MOST = 0.7
"""A contact that explains less than this share of the rise that another explains is none."""
_LITTLE = 0.12
"""Share of the range of the force below which a contact may be part of the background."""
_FOOT = 0.05
"""Share of the largest fitted force below which nothing ends the range: the soft foot of real contacts is no break."""
_STARTS = (0.0, 1 / 3, 0.85)
"""Parts of the record from which the background is learnt first."""
FEWEST = 6
"""Readings in contact."""


class Departure(NamedTuple):
    """Where the model ceases to describe the force: index of the mean, whether by a step, and how far the force is off [share]."""

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
        """Largest force in the range, over the range of the force."""
        return float(self.force[self.end - 1])

    @property
    def touch(self) -> int:
        """The first mean in contact."""
        return int(np.argmax(self.force > 0)) if (self.force > 0).any() else self.force.size

    @property
    def inside(self) -> int:
        """Readings in contact in the range."""
        return int(self.record.counts[self.touch : self.end].sum())

    @property
    def falls(self) -> bool:
        """Whether the force falls below the model where the range ends: a fault; else only the foot of a contact was described."""
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
    given : Background or None
        Chosen by the user: nothing is learnt.
    whole : bool
        The range ends with the record, as the user has chosen it.
    """

    records: tuple[Record, Record]
    limits: object
    given: Background | None = None
    whole: bool = False
    _seen: dict[tuple[Background, float], Fit | None] = field(default_factory=dict)

    def best(self) -> Fit | None:
        """The contact that the record shows; None without any."""
        found: list[Fit] = []
        tried: list[Background] = []
        for part in _STARTS if self.given is None else (0.0,):
            if part > 0.5 and max((f.most for f in found), default=0.0) > _LITTLE:
                continue
            background = self._settled(part)
            if background is None or background in tried:
                continue
            tried.append(background)
            if (own := self._considered(background, _ERRORS[:-1])) is not None:
                found.append(own)
        if max((f.most for f in found), default=0.0) < _LITTLE:
            found += [f for b in tried if (f := self._considered(b, _ERRORS[-1:])) is not None]
        sure = [f for f in found if f.gain >= SURE] or found
        most = max((f.most for f in sure), default=0.0)
        return max((f for f in sure if f.most >= _MOST * most), key=lambda f: f.worth, default=None)

    def _settled(self, part: float) -> Background | None:
        """The background that the readings before the contact found over it show, beginning with a part of the record."""
        record = self.records[0]
        if self.given is not None:
            return self.given
        background = record.learnt(int(np.searchsorted(record.x, part)))
        seen = [background]
        for _ in range(3):
            scans = [self._scan(Noise(background, error)) for error in _ERRORS[:-1]]
            if not any(scans):
                return None
            first = max((s for s in scans if s is not None), key=lambda s: s.worth)
            place = np.searchsorted(record.objective.position, first.contact + record.bent)
            background = record.learnt(int(place))
            if background in seen:
                break
            seen.append(background)
        return background

    def _scan(self, noise: Noise, end: int | None = None) -> Found | None:
        """The likeliest contact, with the table of forces at its modulus where that changes their shape."""
        record = self.records[0]
        white = record.factor(noise)
        found = record.scan(white, record.first_candidates, end)
        for _ in range(3):
            if found is None or not record.moduli or not record.objective.model.bends or abs(np.log(found.amplitude)) < 0.5:
                return found
            x = record.start(found, record.zero)
            table = record.at(x)
            again = record.scan(white, record.candidates(table), end)
            if again is None:
                return found
            # amplitudes count from the table's own moduli
            factor = found.amplitude * again.amplitude
            done = abs(np.log(again.amplitude)) < 0.5
            found = again._replace(amplitude=factor)
            if done:
                return found
        return found

    def _considered(self, background: Background, errors: tuple[float, ...]) -> Fit | None:
        """The fit with the smallest error of the model that describes much of what the largest error describes."""
        fits: list[Fit] = []
        for error in errors:
            noise = Noise(background, error)
            first = self._scan(noise)
            if first is None:
                continue
            made = self.fit(noise, first)
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
        gone, departure = np.zeros(n, dtype=bool), None
        white = record.factor(noise, gone, terms=False)
        for _ in range(30):
            found = record.minimum(objective, x, limits, end, white)
            x = found.x
            force = objective.contact_force(x) / record.range
            touch = int(np.argmax(force > 0)) if (force > 0).any() else n
            if end - touch < 4:
                break
            seen = self._departures(record, objective, white, x, force, end)
            inside = (np.arange(end) >= touch + 2) & (np.arange(end) < end - 1) & (force[:end] > _FOOT * force[end - 1])
            alone = np.abs(seen.alone) * ~gone[:end]
            p = int(np.argmax(alone))
            along = max(np.abs(seen.steps[inside]).max(initial=0.0), np.abs(seen.bends[inside]).max(initial=0.0))
            if (
                alone[p] > max(_FAR, along)
                and abs(seen.off[p]) > 2 * SHARE * force[p]
                and gone.sum() < 0.1 * end + 2
            ):
                gone[p] = True
                white = record.factor(noise, gone, terms=False)
                continue
            if self.whole:
                break
            give = float(np.median(record.give[:end][inside])) if inside.any() else 1.0
            least = (SHARE * give + noise.error) * force[end - 1]
            drop = np.maximum(-seen.jump, TINY)
            by_step = np.where(inside, np.maximum(drop - least, 0.0) / drop * np.abs(seen.steps), 0.0)
            fall = np.maximum(-seen.slope, 0.0) * (force[end - 1] - force[:end])
            by_bend = np.where(inside, np.maximum(fall - 2 * least, 0.0) / np.maximum(fall, TINY) * np.abs(seen.bends), 0.0)
            level = np.maximum(by_step, by_bend)
            at = int(np.argmax(level))
            if level[at] <= CLEAR or at - touch < 3:
                break
            # a twentieth of the readings before a break may be part of it
            end = at - int(0.05 * (at - touch))
            departure = Departure(end, bool(by_step[at] >= by_bend[at]), 0.0)
            if (other := self._scan(noise, end)) is not None and other.sign == first.sign:
                starts = (x, record.start(other, record.zero_of(objective)))
                x = min((record.minimum(objective, s, limits, end, white) for s in starts), key=lambda m: m.cost).x
        found = record.minimum(objective, x, limits, end, white)
        force = objective.contact_force(found.x) / record.range
        if not force[end - 1] > 0:
            return None
        without = self._without(record, objective, white, end, found.x)
        if departure is not None:
            departure = departure._replace(at=end, off=_off(objective, found.x, end, record.range))
        elif end < n:
            departure = Departure(end, False, _off(objective, found.x, end, record.range))
        return Fit(
            record, objective, noise, found.x, end, gone, force, first.worth, 0.5 * (without - found.cost), departure
        )

    def _without(self, record: Record, objective: Objective, white: Array, end: int, x: Array) -> float:
        """Sum of squares of the background alone."""
        part = objective.first(end, white)
        rest = part.split(x)[1]
        terms = [n for n in part.nuisance if n in ("baseline", "tilt", "drag")]
        fixed = rest["baseline"] if "baseline" not in terms else 0.0
        data = part.white @ ((part.force - fixed) / part.frame.span)
        if terms:
            columns = part.white @ np.array([part.column(n, rest, part.position, part.speed) for n in terms]).T
            data = data - columns @ np.linalg.lstsq(columns, data, rcond=None)[0]
        return float(data @ data)

    def _departures(
        self, record: Record, objective: Objective, white: Array, x: Array, force: Array, end: int
    ) -> Departures:
        """Steps and bends at every reading, and every reading alone, beside all unknowns."""
        residual, jacobian = objective.first(end, white).evaluate(x)
        basis = np.linalg.qr(jacobian.T)[0]
        residual = -(residual - basis @ (basis.T @ residual))
        rows, p = white[:end, :end], force[:end]

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
        white = fit.record.factor(fit.noise, fit.gone, terms=False)
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


def _off(objective: Objective, x: Array, end: int, span: float) -> float:
    """How far the force beyond the range is off the model, over the range of the force: above it or below it."""
    rest = objective.split(x)[1]
    over = objective.force - rest["baseline"] - objective.background(rest, objective.position, objective.speed)
    off = (over - objective.contact_force(x)) / span
    touch = int((objective.contact_force(x) <= 0).sum())
    after = off[end : end + max((end - touch) // 2, 5)]
    return float(np.median(after) - np.median(off[max(end - 12, 0) : end])) if after.size else 0.0


def dip(fit: Fit) -> tuple[float, float, slice]:
    """How far the force dips below its background before it rises: standard deviations, size over the range, and the means."""
    record, n = fit.record, fit.record.size
    y = median_filter(record.y, 3, mode="nearest")
    top = int(np.argmax(y))
    if top < 8:
        return 0.0, 0.0, slice(0, 0)
    low = int(np.argmin(y[:top]))
    if low < 6:
        return 0.0, 0.0, slice(0, 0)
    last = min(low + 2, top)
    white = record.factor(replace(fit.noise, error=0.0), share=False)[:last, :last]
    places = np.arange(last)
    ramps = np.array([np.clip(1 - (low - places) / width, 0, 1) for width in (2, 4, 8, 16, 32)]).T
    columns = white @ ramps
    data = white @ record.y[:last]
    size = np.linalg.norm(columns, axis=0)
    t = columns.T @ data / size
    j = int(np.argmin(t))
    begin = max(low - 2 ** (j + 1), 0)
    level = float(np.median(y[:begin])) if begin > 3 else 0.0
    back = low + int(np.argmax(y[low:] >= level)) if (y[low:] >= level).any() else n
    return -float(t[j]), -float(t[j] / size[j]), slice(begin, back)
