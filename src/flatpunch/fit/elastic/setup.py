"""From a curve and a model to a least-squares problem: which part of the curve, which points, limits, where to start.

The order matters: the position determines the approach, the scan of contact points the background, and only then is the force
judged (sign, noise, saturation, adhesion), over its background.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.fit.elastic.background import WAVES, line_error, over_line, tilt_note, wave_note
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.elastic.plastic import HARD, IMPRINT, PLASTIC, depth_reached, plastic_cycles
from flatpunch.fit.elastic.retract import FreeOfContact, free_of_contact
from flatpunch.fit.elastic.wave import best_wavelength
from flatpunch.fit.least_squares.blocks import blocked
from flatpunch.fit.least_squares.minimum import SOON, minimise
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.least_squares.scan import FARTHEST, Scan, scanned
from flatpunch.fit.least_squares.setup import Setup, cut, enough, with_nuisance
from flatpunch.fit.least_squares.speed import before_turn, no_drag, shows_drag, speed_of
from flatpunch.fit.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fit.measured.cycles import turns
from flatpunch.fit.measured.segments import approach, approach_end, forwards, leaves, turning, wander, without_pause
from flatpunch.fit.measured.signal import (
    CLEAR,
    adhesion_dip,
    check_reading,
    check_rise,
    check_saturation,
    converter_step,
    flat_ends,
    noise_of,
    saturated,
    without_spikes,
)
from flatpunch.fit.parameters.settings import Settings
from flatpunch.fit.parameters.unknowns import frame_of

SAFE = 0.6
"""Share of the way to the contact, from the far end, that shows the background alone (attraction acts near the contact).

Of 60 random curves with attraction 50 are refused for it, with half of it 52, with 0.9 only 34; of 80 plain ones none with any.
"""
_BOTH_ENDS = (
    "The tip is in contact at both ends of the curve: its depth was taken with its sign turned, and the approach is the "
    "second part."
)


def elastic_setup(
    curve: Curve, model: ForwardModel, limits: tuple[Array, Array], settings: Settings, *, _second: bool = False
) -> Setup:
    """The approach of a curve against a model without adhesion."""
    curve, notes = forwards(curve)
    turned, force_sign = -1.0 if notes else 1.0, 1.0
    every = curve
    if curve.segment is None and len(at := turns(curve.position)) > 1:
        ends = [0, *at, curve.depth.size - 1]
        advance = np.diff(curve.position[ends])[::2]
        chosen = 2 * int(np.argmax(advance))
        curve = curve.taken(slice(ends[chosen], ends[chosen + 2] + 1))
        notes += (
            f"The curve has {advance.size} loading cycles; the largest approach, of cycle {chosen // 2 + 1}, is fitted.",
        )
    part = before_turn(without_pause(approach(cut(curve, settings, turned))), settings)
    # drag that the approach does not show is a constant there, and is left to the baseline
    shown = settings.drag != "free" or shows_drag([part], settings)
    if not shown and leaves(curve) >= curve.depth.size:
        raise no_drag(part, settings, ", and there is no retraction")
    problem = Approach(part, model, limits, settings if shown else replace(settings, drag=0.0), turned)
    scan = problem.scan()
    if problem.presses_downwards(scan):
        force_sign = -1.0
        part = cut(part.turned(force=-1.0), settings, turned, force_sign)
        problem = replace(problem, part=part)
        scan = problem.scan()
        notes += ("The force falls while the tip presses; it was taken with its sign turned (positive when pressing).",)
    if plastic_cycles(every.turned(force=force_sign)):
        problem.refuse_plastic(scan, curve.turned(force=force_sign), every.turned(force=force_sign))
    problem.check_contact(scan)
    if problem.withdraws(scan):
        if turning(curve) and not _second:
            # in contact at both ends: counted the other way, the tip approaches in the second part
            rest = replace(curve.taken(slice(approach_end(curve), None)), segment=None)
            found = elastic_setup(rest.turned(depth=-1.0), model, limits, settings, _second=True)
            return replace(found, notes=(_BOTH_ENDS, *found.notes))
        raise CurveError(
            f"{curve.name}: the force changes where the curve begins and rests where it ends: this is a retract. Give "
            "the approach, or the whole cycle."
        )
    if not shown:
        # where the tip slows down before it turns, drag bends the force: it is judged over the drag that the retraction shows
        free = problem.free_of_contact(scan, curve.turned(force=force_sign), settings)
        if free is None:
            raise no_drag(part, settings, ", and the retraction has no part without contact to compare with")
        problem = replace(problem, settings=replace(settings, drag=free.drag))
        scan = problem.scan()
    scan, keep, more = problem.judged(scan)
    problem.refuse_plastic(scan, curve.turned(force=force_sign), every.turned(force=force_sign))
    if settings.drag == "free":
        problem, scan, keep = problem.with_retract(scan, keep, curve.turned(force=force_sign), settings)
    return problem.setup(scan, keep, (*notes, *more))


@dataclass(frozen=True, eq=False)
class Approach:
    """An approach on its way to a least-squares problem."""

    part: Curve
    model: ForwardModel
    limits: tuple[Array, Array]
    settings: Settings
    turned: float
    speed: Array | None = None

    def objective(self, keep: Flags | None = None) -> Objective:
        """All points, or some."""
        speed = speed_of(self.part, self.settings) if self.speed is None else self.speed
        if speed is not None:
            self.part.meta["speed"] = speed
        used = self.part if keep is None or keep.all() else self.part.taken(keep)
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
        return [j for j, free in enumerate(self.model.free) if free.endswith("young")]

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

    def presses_downwards(self, scan: Scan) -> bool:
        """Whether the force is negative when pressing: a contact of negative amplitude fits better, deepest where it ends."""
        if not scan.turned < scan.cost:
            return False
        force = over_line(self.part, self.part.position < np.quantile(self.part.position, 0.3))
        few = max(force.size // 200, 3)
        end = float(np.median(force[-few:]))
        return end < 0 and -end > 0.8 * float(np.abs(force).max() - 3 * noise_of(force[: force.size // 3]))

    def check_contact(self, scan: Scan) -> None:
        """Refuse a curve that its background alone describes as well."""
        if scan.gain > CLEAR**2:
            return
        self._check_reading()
        straight = self.settings.baseline in ("linear", "sine")
        raise CurveError(
            f"{self.part.name}: no contact is to be seen: the background alone (baseline = {self.settings.baseline!r}) describes "
            "the force within its noise. "
            + (
                "A force that grows along a straight line is taken for a tilt; choose baseline = 'constant'. "
                if straight
                else ""
            )
            + "Press deeper, average, or check which column is the force."
        )

    @property
    def _straight(self) -> bool:
        """Whether the background is a straight line over the position."""
        return self.settings.baseline != "sine" and self.settings.drag == 0

    @property
    def _neighbours(self) -> float:
        """Noise of the force as neighbouring readings show it, whatever the background [N]."""
        return max(wander(self.part.force), float(converter_step(self.part.force) / np.sqrt(12)))

    def _check_reading(self) -> None:
        """Refuse a detector that stays at a reading."""
        if self._straight:
            order = np.argsort(self.part.position, kind="stable")
            read = without_spikes(self.part.force[order])
            check_reading(self.part, self.part.position[order], read, self._neighbours)

    def withdraws(self, scan: Scan) -> bool:
        """Whether the tip moves out of contact: read backwards, the curve is a much better approach."""
        objective = self.objective()
        inside = objective.indentation(self.part, scan.x)
        if (inside.min() < -0.1 * np.ptp(inside) and scan.cost < scan.turned) or self._begins_free():
            return False
        free = replace(self.settings, contact="free")
        costs = []
        for sign in (1.0, -1.0):
            backwards = replace(self, part=self.part.turned(depth=-1.0, force=sign), settings=free)
            costs.append(backwards.misfit(backwards.scan()))
        return min(costs) < 0.5 * self.misfit(scan)

    def _begins_free(self) -> bool:
        """Whether the force changes less over the first tenth of the way than on the whole: a retract begins at its steepest."""
        order = np.argsort(self.part.position, kind="stable")
        tenth = max(order.size // 10, 3)
        last = np.isin(np.arange(order.size), order[-tenth:])
        force = over_line(self.part, last)[order]
        few = max(tenth // 4, 1)
        change = abs(float(np.median(force[tenth - few : tenth]) - np.median(force[:few])))
        return change < 0.05 * float(np.ptp(force))

    def misfit(self, scan: Scan, keep: Flags | None = None) -> float:
        """Sum of squares after a descent from a scanned contact: a scan takes positions of the tip for free of noise."""
        objective = self.objective(keep)
        lower, upper = with_nuisance(objective, self.limits, self.contacts(objective))
        # limits of moduli that nobody set are widened only later
        lower[self.moduli], upper[self.moduli] = -np.inf, np.inf
        # distance from the minimum, in standard errors, at which two directions of the tip can be compared
        found = minimise(blocked(objective, scan.contact(objective)).evaluate, scan.x, lower, upper, settled=0.1)
        residual = objective.evaluate(found.x)[0] * objective.frame.span
        return float(residual @ residual)

    def _check_end(self, scan: Scan, order: Indices, force: Array, noise: float) -> None:
        """Refuse a curve that is a contact and a constant at its end by more than its noise explains."""
        part, objective = self.part, self.objective()
        residual = (part.force - objective.over(part, scan.x))[order]
        for end in flat_ends(part.position[order], force[order], noise, sure=False):
            # the contact goes on above a force that stays where it is
            if residual[-end:].mean() > -3 * noise / np.sqrt(end):
                continue
            keep = np.ones(part.force.size, dtype=bool)
            keep[order[-end:]] = False
            if keep.sum() <= max(FEWEST, len(objective.names)):
                continue
            last = part.force[~keep]
            short = self.misfit(self.scan(keep), keep)
            # a model that does not describe the rest gains from leaving out any readings
            if short > keep.sum() * (2 * noise) ** 2:
                continue
            apart = short + float(np.sum((last - last.mean()) ** 2))
            if self.misfit(scan) - apart > CLEAR**2 * max(short / keep.sum(), noise**2):
                raise saturated(part, force[order], end)

    def refuse_plastic(self, scan: Scan, whole: Curve, every: Curve) -> None:
        """Load cycles of a nanoindenter that leave an imprint in a stiff body were plastic on loading."""
        young = [np.exp(scan.x[j]) for j in self.moduli]
        if self.part.spring_constant is not None or not young or max(young) < HARD:
            return
        objective = self.objective()
        rest = objective.split(scan.x)[1]
        # the speed of the retract is another one: drag is left out of the judgement
        still = {**rest, "drag": 0.0}
        if plastic_cycles(
            replace(every, force=every.force - rest["baseline"] - objective.background(still, every.position, None))
        ):
            raise CurveError(
                f"{self.part.name}: the unloading of its load cycles is steeper than the loading: {PLASTIC}"
            )
        back = (
            whole.taken(slice(approach_end(whole), None)) if whole.depth.size - approach_end(whole) > FEWEST else None
        )
        if back is None:
            return
        down, up = (
            depth_reached(
                c.depth,
                c.force - rest["baseline"] - objective.background(still, c.position, None),
                float(np.ptp(self.part.force)),
            )
            for c in (self.part, back)
        )
        deepest = float(whole.depth.max()) - rest["contact"]
        left = up - down
        if not left > IMPRINT * deepest:
            return
        raise CurveError(
            f"{self.part.name}: the unloading ends {left / deepest:.0%} of the depth short of where the loading began: {PLASTIC}"
        )

    def judged(self, scan: Scan) -> tuple[Scan, Flags, tuple[str, ...]]:
        """The scan, points that are used and notes, judged over the background."""
        part, objective = self.part, self.objective()
        inside = objective.indentation(part, scan.x)
        before = inside < (1 - SAFE) * min(float(inside.min()), 0.0)
        notes: tuple[str, ...] = ()
        rest = objective.split(scan.x)[1]
        force = part.force - rest["baseline"] - objective.background(rest, objective.position, objective.speed)
        unsure = np.zeros(part.force.size)
        if before.sum() < FEWEST:
            before = np.zeros(part.force.size, dtype=bool)
        elif self._straight and CLEAR * self._neighbours * line_error(part, before).max() < force.max():
            # the background by itself, if its line is certain enough at the other end of the curve
            force, unsure = over_line(part, before), line_error(part, before)
        step = converter_step(part.force)
        order = np.argsort(part.position, kind="stable")
        # where no background is seen neighbours show the noise
        noise = noise_of(force[before], step) if before.any() else self._neighbours
        calm = np.empty(force.size)
        calm[order] = without_spikes(force[order])
        rise = float(calm.max())
        tilt = objective.split(scan.x)[1]["tilt"] if "tilt" in objective.nuisance else 0.0
        self._check_reading()
        check_rise(part, rise, noise, tilt * objective.frame.way)
        check_saturation(part, part.position[order], calm[order], noise)
        self._check_end(scan, order, calm, noise)
        keep, dips = adhesion_dip(part, calm, noise * np.hypot(1, unsure), rise, before, self.settings.adhesion)
        if before.sum() >= FEWEST and self.settings.baseline == "constant":
            notes = tilt_note(part.position[before], part.force[before], float(inside.max()), rise)
        if before.sum() >= 4 * WAVES and self.settings.baseline in ("constant", "linear"):
            notes += wave_note(part.position[before], force[before], rise)
        if not keep.all():
            scan = self.scan(keep)
        return scan, keep, (*notes, *dips)

    def free_of_contact(self, scan: Scan, curve: Curve, settings: Settings) -> FreeOfContact | None:
        """What the parts of approach and retraction without contact show of the drag; None if they do not."""
        objective = self.objective()
        inside = objective.indentation(self.part, scan.x)
        before = inside < (1 - SAFE) * min(float(inside.min()), 0.0)
        rest = {**objective.split(scan.x)[1], "drag": 0.0}
        return free_of_contact(
            curve, self.part, before, lambda c: objective.background(rest, c.position, None), settings
        )

    def with_retract(self, scan: Scan, keep: Flags, curve: Curve, settings: Settings) -> tuple[Approach, Scan, Flags]:
        """The problem with the retraction's points without contact, which distinguish drag from the baseline; else as it is."""
        part = self.part
        free = self.free_of_contact(scan, curve, settings)
        if free is None:
            return self, scan, keep
        size = part.depth.size
        whole = curve.taken(np.append(np.arange(size), free.points))
        whole = replace(whole, meta=dict(whole.meta))
        longer = replace(self, part=whole, settings=settings, speed=free.speed)
        kept = np.append(keep, np.ones(free.points.size, dtype=bool))
        rest = self.objective().split(scan.x)[1]
        if part.spring_constant is not None:
            rest["contact"] += (free.drag - rest["drag"]) * float(np.median(free.speed[:size])) / part.spring_constant
        rest |= {"drag": free.drag, "baseline": free.level}
        target = longer.objective(kept)
        scales = target.scales()
        x = [(rest[name] - scales[name][0]) / scales[name][1] for name in target.nuisance]
        return longer, replace(scan, x=np.append(scan.x[: len(self.model.free)], x)), kept

    def setup(self, scan: Scan, keep: Flags, notes: tuple[str, ...]) -> Setup:
        """The least-squares problem."""
        objective = self.objective(keep)
        lower, upper = with_nuisance(objective, self.limits, self.contacts(objective))
        start = np.clip(scan.x, lower, upper)
        rest = objective.split(start)[1]
        place = rest["contact"] + (rest["baseline"] / objective.spring if objective.spring else 0.0)
        coarse = blocked(objective, place) if self.settings.loss == "linear" else objective
        return Setup(self.part, keep, objective, lower, upper, lambda: start, notes, coarse)
