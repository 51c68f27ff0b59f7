"""An approach on some hundred means, its contact and its background together, and what in it the model does not describe.

    F = A s(p - c) + b(p) + e + m

over the position p of the cantilever's base: s the model's force at its present parameters, c the contact point, b the
background (`background`), e white noise, m the model's own error, white and in proportion to the force that has been reached. A
factor W with W C W^T = 1, C the covariance of b + e + m, makes readings and candidates white. It is triangular: the first n rows
are the factor of the first n means, so that the likelihood of every contact and of every end of the described range comes from
running sums of the same products.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy
from scipy.ndimage import median_filter

from flatpunch._support.checks import TINY, Array, Flags, Indices
from flatpunch.fit.judge.background import Background, likeliest
from flatpunch.fit.least_squares.minimum import Minimum, minimise
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.measured.signal import spread_of
from flatpunch.fit.parameters.unknowns import NUISANCE

NODES = 300
"""Means of a record; more cost time only."""
_CONTACTS, _BEFORE, _AMPLITUDES = 80, 40, 10
"""Candidates of the contact on the record and up to its range before it, and of amplitudes behind a cantilever."""
SHARE = 0.01
"""Share of the force by which a model may be off without being wrong; few tips and calibrations are better."""
_EXACT = 1e-7
"""Share of the range of the force to which models are computed: data without noise have this error."""


class Found(NamedTuple):
    """A contact of the scan: likelihood, amplitude, position of the base [m], sign of the force, end of the range, its gain."""

    worth: float
    amplitude: float
    place: float
    sign: float
    end: int
    gain: float


@dataclass(frozen=True, eq=False)
class Noise:
    """A background and the model's own error over the largest force."""

    background: Background
    error: float = 0.0

    @property
    def white(self) -> bool:
        """Whether readings over level and tilt are independent and alike."""
        return self.background.size == 0 and self.error == 0


@dataclass(frozen=True, eq=False)
class Record:
    """An approach on means.

    Attributes
    ----------
    objective : Objective
        Of the means, with all unknowns, no limits of the model reached.
    edges : ndarray of int
        Readings at which the means begin, and their number.
    noise, step : float
        Standard deviation of a reading, and step of a digitised force, whose rounding no mean makes smaller [N].
    contacts : tuple of float
        Limits of the contact point [m].
    moduli : tuple of int
        Which of the unknowns are moduli.
    """

    objective: Objective
    edges: Indices
    noise: float
    step: float
    contacts: tuple[float, float]
    moduli: tuple[int, ...]

    @cached_property
    def size(self) -> int:
        """Number of means."""
        return int(self.objective.depth.size)

    @cached_property
    def counts(self) -> Array:
        """Readings of each mean."""
        return np.diff(self.edges).astype(float)

    @cached_property
    def x(self) -> Array:
        """Positions over their range."""
        order = np.maximum.accumulate(self.objective.position)
        rising = (order - order[0]) / max(float(order[-1] - order[0]), TINY)
        return np.asarray(rising + 1e-6 * np.arange(order.size) / order.size)

    @cached_property
    def level(self) -> float:
        """Force from which amplitudes are counted [N]; the background has its own level."""
        if "baseline" not in self.objective.nuisance:
            return self.objective.held["baseline"]
        return float(np.median(self.objective.force[: max(self.size // 5, 3)]))

    @cached_property
    def y(self) -> Array:
        """Forces over their range, counted from `level` and without a drag that is known."""
        force, speed = self.objective.force - self.level, self.objective.speed
        if speed is not None and "drag" not in self.objective.nuisance:
            force = force - self.objective.held["drag"] * speed
        return np.asarray(force / self.range)

    @property
    def range(self) -> float:
        """Range of the forces [N]."""
        return self.objective.frame.span

    @cached_property
    def give(self) -> Array:
        """Factor by which an error of the model at a depth moves the force at a position of the base less."""
        k = self.objective.spring
        if k is None:
            return np.ones(self.size)
        way = self.x * float(np.ptp(self.objective.position))
        steep = np.abs(np.gradient(median_filter(self.objective.force, 7, mode="nearest"), way))
        return np.asarray(np.clip(1 - median_filter(steep, 7, mode="nearest") / k, 0.05, 1))

    @cached_property
    def variance(self) -> Array:
        """Variance of the white noise of the means, over the range squared."""
        return np.asarray(
            (self.noise**2 / self.counts + self.step**2 / 12) / self.range**2
            + (SHARE * self.y * self.give) ** 2
            + _EXACT**2
        )

    @cached_property
    def reached(self) -> Array:
        """Share of the largest force that has been reached."""
        rise = np.maximum.accumulate(median_filter(np.abs(self.y), 3, mode="nearest"))
        return np.asarray(rise / max(float(rise[-1]), TINY))

    @property
    def bent(self) -> float:
        """How far the cantilever is bent by the force without contact [m]."""
        return 0.0 if self.objective.spring is None else self.level / self.objective.spring

    @property
    def zero(self) -> Array:
        """Unknowns at the model's starting values."""
        return self.zero_of(self.objective)

    def zero_of(self, objective: Objective) -> Array:
        """Unknowns of a problem at the model's starting values."""
        return np.append(objective.model.start(), np.zeros(len(objective.nuisance)))

    @cached_property
    def first_candidates(self) -> tuple[Array, Array, Array]:
        """Candidates at the model's starting values."""
        return self.candidates(self.at(self.zero))

    def with_tilt(self, tilt: bool) -> Objective:
        """The problem with or without a tilt of the background."""
        wanted = set(self.objective.nuisance) - {"tilt"} | ({"tilt"} if tilt else set())
        return replace(self.objective, nuisance=tuple(n for n in NUISANCE if n in wanted), _before={})

    def at(self, x: Array, *, far: bool = False) -> Table:
        """Force over depth at parameters, as deep as contacts on the record reach, or `far` before it."""
        reach = (12.0 if far else 2.2) * float(np.ptp(self.objective.position))
        theta = self.objective.split(x)[0]
        while True:
            depth = np.geomspace(1e-6 * reach, reach, 600)
            try:
                force = self.objective.model.evaluate(depth, theta)[0]
            except ValueError:
                # the shape of the tip ends
                reach *= 0.8
                continue
            good = np.isfinite(force)
            return Table(np.append(0.0, depth[good]), np.append(0.0, force[good]))

    def white(self, noise: Noise, gone: Flags | None = None, *, share: bool = True) -> Array:
        """Factor that makes the means over level and tilt independent with variance 1: (n,) if they are so, else (n, n).

        Means that are `gone` count for nothing. Without `share` the model is taken for exact but for its stated error.
        """
        variance = self.variance if share else self.variance - (SHARE * self.y * self.give) ** 2
        variance = variance + noise.error**2 * self.reached * self.give**2
        if gone is not None:
            variance = np.where(gone, 1e8, variance)
        if noise.background.size == 0:
            return np.asarray(variance**-0.5)
        covariance = noise.background.covariance(self.x)
        covariance[np.diag_indices(self.size)] += variance
        factor = scipy.linalg.cholesky(covariance, lower=True, overwrite_a=True, check_finite=False)
        return np.asarray(scipy.linalg.lapack.dtrtri(factor, lower=1, overwrite_c=True)[0])

    @cached_property
    def terms(self) -> Array:
        """Level, tilt and drag as far as they are fitted, over the ranges, shape (n, k); the tilt comes last."""
        columns = [np.ones(self.size)] if "baseline" in self.objective.nuisance else []
        if self.objective.speed is not None and "drag" in self.objective.nuisance:
            columns.append(self.objective.speed / self.objective.frame.speed)
        return np.array([*columns, self.x]).T

    def innovations(self, noise: Noise, columns: Array, *, share: bool = True) -> tuple[Array, Array]:
        """Columns (n, m) made white, beside terms as large as the range, and the factors of their diagonal (n,).

        Each mean is compared with what the means before it predict, the terms included (Kalman's filter of constants).
        """
        white = self.white(noise, share=share)
        terms = self.terms if noise.background.tilt else self.terms[:, :-1]
        if white.ndim == 1:
            columns, terms = columns * white[:, None], terms * white[:, None]
            diagonal = white
        else:
            columns, terms, diagonal = white @ columns, white @ terms, np.diag(white)
        k = terms.shape[1]
        if not k:
            return columns, diagonal
        before = np.zeros((self.size, k, k + columns.shape[1]))
        products = terms[:, :, None] * np.hstack([terms, columns])[:, None, :]
        np.cumsum(products[:-1], axis=0, out=before[1:])
        gains = np.linalg.solve(np.eye(k) + before[:, :, :k], terms[:, :, None])[:, :, 0]
        spread = np.sqrt(1 + np.einsum("nk,nk->n", gains, terms))
        left = columns - np.einsum("nk,nkm->nm", gains, before[:, :, k:])
        return left / spread[:, None], diagonal / spread

    def candidates(self, table: Table) -> tuple[Array, Array, Array]:
        """Contact points (as positions of the base) [m], amplitudes, and forces of all candidates over the range, (n, m)."""
        position, k, n = self.objective.position, self.objective.spring, self.size
        low, high = (end + self.bent for end in self.contacts)
        if high > low:
            way = float(np.ptp(position))
            places = np.append(
                position[np.linspace(1, n - 5, _CONTACTS).astype(int)],
                position[-1] - way * np.geomspace(3e-3, 1, _BEFORE),
            )
            places = np.append(places, position[0] - way * np.array([0.03, 0.1, 0.3, 1.0, 1.7, 3.0, 5.0, 7.0, 10.0]))
            places = places[places > position[-1] - table.depth[-1]]
            inside = places[(places >= low) & (places <= min(high, position[-5]))]
            first, last = (float(np.clip(end, position[0] - way, position[-1])) for end in (low, high))
            places = np.unique(inside if inside.size >= 12 else np.append(inside, np.linspace(first, last, 24)))
        else:
            places = np.array([low])
        contacts, amplitudes, forces = [], [], []
        for place in places.tolist():
            beyond = position - place
            if k is None:
                amounts = np.ones(1)
            elif beyond[0] > 0:
                # in contact from the first reading: the rise between both ends, of a tip that goes less far than the base
                rise = abs(float(self.objective.force[-1] - self.objective.force[0]))
                amounts = (
                    rise
                    / max(float(np.diff(table.force(beyond[[0, -1]]))[0]), TINY)
                    * np.geomspace(0.7, 30, _AMPLITUDES)
                )
            else:
                i = min(int(np.searchsorted(position, place)), n - 3)
                rise = np.abs(self.objective.force - self.objective.force[max(i - 12, 0) : i + 1].mean())
                at = np.unique((i + np.geomspace(2, max(n - 1 - i, 2), _AMPLITUDES)).astype(int))
                at = at[at < n]
                shape = table.force(beyond[at] - rise[at] / k)
                amounts = rise[at][shape > 0] / shape[shape > 0]
            for amount in amounts.tolist():
                contacts.append(place)
                amplitudes.append(amount)
                forces.append(table.behind(beyond, amount, k))
        columns = np.array(forces).T.reshape(n, -1) / self.range
        most = columns.max(axis=0, initial=0.0)
        good = most > 0
        return np.array(contacts)[good], np.array(amplitudes)[good], columns[:, good]

    def scan(self, noise: Noise, candidates: tuple[Array, Array, Array], end: int | None = None) -> Found | None:
        """The likeliest contact and end of the range, or the likeliest contact of a given range; None without any."""
        contacts, amplitudes, columns = candidates
        if not contacts.size:
            return None
        n = self.size
        most = columns.max(axis=0)
        made, diagonal = self.innovations(noise, np.column_stack([self.y, columns / most]))
        y, shapes = made[:, 0], made[:, 1:]
        along = np.cumsum(shapes * y[:, None], axis=0)
        square = np.maximum(np.cumsum(shapes * shapes, axis=0), TINY)
        factor = along / square / most
        gain = 0.5 * along**2 / square
        if self.objective.spring is not None:
            # the amplitude is in the shape of the column already
            gain = np.where((np.abs(factor) > 0.5) & (np.abs(factor) < 2), gain, 0.0)
        # a mean beyond the end may be anywhere within the range
        worth = np.cumsum(np.log(diagonal) - 0.5 * np.log(2 * np.pi) - 0.5 * y * y)[:, None] + gain
        touch = np.searchsorted(self.objective.position, contacts)
        worth[np.arange(n)[:, None] < touch + 3] = -np.inf
        if end is not None:
            worth[: end - 1] = worth[end:] = -np.inf
        e, j = np.unravel_index(int(np.argmax(worth)), worth.shape)
        if not np.isfinite(worth[e, j]) or gain[e, j] <= 0:
            return None
        amplitude = abs(factor[e, j]) * (1.0 if self.objective.spring is None else amplitudes[j])
        return Found(
            float(worth[e, j]),
            float(amplitude),
            float(contacts[j]),
            float(np.sign(factor[e, j])),
            int(e) + 1,
            float(gain[e, j]),
        )

    def worths(self, noise: Noise, force: Array) -> Array:
        """Logarithms of the likelihood of one contact, of forces over the range, for every end of the described range."""
        made, diagonal = self.innovations(noise, np.column_stack([self.y, force]))
        left = made[:, 0] - made[:, 1]
        # a mean beyond the end may be anywhere within the range
        return np.asarray(np.cumsum(np.log(diagonal) - 0.5 * np.log(2 * np.pi) - 0.5 * left**2))

    def start(self, found: Found, x: Array) -> Array:
        """Unknowns at a contact of the scan: the amplitude goes into the moduli."""
        objective = self.objective
        x = x.copy()
        for j in self.moduli:
            x[j] += np.log(found.amplitude) / len(self.moduli)
        scales = objective.units
        for name, value in (("contact", found.place - self.bent), ("baseline", self.level)):
            if name in objective.nuisance:
                offset, unit = scales[name]
                x[objective.names.index(name)] = (value - offset) / unit
        return x

    def learnt(self, touch: int, *, smooth: bool = True, tilt: bool = True, given: bool | None = None) -> Background:
        """The background that the first means show, see `likeliest`."""
        quiet = self.variance - (SHARE * self.y * self.give) ** 2
        return likeliest(self.x[:touch], self.y[:touch], quiet[:touch], smooth=smooth, tilt=tilt, given=given)

    def alone(self) -> tuple[Array, float]:
        """The record as a background alone, of any size: logarithms of the likelihood of its first means, and of a beginning.

        The second is how much better the background of a beginning describes it than the background of the whole does, for the
        beginning in which that is most: without contact, all of the record is of one kind.
        """
        quiet, still = self.variance - (SHARE * self.y * self.give) ** 2, np.zeros(self.size)
        worths = self.worths(Noise(likeliest(self.x, self.y, quiet, bound=False)), still)
        parts = np.unique(np.geomspace(8, max(self.size - 8, 8), 12).astype(int))
        gains = [
            self.worths(Noise(self.learnt(n)), still)[n - 1] - worths[n - 1] for n in parts[parts <= self.size].tolist()
        ]
        return worths, float(max(gains, default=0.0))

    def minimum(self, objective: Objective, x: Array, limits: tuple[Array, Array], end: int, white: Array) -> Minimum:
        """Least squares over the first means."""
        part = objective.first(end, white)
        return minimise(part.evaluate, x, *limits, settled=0.05, steps=25)


@dataclass(frozen=True, eq=False)
class Table:
    """Force [N] over depth [m], ascending from (0, 0)."""

    depth: Array
    load: Array

    def force(self, depth: Array) -> Array:
        """Force at depths, zero where they are not positive."""
        return np.interp(depth, self.depth, self.load, left=0.0)

    def behind(self, beyond: Array, amount: float, spring: float | None) -> Array:
        """Force times `amount` at positions of a cantilever's base beyond the contact."""
        if spring is None:
            return amount * self.force(beyond)
        return amount * self.force(np.interp(beyond, self.depth + amount * self.load / spring, self.depth))


def thinned(position: Array, force: Array) -> Indices:
    """Where means over stretches of equal length along way and force begin, and the number of readings; the last stays alone."""
    n = force.size
    calm = median_filter(force, 5, mode="mirror")
    rise = np.maximum.accumulate(np.abs(calm - np.median(calm[: max(n // 5, 3)])))
    way = np.maximum.accumulate(median_filter(position, 5, mode="mirror"))
    # readings of a hold go nowhere: a tenth of the means
    along = (
        0.1 * np.arange(n) / n + (way - way[0]) / max(float(way[-1] - way[0]), TINY) + rise / max(float(rise[-1]), TINY)
    )
    index = np.minimum((along / along[-1] * NODES).astype(int), NODES - 1)
    index[-1] = NODES
    return np.append(np.flatnonzero(np.diff(index, prepend=-1)), n)


def strays(force: Array, noise: float) -> Flags:
    """Readings that jump away and back, at the first and last reading too.

    The median over a stretch keeps every rise; beside it a reading is far off by more than its noise and the bend of the force
    within the stretch explain. The first and last are judged by the line through their neighbours.
    """
    n = force.size
    # longest disturbance that may go away again, readings; and noise levels of a reading that is far off
    half, far = max(min(24, n // 12), 1), 6.0
    out = np.zeros(n, dtype=bool)
    force = force.copy()
    i = np.arange(1, 8)
    low, high = np.triu_indices(7, 1)
    for end, last in ((slice(None), 0), (slice(None, None, -1), n - 1)):
        near = force[end][1:8]
        slope = np.median((near[high] - near[low]) / (high - low))
        if abs(force[last] - np.median(near - slope * i)) > 2 * far * noise + 3 * np.ptp(near):
            out[last] = True
            force[last] = near[0]
    calm = median_filter(np.pad(force, half, mode="reflect", reflect_type="odd"), 2 * half + 1)[half:-half]
    off = force - calm
    # noise may differ along the record
    blocks = np.array_split(np.abs(off), min(16, max(n // 50, 1)))
    spread = np.repeat([spread_of(b) for b in blocks], [b.size for b in blocks])
    bend = np.abs(np.gradient(calm)) * half / 3
    away = np.abs(off) > far * np.maximum(noise, spread) + bend + SHARE * float(np.ptp(calm))
    # the rise before a drop, and that out of a dip, are no jumps
    turns = np.diff(away.astype(int), prepend=0, append=0)
    for a, b in zip(np.flatnonzero(turns > 0).tolist(), np.flatnonzero(turns < 0).tolist(), strict=True):
        jumps = [(a, a - 1, a)] * (a > 0) + [(b, b - 1, b - 1)] * (b < n)
        away[a:b] = all(abs(force[i] - force[j]) > abs(off[k]) / 2 for i, j, k in jumps)
    out |= away
    return out if out.sum() <= 0.1 * n else np.zeros(n, dtype=bool)


def white_noise(force: Array, step: float, edges: Indices | None = None) -> float:
    """Standard deviation of the noise of readings [N], from their fourth differences, in which a contact cancels.

    `edges` are those of means: the noise of the usual of them, so that the many readings of a hold do not decide.
    """
    fourth = np.diff(force, 4)
    cuts = (
        np.zeros(0, dtype=int) if edges is None else np.minimum(edges[:: max(edges.size // 16, 1)][1:-1], fourth.size)
    )
    blocks = [b for b in np.split(fourth, cuts) if b.size > 8]
    spread = float(np.median([spread_of(b) for b in blocks])) / float(np.sqrt(70)) if blocks else 0.0
    return float(max(spread, step / np.sqrt(12), 1e-9 * float(np.ptp(force))))
