"""Noise of measured profiles taken out, and what a change of a profile does to the force on a half-space.

Heights are smoothed by local parabolas with Gaussian weights, from one kink to the next and at the apex from one side only.
Cones, spheres and edges keep their form. Where heights still fall afterwards they are averaged (isotonic regression); straight
lines between the middles of these averages leave no flat, which would act as a flat end.

A round tip with slope f'(r) has on a half-space, at contact radius a and for E* = 1, r = a sin t,

    depth = a int_0^(pi/2) f' dt,    force = 2 a^2 int_0^(pi/2) f' sin^2 t dt
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text

_FAR = 5.0
"""Standard deviations of the Gaussian beyond which points count for nothing: 4e-6 of the weight of the nearest."""


def smoothed_heights(r: Array, f: Array, width: float, cuts: list[int]) -> Array:
    """Measured heights [m], smoothed by a Gaussian of `width` [m] and rising from zero at the apex; slopes jump at `cuts`."""
    total, count = np.zeros(r.size), np.zeros(r.size)
    for i, j in pairwise([0, *cuts, r.size - 1]):
        part = slice(i, j + 1)
        total[part] += _local_parabolas(r[part], f[part], width)
        count[part] += 1
    found = scipy.optimize.isotonic_regression(total / count)
    if found.blocks.size < 3:
        return np.asarray(found.x - found.x[0])
    middles = np.add.reduceat(r, found.blocks[:-1]) / found.weights
    level = scipy.interpolate.make_interp_spline(middles, found.x[found.blocks[:-1]], k=1)(r)
    return np.asarray(level - level[0])


def _local_parabolas(r: Array, f: Array, width: float) -> Array:
    result = np.empty(r.size)
    for i, centre in enumerate(r):
        near = slice(*np.searchsorted(r, [centre - _FAR * width, centre + _FAR * width]))
        x = (r[near] - centre) / width
        weight = np.exp(-(x**2) / 4)
        rows = np.column_stack([weight, weight * x, weight * x**2])
        result[i] = np.linalg.lstsq(rows, weight * f[near], rcond=None)[0][0]
    return result


def what_smoothing_changed(width: float, change: Array) -> str:
    """A sentence about the change of heights [m] by a Gaussian of this width [m], whatever it did to the apex."""
    off = change - np.median(change)
    rms, largest = float(np.sqrt(np.mean(off**2))), float(np.abs(off).max())
    return f"The tip was smoothed over {text(width, 'm')}: heights changed by {text(rms, 'm')} rms, {text(largest, 'm')} at most."


def change_of_force(
    slope: Callable[[Array], Array], other: Callable[[Array], Array], reach: float
) -> tuple[float, float]:
    """Largest relative change of the half-space force between two slopes at equal depth up to a radius [m], and its depth [m]."""
    (depth, force), (depths, forces) = (_curve(each, reach) for each in (slope, other))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.exp(np.interp(np.log(depth), np.log(depths), np.log(forces))) / force
    known = np.isfinite(ratio) & (depth >= depths.min()) & (depth <= depths.max()) & (force > 0)
    if not known.any():
        return 0.0, 0.0
    at = int(np.argmax(np.where(known, np.abs(ratio - 1), 0.0)))
    return float(ratio[at] - 1), float(depth[at])


def _curve(slope: Callable[[Array], Array], reach: float) -> tuple[Array, Array]:
    """Depth and force for E* = 1 at 60 contact radii."""
    a = reach * np.geomspace(0.02, 1, 60)[:, None]
    # midpoints: jumps of the slope cost 1/n of their part
    n = 1000
    t = (np.arange(n) + 0.5) * (np.pi / 2 / n)
    steep = slope(a * np.sin(t))
    weight = np.pi / 2 / n
    return (a * steep).sum(axis=1) * weight, 2 * (a**2 * steep * np.sin(t) ** 2).sum(axis=1) * weight


def possible_kinks(r: Array, f: Array) -> list[int]:
    """Points at which the slope of the chords jumps by far more than it changes elsewhere."""
    bend = np.abs(np.diff(np.diff(f) / np.diff(r))) / ((r[2:] - r[:-2]) / 2)
    # nine tenths of the table are no kinks; noise and smooth profiles bend there at most two or three times as little
    usual = float(np.quantile(bend, 0.9, method="lower"))
    return (np.flatnonzero(bend > 3 * usual) + 1).tolist()
