"""Contacts that are tried on a record: points, amplitudes behind a cantilever, and ends of the range, all at once.

The factor of a background is triangular: its first n rows make the first n means white. Running sums of the same products
therefore give the likelihood of every candidate and of every end of the range.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flatpunch._support.checks import TINY, Array
from flatpunch.fits.judge.record import Noise, Record
from flatpunch.fits.measured.signal import IN_CONTACT, NODES

_ON, _AMPLITUDES = 80, 10
"""Contact points over the record, half as many ever closer to its end, and amplitudes of each behind a cantilever: a grid."""
_BEFORE = (0.03, 0.1, 0.3, 1.0, 1.7, 3.0, 5.0, 7.0, 10.0)
"""Contact points before the first reading, over the way of the record: a grid."""
_DEPTHS = 2 * NODES
"""Depths of a table of forces, from a millionth of the largest: a grid."""


class Found(NamedTuple):
    """A contact of the scan: likelihood, amplitude, position of the base [m], sign of the force, end of the range, its gain.

    `rise` is how much of the force's range it explains.
    """

    worth: float
    amplitude: float
    place: float
    sign: float
    end: int
    gain: float
    rise: float


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


def table_at(record: Record, x: Array, *, far: bool = False) -> Table:
    """Force over depth at parameters, as deep as contacts on the record reach, or `far` before it."""
    objective = record.objective
    reach = (1.2 * _BEFORE[-1] if far else 2.2) * float(np.ptp(objective.position))
    theta = objective.split(x)[0]
    while True:
        depth = np.geomspace(1e-6 * reach, reach, _DEPTHS)
        try:
            force = objective.model.evaluate(depth, theta)[0]
        except ValueError:
            # the shape of the tip ends
            reach *= 0.8
            continue
        good = np.isfinite(force)
        return Table(np.append(0.0, depth[good]), np.append(0.0, force[good]))


class Candidates(NamedTuple):
    """Contact points (positions of the base) [m], amplitudes, and forces over the range of the record, shape (n, m)."""

    places: Array
    amplitudes: Array
    forces: Array


def candidates(record: Record, table: Table) -> Candidates:
    """All contacts that are tried with a table of forces."""
    position, spring = record.objective.position, record.objective.spring
    places = _places(record, table)
    if spring is None:
        amplitudes = np.ones(places.size)
        forces = table.force(position[:, None] - places)
    else:
        pairs = [(p, a) for p in places.tolist() for a in _amplitudes(record, table, p, spring).tolist()]
        places, amplitudes = np.array(pairs).reshape(-1, 2).T
        forces = np.array([table.behind(position - p, a, spring) for p, a in pairs]).T.reshape(record.size, -1)
    forces /= record.range
    good = forces.max(axis=0, initial=0.0) > 0
    return Candidates(places[good], amplitudes[good], forces[:, good])


def _places(record: Record, table: Table) -> Array:
    position, n = record.objective.position, record.size
    low, high = (end + record.bent for end in record.contacts)
    if not high > low:
        return np.array([low])
    way = float(np.ptp(position))
    on = position[np.linspace(1, n - 5, _ON).astype(int)]
    late = position[-1] - way * np.geomspace(1 / NODES, 1, _ON // 2)
    places = np.concatenate([on, late, position[0] - way * np.array(_BEFORE)])
    places = places[places > position[-1] - table.depth[-1]]
    inside = places[(places >= low) & (places <= min(high, position[-5]))]
    if inside.size < _AMPLITUDES:
        # limits of the user lie closer than the grid
        first, last = (float(np.clip(end, position[0] - way, position[-1])) for end in (low, high))
        inside = np.append(inside, np.linspace(first, last, 2 * _AMPLITUDES))
    return np.unique(inside)


def _amplitudes(record: Record, table: Table, place: float, spring: float) -> Array:
    """Amplitudes with which the force of a contact point goes through some of the readings behind it."""
    position, force, n = record.objective.position, record.objective.force, record.size
    beyond = position - place
    if beyond[0] > 0:
        # in contact from the first reading: the rise between both ends, of a tip that goes less far than the base
        rise = float(np.diff(table.force(beyond[[0, -1]]))[0])
        return abs(float(force[-1] - force[0])) / max(rise, TINY) * np.geomspace(0.7, 30, _AMPLITUDES)
    i = min(int(np.searchsorted(position, place)), n - 3)
    rises = np.abs(force - force[max(i - 2 * IN_CONTACT, 0) : i + 1].mean())
    at = np.unique((i + np.geomspace(2, max(n - 1 - i, 2), _AMPLITUDES)).astype(int))
    at = at[at < n]
    shape = table.force(beyond[at] - rises[at] / spring)
    return np.asarray(rises[at][shape > 0] / shape[shape > 0])


def scan(record: Record, noise: Noise, tried: Candidates, end: int | None = None) -> Found | None:
    """The likeliest contact and end of the range, or the likeliest contact of a given range; None without any."""
    places, amplitudes, forces = tried
    if not places.size:
        return None
    most, n, behind = forces.max(axis=0), record.size, record.objective.spring is not None
    passed = record.passed(noise)
    made = passed.innovations(np.column_stack([record.y, forces / most]))
    y, shapes = made[:, 0], made[:, 1:]
    along = np.cumsum(shapes * y[:, None], axis=0)
    square = np.maximum(np.cumsum(shapes * shapes, axis=0), TINY)
    factor = along / square / most
    gain = 0.5 * along**2 / square
    if behind:
        # the amplitude is in the shape of the column already
        gain = np.where((np.abs(factor) > 0.5) & (np.abs(factor) < 2), gain, 0.0)
    # a mean beyond the end may be anywhere within the range
    worth = passed.background(y)[:, None] + gain
    worth[np.arange(n)[:, None] < np.searchsorted(record.objective.position, places) + 3] = -np.inf
    if end is not None:
        worth[: end - 1] = worth[end:] = -np.inf
    e, j = np.unravel_index(int(np.argmax(worth)), worth.shape)
    if not np.isfinite(worth[e, j]) or gain[e, j] <= 0:
        return None
    return Found(
        float(worth[e, j]),
        float(abs(factor[e, j]) * (amplitudes[j] if behind else 1.0)),
        float(places[j]),
        float(np.sign(factor[e, j])),
        int(e) + 1,
        float(gain[e, j]),
        float(abs(factor[e, j]) * (forces[e, j] - forces[0, j])),
    )


def begun(record: Record, found: Found, x: Array) -> Array:
    """Unknowns at a contact of the scan: the amplitude goes into the moduli."""
    objective = record.objective
    x = x.copy()
    for j in record.moduli:
        x[j] += np.log(found.amplitude) / len(record.moduli)
    scales = objective.units
    for name, value in (("contact", found.place - record.bent), ("baseline", record.level)):
        if name in objective.nuisance:
            offset, unit = scales[name]
            x[objective.names.index(name)] = (value - offset) / unit
    return x
