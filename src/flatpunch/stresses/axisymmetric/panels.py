"""Panels in radius and depth on which fields under a round load are smooth, and the shortest waves that matter there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances.stack import attenuation, fastest_rate, interfaces
from flatpunch.media import Stack
from flatpunch.numerics.chebyshev import nodal_transform, unit_nodes

REACH, SECOND_REACH = 36.0, 30.0
"""k times the decay length at which integrals end: exp(-36) (kl)^2 is below rounding, exp(-30) (kl)^2 is 1e-10. The second is
for estimates of the error."""

SHORTEST = 1 / 24
"""Decay length over the load's radius that is resolved below a graded surface, where the rest decays only like 1/k; shorter
waves are ended by a smooth window, which blurs the rim."""

_HALVED = 5
"""Times that this length is halved close to edges: it is 1/48 to 1/24 of the distance down to 1/380 of the radius."""

OCTAVE = 16
"""Chebyshev nodes over an octave of depth or of wavenumbers: with poles 45 degrees off the real axis they leave 5^-16 = 1e-11."""

_R_NODES, _R_WIDTH = 20, 1.25
"""Chebyshev nodes of a panel in r, and its width over the decay length: they leave 1e-11."""

_TOGETHER = 4 * OCTAVE
"""Most nodes in z of layers that share their wavenumbers: half as many take up to twice the time in a stack of hundreds of
layers, twice as many twice the memory."""


class Edge(NamedTuple):
    """A ring at which the pressure is not smooth.

    Its radius [m]; the power of the distance like which the pressure varies there; whether shorter waves are resolved close to
    it: at the rim, and where the slope of the tip jumps.
    """

    radius: float
    power: float
    sharp: bool = True


Edges = tuple[Edge, ...]
"""Those of a load, its rim last."""


class RoundLoad(Protocol):
    """A round pressure: its transform, and its half-space integrals."""

    @property
    def radius(self) -> float:
        """Radius [m]."""

    @property
    def shallow(self) -> float:
        """Depth to which the surface part of a power-law half-space is split off [m]: radius/12 times a power of 2."""

    @property
    def edges(self) -> Edges:
        """Where the pressure is not smooth."""

    @property
    def scale(self) -> float:
        """Size of the pressure [Pa]."""

    def transform(self, k: Array) -> Array:
        """P(k), p(r) = int k P J_0(kr) dk [Pa m^2 / m]."""

    def integrals(self, r: Array, z: Array) -> Array:
        """I_mj = int k^j P J_m(kr) exp(-kz) dk at points (r, z), m = 0 ... 3, j = 0, 1, 2; shape (4, 3, n)."""


@dataclass(frozen=True, slots=True)
class Points:
    """Points of one panel in z: which, between which depths, the decay length there, layer, whether a window ends integrals."""

    chosen: Indices
    low: float
    high: float
    decay: float
    layer: int = 0
    faded: bool = False


def panels_in_depth(body: Stack, load: RoundLoad, r: Array, z: Array, layer: Indices) -> Iterator[list[Points]]:
    """All points in panels, by groups that share their wavenumbers; none where nothing is left but the closed form."""
    if body.power_law:
        yield from ([part] for part in _by_distance(_octaves(load, z), load, r, z))
    elif body.layers:
        layers = (_in_layer(body, load, int(i), layer, z) for i in np.unique(layer))
        yield from _groups([part for parts in layers for part in _by_distance(parts, load, r, z)])


def _groups(parts: list[Points]) -> Iterator[list[Points]]:
    """Panels that share their wavenumbers, from the surface down: those of thin layers below the first."""
    group: list[Points] = []
    for part in parts:
        alike = group and group[0].layer > 0 and part.decay <= 2 * group[0].decay
        if not alike or sum(min(each.chosen.size, OCTAVE) for each in (*group, part)) > _TOGETHER:
            if group:
                yield group
            group = []
        group.append(part)
    if group:
        yield group


def _in_layer(medium: Stack, load: RoundLoad, i: int, layer: Indices, depths: Array) -> Iterator[Points]:
    """Panels over whose depth fields are smooth: in isotropic layers octaves, and all of a top layer that is split off.

    Graded layers have a panel for each stretch of their laws: stresses along the surface are as smooth as the modulus.

    Fields that return from a face decay at most as fast as the larger rate, those that arrive there at the smaller one.
    """
    here = np.flatnonzero(layer == i)
    z = depths[here]
    faces, rate = np.concatenate([[0.0], interfaces(medium)]), fastest_rate(medium, i)
    split = i == 0 and not medium.layers[0].varies

    def decay(depth: float) -> float:
        """Length over which fields decay [m]: in the top layer counted from the surface to its lower face and back."""
        reached, face = attenuation(medium, np.array([depth, faces[1]]))
        return float(2 * face - reached if split else reached)

    if split and rate == 1:
        yield Points(here, 0.0, faces[1], decay(float(z.max())))
        return
    start = faces[i]
    low = max(decay(start), SHORTEST * load.radius if i == 0 and not split else 0.0)
    limit = faces[i + 1] if i + 1 < faces.size else np.inf
    breaks = faces[i] + np.array(medium.parts[i].breaks)
    while start < limit:
        # the shallowest panel under a graded surface is as long as the first wave that is resolved
        end = (low if i == 0 and start == 0 and not split else start) + low / rate
        end = min(end, limit, *breaks[breaks > start])
        last = end >= limit or end >= z.max()
        chosen = np.flatnonzero((z >= start) & ((z <= end) if last else (z < end)))
        if chosen.size:
            yield Points(here[chosen], start, end, decay(end) if split else low, i, start == 0 and not split)
        if last:
            return
        start, low = end, decay(end)


def _octaves(load: RoundLoad, z: Array) -> Iterator[Points]:
    """Panels in the depth of a power-law half-space."""
    start, end = 0.0, 2 * SHORTEST * load.radius
    while start < z.max(initial=-1.0) or start == 0:
        chosen = np.flatnonzero((z > start) & (z <= end) if start > 0 else z <= end)
        if chosen.size:
            yield Points(chosen, start, end, start or end / 2, faded=start == 0)
        start, end = end, 2 * end


def _by_distance(parts: Iterable[Points], load: RoundLoad, r: Array, z: Array) -> Iterator[Points]:
    """The panels, those whose short waves fade out in octaves of the distance from sharp edges, where shorter ones count."""
    for part in parts:
        if not part.faded:
            yield part
            continue
        halved = _halvings(load, r[part.chosen], z[part.chosen])
        for times in np.unique(halved):
            here, decay = part.chosen[halved == times], part.decay / 2**times
            deep = (z[here] > 2 * decay) & (times > 0)
            for which, low in ((~deep, 0.0), (deep, 2 * decay)):
                if which.any():
                    yield replace(part, chosen=here[which], low=low, high=min(low + 2 * decay, part.high), decay=decay)


def _halvings(load: RoundLoad, r: Array, z: Array) -> Indices:
    """How many times the shortest length is halved at points, for their distance from the nearest sharp edge."""
    away: Array = np.min([np.hypot(r - edge.radius, z) for edge in load.edges if edge.sharp], axis=0)
    octave = np.ceil(-np.log2(np.maximum(away / (2 * SHORTEST * load.radius), 2.0**-_HALVED)))
    return np.asarray(np.maximum(octave, 0), dtype=int)


def missing(body: Stack, load: RoundLoad, r: Array, z: Array) -> Array:
    """What all waves that are left out change, over what those between `SECOND_REACH` and `REACH` do, shape (n,).

    It is 1 but at points that are closer to an edge than the shortest distance that is resolved. There stresses vary like a
    power of the distance, down to a multiple of the shortest wavelength: by this law the rest follows.
    """
    if not body.parts[0].varies:
        return np.ones(r.size)
    result = np.ones(r.size)
    for ring, power, sharp in load.edges:
        resolved = 2 * SHORTEST * load.radius / (2**_HALVED if sharp else 1)
        # what grading adds to the part in closed form is less singular by one power of the distance
        nearer, power = np.minimum(np.hypot(r - ring, z) / resolved, 1.0), power + (not body.power_law)
        change = np.abs(scipy.special.boxcox(nearer, power)) / scipy.special.boxcox(REACH / SECOND_REACH, power)
        result = np.maximum(result, change)
    return result


def nodes_in_depth(part: Points, z: Array) -> tuple[Array, Array]:
    """Depths at which fields are taken, and weights that bring them to the points, as `nodes_or_points`."""
    return nodes_or_points(z[part.chosen], part.low, part.high, OCTAVE)


def nodes_in_radius(r: Array, a: float, decay: float) -> Iterator[tuple[Indices, Array, Array]]:
    """Panels in r, which grow with the distance from the load: which points, radii, weights."""
    order = np.argsort(r, kind="stable")
    ordered = r[order]
    at = 0
    while at < r.size:
        low = float(ordered[at])
        if low <= a + decay:
            # panels on a fixed grid of this width
            width = _R_WIDTH * decay
            low = width * np.floor(low / width)
            high = low + width
        else:
            high = low + _R_WIDTH * max(decay, low - a)
        end = int(np.searchsorted(ordered, high, side="right"))
        yield order[at:end], *nodes_or_points(ordered[at:end], low, high, _R_NODES)
        at = end


def nodes_or_points(x: Array, low: float, high: float, count: int) -> tuple[Array, Array]:
    """Places at which functions are taken, and weights that bring them to the points x, shape (n, places).

    The places are the points themselves where they are fewer than Chebyshev nodes would be.
    """
    own, which = np.unique(x, return_inverse=True)
    if own.size <= count:
        weights = np.zeros((x.size, own.size))
        weights[np.arange(x.size), which.ravel()] = 1
        return own, weights
    return at_nodes(x, max(low, own[0] - 1e-9 * (own[-1] - own[0])), min(high, own[-1]), count)


def at_nodes(x: Array, low: float, high: float, count: int) -> tuple[Array, Array]:
    """Chebyshev nodes of an interval, and weights that bring functions from there to the points x in it, shape (n, count)."""
    values = chebyshev.chebvander(np.clip((2 * x - low - high) / (high - low), -1, 1), count - 1)
    nodes = (low + high) / 2 + (high - low) / 2 * unit_nodes(count)
    return np.maximum(nodes, 0.0), values @ nodal_transform(count)
