"""An approach on some hundred means, its contact and its background together, and what in it the model does not describe.

    F = A s(p - c) + b(p) + e + m

over the position p of the cantilever's base: s the model's force at its present parameters, c the contact point, b the
background (`background`), e white noise, m the model's own error, white and in proportion to the force that has been reached. A
factor W with W C W^T = 1, C the covariance of b + e + m, makes readings and candidates white. It is triangular: the first n rows
are the factor of the first n means, so that the likelihood of every contact and of every end of the described range comes from
running sums of the same products.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy
from scipy.ndimage import median_filter

from flatpunch._support.checks import TINY, Array, Flags, Indices
from flatpunch.fits.judge.background import LEARNT, Background, likeliest
from flatpunch.fits.least_squares.minimum import Minimum, minimise
from flatpunch.fits.least_squares.objective import Objective
from flatpunch.fits.measured.signal import ROUNDED, SHARE, over_line
from flatpunch.fits.parameters.sample import NUISANCE

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

    @property
    def zero(self) -> Array:
        """Unknowns at the model's starting values."""
        return self.zero_of(self.objective)

    def zero_of(self, objective: Objective) -> Array:
        """Unknowns of a problem at the model's starting values."""
        return np.append(objective.model.start(), np.zeros(len(objective.nuisance)))

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
