"""An approach against a model without adhesion: its best contact, and what is judged over the background that this leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.fit.elastic.background import (
    WAVES,
    asks_for_tilt,
    begins_free,
    describes_better,
    line_error,
    over_line,
    wave_note,
)
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.elastic.plastic import refuse_plastic
from flatpunch.fit.elastic.wave import best_wavelength
from flatpunch.fit.least_squares.blocks import blocked
from flatpunch.fit.least_squares.minimum import SOON, minimise
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.least_squares.scan import FARTHEST, Scan, scanned
from flatpunch.fit.least_squares.setup import Setup, cut, enough, with_nuisance
from flatpunch.fit.least_squares.speed import speed_of
from flatpunch.fit.measured.approach import Approach
from flatpunch.fit.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fit.measured.drops import Drop, drop_of, last_drop, weak_drop
from flatpunch.fit.measured.signal import (
    CLEAR,
    adhesion_dip,
    check_reading,
    check_rise,
    check_saturation,
    converter_step,
    flat_ends,
    noise_of,
    noise_of_readings,
    saturated,
    without_spikes,
)
from flatpunch.fit.parameters.scaling import MODULI
from flatpunch.fit.parameters.settings import Settings
from flatpunch.fit.parameters.unknowns import frame_of

SAFE = 0.6
"""Share of the way to the contact, from the far end, that shows the background alone: of 60 random curves with attraction 50
are refused for it, with half of it 52, with 0.9 only 34; of 80 plain ones none with any."""
Judged = tuple["Problem", Scan, Flags, tuple[str, ...]]


@dataclass(frozen=True, eq=False)
class Problem:
    """An approach on its way to a least-squares problem."""

    part: Curve
    model: ForwardModel
    limits: tuple[Array, Array]
    settings: Settings
    turned: float
    speed: Array | None = None
    tilted: bool = False
    doubtful: bool = False
    upright: float = 1.0
    whole: bool = True
    line: Scan | None = None
    """The contact over a straight line as background, where it is known."""

    def objective(self, keep: Flags | None = None) -> Objective:
        """All points, or some."""
        return self._all if keep is None or keep.all() else self._objective(keep)

    @cached_property
    def _all(self) -> Objective:
        return self._objective(None)

    def _objective(self, keep: Flags | None) -> Objective:
        speed = speed_of(self.part, self.settings) if self.speed is None else self.speed
        if speed is not None:
            self.part.meta["speed"] = speed
        used = self.part if keep is None else self.part.taken(keep)
        if speed is not None and keep is not None:
            speed = speed[keep]
        held = self.settings.held
        held["contact"] *= self.turned
        found = Objective(
            model=self.model,
            depth=used.depth,
            force=used.force,
            nuisance=self.settings.nuisance,
            held=held,
            frame=frame_of(used.depth, used.force, used.position, speed),
            spring=used.spring_constant,
            speed=speed,
        )
        enough(self.part, found)
        return found

    @property
    def moduli(self) -> list[int]:
        """Which of the free parameters are moduli."""
        return [j for j, free in enumerate(self.model.free) if free.endswith(MODULI)]

    def contacts(self, objective: Objective) -> tuple[float, float]:
        """Contact points that are allowed, those of the user or the whole curve and ten times as much before it."""
        low, high = self.settings.contact_limits
        if self.turned < 0:
            low, high = (None if v is None else -v for v in (high, low))
        position, force, k = objective.position, objective.force, objective.spring
        bent = (0.0, 0.0) if k is None else (float(force.max()) / k, float(force.min()) / k)
        first, last = float(position.min()) - bent[0], float(position.max()) - bent[1]
        return first - FARTHEST * (last - first) if low is None else low, last if high is None else high

    def scan(self, keep: Flags | None = None) -> Scan:
        """Best contact point, with a wave in the background if one is fitted."""
        objective = self.objective(keep)
        start = np.append(self.model.start(), np.zeros(len(objective.nuisance)))
        if "wavelength" in objective.nuisance:
            plain = replace(
                objective, nuisance=tuple(n for n in objective.nuisance if n not in ("sine", "cosine", "wavelength"))
            )
            first = scanned(plain, start[: len(plain.names)], self.moduli, self.contacts(objective))
            wavelength = best_wavelength(plain, first.x, self.moduli, self.contacts(objective))
            start[objective.names.index("wavelength")] = wavelength / objective.frame.way
        scan = scanned(objective, start, self.moduli, self.contacts(objective))
        if not {"wavelength", "drag"} & set(objective.nuisance):
            return scan
        # a wave or a drag that is a little off leaves a dip or a flat end: what is judged later is over its best background
        lower, upper = with_nuisance(objective, self.limits, self.contacts(objective))
        lower[self.moduli], upper[self.moduli] = -np.inf, np.inf
        place = objective.split(scan.x)[1]["contact"]
        found = minimise(blocked(objective, place).evaluate, scan.x, lower, upper, settled=SOON)
        return replace(scan, x=found.x)

    def pressed(self) -> tuple[Problem, Scan]:
        """The problem with a force that grows as the tip presses, and its best contact."""
        scan = self.scan()
        if not self.presses_downwards(scan):
            return self, scan
        part = cut(self.part.turned(force=-1.0), self.settings, self.turned, -self.upright)
        turned = replace(self, part=part, upright=-self.upright)
        return turned, turned.scan()

    @property
    def uncut(self) -> bool:
        """Whether the user has chosen no part of the curve."""
        return self.settings.depth_to is None and self.settings.force_to is None

    def presses_downwards(self, scan: Scan) -> bool:
        """Whether the force is negative when pressing: a contact of negative amplitude fits better, deepest where it ends."""
        if not scan.turned < scan.cost:
            return False
        force = over_line(self.part, self.part.position < np.quantile(self.part.position, 0.3))
        few = max(force.size // 200, 3)
        end = float(np.median(force[-few:]))
        return end < 0 and -end > 0.8 * float(np.abs(force).max() - 3 * noise_of(force[: force.size // 3]))

    def hardest(self, scan: Scan) -> float:
        """Largest modulus that is fitted [Pa]; 0 without one."""
        return max((float(np.exp(scan.x[j])) for j in self.moduli), default=0.0)

    def tilted_where_needed(self, scan: Scan) -> tuple[Problem, Scan]:
        """The problem over a straight line, where only that leaves a contact; else as it is."""
        if scan.gain > CLEAR**2 or self.settings.baseline != "auto" or not self.straight:
            return self, scan
        linear, line = self.linear, self.linear.scan()
        return (linear, line) if line.gain > CLEAR**2 and linear._free(line).sum() >= FEWEST else (self, scan)

    @property
    def linear(self) -> Problem:
        """The problem over a straight line."""
        return replace(self, settings=replace(self.settings, baseline="linear"), tilted=True)

    def check_contact(self, scan: Scan) -> None:
        """Refuse a curve that its background alone describes as well."""
        if scan.gain > CLEAR**2:
            return
        self.check_as_read()
        straight = "A force that grows along a straight line is taken for a tilt; choose baseline = 'constant'. "
        raise CurveError(
            f"{self.part.name}: no contact is to be seen: the background alone (baseline = {self.settings.baseline!r}) describes "
            f"the force within its noise. {straight if self.settings.baseline in ('linear', 'sine') else ''}Press deeper, "
            "average, or check which column is the force."
        )

    @property
    def straight(self) -> bool:
        """Whether the background is a straight line over the position."""
        return self.settings.baseline != "sine" and self.settings.drag == 0

    @cached_property
    def _neighbours(self) -> float:
        """Noise of the force as neighbouring readings show it, whatever the background [N]."""
        return noise_of_readings(self.part.force)

    def check_as_read(self) -> None:
        """Refuse a detector that stays at a reading."""
        if self.straight:
            part, order = self.part, np.argsort(self.part.position, kind="stable")
            check_reading(part, part.position[order], without_spikes(part.force[order]), self._neighbours)

    def withdraws(self, scan: Scan) -> bool:
        """Whether the tip moves out of contact: read backwards, the curve is a much better approach."""
        objective = self.objective()
        inside = objective.indentation(self.part, scan.x)
        if (inside.min() < -0.1 * np.ptp(inside) and scan.cost < scan.turned) or begins_free(self.part):
            return False
        free = replace(self.settings, contact="free")
        costs = []
        for sign in (1.0, -1.0):
            backwards = replace(self, part=self.part.turned(depth=-1.0, force=sign), settings=free, line=None)
            costs.append(backwards.misfit(backwards.scan())[0])
        return min(costs) < 0.5 * self.misfit(scan)[0]

    def misfit(self, scan: Scan, keep: Flags | None = None) -> tuple[float, Array]:
        """Sum of squares after a descent from a scanned contact, which takes positions of the tip for free of noise; residuals.

        The residuals [N] are those of all readings, also of those that are left out.
        """
        residual = self.residuals(scan, keep)
        off = self.part.force - self.objective(keep).over(self.part, self._descended(scan, keep))
        return float(residual @ residual), off

    def residuals(self, scan: Scan, keep: Flags | None = None) -> Array:
        """Measured minus fitted force [N] near a scanned contact; behind a cantilever at the position of its base."""
        objective = self.objective(keep)
        return np.asarray(-objective.evaluate(self._descended(scan, keep))[0] * objective.frame.span)

    def _descended(self, scan: Scan, keep: Flags | None = None) -> Array:
        """Parameters at the minimum near a scanned contact."""
        if scan.settled:
            return scan.x
        objective = self.objective(keep)
        lower, upper = with_nuisance(objective, self.limits, self.contacts(objective))
        # limits of moduli that nobody set are widened only later
        lower[self.moduli], upper[self.moduli] = -np.inf, np.inf
        # distance from the minimum, in standard errors, at which two directions of the tip can be compared
        return minimise(blocked(objective, scan.contact(objective)).evaluate, scan.x, lower, upper, settled=0.1).x

    def _check_end(self, scan: Scan, order: Indices, force: Array, noise: float) -> None:
        """Refuse a curve that is a contact and a constant at its end by more than its noise explains."""
        part, objective = self.part, self.objective()
        if not (ends := flat_ends(part.position[order], force[order], noise, sure=False)):
            return
        residual = self.residuals(scan)
        whole, residual = float(residual @ residual), residual[order]
        for end in ends:
            # the contact goes on above a force that stays where it is
            if residual[-end:].mean() > -3 * noise / np.sqrt(end):
                continue
            keep = np.ones(part.force.size, dtype=bool)
            keep[order[-end:]] = False
            if keep.sum() <= max(FEWEST, len(objective.names)):
                continue
            last = part.force[~keep]
            short, off = self.misfit(self.scan(keep), keep)
            # a model that does not describe the rest gains from leaving out any readings
            if short > keep.sum() * (2 * noise) ** 2:
                continue
            constant, ahead = (float(np.var(each) * end) for each in (last, off[~keep]))
            sure = CLEAR**2 * max(short / keep.sum(), noise**2)
            # after a jump of the tip the contact goes on as steep as before
            if min(ahead, whole - short) - constant > sure:
                raise saturated(part, force[order], end)

    def refuse_plastic(self, scan: Scan, found: Approach) -> tuple[str, ...]:
        """Load cycles that leave an imprint in a stiff body were plastic on loading; in soft ones that is one of two reasons."""
        rest = self.objective().split(scan.x)[1]
        # the speed of the retract is another one: drag is left out of the judgement
        still = {**rest, "drag": 0.0}

        def over(curve: Curve) -> Array:
            objective = self.objective()
            return np.asarray(curve.force - rest["baseline"] - objective.background(still, curve.position, None))

        return refuse_plastic(self.part, found, over, rest["contact"], self.hardest(scan))

    def before(self, scan: Scan, curve: Curve) -> Flags:
        """Which points of a curve are far enough before the contact to show the background alone."""
        inside = self.objective().indentation(curve, scan.x)
        return np.asarray(inside < (1 - SAFE) * min(float(inside.min()), 0.0))

    def over(self, scan: Scan, curve: Curve) -> tuple[Array, Flags, Array]:
        """Force of a curve over its background, which of its points show that alone, and the error of it over the noise."""
        objective, before = self.objective(), self.before(scan, curve)
        if before.sum() < FEWEST:
            before = np.zeros(curve.force.size, dtype=bool)
        elif self.straight and CLEAR * self._neighbours * line_error(curve, before).max() < np.ptp(curve.force):
            # the background by itself, if its line is certain enough at the other end of the curve
            return over_line(curve, before), before, line_error(curve, before)
        rest = objective.split(scan.x)[1]
        speed = objective.speed if curve is self.part else None
        force = curve.force - rest["baseline"] - objective.background(rest, curve.position, speed)
        return force, before, np.zeros(curve.force.size)

    def drop(self, scan: Scan, curve: Curve) -> Drop | None:
        """The drop of the force of a curve that begins with this approach, over the background that its scan found."""
        return self._drop(curve, self.over(scan, curve))

    def _drop(self, curve: Curve, over: tuple[Array, Flags, Array]) -> Drop | None:
        force, before, _ = over
        read = without_spikes(curve.force if self.straight else force)
        calm = without_spikes(force)
        if (drop := drop_of(read, calm, before, self._neighbours)) is None:
            return last_drop(force, calm, self._neighbours) or weak_drop(curve.force, calm, self._neighbours)
        # the median of a rise that ends in a drop is largest up to two readings before its end
        at = drop.at + int(np.argmax(force[drop.at : drop.at + 3]))
        return replace(drop, at=at, size=drop.size + float(force[at] - calm[drop.at]))

    def judged(self, scan: Scan) -> Judged:
        """Problem, scan, points that are used and notes, judged over the background; up to a drop of the force."""
        part = self.part
        over = self.over(scan, part)
        if self.whole and (drop := self._drop(part, over)) is not None:
            cut = self.uncut
            shorter = replace(self, part=part.taken(slice(0, drop.at + 1)) if cut else part, whole=False, line=None)
            problem, scan, keep, more = shorter.judged(shorter.scan() if cut else scan)
            return problem, scan, keep, (drop.note(part.depth[drop.at] * self.turned, cut), *more)
        asks = self.asks(scan)
        if self.settings.baseline != "auto":
            tilted = self.tilted or (asks and self.settings.baseline == "constant")
            return replace(self, tilted=tilted)._checked(scan, over)
        unseen = self.straight and self._free(scan).sum() < FEWEST
        if (asks or unseen) and (found := self._tilted(scan)) is not None:
            linear, scan = found
            return linear.judged(scan)
        # data that begin in contact show no baseline
        doubtful = self.straight and bool(self._free(scan).any())
        constant = replace(self, settings=replace(self.settings, baseline="constant"), doubtful=doubtful)
        return constant._checked(scan, over)

    def asks(self, scan: Scan) -> bool:
        """Whether the readings without contact show a tilt."""
        free = self._free(scan)
        # at a speed that changes drag looks like a tilt
        return self.straight and asks_for_tilt(self.part.position[free], self.part.force[free])

    def _checked(self, scan: Scan, over: tuple[Array, Flags, Array]) -> Judged:
        """The force over its background rises, does not stay at a reading, and has no dip that is not left out."""
        part, (force, before, unsure) = self.part, over
        objective = self.objective()
        step = converter_step(part.force)
        order = np.argsort(part.position, kind="stable")
        # where no background is seen neighbours show the noise
        noise = noise_of(force[before], step) if before.any() else self._neighbours
        calm = np.empty(force.size)
        calm[order] = without_spikes(force[order])
        rise = float(calm.max())
        tilt = objective.split(scan.x)[1]["tilt"] if "tilt" in objective.nuisance else 0.0
        if ends := self.whole or not self.uncut:
            # what lies before a drop is no end of the approach
            self.check_as_read()
        check_rise(part, rise, noise, tilt * objective.frame.way)
        if ends:
            check_saturation(part, part.position[order], calm[order], noise)
            self._check_end(scan, order, calm, noise)
        keep, notes = adhesion_dip(part, calm, noise * np.hypot(1, unsure), rise, before, self.settings.adhesion)
        if before.sum() >= 4 * WAVES and self.settings.baseline in ("constant", "linear"):
            notes = (*wave_note(part.position[before], force[before], rise), *notes)
        return self, scan if keep.all() else self.scan(keep), keep, notes

    def _free(self, scan: Scan) -> Flags:
        """Readings that show the background alone, by the position of the base, which the noise of the force does not move."""
        rest, position = self.objective().split(scan.x)[1], self.part.position
        first, k = float(position.min()), self.part.spring_constant
        place = rest["contact"] + (rest["baseline"] / k if k is not None else 0.0)
        return np.asarray(position < first + SAFE * (place - first))

    def _tilted(self, scan: Scan) -> tuple[Problem, Scan] | None:
        """The problem over a straight line, where it describes the whole curve better and still has readings without contact."""
        linear, tilted = self.linear, self.line or self.linear.scan()
        # a line may take the place of a contact
        seen = tilted.gain > CLEAR**2 and linear._free(tilted).any()
        better = seen and describes_better(self.part.force, linear.residuals(tilted), self.residuals(scan))
        return (linear, tilted) if better else None

    def setup(self, scan: Scan, keep: Flags, notes: tuple[str, ...]) -> Setup:
        """The least-squares problem."""
        objective = self.objective(keep)
        lower, upper = with_nuisance(objective, self.limits, self.contacts(objective))
        start = np.clip(scan.x, lower, upper)
        rest = objective.split(start)[1]
        place = rest["contact"] + (rest["baseline"] / objective.spring if objective.spring else 0.0)
        coarse = blocked(objective, place) if self.settings.loss == "linear" else objective
        return Setup(
            part=self.part,
            used=keep,
            objective=objective,
            lower=lower,
            upper=upper,
            start=lambda: start,
            settings=self.settings,
            notes=notes,
            coarse=coarse,
            tilted=self.tilted,
            doubtful=self.doubtful,
        )
