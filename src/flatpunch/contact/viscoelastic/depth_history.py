"""Force over time for a prescribed depth: a growing contact (Lee and Radok 1960) and the shrinking one after it (Ting 1966).

d(t) is linear between the given times. With psi as a sum of exponentials all memory integrals are recursions,

    D_j(t) = int exp(-s_j (t - t')) d'(t') dt',      Y_j(t) = int exp(-s_j (t - t')) K(d(t')) d'(t') dt',

exact for D and with K quadratic over each step for Y. While the contact grows F = sum w_j Y_j(t). While it shrinks it has the
extent of the earlier time t1 with int_t1^t psi(t - t') d'(t') dt' = 0, and F = sum w_j exp(-s_j (t - t1)) Y_j(t1): the
pressure of what has touched since t1 is gone. Steps are halved until K is quadratic over each of them.

Ting's construction needs a contact that only shrinks once it has begun to. Where the tip stops or slows down the surface may
catch up with it; `one_cycle` estimates the error that its force then has, and the springs follow the depth instead, as they do
all other histories.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch.contact.viscoelastic.elastic import ElasticForce
from flatpunch.contact.viscoelastic.series import ExponentialSeries, convolve, exponential_series, moments, recovery
from flatpunch.contact.viscoelastic.springs import SPRINGS, Springs
from flatpunch.media.relaxation import Relaxation

TOLERANCE = 2e-5
"""Error of the force over its largest value down to which springs are added and steps are halved."""

SECOND_ORDER = 2 / 3
"""Share of the change by twice as many springs or steps that is taken for the error left: it bounds orders from one to two."""


@dataclass(frozen=True, slots=True)
class Response:
    """Arrays of shape (n,): depth [m], force [N], contact depth [m], and the estimated error of the force [N].

    The contact depth is that of the elastic contact with the same extent. Where the force is prescribed the error is that of the
    force which the depth would need.
    """

    depth: Array
    force: Array
    contact: Array
    error: Array


HALVINGS = 16
"""Halvings of a step at most."""


@dataclass(frozen=True, slots=True)
class Memory:
    """Memory integrals at the n times of a history; `decay` over each step, shape (n - 1, terms)."""

    time: Array
    depth: Array
    rate: Array
    series: ExponentialSeries
    elastic: ElasticForce
    approach: Array
    force: Array

    def pull(self, now: Indices, then: Indices) -> Array:
        """int_(t_then)^(t_now) psi(t_now - t') d'(t') dt' [m] at pairs of times."""
        fading = np.exp(-np.subtract(self.time[now], self.time[then])[:, None] * self.series.rates)
        memory = (self.approach[now] - fading * self.approach[then]) @ self.series.weights
        return np.asarray(memory + self.series.constant * (self.depth[now] - self.depth[then]))


def one_cycle(
    time: Array,
    depth: Array,
    relaxation: Relaxation,
    series: ExponentialSeries,
    elastic: ElasticForce,
    tolerance: float,
) -> tuple[Array, Array, Array]:
    """Force [N], contact depth [m] and estimated error of the force [N] at each time, shape (n,).

    Depths [m] rise up to their first maximum and never again; `series` is psi as exponentials. Steps are halved until the error
    is below `tolerance` times the largest force. The contact depth is that of an elastic contact of the same extent; the error is
    infinite where the contact is lost and comes back.
    """
    fine, share, bound = _fine_steps(time, depth, elastic, tolerance)
    pressed = np.maximum(np.interp(fine, time, depth), 0.0)
    top = last_rise(pressed)
    memory = _memory(fine, pressed, series, elastic, share)
    force = memory.force @ series.weights + series.constant * elastic.force(pressed)
    contact = pressed.copy()
    step = np.diff(fine)
    error = np.cumsum(np.append(0.0, bound * relaxation.integral(step) / step))
    falling = np.arange(top + 1, fine.size)
    if falling.size:
        force[falling], contact[falling] = _shrinking(memory, relaxation, falling, top)
        error[falling] += np.cumsum(_regrown(memory, relaxation, contact, top))
        if _regained(memory, contact, np.interp(fine, time, depth), top):
            error[falling] = np.inf
    at = np.searchsorted(fine, time)
    return force[at], contact[at], error[at]


def _fine_steps(time: Array, depth: Array, elastic: ElasticForce, tolerance: float) -> tuple[Array, Array, Array]:
    """Times with halved steps, coefficients of K over each, (3, steps), and the elastic force in question, (steps,)."""
    fine = with_touches(time, depth)
    share, bound = np.zeros((3, fine.size - 1)), np.zeros(fine.size - 1)
    new = np.ones(fine.size - 1, dtype=bool)
    allowed = tolerance * float(elastic.force(depth.max(keepdims=True))[0])
    for turn in range(HALVINGS + 1):
        pressed = np.maximum(np.interp(fine, time, depth), 0.0)
        rising = np.diff(pressed) > 0
        chosen = np.flatnonzero(new & rising)
        share[:, chosen], bound[chosen] = _stiffness_shares(elastic, pressed[chosen], pressed[chosen + 1])
        coarse = bound * np.count_nonzero(rising) > allowed
        if not coarse.any() or turn == HALVINGS:
            break
        pieces = 1 + coarse
        fine = np.unique(np.concatenate([fine, (fine[:-1] + fine[1:])[coarse] / 2]))
        share, bound, new = np.repeat(share, pieces, axis=1), np.repeat(bound, pieces), np.repeat(coarse, pieces)
    return fine, share, bound


def _regrown(memory: Memory, relaxation: Relaxation, contact: Array, top: int) -> Array:
    """Error of the force [N] in each step after `top`, of springs that were free and count as held."""
    shrunk = np.minimum.accumulate(contact[top:])
    back = np.flatnonzero(np.diff(contact[top:]) > 0)
    result = np.zeros(contact.size - top - 1)
    if back.size:
        left = np.searchsorted(-shrunk, -contact[top + back + 1], side="right") - 1
        moved = memory.depth[top + np.maximum(left, 0)] - memory.depth[top + back]
        stiffness = memory.elastic.stiffness(contact[top + back + 1]) - memory.elastic.stiffness(contact[top + back])
        result[back] = stiffness * relaxation(np.diff(memory.time)[top + back]) * np.maximum(moved, 0)
    return result


def _regained(memory: Memory, contact: Array, depth: Array, top: int) -> bool:
    """Whether the first point of contact meets the tip again after it was lost."""
    lost = np.flatnonzero(contact[top + 1 :] <= 0) + top + 1
    if not lost.size or (depth[lost] <= 0).all():
        return False
    first = int(lost[0])
    rate = np.diff(depth[first - 1 :]) / np.diff(memory.time[first - 1 :])
    # its height falls ever slower: a tip that does not slow down, but for rounding, stays ahead of it
    if (np.diff(rate) <= 1e-9 * np.abs(rate).max()).all():
        return False
    modes = recovery(memory.series)
    speed = memory.approach[first] @ modes.amplitudes
    since = (memory.time[lost] - memory.time[first])[:, None]
    still = modes.rates == 0
    back = np.where(still, since, -np.expm1(-since * modes.rates) / np.where(still, 1.0, modes.rates))
    return bool((depth[lost][1:] > (depth[first] + back @ speed)[1:]).any())


def with_touches(time: Array, value: Array) -> Array:
    """Times with the moments of touching and leaving added and the steps after each touch split."""
    crossing = np.flatnonzero((value[:-1] <= 0) != (value[1:] <= 0))
    at = time[crossing] - value[crossing] * np.diff(time)[crossing] / np.diff(value)[crossing]
    rising = value[crossing + 1] > 0
    start, end = at[rising], time[crossing + 1][rising]
    if value[0] > 0:
        start, end = np.append(start, time[0]), np.append(end, time[1])
    # K begins at the first touch like a root of d: its step is split into pieces, each half as long as the next
    pieces = start + (end - start) * 0.5 ** np.arange(HALVINGS)[:, None]
    return np.unique(np.concatenate([time, at, pieces.ravel()]))


def last_rise(depth: Array) -> int:
    """Last index before the depth first falls."""
    falls = np.flatnonzero(np.diff(depth) < 0)
    return int(falls[0]) if falls.size else depth.size - 1


def _memory(time: Array, depth: Array, series: ExponentialSeries, elastic: ElasticForce, share: Array) -> Memory:
    step = np.diff(time)
    rate = np.diff(depth) / step
    z = step[:, None] * series.rates
    weight = moments(z)
    decay = np.exp(-z)
    start = np.ones(series.rates.size)
    approach = convolve(decay, np.diff(depth)[:, None] * weight[0], depth[0] * start)
    grown = np.diff(depth)[:, None] * np.einsum("pn,pnj->nj", share, weight)
    force = convolve(decay, grown, elastic.force(depth[:1]) * start)
    return Memory(time, depth, rate, series, elastic, approach, force)


def _stiffness_shares(elastic: ElasticForce, start: Array, end: Array) -> tuple[Array, Array]:
    """K = k_0 + k_1 x + k_2 x^2 over steps, (3, n), at the exact elastic force; its error times the way, (n,) [N]."""
    moved = end - start
    places = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    at = start + places[:, None] * moved
    first, early, middle, late, last = elastic.stiffness(at.ravel()).reshape(at.shape)
    before, after = elastic.force(at[::4].ravel()).reshape(2, -1)
    mean = (first + 4 * middle + last) / 6
    exact = (after - before) / np.where(moved == 0, 1, moved)
    # the difference of two tabulated forces means something only where it is large against their rounding
    clear = np.abs(moved) > 1e-5 * end
    scale = np.where(clear & (mean > 0), exact / np.where(mean > 0, mean, 1), 1.0)
    share = scale * np.stack([first, 4 * middle - 3 * first - last, 2 * (first + last) - 4 * middle])
    quarters = [share[0] + x * (share[1] + x * share[2]) for x in places[1::2]]
    return share, np.maximum(np.abs(quarters[0] - early), np.abs(quarters[1] - late)) * np.abs(moved)


def _shrinking(memory: Memory, relaxation: Relaxation, now: Indices, top: int) -> tuple[Array, Array]:
    """Force and contact depth at the times `now`, all after the depth began to fall at `top`."""
    first = max(int(np.searchsorted(memory.depth[: top + 1] > 0, True)) - 1, 0)
    low, high = np.full(now.size, first), np.full(now.size, top)
    start = memory.pull(now, low)
    # the pull falls as t1 rises: find the last time at which it is still positive
    while (high - low > 1).any():
        middle = (low + high) // 2
        positive = memory.pull(now, middle) > 0
        low, high = np.where(positive, middle, low), np.where(positive, high, middle)
    force, contact = np.zeros(now.size), np.zeros(now.size)
    within = start > 0
    if within.any():
        force[within], contact[within] = _since(memory, relaxation, now[within], low[within])
    # contacts that began with a jump to d_0 shrink below it: F = psi(t) F_el(d_1)
    jumped = ~within & (memory.depth[0] > 0)
    if jumped.any():
        left = memory.series(memory.time[now[jumped]] - memory.time[0])
        contact[jumped] = np.maximum(memory.depth[0] + start[jumped] / left, 0)
        force[jumped] = left * memory.elastic.force(contact[jumped])
    # a contact once lost stays so
    lost = np.cumsum(contact <= 0) > 0
    return np.where(lost, 0, force), np.where(lost, 0, contact)


def _since(memory: Memory, relaxation: Relaxation, now: Indices, then: Indices) -> tuple[Array, Array]:
    """Force and contact depth where t1 lies in the steps that begin at `then`."""
    series, elastic = memory.series, memory.elastic
    x = _time_within(memory, relaxation, now, then)
    z = x[:, None] * series.rates
    weight = moments(z)
    begin = memory.depth[then]
    end = begin + memory.rate[then] * x
    grown = (end - begin)[:, None] * np.einsum("pn,pnj->nj", _stiffness_shares(elastic, begin, end)[0], weight)
    state = np.exp(-z) * memory.force[then] + grown
    fading = np.exp(-(memory.time[now] - memory.time[then] - x)[:, None] * series.rates)
    return (fading * state) @ series.weights + series.constant * elastic.force(end), end


def _time_within(memory: Memory, relaxation: Relaxation, now: Indices, then: Indices) -> Array:
    """Time from `then` to t1: pull(then) = rate int_0^x psi(t - t_then - x') dx'; Newton on a monotone function."""
    since = memory.time[now] - memory.time[then]
    length = memory.time[then + 1] - memory.time[then]
    rate, pull = memory.rate[then], memory.pull(now, then)
    whole = relaxation.integral(since)
    moving = rate > 0
    wanted = np.where(moving, pull / np.where(moving, rate, 1), 0.0)
    low, high = np.zeros_like(since), length.copy()
    x = np.minimum(wanted / relaxation(since), length)
    for _ in range(60):
        miss = whole - relaxation.integral(since - x) - wanted
        low, high = np.where(miss < 0, x, low), np.where(miss >= 0, x, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            trial = x - miss / relaxation(since - x)
        trial = np.where((trial >= low) & (trial <= high), trial, (low + high) / 2)
        moved = np.abs(trial - x) / length
        x = trial
        if moved.max() < ROUNDING:
            break
    return x


def force_of_depth(time: Array, depth: Array, relaxation: Relaxation, elastic: ElasticForce) -> Response:
    """Follow a history of depths [m], negative above the surface and somewhere positive, at ascending times [s].

    One rise and one fall are solved by Lee-Radok and Ting, which is faster, as long as the contact then only shrinks; everything
    else by springs.
    """
    series = exponential_series(relaxation, float(np.diff(time).min()), float(time[-1] - time[0]))
    pressed = np.maximum(depth, 0.0)
    if (np.diff(pressed[last_rise(pressed) :]) <= 0).all():
        force, contact, error = one_cycle(time, depth, relaxation, series, elastic, TOLERANCE)
        if error.max() <= 2 * TOLERANCE * np.abs(force).max():
            return Response(depth, force, contact, error)
    return by_springs(time, depth, series, elastic)


def by_springs(time: Array, depth: Array, series: ExponentialSeries, elastic: ElasticForce) -> Response:
    """Follow the depth by springs, as many as the tolerance takes."""
    count = SPRINGS
    while True:
        force, rough, contact = followed(Springs(elastic, series, float(depth.max()), count), time, depth).T
        error = SECOND_ORDER * np.abs(force - rough)
        if error.max() <= TOLERANCE * force.max() or count >= 2**4 * SPRINGS:
            # second order in the number of springs: half as many are off by four times as much
            return Response(depth, np.maximum(force + (force - rough) / 3, 0.0), contact, error)
        count *= 2


def followed(springs: Springs, time: Array, depth: Array) -> Array:
    """Force of all springs and of every other one, and contact depth, shape (n, 3)."""
    result = np.empty((time.size, 3))
    result[0] = springs.jump(float(depth[0]))
    steps = np.diff(time)
    for n, (step, rate) in enumerate(zip(steps.tolist(), (np.diff(depth) / steps).tolist(), strict=True)):
        ahead = springs.ahead(step)
        end = springs.end(ahead, rate)
        springs.move(ahead, end)
        result[n + 1] = end.force, end.coarse, end.extent
    return result
