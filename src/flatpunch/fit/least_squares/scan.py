"""Where to start: all contact points are tried, amplitude and background by linear least squares.

For a contact point z0 the force is a M(d - z0) + B, linear in its amplitude a and in the background B. With the background
projected out, a = (M, F)/(M, M), and the sum of squares falls by (M, F)^2/(M, M). No offset or tilt of the force changes
which contact point is best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import ROUNDING, TINY, Array
from flatpunch.fit.least_squares.blocks import towards_the_end
from flatpunch.fit.least_squares.objective import Objective

FARTHEST = 10.0
"""Contact points are looked for this far before the first point, over the range of depths; a ceiling."""
_BEFORE = (0.03, 0.1, 0.3, 1.0, 3.0, FARTHEST)
"""Contact points before the first point that are tried, over the range of depths."""
_TURNS = 6
"""Scans in which the shape of the force curve, or the background behind a cantilever, must settle."""


@dataclass(frozen=True, eq=False)
class Scan:
    """The best contact point.

    Attributes
    ----------
    x : ndarray
        Start for a descent.
    cost, without : float
        Sum of squares there, and that of the background alone, both over the force range squared.
    turned : float
        Sum of squares of the best contact with a negative amplitude.
    freedom : int
        Block means less parameters.
    settled : bool
        Whether x is a minimum already.
    """

    x: Array
    cost: float
    without: float
    turned: float
    freedom: int
    settled: bool = False

    @property
    def gain(self) -> float:
        """What a contact of either sign explains beyond the background, over the variance of the noise."""
        return self.over(self.without)

    def over(self, without: float) -> float:
        """What a contact of either sign explains beyond what leaves this sum of squares, over the variance of the noise."""
        best = min(self.cost, self.turned)
        return (without - best) / max(best / self.freedom, TINY)

    def contact(self, objective: Objective) -> float:
        """Contact point [m]."""
        return objective.split(self.x)[1]["contact"]


def scanned(objective: Objective, start: Array, moduli: Sequence[int], between: tuple[float, float]) -> Scan:
    """Try contact points between two [m], for all points of the approach.

    `start` has internal parameters, and a wavelength of the background behind the nuisance parameters if it has one; the
    amplitude of the contact goes into the entries `moduli`.
    """
    coarse = towards_the_end(objective)
    theta = start[: len(objective.model.free)].copy()
    if coarse.spring is None or not {"tilt", "drag"} & set(coarse.nuisance):
        return _settled(coarse, coarse.depth, theta, start[theta.size :], moduli, between)
    # share of the way that shows the tilt by itself, to start from
    early = objective.position < objective.frame.first + 0.15 * objective.frame.way
    slope = _slope(objective.position[early], objective.force[early])
    starts = (slope * (coarse.position - coarse.frame.first), np.zeros_like(coarse.depth))
    found = (_consistent(coarse, moving, theta, start[theta.size :], moduli, between) for moving in starts)
    return min(found, key=lambda scan: scan.cost)


def _slope(position: Array, force: Array) -> float:
    """Slope of the straight line through points [N/m]; 0 where there are hardly any."""
    if position.size < 3:
        return 0.0
    along = position - position.mean()
    return float(along @ force) / max(float(along @ along), TINY)


def _consistent(
    coarse: Objective, moving: Array, theta: Array, rest: Array, moduli: Sequence[int], between: tuple[float, float]
) -> Scan:
    """Scan behind a cantilever whose detector reads a tilt or drag that moves no tip.

    The tip's depth follows from that background, and the background from a scan at that depth: a fixed point, found by
    secants (Anderson's acceleration with one earlier step).
    """
    assert coarse.spring is not None
    before: tuple[Array, Array] | None = None
    for _ in range(_TURNS):
        scan = _settled(coarse, coarse.depth + moving / coarse.spring, theta, rest, moduli, between)
        miss = coarse.background(coarse.split(scan.x)[1], coarse.position, coarse.speed) - moving
        # change of that background over the force range at which it has settled
        if np.abs(miss).max() < 0.01 * coarse.frame.span:
            break
        last = (moving, miss)
        moving = moving + miss
        if before is not None:
            change = last[1] - before[1]
            part = float(change @ last[1]) / max(float(change @ change), TINY)
            moving = moving - part * (last[0] - before[0] + change)
        before, theta = last, scan.x[: theta.size]
    return scan


def _settled(
    coarse: Objective, depth: Array, theta: Array, rest: Array, moduli: Sequence[int], between: tuple[float, float]
) -> Scan:
    """Scans at given depths until the modulus, and with it the shape of the force curve, is about right."""
    tried = _candidates(coarse, depth, between)
    for _ in range(_TURNS):
        found, shift = _one_scan(coarse, depth, theta, rest, moduli, tried)
        theta = found.x[: theta.size]
        # largest change of ln E for which the shape of the force curve is not computed again
        if not moduli or abs(shift) < 0.5 or not coarse.model.bends:
            break
    if tried.size < 2:
        return found
    # between the neighbours of the best
    ordered = np.sort(tried)
    best = int(np.argmin(np.abs(ordered - found.contact(coarse))))
    # contact points tried between the neighbours of the best
    finer = np.linspace(ordered[max(best - 1, 0)], ordered[min(best + 1, ordered.size - 1)], 9)
    again = _one_scan(coarse, depth, theta, rest, moduli, finer)[0]
    return replace(again if again.cost < found.cost else found, turned=min(found.turned, again.turned))


def _one_scan(
    coarse: Objective, depth: Array, theta: Array, rest: Array, moduli: Sequence[int], candidates: Array
) -> tuple[Scan, float]:
    origin, width, span, level, *_ = coarse.frame
    assert coarse.counts is not None
    inside = depth - candidates[:, None]
    model = np.zeros_like(inside)
    touching = inside > 0
    if touching.any():
        model[touching] = coarse.model.evaluate(inside[touching], theta)[0] / span
    given = np.zeros(len(coarse.names))
    given[theta.size :] = rest
    values = coarse.split(given)[1]
    fitted = [n for n in coarse.nuisance if n in ("baseline", "tilt", "sine", "cosine", "drag")]
    held = coarse.background({**values, **dict.fromkeys(fitted, 0.0)}, coarse.position, coarse.speed)
    fixed = level if "baseline" in fitted else values["baseline"]
    weight = np.sqrt(coarse.counts)
    data = weight * (coarse.force - fixed - held) / span
    columns = np.array([weight * coarse.column(n, values, coarse.position, coarse.speed) for n in fitted])
    basis = np.linalg.qr(columns.T)[0] if fitted else np.zeros((data.size, 0))
    steepness = model.max(axis=1) * span / np.maximum(inside.max(axis=1), TINY)
    model *= weight
    square, along, total = beside(basis, model, data)
    # readings that must be in contact, or any curve fits them
    usable = (touching * coarse.counts).sum(axis=1) >= 4
    gain = np.where(usable, along**2 / square, 0.0)
    up = np.where(along > 0, gain if moduli else 2 * along - square, -np.inf)
    best = int(np.argmax(up))
    falls = along < 0
    if coarse.spring is not None:
        # S < 0 behind a cantilever whose force has its sign turned is S/(1 + 2 S/k) > -k/2 over the position without the turn;
        # -k is the position's own noise, F = k (p - depth)
        falls &= -along / square * steepness < 0.75 * coarse.spring
    down = float(np.max(np.where(falls, gain, 0.0), initial=0.0))
    amplitude = max(float(along[best] / square[best]), ROUNDING) if moduli and up[best] > 0 else 1.0
    end = theta.copy()
    for j in moduli:
        end[j] += np.log(amplitude) / len(moduli)
    x = np.append(end, rest)
    if fitted:
        coefficients = np.linalg.lstsq(columns.T, data - amplitude * model[best], rcond=None)[0]
        for name, value in zip(fitted, coefficients, strict=True):
            x[coarse.names.index(name)] = value
    if "contact" in coarse.nuisance:
        x[coarse.names.index("contact")] = (candidates[best] - origin) / width
    freedom = max(data.size - len(fitted) - 2, 1)
    return Scan(x, total - max(float(up[best]), 0.0), total, total - down, freedom), float(np.log(amplitude))


def beside(basis: Array, shapes: Array, data: Array) -> tuple[Array, Array, float]:
    """Squares of shapes (shapes, n), products with the data, and the data's square, all without what the background explains.

    `basis` has orthonormal terms of the background, shape (n, terms); a combination of them has an infinite square.
    """
    left = data - basis @ (basis.T @ data)
    reduced = shapes - (shapes @ basis) @ basis.T
    square = np.einsum("ij,ij->i", reduced, reduced)
    square = np.where(square > ROUNDING * np.einsum("ij,ij->i", shapes, shapes), square, np.inf)
    return square, reduced @ left, float(left @ left)


def _candidates(coarse: Objective, depth: Array, between: tuple[float, float]) -> Array:
    """Contact points to try: the blocks, some points before them, and the ends of the range if it is narrow."""
    if "contact" not in coarse.nuisance:
        return np.array([coarse.held["contact"]])
    first, width = float(depth.min()), float(np.ptp(depth))
    tried = np.concatenate([first - width * np.array(_BEFORE), depth])
    inside = tried[(tried >= between[0]) & (tried <= between[1])]
    if inside.size < 12:
        low, high = (float(np.clip(v, first - width, first + width)) for v in between)
        return np.append(inside, np.linspace(low, high, 24))
    return inside
