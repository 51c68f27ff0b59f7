"""Modulus, contact point and background of many curves at once.

Each approach is reduced to blocks of consecutive readings. Of a block its mean, the spread of its positions and the covariance
of force and position are kept, as two points

    p = <p> -+ s,    F = <F> -+ cov(p, F)/s,    s^2 = var p,

each of half of its weight: their sum of squares against a model that is linear within the block is that of all readings, up to
a constant. Then all curves are scanned for their contact points, and descend by Gauss-Newton, side by side.

Only what is plain is fitted here: a curve with anything to judge (adhesion, saturation, a wave, a short contact, a poor
minimum) is left to the fit of single curves.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.least_squares.blocks import CONTACT, FREE
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.measured.segments import approach, forwards, without_pause
from flatpunch.fit.parameters.settings import Settings

_SCANNED = 48
"""Blocks, and contact points, of a scan."""
_NODES = 2048
"""Points at which the force is tabulated for scans."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """An approach, its readings and the blocks they are reduced to.

    Attributes
    ----------
    curve : Curve
        The approach.
    position, force : ndarray, shape (n,)
        Position of the cantilever's base (of the tip without one) [m], force [N].
    edges : ndarray of int, shape (blocks + 1,)
        Readings at which blocks begin.
    mean, spread, level, slope : ndarray, shape (blocks,)
        <p> and s [m], <F> [N], cov/s^2 [N/m].
    off : ndarray, shape (n,)
        Position over the mean of its block [m].
    """

    curve: Curve
    position: Array
    force: Array
    edges: Indices
    mean: Array
    spread: Array
    level: Array
    slope: Array
    off: Array

    @property
    def counts(self) -> Array:
        """Readings of each block."""
        return np.diff(self.edges).astype(float)

    def spreaded(self, values: Array) -> Array:
        """One value a block, repeated for its readings."""
        return np.repeat(values, np.diff(self.edges))


def reduced(curve: Curve, position: Array, edges: Indices) -> Reduced:
    """Reduce an approach to blocks."""
    counts, first = np.diff(edges), edges[:-1]
    force = curve.force
    mean, level = (np.add.reduceat(c, first) / counts for c in (position, force))
    off = position - np.repeat(mean, counts)
    variance = np.add.reduceat(off * off, first) / counts
    slope = np.add.reduceat(off * force, first) / counts / np.maximum(variance, 1e-300)
    return Reduced(curve, position, force, edges, mean, np.sqrt(variance), level, slope, off)


@dataclass(frozen=True, eq=False)
class Found:
    """A fitted curve of many.

    Attributes
    ----------
    data : Reduced
    x : ndarray, shape (2 or more,)
        ln E, contact point [m], and the baseline [N] and tilt [N/m] as far as they are fitted.
    variances : ndarray
        Of x, over the variance of the noise [N^2].
    residual : ndarray, shape (n,)
        Measured minus fitted force of all readings [N].
    fitted : ndarray, shape (blocks,)
        Fitted force at the means of the blocks [N].
    """

    data: Reduced
    x: Array
    variances: Array
    residual: Array
    fitted: Array


def at_once(curves: Sequence[Curve], model: ForwardModel, settings: Settings) -> list[Found | None]:
    """Fit curves side by side; None for those that are no plain ones.

    Parameters
    ----------
    curves : sequence of Curve
    model : ForwardModel
        One modulus is free.
    settings : Settings
        Contact point fitted, baseline "constant", "linear" or "none", least squares.
    """
    parts = [_plain(curve) for curve in curves]
    result: list[Found | None] = [None] * len(curves)
    for springy in (False, True):
        chosen = [
            (i, part)
            for i, part in enumerate(parts)
            if part is not None and (part.spring_constant is not None) == springy
        ]
        if chosen:
            for place, found in _side_by_side(chosen, model, settings):
                result[place] = found
    return result


def supported(model: object, settings: Settings) -> bool:
    """Whether a case can be fitted side by side at all."""
    return (
        isinstance(model, ForwardModel)
        and len(model.free) == 1
        and model.free[0].endswith("young")
        and settings.contact == "free"
        and settings.baseline in ("constant", "linear", "none")
        and settings.loss == "linear"
        and settings.drag == 0
        and settings.depth_to is None
        and settings.force_to is None
        and settings.engine == "normal-equations"
        and settings.segment in ("auto", "approach")
    )


def _plain(curve: Curve) -> Curve | None:
    """The approach of a curve that has nothing unusual about its position."""
    if curve.meta.get("calibration"):
        return None
    try:
        curve, notes = forwards(curve)
        part = None if notes else without_pause(approach(curve))
    except CurveError:
        return None
    return part if part is not None and part.depth.size >= 4 * _SCANNED else None


def _side_by_side(
    chosen: Sequence[tuple[int, Curve]], model: ForwardModel, settings: Settings
) -> Iterator[tuple[int, Found]]:
    places = [place for place, _ in chosen]
    positions = [part.position for _, part in chosen]
    coarse = [
        reduced(part, position, _equal(position.size, _SCANNED))
        for (_, part), position in zip(chosen, positions, strict=True)
    ]
    fitted = ["baseline"] * (settings.baseline != "none") + ["tilt"] * (settings.baseline == "linear")
    starts, good = _scan(coarse, model, fitted)
    fine = []
    for i in np.flatnonzero(good).tolist():
        part, position = chosen[i][1], positions[i]
        end = _in_readings(position, starts[i, -1])
        if position.size - end < CONTACT // 2:
            good[i] = False
            continue
        fine.append(reduced(part, position, _edges(position.size, end)))
    if not fine:
        return
    batch = _Batch(model, fine, fitted)
    x, normal, ahead, good_end = batch.descend(starts[good, :-1])
    variances = _variances(normal)
    for data, row, n, a, converged, i in zip(
        fine, x, variances, ahead, good_end, np.flatnonzero(good).tolist(), strict=True
    ):
        if converged:
            low, high = a.reshape(2, -1)
            middle, rise = (low + high) / 2, (high - low) / (2 * np.maximum(data.spread, 1e-300))
            residual = data.force - data.spreaded(middle) - data.spreaded(rise) * data.off
            yield places[i], Found(data, row, n, residual, middle)


def _in_readings(position: Array, contact: float) -> int:
    """First reading beyond a position."""
    return int(np.searchsorted(np.maximum.accumulate(position), contact))


def _edges(size: int, contact: int) -> Indices:
    """Blocks of readings: few before the contact, many from somewhat before it."""
    begin = max(contact - (size - contact) // 4, 0)
    return np.append(_equal(begin, min(FREE, begin))[:-1], begin + _equal(size - begin, CONTACT // 2))


def _equal(size: int, parts: int) -> Indices:
    """Where equal parts of so many readings begin, and their end."""
    return np.arange(parts + 1) * size // max(parts, 1)


def _scan(coarse: Sequence[Reduced], model: ForwardModel, fitted: Sequence[str]) -> tuple[Array, Flags]:
    """Best contact points; rows of starts (x, then the position of the contact), and which of them are plain."""
    k = np.array([c.curve.spring_constant or np.inf for c in coarse])[:, None]
    position, level = (np.array([getattr(c, name) for c in coarse]) for name in ("mean", "level"))
    counts = np.array([c.counts for c in coarse])
    depth = position - level / k
    if "tilt" in fitted and np.isfinite(k).all():
        early = max(_SCANNED // 8, 3)
        along = position[:, :early] - position[:, :early].mean(axis=1, keepdims=True)
        slope = np.sum(along * level[:, :early], axis=1) / np.sum(along**2, axis=1)
        depth = depth + slope[:, None] * (position - position[:, :1]) / k
    theta = np.full(len(coarse), float(model.start()[0]))
    for _ in range(4):
        best, better, contact, background, good = _tried(model, theta, depth, position, level, counts, fitted)
        shift, theta = better - theta, better
        if not model.bends or np.abs(shift[good]).max(initial=0.0) < 0.5:
            break
    rows = np.arange(len(coarse))
    place = position[rows, best]
    return np.column_stack([theta, contact, *background, place]), good


def _tried(
    model: ForwardModel, theta: Array, depth: Array, position: Array, level: Array, counts: Array, fitted: Sequence[str]
) -> tuple[Indices, Array, Array, list[Array], Flags]:
    """All block means as contact points; amplitude and background by linear least squares."""
    size = len(theta)
    best = np.zeros(size, dtype=np.intp)
    better, contact = theta.copy(), np.zeros(size)
    background: list[Array] = [np.zeros(size) for _ in fitted]
    good = np.zeros(size, dtype=bool)
    reach = float(np.ptp(depth, axis=1).max())
    grid = np.linspace(0, reach, _NODES)[1:]
    shapes: dict[float, Array] = {}
    for i in range(size):
        # scans take ln E in such steps where it changes the shape of the force curve
        near = 0.25 * round(theta[i] / 0.25) if model.bends else float(model.start()[0])
        if near not in shapes:
            shapes[near] = np.append(0.0, model.evaluate(grid, np.array([near]))[0])
        # blocks of the scan that the contact must cover at least
        inside = depth[i] - depth[i, :-5, None]
        at = np.maximum(inside, 0.0) * ((_NODES - 1) / reach)
        index = np.minimum(at.astype(np.intp), _NODES - 2)
        low = shapes[near].take(index)
        force = low + (at - index) * (shapes[near].take(index + 1) - low)
        root = np.sqrt(counts[i])
        data, force = root * level[i], force * root
        along = (position[i] - position[i, 0]) / (position[i, -1] - position[i, 0])
        columns = np.array([root * (np.ones_like(along) if name == "baseline" else along) for name in fitted])
        left, without = data, force
        if fitted:
            basis, corner = np.linalg.qr(columns.T)
            left = data - basis @ (basis.T @ data)
            without = force - (force @ basis) @ basis.T
        square = np.maximum(np.einsum("ij,ij->i", without, without), 1e-300)
        amount = without @ left
        gain = amount**2 / square
        up, down = np.where(amount > 0, gain, 0.0), np.where(amount < 0, gain, 0.0)
        j = int(np.argmax(up))
        # a contact that covers a tenth of the way, with as much before it, and presses upwards
        good[i] = bool(along[j] > 0.1 and j < up.size - 1 and up[j] > 2 * down.max())
        if good[i]:
            better[i] = near + np.log(amount[j] / square[j])
        best[i], contact[i] = j, depth[i, j]
        if 0 < j < up.size - 1:
            bend = up[j - 1] - 2 * up[j] + up[j + 1]
            step = 0.5 * (up[j - 1] - up[j + 1]) / bend if bend < 0 else 0.0
            side = depth[i, j + (1 if step > 0 else -1)] - depth[i, j]
            contact[i] += abs(step) * side
        if fitted:
            found = np.linalg.solve(corner, basis.T @ (data - amount[j] / square[j] * force[j]))
            for values, value, name in zip(background, found, fitted, strict=True):
                values[i] = value / (1.0 if name == "baseline" else position[i, -1] - position[i, 0])
    return best, better, contact, background, good


class _Batch:
    """Curves of equal numbers of pseudo-points, as rows of arrays."""

    def __init__(self, model: ForwardModel, data: Sequence[Reduced], fitted: Sequence[str]) -> None:
        self.model, self.fitted = model, fitted
        # rows of unequal numbers of blocks are filled up with points without weight
        width = 2 * max(d.mean.size for d in data)
        shape = (len(data), width)
        self.position, self.force, self.weight = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        self.sizes = [d.mean.size for d in data]
        for i, d in enumerate(data):
            n = 2 * d.mean.size
            step = d.slope * d.spread
            self.position[i, :n] = np.append(d.mean - d.spread, d.mean + d.spread)
            self.force[i, :n] = np.append(d.level - step, d.level + step)
            self.weight[i, :n] = np.tile(d.counts / 2, 2)
            self.position[i, n:], self.force[i, n:] = d.mean[0], d.level[0]
        self.first = np.array([[d.position.min()] for d in data])
        self.readings = np.array([d.force.size for d in data], dtype=float)
        self.spring = np.array([d.curve.spring_constant or np.inf for d in data])[:, None]
        self.along = self.position - self.first
        self.depth = self.position - self.force / self.spring

    def descend(self, x: Array) -> tuple[Array, Array, list[Array], Flags]:
        """Gauss-Newton from starts; x, normal matrices, fitted force at the points, and which have converged."""
        x = x.copy()
        residual = np.zeros_like(self.force)
        converged = np.zeros(len(x), dtype=bool)
        before = np.full(len(x), np.inf)
        lost = np.zeros(len(x), dtype=bool)
        # steps of Gauss-Newton after which a curve is left to the fit of single curves
        for turn in range(12):
            residual, jacobian = self._evaluated(x, residual)
            weighted = jacobian * self.weight[:, None, :]
            normal = weighted @ jacobian.transpose(0, 2, 1)
            gradient = (weighted @ residual[:, :, None])[:, :, 0]
            cost = np.sum(self.weight * residual**2, axis=1)
            # the first steps may climb
            lost |= (turn > 3) & (cost > 1.01 * before) | ~np.isfinite(cost)
            before = cost
            if (converged | lost).all():
                break
            step = -_solved(normal, gradient)
            size = np.einsum("bi,bij,bj->b", step, normal, step) * self.readings / np.maximum(cost, 1e-300)
            moving = ~lost & ~converged
            largest = np.maximum(np.abs(step[:, 0]), np.abs(step[:, 1]) / (0.3 * np.ptp(self.depth, axis=1)))
            step *= (1 / np.maximum(largest, 1.0))[:, None]
            x = np.where(moving[:, None], x + step, x)
            # A step this small against the standard errors is the last one
            converged |= moving & (size < 1e-3**2)
        ahead = [row[: 2 * n] for row, n in zip(self.force + residual, self.sizes, strict=True)]
        return x, normal, ahead, converged & ~lost

    def _evaluated(self, x: Array, residual: Array) -> tuple[Array, Array]:
        """Residuals [N] and their derivatives, with one step of Newton's method behind a cantilever."""
        extra = dict(zip(self.fitted, x[:, 2:].T, strict=True))
        level = extra.get("baseline", np.zeros(len(x)))[:, None]
        moving = extra.get("tilt", np.zeros(len(x)))[:, None] * self.along
        at = self.depth - x[:, 1:2] + (moving - residual) / self.spring
        force, stiffness, by_theta = self._force(at, x[:, 0])
        give = 1 + stiffness / self.spring
        miss = level + moving + force - self.force - np.where(np.isfinite(self.spring), residual, 0.0)
        residual = np.where(np.isfinite(self.spring), residual + miss / give, miss)
        jacobian = np.zeros((len(x), x.shape[1], self.force.shape[1]))
        jacobian[:, 0], jacobian[:, 1] = by_theta / give, -stiffness / give
        for j, name in enumerate(self.fitted, start=2):
            jacobian[:, j] = 1 / give if name == "baseline" else self.along
        return residual, jacobian

    def _force(self, at: Array, theta: Array) -> tuple[Array, Array, Array]:
        touching = at > 0
        force, stiffness, by_theta = (np.zeros_like(at) for _ in range(3))
        if self.model.bends:
            for i, row in enumerate(touching):
                found = self.model.evaluate(at[i, row], theta[i : i + 1])
                force[i, row], stiffness[i, row], by_theta[i, row] = found[0], found[1], found[2][0]
            return force, stiffness, by_theta
        # the modulus is a factor
        start = self.model.start()
        found = self.model.evaluate(at[touching], start)
        force[touching], stiffness[touching] = found[0], found[1]
        scale = np.exp(theta - start[0])[:, None]
        force *= scale
        stiffness *= scale
        return force, stiffness, force


def _variances(normal: Array) -> Array:
    """Diagonals of the inverse normal matrices; infinite for singular ones."""
    unit = 1 / np.sqrt(np.maximum(np.einsum("bii->bi", normal), 1e-300))
    scaled = normal * unit[:, :, None] * unit[:, None, :]
    try:
        inverse = np.einsum("bii->bi", np.linalg.inv(scaled))
    except np.linalg.LinAlgError:
        return np.full(unit.shape, np.inf)
    return np.asarray(inverse * unit**2)


def _solved(normal: Array, gradient: Array) -> Array:
    """Newton steps of all curves, in variables scaled to unit diagonal; a trace of damping keeps singular ones finite."""
    unit = 1 / np.sqrt(np.maximum(np.einsum("bii->bi", normal), 1e-300))
    scaled = normal * unit[:, :, None] * unit[:, None, :] + 1e-12 * np.eye(normal.shape[1])
    return np.asarray(unit * np.linalg.solve(scaled, (unit * gradient)[:, :, None])[:, :, 0])
