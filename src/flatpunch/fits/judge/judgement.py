"""What an approach shows: its contact, its background, and the range that the model describes, by one likelihood; notes of it.

The background is learnt from the readings before the contact, the contact found over it, and so on until both stay; a record
has three beginnings: no process, that of its first third, that of nearly all of it. Inside the contact a step or a bend of the
force downwards ends the range, by more than noise and the model's own error: that of a saturated detector, a breakthrough, a
held load, yield. A contact that leaves much of the rise unexplained is none while another explains more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.ndimage import median_filter

from flatpunch._support.checks import TINY, Array
from flatpunch._support.prefixes import text
from flatpunch.fits.judge.candidates import Candidates, Found, begun, candidates, scan, table_at
from flatpunch.fits.judge.fitted import FOOT, MOST, SURE, Descent, Fit, over_background
from flatpunch.fits.judge.record import LEARNT, Background, Noise, Record
from flatpunch.fits.least_squares.objective import Objective
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.signal import CLEAR, IN_CONTACT, SHARE
from flatpunch.fits.parameters.settings import Settings

_ERRORS = (0.0, 0.01, 0.03, 0.1)
"""Errors of a model over the largest force; the last only where the others describe little of the rise."""
_PART = 0.4
"""Share of what the largest error of a model describes that a smaller error has to describe."""
_LITTLE = 0.12
"""Share of the range of the force below which what falls behind it may be part of the background."""
_STARTS = (0.0, 1 / 3, 0.85)
"""Parts of the record from which the background is learnt first."""


@dataclass(frozen=True, eq=False)
class Judge:
    """Judges the two signs of one approach.

    Parameters
    ----------
    signed : function
        Sign -> the record as measured (1), or with the sign of the force turned (-1).
    limits : function
        Objective -> lower and upper limits of its unknowns.
    given : bool or None
        Whether the background is tilted, where the user has chosen it: what departs from it is white.
    whole : bool
        The range ends with the record, as the user has chosen it.
    """

    signed: Callable[[float], Record]
    limits: Callable[[Objective], tuple[Array, Array]]
    given: bool | None = None
    whole: bool = False
    _scans: dict[tuple[Noise, int | None], Found | None] = field(default_factory=dict)
    _fits: dict[tuple[Noise, int | None], Fit | None] = field(default_factory=dict)

    @cached_property
    def record(self) -> Record:
        """The approach as measured."""
        return self.signed(1.0)

    @cached_property
    def turned(self) -> Record:
        """The approach with the sign of the force turned."""
        return self.signed(-1.0)

    @cached_property
    def first(self) -> Candidates:
        """Candidates at the model's starting values."""
        return candidates(self.record, table_at(self.record, self.record.objective.zero))

    def best(self) -> Fit | None:
        """The contact that the record shows; None without any."""
        if (plain := self._plain()) is not None:
            return plain
        backgrounds = [Background(tilt=bool(self.given))]
        backgrounds += [b for part in _STARTS[:-1] if (b := self._settled(part)) is not None]
        found = self._considered(backgrounds, _ERRORS[:-1])
        if not _explained(found):
            backgrounds += [b for part in _STARTS[-1:] if (b := self._settled(part)) is not None]
            found = self._considered(backgrounds, _ERRORS[:-1])
        if not _explained(found):
            found += self._considered(backgrounds, _ERRORS[-1:])
        if not _explained(found):
            found += self._considered(backgrounds, _ERRORS[-1:], self.record.size)
        most = max((f.most for f in found), default=0.0)
        return max((f for f in found if f.most >= MOST * most), key=lambda f: f.worth, default=None)

    def _plain(self) -> Fit | None:
        """The contact over a white background, where it describes all of the record and leaves nothing before it unexplained."""
        background = Background(tilt=bool(self.given))
        for _ in range(2):
            noise = Noise(background)
            if (first := self._scan(noise)) is None or first.rise < _PART:
                return None
            fit = self._fit(noise)
            if fit is None or fit.departure is not None or fit.most < MOST:
                return None
            shown = fit.record.learnt(fit.touch, given=self.given)
            if shown.size or fit.touch < LEARNT:
                return None
            if shown.tilt == background.tilt:
                return fit
            background = shown
        return None

    def _settled(self, part: float) -> Background | None:
        """The background that the readings before the contact found over it show, beginning with a part of the record."""
        record = self.record
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
        end = self.record.size if self.whole else end
        # candidates lie apart, so that none of them describes the force to its noise
        key = Noise(noise.background, max(noise.error, SHARE)), end
        if key not in self._scans:
            self._scans[key] = self._scanned(*key)
        return self._scans[key]

    def _scanned(self, noise: Noise, end: int | None) -> Found | None:
        record = self.record
        found = scan(record, noise, self.first, end)
        position = record.objective.position
        if found is not None and found.place < position[0] - 0.5 * np.ptp(position):
            found = scan(record, noise, candidates(record, table_at(record, record.objective.zero, far=True)), end)
        for _ in range(3):
            if (
                found is None
                or not record.moduli
                or not record.objective.model.bends
                or abs(np.log(found.amplitude)) < 0.5
            ):
                return found
            table = table_at(record, begun(record, found, record.objective.zero), far=found.place < position[0])
            again = scan(record, noise, candidates(record, table), end)
            if again is None:
                return found
            # amplitudes count from the table's own moduli
            done = abs(np.log(again.amplitude)) < 0.5
            found = again._replace(amplitude=found.amplitude * again.amplitude)
            if done:
                return found
        return found

    def _considered(
        self, backgrounds: Sequence[Background], errors: Sequence[float], end: int | None = None
    ) -> list[Fit]:
        """Over each background the fit with the least error of the model that describes much of what the largest describes.

        Contacts that describe the record up to an `end` are tried where that is given; those of little rise are not.
        """
        noises = {b: [Noise(b, error) for error in errors] for b in backgrounds}
        rises = {n: found.rise for each in noises.values() for n in each if (found := self._scan(n, end)) is not None}
        least, best = _PART * max(rises.values(), default=0.0), []
        for each in noises.values():
            fits: list[Fit] = []
            for noise in each:
                if rises.get(noise, -1.0) < least or (made := self._fit(noise, end)) is None:
                    continue
                fits.append(made)
                if made.most > MOST:
                    break
            most = max((f.most for f in fits), default=0.0)
            best += [f for f in fits if f.most >= _PART * most or (f.falls and f.most > FOOT * most)][:1]
        return best

    def _fit(self, noise: Noise, end: int | None = None) -> Fit | None:
        if (noise, end) not in self._fits:
            first = self._scan(noise, end)
            self._fits[noise, end] = None if first is None else self._fitted(noise, first, end)
        return self._fits[noise, end]

    def _fitted(self, noise: Noise, first: Found, end: int | None) -> Fit | None:
        """The fit of a contact of the scan over a range that ends where the model ceases to describe the force."""
        record = self.turned if first.sign < 0 else self.record
        objective = record.with_tilt(noise.background.tilt)

        def begins(found: Found | None) -> Array | None:
            return None if found is None or found.sign != first.sign else begun(record, found, objective.zero)

        start, limits = begun(record, first, objective.zero), self.limits(objective)
        last = record.size if self.whole else end or first.end
        return Descent(
            record, objective, noise, limits, start, last, self.whole, lambda e: begins(self._scan(noise, e))
        ).ended()


def _explained(found: Sequence[Fit]) -> bool:
    """Whether half of the rise is, or a fault ends the range; else the background or the model's error is larger."""
    return any(f.most > 0.5 or (f.falls and f.most > _LITTLE) for f in found)


def dip(record: Record, objective: Objective, noise: Noise, x: Array, end: int) -> tuple[float, float, slice]:
    """How far the force dips below its background before it rises: standard deviations, size over the range, and the means."""
    over = median_filter(over_background(objective, x) / record.range, 3, mode="nearest")
    top = int(np.argmax(over[:end]))
    low = int(np.argmin(over[: top + 1]))
    if min(objective.touch(x), low) < IN_CONTACT or over[low] >= 0:
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


_CAUSES = {
    (True, -1): "a breakthrough, a slip or a pop-in",
    (True, 1): "a jump or a second contact",
    (False, -1): "a saturated detector, a held or withdrawn load, or yield",
    (False, 1): "a stiffer layer below, a second contact, or a model that is not this body",
}
"""Usual causes of a step or a bend of the force below or above the model."""


def about_range(fit: Fit, part: Curve, last: int, turned: float) -> list[str]:
    """Where the fitted range ends and why, and what departs within it."""
    notes = []
    if (found := fit.departure) is not None and last < part.depth.size:
        off = found.off / max(fit.most, TINY)
        side = -1 if off < 0 else 1
        notes.append(
            f"From a depth of {text(turned * float(part.depth[last]), 'm')} on ({part.depth.size - last} of {part.depth.size} "
            f"readings) the model does not describe the force, which is {abs(off):.1%} of the fitted force "
            f"{'below' if side < 0 else 'above'} it: usually {_CAUSES[found.step, side]}. What lies before it is fitted; "
            "depth_to = '...' overrides."
        )
    if fit.noise.error:
        notes.append(
            f"The model misses the force by about {fit.noise.error:.0%} of its largest value; the intervals contain this as "
            "noise, not what a wrong model adds."
        )
    if (inside := fit.tested).any():
        far, step, size = fit.departures.largest(inside, fit.force[: fit.end])
        size /= fit.most
        if far > CLEAR and abs(size) > SHARE / 2:
            notes.append(
                f"Within the fitted range the force {'jumps' if step else 'bends away from the model'} by {size:+.1%} of its "
                f"largest value ({far:.0f} standard deviations): usually {_CAUSES[step, -1 if size < 0 else 1]}."
            )
    return notes


def about_background(fit: Fit) -> list[str]:
    """Waves and drift of the force without contact."""
    background = fit.noise.background
    if not background.size:
        return []
    over = background.size / max(fit.most, TINY)
    if background.memory and not background.smooth:
        over *= np.sqrt(min(background.memory / 2, float(fit.record.x[max(fit.touch - 1, 0)])))
    does = "waves" if background.smooth else "drifts" if background.memory else "scatters"
    return [
        f"The force without contact {does} by about {over:.1%} of the rise (interference, "
        "drift, long-range forces). It is fitted as a random process of this size, which widens the intervals."
    ]


def no_contact(part: Curve, fit: Fit | None, settings: Settings) -> CurveError:
    """Refusal of a record in which no contact stands out of the background, or one of too few readings does."""
    if fit is not None and fit.gain >= SURE and fit.inside < IN_CONTACT:
        return CurveError(
            f"{part.name}: {fit.inside} of {part.force.size} readings are in contact and described by this model; a fit needs "
            f"{IN_CONTACT} or more. Press deeper, or record more readings."
        )
    seen = "" if fit is None else f", of which {fit.inside} rise by {text(fit.most * fit.record.range, 'N')}"
    foot = " The force beyond rises by more than this contact explains." if fit is not None and fit.foot else ""
    begun = "The data begin in contact, and no baseline is seen. " if fit is not None and fit.touch <= 2 else ""
    tilted = settings.baseline == "linear" or (settings.baseline == "auto" and begun != "")
    straight = "A force that grows along a straight line is taken for a tilt; choose baseline = 'constant' where there is none. "
    return CurveError(
        f"{part.name}: no contact is to be seen: the background alone (baseline = {settings.baseline!r}) describes the "
        f"{part.force.size} readings{seen}, as well.{foot} {begun}{straight if tilted else ''}Press deeper, average, or check "
        "which column is the force; `flatpunch read FILE --plot PICTURE` draws the curve."
    )
