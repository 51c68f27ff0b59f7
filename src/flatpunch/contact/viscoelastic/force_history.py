"""Depth over time for a prescribed force, linear between the given times."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import ROUNDING, Array
from flatpunch.contact.viscoelastic.depth_history import HALVINGS, SECOND_ORDER, TOLERANCE, Response, with_touches
from flatpunch.contact.viscoelastic.elastic import ElasticCurve
from flatpunch.contact.viscoelastic.series import ExponentialSeries, exponential_series, mean_decay
from flatpunch.contact.viscoelastic.springs import SPRINGS, Ahead, End, Springs, State
from flatpunch.media.relaxation import Relaxation


def most_elastic_force(time: Array, force: Array, relaxation: Relaxation) -> float:
    """Elastic force [N] at the largest depth that creep under a history of forces may reach.

    That of a growing contact under the largest force so far, which is nowhere smaller than the force.
    """
    series = exponential_series(relaxation, float(np.diff(time).min()), float(time[-1] - time[0]))
    fine = with_touches(time, force)
    largest = np.maximum.accumulate(np.interp(fine, time, force))
    return float(grown_force(fine, largest, series).max())


def depth_of_force(
    time: Array, force: Array, relaxation: Relaxation, elastic: ElasticCurve, deepest: float
) -> Response:
    """Follow a history of forces [N], none negative and some positive, at ascending times [s]; depths stay below `deepest` [m].

    While the contact grows the elastic force F_el(d(t)) follows from F by itself; else the springs are followed, each step with
    the rate of the depth at which they carry the force at its end.
    """
    series = exponential_series(relaxation, float(np.diff(time).min()), float(time[-1] - time[0]))
    grown = _growing(time, force, series)
    if grown is not None:
        wanted, error = grown
        depth = elastic.depth_of(wanted, deepest)
        response = Response(depth, force, depth, error)
    else:
        response = _Follower(elastic, series, float(force.max()), deepest).run(time, force)
    # at the first moment the series is softer than a power law
    at_once = elastic.depth_of(force[:1] / relaxation(np.zeros(1)), deepest)[0]
    response.depth[0] = response.contact[0] = at_once
    return response


def grown_force(time: Array, force: Array, series: ExponentialSeries) -> Array:
    """F_el(d(t)) of a growing contact under a force history: F = int psi(t - t') dF_el(t') step by step, linear in between."""
    z = np.diff(time)[:, None] * series.rates
    decay, gain = np.exp(-z), mean_decay(z)
    total = series.constant + gain @ series.weights
    result = np.empty_like(time)
    result[0] = current = force[0] / series.initial
    memory = current * np.ones(series.rates.size)
    for n in range(time.size - 1):
        memory = memory * decay[n]
        change = (force[n + 1] - series.constant * current - series.weights @ memory) / total[n]
        memory += change * gain[n]
        result[n + 1] = current = current + change
    return result


def _growing(time: Array, force: Array, series: ExponentialSeries) -> tuple[Array, Array] | None:
    """F_el of a contact that never shrinks, and the error of the force; None for others. Steps are halved where F_el bends."""
    fine = with_touches(time, force)
    for _ in range(HALVINGS):
        elastic = grown_force(fine, np.interp(fine, time, force), series)
        if (np.diff(elastic) < 0).any():
            return None
        slope = np.diff(elastic) / np.diff(fine)
        bend = np.abs(np.diff(slope, prepend=slope[0])) + np.abs(np.diff(slope, append=slope[-1]))
        sharp = np.flatnonzero(bend * np.diff(fine) / 8 > TOLERANCE * elastic.max())
        if not sharp.size:
            break
        fine = np.unique(np.concatenate([fine, (fine[sharp] + fine[sharp + 1]) / 2]))
    halved = np.unique(np.concatenate([fine, (fine[1:] + fine[:-1]) / 2]))
    better = grown_force(halved, np.interp(halved, time, force), series)[np.searchsorted(halved, time)]
    change = np.abs(better - elastic[np.searchsorted(fine, time)])
    return better, SECOND_ORDER * change * (force / np.where(better > 0, better, 1.0))


class _Follower:
    """Two rows of springs under a force, one with steps of half the length: their difference is the error of the step."""

    def __init__(self, elastic: ElasticCurve, series: ExponentialSeries, most: float, deepest: float) -> None:
        self.elastic, self.most, self.deepest = elastic, most, deepest
        self.whole, self.half = (_Driven(Springs(elastic, series, deepest, SPRINGS), most) for _ in range(2))

    def run(self, time: Array, force: Array) -> Response:
        """Follow the whole history."""
        depth, contact, error = np.empty((3, time.size))
        springs = self.half.springs
        depth[0] = self.elastic.depth_of(force[:1] / springs.series.initial, self.deepest)[0]
        self.whole.springs.jump(float(depth[0]))
        loaded, coarse, contact[0] = springs.jump(float(depth[0]))
        error[0] = SECOND_ORDER * abs(loaded - coarse)
        for n in range(time.size - 1):
            end = self._through(float(time[n + 1] - time[n]), float(force[n]), float(force[n + 1]), 0)
            depth[n + 1], contact[n + 1] = springs.depth, end.extent
            error[n + 1] = SECOND_ORDER * (
                abs(end.force - end.coarse) + self._of_steps(float(force[n + 1]), end.extent)
            )
        # a tip that carries nothing rests on the surface
        return Response(depth, force, np.where(force > 0, contact, 0.0), error)

    def _of_steps(self, force: float, contact: float) -> float:
        """Force [N] that goes with the difference in depth of the two rows, at the slope that the elastic curve has there."""
        if contact <= 0:
            return 0.0
        at = np.array([contact])
        slope = float(self.elastic.stiffness(at)[0] / self.elastic.force(at)[0])
        return force * slope * abs(self.half.springs.depth - self.whole.springs.depth)

    def _through(self, step: float, before: float, after: float, level: int) -> End:
        """Go through a step, in parts where it takes them; the end of its last half."""
        whole, half = self.whole, self.half
        kept = whole.state(), half.state()
        off = whole.springs.depth - half.springs.depth
        middle = (before + after) / 2
        whole.go(step, after)
        half.go(step / 2, middle)
        last = half.go(step / 2, after)
        miss = abs(whole.springs.depth - half.springs.depth - off)
        if miss <= TOLERANCE * self.deepest or level == HALVINGS:
            return last
        whole.restore(kept[0])
        half.restore(kept[1])
        self._through(step / 2, before, middle, level + 1)
        return self._through(step / 2, middle, after, level + 1)


class _Driven:
    """Springs of which the force is prescribed."""

    def __init__(self, springs: Springs, most: float) -> None:
        self.springs, self.most, self.rate = springs, most, 0.0

    def state(self) -> tuple[State, float]:
        """Copy of the present state."""
        return self.springs.state(), self.rate

    def restore(self, state: tuple[State, float]) -> None:
        """Go back to a state."""
        self.springs.restore(state[0])
        self.rate = state[1]

    def go(self, step: float, force: float) -> End:
        """Go to the end of a step, with this force there."""
        ahead = self.springs.ahead(step)
        end = self._rate(ahead, force)
        self.springs.move(ahead, end)
        self.rate = end.rate
        return end

    def _rate(self, ahead: Ahead, force: float) -> End:
        """End of a step at which the springs carry a force, which grows with the rate; Newton's method, kept between bounds."""
        springs = self.springs
        if springs.contact:
            low = -float(ahead.pull[0]) / ahead.total
        else:
            low = (float(ahead.free[0]) - springs.depth) / ahead.time
        high, rate = np.inf, max(self.rate, low)
        if force <= 0:
            return springs.end(ahead, low)
        # Newton steps and halvings for the rate of the depth over a step
        for _ in range(60):
            end = springs.end(ahead, rate)
            miss = force - end.extrapolated
            if abs(miss) <= 10 * ROUNDING * self.most:
                break
            low, high = (rate, high) if miss > 0 else (low, rate)
            trial = rate + miss / (springs.stiffness(max(end.contact, 1)) * ahead.total)
            if not low < trial < high:
                trial = (low + high) / 2 if np.isfinite(high) else rate + 2 * (trial - rate)
            if trial == rate:
                break
            rate = trial
        return end
