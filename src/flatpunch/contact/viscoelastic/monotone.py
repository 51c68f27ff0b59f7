"""One growing contact (Lee and Radok 1960) and the shrinking one that follows (Ting 1966), for a prescribed depth.

d(t) is linear between the given times. With psi as a sum of exponentials all memory integrals are recursions,

    D_j(t) = int exp(-s_j (t - t')) d'(t') dt',      Y_j(t) = int exp(-s_j (t - t')) K(d(t')) d'(t') dt',

exact for D and with K quadratic over each step for Y. While the contact grows F = sum w_j Y_j(t). While it shrinks it has the
extent of the earlier time t1 with int_t1^t psi(t - t') d'(t') dt' = 0, and F = sum w_j exp(-s_j (t - t1)) Y_j(t1): the
pressure of what has touched since t1 is gone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.contact.viscoelastic.elastic import ElasticCurve
from flatpunch.contact.viscoelastic.series import ExponentialSeries, convolve, moments
from flatpunch.media.relaxation import Relaxation


@dataclass(frozen=True, slots=True)
class Memory:
    """Memory integrals at the n times of a history; `decay` over each step, shape (n - 1, terms)."""

    time: Array
    depth: Array
    rate: Array
    series: ExponentialSeries
    elastic: ElasticCurve
    approach: Array
    force: Array

    def pull(self, now: Indices, then: Indices) -> Array:
        """int_(t_then)^(t_now) psi(t_now - t') d'(t') dt' [m] at pairs of times."""
        fading = np.exp(-np.subtract(self.time[now], self.time[then])[:, None] * self.series.rates)
        memory = (self.approach[now] - fading * self.approach[then]) @ self.series.weights
        return np.asarray(memory + self.series.constant * (self.depth[now] - self.depth[then]))


def one_cycle(
    time: Array, depth: Array, relaxation: Relaxation, series: ExponentialSeries, elastic: ElasticCurve
) -> tuple[Array, Array]:
    """Force [N] and contact depth [m] at each time; depth >= 0 rises up to its first maximum and never again.

    The contact depth is the one at which an elastic contact has the same extent.
    """
    top = last_rise(depth)
    memory = _memory(time, depth, series, elastic)
    force = memory.force @ series.weights + series.constant * elastic.force(depth)
    contact = depth.copy()
    falling = np.arange(top + 1, time.size)
    if falling.size:
        force[falling], contact[falling] = _shrinking(memory, relaxation, falling, top)
    return force, contact


def last_rise(depth: Array) -> int:
    """Index up to which the depth never falls."""
    falls = np.flatnonzero(np.diff(depth) < 0)
    return int(falls[0]) if falls.size else depth.size - 1


def _memory(time: Array, depth: Array, series: ExponentialSeries, elastic: ElasticCurve) -> Memory:
    step = np.diff(time)
    rate = np.diff(depth) / step
    z = step[:, None] * series.rates
    weight = moments(z)
    decay = np.exp(-z)
    start = np.ones(series.rates.size)
    approach = convolve(decay, np.diff(depth)[:, None] * weight[0], depth[0] * start)
    share = _stiffness_shares(elastic, depth[:-1], depth[1:])
    grown = np.diff(depth)[:, None] * np.einsum("pn,pnj->nj", share, weight)
    force = convolve(decay, grown, elastic.force(depth[:1]) * start)
    return Memory(time, depth, rate, series, elastic, approach, force)


def _stiffness_shares(elastic: ElasticCurve, start: Array, end: Array) -> Array:
    """K = k_0 + k_1 x + k_2 x^2 over steps between two depths, 0 <= x <= 1; shape (3, n).

    Scaled so that the elastic force is exact: at the first touch K is no polynomial.
    """
    first, middle, last = (elastic.stiffness(d) for d in (start, (start + end) / 2, end))
    moved = end - start
    mean = (first + 4 * middle + last) / 6
    exact = (elastic.force(end) - elastic.force(start)) / np.where(moved == 0, 1, moved)
    # the difference of two tabulated forces means something only where it is large against their rounding
    clear = np.abs(moved) > 1e-5 * end
    scale = np.where(clear & (mean > 0), exact / np.where(mean > 0, mean, 1), 1.0)
    return scale * np.stack([first, 4 * middle - 3 * first - last, 2 * (first + last) - 4 * middle])


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
    grown = (end - begin)[:, None] * np.einsum("pn,pnj->nj", _stiffness_shares(elastic, begin, end), weight)
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
        # 1e-12 of a step moves the force by far less than the steps themselves do
        if moved.max() < 1e-12:
            break
    return x
