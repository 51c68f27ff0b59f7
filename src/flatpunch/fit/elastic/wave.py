"""The wavelength of a wave on the background, found together with the contact.

Looked for before a contact that was placed without the wave, the wave has to explain the beginning of the contact as well, and
half a period over the whole way does so best. Here every wavelength is tried with every contact point.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.fit.elastic.background import WAVES
from flatpunch.fit.least_squares.blocks import uniform
from flatpunch.fit.least_squares.objective import Objective
from flatpunch.fit.least_squares.scan import beside

_TURNS = 3
"""Searches, each with the moduli of the one before: behind a cantilever they decide the shape over the position."""


def best_wavelength(plain: Objective, x: Array, moduli: Sequence[int], between: tuple[float, float]) -> float:
    """Wavelength of the sine that, beside a straight line and a contact, fits best [m].

    `plain` has all points of the approach and a straight background, x its best contact; the amplitude goes into the entries
    `moduli`.
    """
    theta = plain.split(x)[0].copy()
    index = uniform(plain.position, min(WAVES, plain.position.size // 4))
    size = np.bincount(index).astype(float)
    filled = size > 0
    position, force = ((np.bincount(index, c)[filled] / size[filled]) for c in (plain.position, plain.force))
    position, weight = position - plain.frame.first, np.sqrt(size[filled])
    data, way = weight * (force - force.mean()), float(np.ptp(position))
    # half a period and less is a bend, and a wave needs five stretches
    tried = way / np.linspace(0.4, size.size / 5, 400)
    bent = 0.0 if plain.spring is None else float(plain.split(x)[1]["baseline"]) / plain.spring
    places = position[(position + plain.frame.first >= between[0] + bent) & (position[-1] > position)]
    if not places.size:
        places = position[:1]
    best = tried[0]
    for _ in range(_TURNS):
        shapes = weight * _over_position(plain, theta, position - places[:, None])
        least = np.inf
        for wavelength in tried:
            phase = 2 * np.pi * position / wavelength
            columns = np.array([np.ones_like(phase), position / way, np.sin(phase), np.cos(phase)]) * weight
            basis = np.linalg.qr(columns.T)[0]
            square, along, total = beside(basis, shapes, data)
            gain = np.where(along > 0, along**2 / square, 0.0)
            at = int(np.argmax(gain))
            cost = total - float(gain[at])
            if cost < least:
                least, best, amplitude = cost, wavelength, float(along[at] / square[at]) if gain[at] else 1.0
        if not moduli:
            break
        for j in moduli:
            theta[j] += np.log(amplitude) / len(moduli)
    return float(best)


def _over_position(plain: Objective, theta: Array, inside: Array) -> Array:
    """Force of the contact over how far the cantilever's base (without one: the tip) has moved since it began."""
    result = np.zeros_like(inside)
    touching = inside > 0
    if plain.spring is None:
        result[touching] = plain.model.evaluate(inside[touching], theta)[0]
        return result
    depth = np.linspace(0, 1, 400)[1:] ** 2 * float(inside.max())
    force = plain.model.evaluate(depth, theta)[0]
    result[touching] = np.interp(inside[touching], np.append(0, depth + force / plain.spring), np.append(0, force))
    return result
