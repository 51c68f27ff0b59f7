"""All histories, contact growing and shrinking as often as it likes: a row of independent viscoelastic springs.

A contact on any medium is a superposition of flat punches, p = -int Q'(x) p_x dx, with p_x the pressure of a punch of the outline
that an elastic contact has at depth x. The displacement inside the outline x fixes the deflection w(x) = d - x, no pressure
outside it means Q = 0 from x on, and the force is int Q dK(x). Both maps are triangular in x, so that each x is a spring of
stiffness dK(x) with the relaxation of the medium, Q = int psi(t - t') w'(x, t') dt'.

Each spring is in contact (w = d - x, Q >= 0) or free (Q = 0, w >= d - x). Its height x + w never decreases with x: two springs
with the same tip keep their order, for psi that falls. Therefore the springs in contact are those up to one x, the contact depth;
the pressure is nowhere negative and the tip nowhere penetrates (docs/theory/viscoelasticity.md). The row is thus exact for every
history, and needs of the medium and the tip their elastic curve alone.

Over a time step with a constant rate of the depth each spring moves in closed form: with the tip, or in the modes of `recovery`.
A spring that is free is met at most once, and one in contact left at most once, in this order. The only error is that of the
number of springs; it is the difference from the row of every other one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, Flags
from flatpunch.contact.viscoelastic.elastic import ElasticForce, Lumps
from flatpunch.contact.viscoelastic.series import ExponentialSeries, recovery

SPRINGS = 400
"""Springs to begin with: errors of the force of about 1e-5; half as many leave four times that, twice take twice as long."""


State = tuple[Array, Array, Array, float, int, int]
"""Memories, modes and deflections, depth, springs in contact and springs touched."""


@dataclass(frozen=True, slots=True)
class Elapsed:
    """What a time step does to memories (`decay`, `gain` [s]) and modes (`fade`, `back` [s]); arrays of shape (terms,)."""

    decay: Array
    gain: Array
    fade: Array
    back: Array


@dataclass(frozen=True, slots=True)
class Ahead:
    """What the springs do over a step of `time` whatever the depth does.

    `pull` [m] of the springs in contact is Q without motion, `free` [m] the height to which the others recover, `total` [s] the
    integral of psi over the step.
    """

    time: float
    elapsed: Elapsed
    total: float
    pull: Array
    free: Array


@dataclass(frozen=True, slots=True)
class End:
    """Springs at the end of a step with a given rate.

    Attributes
    ----------
    rate : float
        d' [m/s].
    contact : int
        Springs in contact.
    pull : ndarray, shape (contact,)
        Their Q [m].
    first : int
        First spring that changed between contact and free, or was met and left.
    memory : ndarray, shape (contact - first, terms)
        Memory of those that were met.
    modes, deflection : ndarray, shape (left, modes), (left,)
        Of those that were left, from spring max(contact, first) on.
    growing : bool
        Whether the contact is growing at the end of the step.
    force, coarse : float
        Force of all springs and of every other one [N].
    extent : float
        Contact depth [m].
    """

    rate: float
    contact: int
    pull: Array
    first: int
    memory: Array
    modes: Array
    deflection: Array
    growing: bool
    force: float
    coarse: float
    extent: float

    @property
    def extrapolated(self) -> float:
        """Force [N] without the error of second order in the number of springs."""
        return self.force + (self.force - self.coarse) / 3


@dataclass
class Springs:
    """Row of springs for contacts up to the depth `deepest` [m], spaced by the square of their number; `count` is even."""

    elastic: ElasticForce
    series: ExponentialSeries
    deepest: float
    count: int
    depth: float = 0.0
    contact: int = 0
    touched: int = 0
    _elapsed: dict[float, Elapsed] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        self.touch = self.deepest * np.linspace(0, 1, self.count + 1) ** 2
        force, stiffness = self.elastic.force(self.touch), self.elastic.stiffness(self.touch)
        # the stiffness of flat ends begins with that of their face, taken at the first touch
        stiffness[0] = self.elastic.stiffness(1e-9 * self.touch[1:2])[0]
        self.fine = Lumps(self.touch, force, stiffness)
        self.rough = Lumps(self.touch[::2], force[::2], stiffness[::2])
        self.recovery = recovery(self.series)
        terms = self.series.rates.size
        self.memory = np.zeros((self.count + 1, terms))
        self.modes = np.zeros((self.count + 1, terms))
        self.deflection = np.zeros(self.count + 1)

    def jump(self, depth: float) -> tuple[float, float, float]:
        """Go to a first depth at once; forces of all and of every other spring [N] and contact depth [m]."""
        self.depth, n = depth, int(np.searchsorted(self.touch, depth))
        pressed = depth - self.touch[:n]
        self.memory[:n] = pressed[:, None]
        self.contact = self.touched = n
        extent = max(depth, 0.0)
        pull = pressed * self.series.initial
        return self.fine.force(pull, extent), self.rough.force(pull[::2], extent), extent

    def ahead(self, time: float) -> Ahead:
        """What a step of this length brings by itself."""
        elapsed = self._elapsed.get(time)
        if elapsed is None:
            at = np.array(time)
            elapsed = self._elapsed[time] = Elapsed(*self._held(at), *self._free(at))
        n, m = self.contact, self.touched
        pull = self.series.constant * (self.depth - self.touch[:n]) + self.memory[:n] @ (
            elapsed.decay * self.series.weights
        )
        free = self.touch[n:].copy()
        free[: m - n] += self.deflection[n:m] + self.modes[n:m] @ elapsed.back
        total = float(self.series.constant * time + elapsed.gain @ self.series.weights)
        return Ahead(time, elapsed, total, pull, free)

    def end(self, ahead: Ahead, rate: float) -> End:
        """Springs after a step in which the depth changes at a constant rate; nothing is changed yet."""
        n = self.contact
        pull = ahead.pull + rate * ahead.total
        left = int(np.argmax(pull < 0)) if rate < 0 and n and pull[-1] < 0 else n
        if left < n:
            rows = slice(left, n)
            modes, deflection = self._leave(
                self.memory[rows], self.depth - self.touch[rows], rate, np.full(n - left, ahead.time)
            )
            return self._ended(ahead, rate, pull[:left], left, self.memory[:0], modes, deflection, False)
        rows, met = self._met(ahead, rate)
        if not met.size:
            return self._ended(ahead, rate, pull, n, self.memory[:0], self.modes[:0], self.deflection[:0], None)
        memory, deflection, more = self._after_meeting(rows, met, ahead.time, rate)
        kept = int(np.argmax(more < 0)) if (more < 0).any() else more.size
        modes = self.modes[:0]
        if kept < more.size:
            # met and left within the step
            modes, deflection = self._leave(memory[kept:], deflection[kept:], rate, (ahead.time - met)[kept:])
        else:
            deflection = self.deflection[:0]
        if kept:
            decay, gain = self._held((ahead.time - met)[:kept])
            memory = memory[:kept] * decay + rate * gain
        pull = np.concatenate([pull, np.maximum(more[:kept], 0.0)])
        return self._ended(ahead, rate, pull, n, memory[:kept], modes, deflection, kept == more.size)

    def move(self, ahead: Ahead, end: End) -> None:
        """Go to the end of a step."""
        n, m, k = self.contact, self.touched, end.contact
        elapsed = ahead.elapsed
        stay = min(n, k)
        self.memory[:stay] *= elapsed.decay
        self.memory[:stay] += end.rate * elapsed.gain
        self.deflection[n:m] = ahead.free[: m - n] - self.touch[n:m]
        self.modes[n:m] *= elapsed.fade
        self.memory[end.first : k] = end.memory
        gone = slice(max(k, end.first), max(k, end.first) + end.deflection.size)
        self.modes[gone], self.deflection[gone] = end.modes, end.deflection
        self.depth += end.rate * ahead.time
        self.contact, self.touched = k, max(m, gone.stop)

    def stiffness(self, contact: int) -> float:
        """Stiffness of so many springs [N/m]."""
        return float(self.fine.slope[min(contact, self.count) - 1]) if contact else 0.0

    def state(self) -> State:
        """Copy of the present state."""
        arrays = self.memory.copy(), self.modes.copy(), self.deflection.copy()
        return (*arrays, self.depth, self.contact, self.touched)

    def restore(self, state: State) -> None:
        """Go back to a state."""
        self.memory, self.modes, self.deflection, self.depth, self.contact, self.touched = state

    def _held(self, time: Array) -> tuple[Array, Array]:
        """What is left of memories after times of shape (n,), and what they gain per rate [s]; shape (n, terms)."""
        decay = -np.expm1(-time[..., None] * self.series.rates)
        return 1 - decay, decay / self.series.rates

    def _free(self, time: Array) -> tuple[Array, Array]:
        """What is left of modes after times of shape (n,), and how far they went per amplitude [s]; shape (n, modes)."""
        r = self.recovery.rates
        gone = -np.expm1(-time[..., None] * r)
        if r[0] == 0:
            return 1 - gone, np.concatenate([time[..., None], gone[..., 1:] / r[1:]], axis=-1)
        return 1 - gone, gone / r

    def _met(self, ahead: Ahead, rate: float) -> tuple[slice, Array]:
        """Free springs that the tip meets within the step, and when; the heights of free springs fall ever slower."""
        n, m, time = self.contact, self.touched, ahead.time
        end = self.depth + rate * time
        count = int(np.searchsorted(ahead.free, end)) if ahead.free.size and ahead.free[0] < end else 0
        when = np.full(count, time)
        if rate < 0 and count < m - n:
            # a spring may be met and left within the step: its height above the tip is convex
            extra = self._grazed(slice(n + count, m), rate, time, ahead.elapsed.fade)
            when = np.concatenate([when, extra])
        rows = slice(n, n + when.size)
        old = min(when.size, max(m - n, 0))
        if when.size > old:
            when[old:] = (self.touch[n + old : rows.stop] - self.depth) / rate
        if old:
            chosen = slice(n, n + old)
            modes, above = self.modes[chosen], self.touch[chosen] + self.deflection[chosen] - self.depth

            def height(x: Array) -> Array:
                return np.asarray(above + _along(modes, self._free(x)[1]) - rate * x)

            when[:old] = _first_root(height, when[:old])
        return rows, np.clip(when, 0.0, time)

    def _grazed(self, rows: slice, rate: float, time: float, fade: Array) -> Array:
        """Times of lowest height above the tip for those first springs of `rows` that are met and passed within the step."""
        first, last = self.modes[rows].sum(axis=1), self.modes[rows] @ fade
        turning = (first < rate) & (last > rate)
        count = int(np.argmin(turning)) if not turning.all() else turning.size
        if not count:
            return np.zeros(0)
        chosen = slice(rows.start, rows.start + count)
        modes = self.modes[chosen]

        def speed(x: Array) -> Array:
            return np.asarray(rate - _along(modes, self._free(x)[0]))

        lowest = _first_root(speed, np.full(count, time))
        height = (
            self.touch[chosen]
            + self.deflection[chosen]
            - self.depth
            + _along(modes, self._free(lowest)[1])
            - rate * lowest
        )
        below = height < 0
        return lowest[: int(np.argmin(below)) if not below.all() else count]

    def _after_meeting(self, rows: slice, met: Array, time: float, rate: float) -> tuple[Array, Array, Array]:
        """Memory and deflection of springs when they are met, and their Q at the end of the step."""
        old = min(met.size, max(self.touched - rows.start, 0))
        memory = np.zeros((met.size, self.series.rates.size))
        if old:
            modes = self.modes[rows.start : rows.start + old] * self._free(met[:old])[0]
            memory[:old] = modes @ self.recovery.shapes
        deflection = self.depth + rate * met - self.touch[rows]
        decay, gain = self._held(time - met)
        pull = (memory * decay + rate * gain) @ self.series.weights
        return memory, deflection, pull + self.series.constant * (deflection + rate * (time - met))

    def _leave(self, memory: Array, deflection: Array, rate: float, time: Array) -> tuple[Array, Array]:
        """Modes and deflection after `time` of springs in contact that are left within it, the tip going at a constant rate."""
        w, constant = self.series.weights, self.series.constant

        def pull(x: Array) -> Array:
            decay, gain = self._held(x)
            return np.asarray((memory * decay + rate * gain) @ w + constant * (deflection + rate * x))

        when = _first_root(pull, time)
        decay, gain = self._held(when)
        modes = (memory * decay + rate * gain) @ self.recovery.amplitudes
        fade, back = self._free(time - when)
        return modes * fade, deflection + rate * when + _along(modes, back)

    def _ended(
        self,
        ahead: Ahead,
        rate: float,
        pull: Array,
        first: int,
        memory: Array,
        modes: Array,
        deflection: Array,
        growing: bool | None,
    ) -> End:
        n, k = self.contact, pull.size
        depth = self.depth + rate * ahead.time
        if growing is None:
            free = float(self.modes[k] @ ahead.elapsed.fade) if k < self.touched else 0.0
            growing = rate >= 0 or free < rate
        height = ahead.free[k - n :] if growing else ahead.free[:0]
        forces, extent = [], 0.0
        for lumps, every in ((self.rough, 2), (self.fine, 1)):
            pulls = pull[::every]
            extent = (
                lumps.grown_to(pulls.size, depth, height[-k % every :: every]) if growing else lumps.shrunk_to(pulls)
            )
            forces.append(lumps.force(pulls, extent))
        return End(rate, k, pull, first, memory, modes, deflection, growing, forces[1], forces[0], extent)


def _along(modes: Array, share: Array) -> Array:
    """Sum over the modes of each spring."""
    return np.asarray(np.einsum("ij,ij->i", modes, share))


def _first_root(function: Callable[[Array], Array], high: Array) -> Array:
    """Roots in (0, high) of functions positive before and negative after, shape (n,), as Chandrupatla (1997)."""
    old, new = np.zeros_like(high), high.copy()
    f_old, f_new = function(old), function(new)
    third, f_third = old, f_old
    # tolerance of the time over the step; SciPy's root finder, the same method, takes five times as long for a few springs
    share, tolerance = np.full_like(high, 0.5), 10 * ROUNDING
    # Newton steps and halvings for the time at which a spring is met or left
    for _ in range(100):
        x = new + share * (old - new)
        value = function(x)
        same: Flags = (value > 0) == (f_new > 0)
        third, f_third = np.where(same, new, old), np.where(same, f_new, f_old)
        old, f_old = np.where(same, old, new), np.where(same, f_old, f_new)
        new, f_new = x, value
        width = np.abs(old - new)
        if ((width <= tolerance * high) | (value == 0)).all():
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            xi, phi = (new - old) / (third - old), (f_new - f_old) / (f_third - f_old)
            curved = f_new / (f_old - f_new) * f_third / (f_old - f_third)
            curved += (third - new) / (old - new) * f_new / (f_third - f_new) * f_old / (f_third - f_old)
            smooth = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
            least = 0.5 * tolerance * high / width
        share = np.clip(np.where(smooth, curved, 0.5), least, 1 - least)
    return np.where(np.abs(f_old) < np.abs(f_new), old, new)
