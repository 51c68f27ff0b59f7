"""Force over time for a prescribed depth, linear between the given times."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.contact.viscoelastic.elastic import ElasticForce
from flatpunch.contact.viscoelastic.monotone import last_rise, one_cycle
from flatpunch.contact.viscoelastic.response import SECOND_ORDER, TOLERANCE, Response
from flatpunch.contact.viscoelastic.series import ExponentialSeries, exponential_series
from flatpunch.contact.viscoelastic.springs import SPRINGS, Springs
from flatpunch.media.relaxation import Relaxation


def force_of_depth(time: Array, depth: Array, relaxation: Relaxation, elastic: ElasticForce) -> Response:
    """Follow a history of depths [m], negative above the surface and somewhere positive, at ascending times [s].

    One rise and one fall are solved by Lee-Radok and Ting, which is faster, as long as the contact then only shrinks; everything
    else by springs.
    """
    series = exponential_series(relaxation, float(np.diff(time).min()), float(time[-1] - time[0]))
    pressed = np.maximum(depth, 0.0)
    if (np.diff(pressed[last_rise(pressed) :]) <= 0).all():
        force, contact, error = one_cycle(time, depth, relaxation, series, elastic, TOLERANCE)
        if error.max() <= 2 * TOLERANCE * np.abs(force).max():
            return Response(depth, force, contact, error)
    return by_springs(time, depth, series, elastic)


def by_springs(time: Array, depth: Array, series: ExponentialSeries, elastic: ElasticForce) -> Response:
    """Follow the depth by springs, as many as the tolerance takes."""
    count = SPRINGS
    while True:
        force, rough, contact = followed(Springs(elastic, series, float(depth.max()), count), time, depth).T
        error = SECOND_ORDER * np.abs(force - rough)
        if error.max() <= TOLERANCE * force.max() or count >= 2**4 * SPRINGS:
            # second order in the number of springs: half as many are off by four times as much
            return Response(depth, np.maximum(force + (force - rough) / 3, 0.0), contact, error)
        count *= 2


def followed(springs: Springs, time: Array, depth: Array) -> Array:
    """Force of all springs and of every other one, and contact depth, shape (n, 3)."""
    result = np.empty((time.size, 3))
    result[0] = springs.jump(float(depth[0]))
    steps = np.diff(time)
    for n, (step, rate) in enumerate(zip(steps.tolist(), (np.diff(depth) / steps).tolist(), strict=True)):
        ahead = springs.ahead(step)
        end = springs.end(ahead, rate)
        springs.move(ahead, end)
        result[n + 1] = end.force, end.coarse, end.extent
    return result
