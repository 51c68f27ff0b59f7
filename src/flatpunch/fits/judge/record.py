"""An approach on some hundred means, its contact and its background together, and what in it the model does not describe.

    F = A s(p - c) + b(p) + e + m

over the position p of the cantilever's base: s the model's force at its present parameters, c the contact point, b the
background, e white noise, m the model's own error, white and in proportion to the force that has been reached. A
factor W with W C W^T = 1, C the covariance of b + e + m, makes readings and candidates white. It is triangular: the first n rows
are the factor of the first n means, so that the likelihood of every contact and of every end of the described range comes from
running sums of the same products.

The force without contact is a random process, b(x) = level + tilt x + w(x), <w(x) w(x')> = size^2 K(|x - x'|/memory),
x from 0 to 1 over the record, forces over their range. w is a walk that is held back over its memory (exponential K) or smooth
waves (Matern 5/2). Drift, interference, slow noise and bent lines are one thing, beside which a contact must stand out. Its size
and memory are those that make the readings before the contact likeliest.

These are averaged over equal stretches: K is the same matrix for all curves, and its eigenvectors v_k and eigenvalues l_k are
computed once. The likelihood of a size is a sum over k of variances s^2 + size^2 l_k; level and tilt, which may be as large as
the range, enter it by Woodbury's identity.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
import scipy
from scipy.ndimage import median_filter

from flatpunch._support.checks import TINY, Array, Flags, Indices
from flatpunch.fits.least_squares.minimum import Minimum, minimise
from flatpunch.fits.least_squares.objective import Objective
from flatpunch.fits.measured.signal import ROUNDED, SHARE, over_line
from flatpunch.fits.parameters.sample import NUISANCE

_WALKS = (0.02, 0.1, 0.5, np.inf)
"""Memories of walks, over the way before the contact."""
_WAVES = (0.15, 0.5, 1.5)
"""Memories of smooth waves, over the way before the contact."""
_SIZES = np.geomspace(1e-3, 0.25, 16)
"""Sizes of a process over the range of the force; a larger process would swallow a contact."""
_UNBOUND = np.geomspace(1e-3, 1.0, 20)
"""Sizes of a process that explains a whole record without contact."""
_USUAL = 0.1
"""Size that the force without contact seldom exceeds, over the range of the force: standard deviation of the prior."""
_NODES = 64
"""Stretches over which the readings before the contact are averaged; more cost time only."""
LEARNT = 8
"""Stretches from which a process can be learnt."""


@dataclass(frozen=True, slots=True)
class Background:
    """Size and memory of a process, whether it is smooth, and whether a tilt comes with it; without memory it is white."""

    size: float = 0.0
    memory: float = np.inf
    smooth: bool = False
    tilt: bool = False

    @property
    def white(self) -> bool:
        """Whether readings over level and tilt are independent."""
        return self.size == 0 or self.memory == 0

    def covariance(self, x: Array) -> Array:
        """Covariance of the process without level and tilt, shape (n, n)."""
        return self.size**2 * _kernel(x, self.memory, self.smooth)


def _kernel(x: Array, memory: float, smooth: bool) -> Array:
    if memory == 0:
        return np.eye(x.size)
    if np.isinf(memory):
        return np.asarray(np.minimum.outer(x, x))
    apart = np.abs(np.subtract.outer(x, x)) / memory
    if smooth:
        apart *= np.sqrt(5)
        return np.asarray((1 + apart + apart**2 / 3) * np.exp(-apart))
    return np.asarray(np.exp(-apart) * memory / 2)


@lru_cache(maxsize=256)
def _spectrum(nodes: int, memory: float, smooth: bool) -> tuple[Array, Array, Array, Array]:
    """Eigenvalues and eigenvectors (columns) of a kernel over equal stretches from 0 to 1, level and tilt in them."""
    x = (np.arange(nodes) + 0.5) / nodes
    values, vectors = np.linalg.eigh(_kernel(x, memory, smooth))
    level, tilt = np.array([np.ones(nodes), x]) @ vectors
    return np.maximum(values, 0.0), vectors, level, tilt


def likeliest(
    x: Array,
    y: Array,
    variance: Array,
    *,
    smooth: bool = True,
    tilt: bool = True,
    given: bool | None = None,
    bound: bool = True,
) -> Background:
    """The process that forces without contact show: the largest of all likelihoods.

    Parameters
    ----------
    x, y, variance : ndarray, shape (n,)
        Ascending positions, forces and variances of their white noise, over the ranges of the record.
    smooth, tilt : bool
        Whether smooth waves and a tilt are tried.
    given : bool, optional
        Whether the background is a tilted line, where the user has chosen one: what departs from it is white.
    bound : bool
        Whether the process is small beside the range of the force: before a contact, but not without one.
    """
    usual, tried = (_USUAL, _SIZES) if bound else (np.inf, _UNBOUND)
    nodes = min(_NODES, x.size)
    way = float(x[-1] - x[0]) if x.size else 0.0
    if nodes < LEARNT or not way > 0:
        return Background(tilt=bool(given))
    index = np.minimum(((x - x[0]) * (nodes / way)).astype(int), nodes - 1)
    weight = np.bincount(index, 1 / variance, nodes)
    filled = weight > 0
    centres = (np.arange(nodes) + 0.5) / nodes
    means = np.interp(centres, centres[filled], (np.bincount(index, y / variance, nodes)[filled] / weight[filled]))
    noise = float(np.mean(1 / weight[filled]))
    best, found = -np.inf, Background()
    kinds = [(m, False) for m in _WALKS] + ([(m, True) for m in _WAVES] if smooth else [])
    tilts = ((False, True) if tilt else (False,)) if given is None else (given,)
    for memory, waves in kinds if given is None else [(0.0, False)]:
        values, vectors, level, slope = _spectrum(nodes, memory, waves)
        # a walk spreads over its way: the same size over a longer record
        scale = way if memory and not waves else 1.0
        sizes = np.append(0.0, tried) if memory in (0.0, np.inf) else tried
        spread = noise + np.multiply.outer(sizes**2 * scale, values)
        # by Akaike's criterion: a process has two numbers, a tilt one
        prior = 2.0 * (sizes > 0) + 0.5 * (sizes / usual) ** 2
        worths = _worths(spread, means @ vectors, level, way * slope)
        for tilted in tilts:
            worth = worths[tilted] - prior - tilted
            at = int(np.argmax(worth))
            if worth[at] > best:
                best = float(worth[at])
                found = Background(float(sizes[at]), memory * way, waves, tilted)
    return found


def _worths(spread: Array, along: Array, level: Array, tilt: Array) -> tuple[Array, Array]:
    """Logarithms of the likelihood for variances (sizes, n) of components, beside a level, and beside a level and a tilt.

    Level and tilt have the variance 1.
    """
    columns = np.array([along**2, along * level, along * tilt, level**2, level * tilt, tilt**2])
    square, by_level, by_tilt, a, b, c = columns @ (1 / np.maximum(spread, TINY)).T
    a, c = 1 + a, 1 + c
    free, determinant = square + np.log(spread).sum(axis=1), a * c - b**2
    both = (c * by_level**2 - 2 * b * by_level * by_tilt + a * by_tilt**2) / determinant
    return -0.5 * (free - by_level**2 / a + np.log(a)), -0.5 * (free - both + np.log(determinant))


_EXACT = 1e-7
"""Share of the range of the force to which models are computed: data without noise have this error."""
_PARTS = 12
"""Beginnings of a record that are compared with the whole: a grid."""
_NOTHING = 1e8
"""Variance of a mean that counts for nothing, over the range squared."""
_CALM, _STIFF = 7, 0.05
"""Means of the running median before a force is differentiated, and the least share of an error that a cantilever leaves."""


@dataclass(frozen=True, slots=True)
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
    _risen: dict[bool, tuple[Array, Array]] = field(default_factory=dict)
    _passed: dict[tuple[Noise, bool], Whitening] = field(default_factory=dict)

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
    def quiet(self) -> Array:
        """Variance of the white noise of the means, over the range squared."""
        return np.asarray((self.noise**2 / self.counts + (self.step * ROUNDED) ** 2) / self.range**2 + _EXACT**2)

    def risen(self, tilt: bool) -> tuple[Array, Array]:
        """Size of the force over its first fifth, and the factor by which an error of the model moves it less.

        Behind a cantilever an error at a depth moves the force at a position of the base less.
        """
        if tilt not in self._risen:
            over, k = self.y, self.objective.spring
            if tilt and "baseline" in self.objective.nuisance:
                over = over_line(self.x, over)
            give = np.ones(self.size)
            if k is not None:
                steep = np.abs(np.gradient(median_filter(over, _CALM, mode="nearest"), self.x))
                steep *= self.range / float(np.ptp(self.objective.position))
                give = np.clip(1 - median_filter(steep, _CALM, mode="nearest") / k, _STIFF, 1)
            self._risen[tilt] = np.abs(over), give
        return self._risen[tilt]

    @property
    def bent(self) -> float:
        """How far the cantilever is bent by the force without contact [m]."""
        return 0.0 if self.objective.spring is None else self.level / self.objective.spring

    def with_tilt(self, tilt: bool) -> Objective:
        """The problem with or without a tilt of the background."""
        wanted = set(self.objective.nuisance) - {"tilt"} | ({"tilt"} if tilt else set())
        return replace(self.objective, nuisance=tuple(n for n in NUISANCE if n in wanted), _before={})

    def white(self, noise: Noise, gone: Flags | None = None, *, share: bool = True) -> Array:
        """Factor that makes the means over level and tilt independent with variance 1: (n,) if they are so, else (n, n).

        Means that are `gone` count for nothing. Unless `share` the model is taken for exact but for its stated error.
        """
        over, give = self.risen(noise.background.tilt)
        variance = self.quiet
        if share:
            variance = variance + (SHARE * over * give) ** 2
        if noise.error:
            rise = np.maximum.accumulate(median_filter(over, 3, mode="nearest"))
            rise /= max(float(rise[-1]), TINY)
            variance = variance + noise.error**2 * rise * give**2
        if gone is not None:
            variance = np.where(gone, _NOTHING, variance)
        if noise.background.size == 0:
            return np.asarray(variance**-0.5)
        covariance = noise.background.covariance(self.x)
        covariance[np.diag_indices(self.size)] += variance
        factor = scipy.linalg.cholesky(covariance, lower=True, overwrite_a=True, check_finite=False)
        return np.asarray(scipy.linalg.lapack.dtrtri(factor, lower=1, overwrite_c=True)[0])

    def passed(self, noise: Noise, *, share: bool = True) -> Whitening:
        """The means one after the other over a noise, see `white`."""
        if (noise, share) not in self._passed:
            terms = self.terms if noise.background.tilt else self.terms[:, :-1]
            self._passed[noise, share] = whitening(self.white(noise, share=share), terms)
        return self._passed[noise, share]

    @cached_property
    def terms(self) -> Array:
        """Level, tilt and drag as far as they are fitted, over the ranges, shape (n, k); the tilt comes last."""
        columns = [np.ones(self.size)] if "baseline" in self.objective.nuisance else []
        if self.objective.speed is not None and "drag" in self.objective.nuisance:
            columns.append(self.objective.speed / self.objective.frame.speed)
        return np.array([*columns, self.x]).T

    def worths(self, noise: Noise, force: Array | None = None) -> Array:
        """Logarithms of the likelihood of one contact, of forces over the range, for every end of the described range."""
        passed = self.passed(noise)
        return passed.background(
            passed.innovations(self.y[:, None] if force is None else (self.y - force)[:, None])[:, 0]
        )

    def learnt(self, touch: int, *, smooth: bool = True, tilt: bool = True, given: bool | None = None) -> Background:
        """The background that the first means show beside a drag that is fitted, see `likeliest`."""
        y, terms = self.y[:touch], self.terms[:touch, :-1]
        if touch and terms.shape[1] > 1:
            y = y - terms @ np.linalg.lstsq(terms, y, rcond=None)[0]
        return likeliest(self.x[:touch], y, self.quiet[:touch], smooth=smooth, tilt=tilt, given=given)

    @cached_property
    def alone(self) -> Array:
        """Logarithms of the likelihood of the first means, of a record that is a background of any size alone."""
        return self.worths(Noise(likeliest(self.x, self.y, self.quiet, bound=False)))

    @cached_property
    def quieter(self) -> float:
        """How much better the background of a beginning describes it than that of the whole, where that is most [logarithm].

        Without contact, all of the record is of one kind.
        """
        parts = np.unique(np.geomspace(LEARNT, max(self.size - LEARNT, LEARNT), _PARTS).astype(int))
        gains = [
            self.worths(Noise(self.learnt(n)))[n - 1] - self.alone[n - 1] for n in parts[parts <= self.size].tolist()
        ]
        return float(max(gains, default=0.0))

    def minimum(self, objective: Objective, x: Array, limits: tuple[Array, Array], end: int, white: Array) -> Minimum:
        """Least squares over the first means."""
        part = objective.first(end, white)
        return minimise(part.evaluate, x, *limits, settled=0.05, steps=25)


@dataclass(frozen=True, eq=False)
class Whitening:
    """Means one after the other, each compared with what those before it predict (Kalman's filter of constants).

    Attributes
    ----------
    factor : ndarray, shape (n,) or (n, n)
        Makes the means white over terms that are known.
    terms, gains : ndarray, shape (n, k)
        Terms as large as the range, made white, and what each mean takes of them from those before it.
    spread : ndarray, shape (n,)
        Standard deviation of a mean, of which the terms are not known before the first.
    """

    factor: Array
    terms: Array
    gains: Array
    spread: Array

    def innovations(self, columns: Array) -> Array:
        """Columns (n, m) made white."""
        columns = columns * self.factor[:, None] if self.factor.ndim == 1 else self.factor @ columns
        left = columns.copy()
        for term, gain in zip(self.terms.T, self.gains.T, strict=True):
            left[1:] -= gain[1:, None] * np.cumsum(term[:-1, None] * columns[:-1], axis=0)
        return np.asarray(left / self.spread[:, None])

    def background(self, y: Array) -> Array:
        """Logarithm of the likelihood of the first means without contact, from their innovations (n,).

        A mean beyond the last may be anywhere within the range.
        """
        diagonal = self.factor if self.factor.ndim == 1 else np.diag(self.factor)
        return np.asarray(np.cumsum(np.log(diagonal / self.spread) - 0.5 * np.log(2 * np.pi) - 0.5 * y * y))


def whitening(factor: Array, terms: Array) -> Whitening:
    """The filter of a factor and of terms (n, k) as large as the range."""
    terms = terms * factor[:, None] if factor.ndim == 1 else factor @ terms
    before = np.zeros((*terms.shape, terms.shape[1]))
    np.cumsum(terms[:-1, :, None] * terms[:-1, None, :], axis=0, out=before[1:])
    gains = np.asarray(np.linalg.solve(np.eye(terms.shape[1]) + before, terms[:, :, None])[:, :, 0], dtype=float)
    return Whitening(factor, terms, gains, np.asarray(np.sqrt(1 + (gains * terms).sum(axis=1))))
