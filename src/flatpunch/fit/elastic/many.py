"""Modulus, contact point and background of many curves at once.

Each approach is reduced to blocks of consecutive readings. Of a block its mean, the spread of its positions and the covariance
of force and position are kept, as two points

    p = <p> -+ s,    F = <F> -+ cov(p, F)/s,    s^2 = var p,

each of half of its weight: their sum of squares against a model that is linear within the block is that of all readings, up to
a constant. Then all curves are scanned for their contact points, and descend by Gauss-Newton, side by side.

Whether a curve has anything unusual is judged afterwards, as for single curves (`flatpunch.fit.many`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import ROUNDING, TINY, Array, Flags, Indices
from flatpunch.fit.elastic.model import ForwardModel
from flatpunch.fit.least_squares.blocks import CONTACT, FREE
from flatpunch.fit.measured.approach import Approach, approach_of
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.parameters.scaling import MODULI
from flatpunch.fit.parameters.settings import Baseline, Settings

_SCANNED = 48
"""Blocks, and contact points, of a scan."""
_NODES = 2048
"""Points at which the force is tabulated for scans."""


@dataclass(frozen=True, eq=False)
class Reduced:
    """An approach reduced to blocks.

    Attributes
    ----------
    spring : float
        Of its cantilever [N/m]; infinite without one.
    first : float
        Least position of the cantilever's base (of the tip without one) [m].
    counts : ndarray, shape (blocks,)
        Readings of each block.
    mean, spread, level, slope : ndarray, shape (blocks,)
        <p> and s [m], <F> [N], cov/s^2 [N/m].
    """

    spring: float
    first: float
    counts: Array
    mean: Array
    spread: Array
    level: Array
    slope: Array


def reduced(curve: Curve, position: Array, edges: Indices) -> Reduced:
    """Reduce an approach to blocks."""
    counts, first = np.diff(edges), edges[:-1]
    force = curve.force
    mean, level = (np.add.reduceat(c, first) / counts for c in (position, force))
    off = position - np.repeat(mean, counts)
    variance = np.add.reduceat(off * off, first) / counts
    slope = np.add.reduceat(off * force, first) / counts / np.maximum(variance, TINY)
    k = curve.spring_constant or np.inf
    return Reduced(k, float(position.min()), counts.astype(float), mean, np.sqrt(variance), level, slope)


Costs = tuple[float, float, float, int]


@dataclass(frozen=True, eq=False)
class Found:
    """A fitted curve of many.

    Attributes
    ----------
    x : ndarray, shape (2 or more,)
        ln E, contact point [m], and the baseline [N] and tilt [N/m] as far as they are fitted.
    baseline : str
        Which of them are.
    costs : tuple of float and int
        Of the scan: sum of squares, that of the background alone, that of the best contact of negative force, and freedom.
    """

    x: Array
    baseline: Baseline
    costs: Costs


def at_once(curves: Sequence[Curve], model: ForwardModel, settings: Settings) -> list[Found | None]:
    """Fit approaches of `plain` curves side by side; None for those whose search does not settle.

    One modulus is free; the contact point is fitted, the baseline "constant", "linear" or "none", by least squares.
    """
    result: list[Found | None] = [None] * len(curves)
    for springy in (False, True):
        chosen = [(i, curve) for i, curve in enumerate(curves) if (curve.spring_constant is not None) == springy]
        if chosen:
            for place, found in _side_by_side(chosen, model, settings):
                result[place] = found
    return result


def supported(model: object, settings: Settings) -> bool:
    """Whether a case can be fitted side by side at all."""
    return (
        isinstance(model, ForwardModel)
        and len(model.free) == 1
        and model.free[0].endswith(MODULI)
        and settings.contact == "free"
        and settings.baseline in ("auto", "constant", "linear", "none")
        and settings.loss == "linear"
        and settings.drag == 0
        and settings.depth_to is None
        and settings.force_to is None
        and settings.quick
        and settings.segment in ("auto", "approach")
        and settings.direction == "auto"
    )


def plain(curve: Curve) -> Approach | None:
    """Approach of a curve that can be reduced to blocks; None if it is too short, or its force or calibration is uncertain."""
    if curve.meta.get("calibration"):
        return None
    try:
        found = approach_of(curve)
        return found if found.pressing > 0 and found.part.depth.size >= 4 * _SCANNED else None
    except CurveError:
        return None


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
    starts, good, costs = _scan(coarse, model, fitted)
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
    x, converged = batch.descend(starts[good, :-1])
    for row, settled, i in zip(x, converged, np.flatnonzero(good).tolist(), strict=True):
        if settled:
            yield places[i], Found(row, settings.baseline, costs[i])


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


def _scan(coarse: Sequence[Reduced], model: ForwardModel, fitted: Sequence[str]) -> tuple[Array, Flags, list[Costs]]:
    """Best contact points: starts (x, then the position of the contact), which of them are inner ones, sums of squares."""
    k = np.array([c.spring for c in coarse])[:, None]
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
        best, better, contact, background, good, costs = _tried(model, theta, depth, position, level, counts, fitted)
        shift, theta = better - theta, better
        if not model.bends or np.abs(shift[good]).max(initial=0.0) < 0.5:
            break
    rows = np.arange(len(coarse))
    place = position[rows, best]
    return np.column_stack([theta, contact, *background, place]), good, costs


def _tried(
    model: ForwardModel, theta: Array, depth: Array, position: Array, level: Array, counts: Array, fitted: Sequence[str]
) -> tuple[Indices, Array, Array, list[Array], Flags, list[Costs]]:
    """All block means as contact points; amplitude and background by linear least squares."""
    size = len(theta)
    best = np.zeros(size, dtype=np.intp)
    better, contact = theta.copy(), np.zeros(size)
    background: list[Array] = [np.zeros(size) for _ in fitted]
    good, costs = np.zeros(size, dtype=bool), []
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
        square = np.maximum(np.einsum("ij,ij->i", without, without), TINY)
        amount = without @ left
        gain = amount**2 / square
        up, down = np.where(amount > 0, gain, 0.0), np.where(amount < 0, gain, 0.0)
        j = int(np.argmax(up))
        total = float(left @ left)
        costs.append((total - float(up[j]), total, total - float(down.max()), data.size - len(fitted) - 2))
        good[i] = bool(0 < j < up.size - 1 and up[j] > 0)
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
    return best, better, contact, background, good, costs


class _Batch:
    """Curves of equal numbers of pseudo-points, as rows of arrays."""

    def __init__(self, model: ForwardModel, data: Sequence[Reduced], fitted: Sequence[str]) -> None:
        self.model, self.fitted = model, fitted
        # rows of unequal numbers of blocks are filled up with points without weight
        width = 2 * max(d.mean.size for d in data)
        shape = (len(data), width)
        self.position, self.force, self.weight = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        for i, d in enumerate(data):
            n = 2 * d.mean.size
            step = d.slope * d.spread
            self.position[i, :n] = np.append(d.mean - d.spread, d.mean + d.spread)
            self.force[i, :n] = np.append(d.level - step, d.level + step)
            self.weight[i, :n] = np.tile(d.counts / 2, 2)
            self.position[i, n:], self.force[i, n:] = d.mean[0], d.level[0]
        self.first = np.array([[d.first] for d in data])
        self.readings = np.array([d.counts.sum() for d in data])
        self.spring = np.array([d.spring for d in data])[:, None]
        self.along = self.position - self.first
        self.depth = self.position - self.force / self.spring

    def descend(self, x: Array) -> tuple[Array, Flags]:
        """Gauss-Newton from starts; x, and which have converged."""
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
            size = np.einsum("bi,bij,bj->b", step, normal, step) * self.readings / np.maximum(cost, TINY)
            moving = ~lost & ~converged
            largest = np.maximum(np.abs(step[:, 0]), np.abs(step[:, 1]) / (0.3 * np.ptp(self.depth, axis=1)))
            step *= (1 / np.maximum(largest, 1.0))[:, None]
            x = np.where(moving[:, None], x + step, x)
            # A step this small against the standard errors is the last one
            converged |= moving & (size < 1e-3**2)
        return x, converged & ~lost

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


def _solved(normal: Array, gradient: Array) -> Array:
    """Newton steps of all curves, in variables scaled to unit diagonal; a trace of damping keeps singular ones finite."""
    unit = 1 / np.sqrt(np.maximum(np.einsum("bii->bi", normal), TINY))
    scaled = normal * unit[:, :, None] * unit[:, None, :] + ROUNDING * np.eye(normal.shape[1])
    return np.asarray(unit * np.linalg.solve(scaled, (unit * gradient)[:, :, None])[:, :, 0])
