"""What layers add to the half-space part of a round load, and all of it below the top layer.

In the top layer the half-space of its material is split off (`ring_sources`); the rest looks like the field of sources at the
depth 2h, seen from z: it decays like exp(-k (2h - z)) over the wavenumber, and is smooth over distances of that length. Below
the top layer all fields decay like exp(-kz). So Hankel integrals over a finite range of k are exact to rounding, and where
there are many points they are taken on Chebyshev nodes of panels in r and z whose lengths follow that smoothness.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch._support.prefixes import text
from flatpunch.compliance.power_law_depth import power_law_waves
from flatpunch.compliance.stack import Body, attenuation, fastest_rate, interfaces
from flatpunch.fields.axisymmetric.anisotropic import surface_part
from flatpunch.fields.axisymmetric.radial import NORMAL_ORDERS, SHEAR_ORDERS, normal_waves, shear_waves
from flatpunch.fields.axisymmetric.wave_table import waves_between
from flatpunch.media import GradedLayer, Medium, PowerLawHalfSpace
from flatpunch.numerics.gauss import gauss
from flatpunch.punch import UnresolvedLayer

REACH, SECOND_REACH = 36.0, 30.0
"""k times the decay length at which integrals end: exp(-36) (kl)^2 is below rounding, exp(-30) (kl)^2 is 1e-10. The second is
for estimates of the error."""

SHORTEST = 1 / 24
"""Decay length over the load's radius that is resolved below a graded surface, where the rest decays only like 1/k; shorter
waves are ended by a smooth window, which blurs the rim."""

FADING = 0.55, 0.12
"""Middle and width of that window over its last wavenumber: 1e-7 is left there."""

_R_NODES, _Z_NODES = 20, 16
"""Chebyshev nodes of a panel in r, and in z, an octave of depth: they leave 1e-11."""

_TOGETHER = 64
"""Most nodes in z of layers that share their wavenumbers: half as many take up to twice the time in a stack of hundreds of
layers, twice as many twice the memory."""

_R_WIDTH = 1.25
"""Width of a panel in r over the decay length."""

_FEW, _NEAR = 64, 4.0
"""Most different radii for which no panels are needed, within this multiple of the load's radius and the decay length."""

_WINDOW = 140.0, 18.0
"""Middle and width of the window that ends integrals far from the load, in k times the distance: exp(-81) is left."""

_SHARED = 1.5
"""Largest ratio of distances within a panel, whose points share their wavenumbers."""


class Load(Protocol):
    """A round load by its transform."""

    @property
    def radius(self) -> float:
        """Radius [m]."""

    @property
    def shallow(self) -> float:
        """Depth to which the surface part of a power-law half-space is split off [m]: radius/12 times a power of 2."""

    def transform(self, k: Array) -> Array:
        """P(k), p(r) = int k P J_0(kr) dk [Pa m^2 / m]."""


@dataclass(frozen=True, slots=True)
class Points:
    """Points of one panel in z: which, between which depths, the decay length there, layer, whether a window ends integrals."""

    chosen: Indices
    low: float
    high: float
    decay: float
    layer: int = 0
    faded: bool = False


def split_off(medium: Body | PowerLawHalfSpace, load: Load, z: Array, layer: Indices) -> Flags:
    """Points at which a part in closed form is split off, which `layered_part` therefore leaves out."""
    if isinstance(medium, PowerLawHalfSpace):
        return np.asarray(z <= load.shallow)
    return np.asarray(layer == 0)


def layered_part(
    medium: Body | PowerLawHalfSpace,
    load: Load,
    r: Array,
    z: Array,
    layer: Indices,
    shear: bool,
    reach: float = REACH,
) -> tuple[Array, Array | None]:
    """Radial functions that layers add in the top layer, and all of them below it.

    Parameters
    ----------
    medium : HalfSpace, TransverselyIsotropicHalfSpace, Medium or PowerLawHalfSpace
        The body.
    load : Load
        Round pressure.
    r, z : ndarray, shape (n,)
        Points [m].
    layer : ndarray of int, shape (n,)
        Layer that each point belongs to.
    shear : bool
        Whether a traction of the same shape acts as well.
    reach : float
        k times the decay length at which integrals end; less than `REACH` is faster, and off by exp(-reach) reach^2 or so.

    Returns
    -------
    normal : ndarray, shape (6, n)
    shear : ndarray, shape (9, n), or None
    """
    count = 6 + (9 if shear else 0)
    result = np.zeros((count, r.size))
    if isinstance(medium, PowerLawHalfSpace):
        for part in _octaves(load, z):
            _fill(result, medium, load, [part], r, z, shear, reach)
    elif isinstance(medium, Medium) and medium.layers:
        tops = np.concatenate([[0.0], interfaces(medium), [np.inf]])
        # points on an interface may be outside their layer by rounding
        z = np.clip(z, tops[layer], tops[layer + 1])
        parts = [part for i in np.unique(layer) for part in _panels_in_depth(medium, load, int(i), layer, z)]
        for group in _groups(parts):
            _fill(result, medium, load, group, r, z, shear, reach)
    return result[:6], result[6:] if shear else None


def _groups(parts: list[Points]) -> Iterator[list[Points]]:
    """Panels that share their wavenumbers, from the surface down: those of thin layers below the first."""
    group: list[Points] = []
    for part in parts:
        alike = group and group[0].layer > 0 and part.decay <= 2 * group[0].decay
        if not alike or sum(min(each.chosen.size, _Z_NODES) for each in (*group, part)) > _TOGETHER:
            if group:
                yield group
            group = []
        group.append(part)
    if group:
        yield group


def _panels_in_depth(medium: Medium, load: Load, i: int, layer: Indices, depths: Array) -> Iterator[Points]:
    """Panels over whose depth fields are smooth: in isotropic layers octaves, and all of a top layer that is split off.

    Graded layers have a panel for each stretch of their laws: stresses along the surface are as smooth as the modulus.

    Fields that return from a face decay at most as fast as the larger rate, those that arrive there at the smaller one.
    """
    here = np.flatnonzero(layer == i)
    z = depths[here]
    faces, rate = np.concatenate([[0.0], interfaces(medium)]), fastest_rate(medium, i)
    split = i == 0 and not isinstance(medium.layers[0], GradedLayer)

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
    breaks = faces[i] + np.array(getattr(medium.layers[i], "breaks", ()) if i < len(medium.layers) else ())
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


def _octaves(load: Load, z: Array) -> Iterator[Points]:
    """Panels in the depth of a power-law half-space."""
    start, end = 0.0, 2 * SHORTEST * load.radius
    while start < z.max(initial=-1.0) or start == 0:
        chosen = np.flatnonzero((z > start) & (z <= end) if start > 0 else z <= end)
        if chosen.size:
            yield Points(chosen, start, end, start or end / 2, faded=start == 0)
        start, end = end, 2 * end


def _fill(
    result: Array,
    medium: Medium | PowerLawHalfSpace,
    load: Load,
    parts: list[Points],
    r: Array,
    z: Array,
    shear: bool,
    reach: float,
) -> None:
    """Functions at the points of panels in depth that share their wavenumbers, into `result`, (functions, points)."""
    decay = min(part.decay for part in parts)
    rules = [nodes_or_points(z[part.chosen], part.low, part.high, _Z_NODES) for part in parts]
    depths, layers = (
        np.concatenate([nodes for nodes, _ in rules]),
        np.concatenate([np.full(nodes.size, part.layer) for part, (nodes, _) in zip(parts, rules, strict=True)]),
    )
    points = np.concatenate([part.chosen for part in parts])
    first, node = (np.cumsum([0, *sizes]) for sizes in zip(*((w.shape) for _, w in rules), strict=True))
    spectra: dict[float, tuple[Array, Array, Array]] = {}
    for chosen, low, high in _panels_in_radius(r[points], load.radius, decay):
        radii, weights = nodes_or_points(r[points[chosen]], low, high, _R_NODES if high > 0 else _FEW)
        # panels share wavenumbers, and the fields of the waves, up to a few lengths each of their distance
        extent = load.radius * _SHARED ** np.ceil(np.log1p(float(radii.max()) / load.radius) / np.log(_SHARED))
        # with another reach all nodes differ, so that a second one gives an estimate of the error
        extent *= REACH / reach
        gap = min(float(radii.min()), extent / _SHARED - load.radius) - load.radius if high > 0 else 0.0
        if extent not in spectra:
            spectra[extent] = _spectrum(
                medium, load, layers, depths, (reach / decay, extent, gap, parts[0].faded), shear
            )
        table = _table(spectra[extent], radii)
        for n, (_, depth_weights) in enumerate(rules):
            mine = (chosen >= first[n]) & (chosen < first[n + 1])
            there = chosen[mine]
            of_depth = depth_weights[there - first[n]]
            result[:, points[there]] = _combined(table[:, :, node[n] : node[n + 1]], weights[mine], of_depth)


def _panels_in_radius(r: Array, a: float, decay: float) -> Iterator[tuple[Indices, float, float]]:
    """Points by panels in r, which grow with the distance from the load."""
    order = np.argsort(r, kind="stable")
    ordered = r[order]
    at = int(np.searchsorted(ordered, _NEAR * (a + decay), side="right"))
    if 0 < np.unique(ordered[:at]).size <= _FEW:
        yield order[:at], 0.0, 0.0
    else:
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
        yield order[at:end], low, high
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
    low, high = max(low, own[0] - 1e-9 * (own[-1] - own[0])), min(high, own[-1])
    nodes = np.cos(np.pi * (np.arange(count) + 0.5) / count)
    values = chebyshev.chebvander(np.clip((2 * x - low - high) / (high - low), -1, 1), count - 1)
    transform = chebyshev.chebvander(nodes, count - 1).T * 2 / count
    transform[0] /= 2
    return np.maximum((low + high) / 2 + (high - low) / 2 * nodes, 0.0), values @ transform


def _spectrum(
    medium: Medium | PowerLawHalfSpace,
    load: Load,
    layer: Indices,
    z: Array,
    rule: tuple[float, float, float, bool],
    shear: bool,
) -> tuple[Array, Array, Array]:
    """Wavenumbers and weights with the load's transform, (nk,), and amplitudes of the functions, (functions, nk, nz).

    `rule` is the largest wavenumber, the largest and smallest distance between points and load, and whether short waves fade
    out. Far from the load they cancel: a smooth window ends the integral, whose own transform is below rounding there.
    """
    last, extent, gap, faded = rule
    windowed = gap * last > _WINDOW[0] + 6 * _WINDOW[1]
    if windowed:
        last = (_WINDOW[0] + 6 * _WINDOW[1]) / gap
    # largest wavenumber times the extent of load and points that is integrated: half a minute
    if last * extent > 1e6:
        raise UnresolvedLayer(
            f"points are up to {text(extent, 'm')} from the load, {extent * last / REACH:.0e} times the "
            f"{text(REACH / last, 'm')} over which the fields of the layers vary; their integrals need too many wavenumbers. "
            "Check the units, or leave out the thin layer."
        )
    longest = max(medium.thickness, load.radius) if isinstance(medium, Medium) else load.radius
    k, weight = wavenumbers(last, extent, longest)
    if windowed:
        weight = weight * scipy.special.erfc((k * gap - _WINDOW[0]) / _WINDOW[1]) / 2
    elif faded:
        weight = weight * scipy.special.erfc((k / last - FADING[0]) / FADING[1]) / 2
    fields = amplitudes(medium, k, z, layer, shear)
    if split_off(medium, load, z[:1], layer[:1])[0]:
        fields -= surface_part(medium).amplitudes(k, z, shear)
    return k, weight * k * load.transform(k), fields


def amplitudes(body: Body | PowerLawHalfSpace, k: Array, z: Array, layer: Indices, shear: bool) -> Array:
    """Amplitudes of all functions under unit load waves, shape (functions, nk, nz)."""
    if isinstance(body, PowerLawHalfSpace):
        waves = power_law_waves(body, k, z)
    else:
        waves = waves_between(body, k, z, layer, shear=shear)
    normal = normal_waves(waves, k)
    return np.concatenate([normal, shear_waves(waves, k)]) if shear else normal


def _table(spectrum: tuple[Array, Array, Array], r: Array) -> Array:
    """Functions on the product of radii and depths, shape (functions, nr, nz)."""
    k, weight, fields = spectrum
    orders = NORMAL_ORDERS + (SHEAR_ORDERS if len(fields) > len(NORMAL_ORDERS) else ())
    bessel = [values * weight for values in bessel_functions(np.outer(r, k), max(orders) + 1)]
    return np.stack([bessel[m] @ each for m, each in zip(orders, fields, strict=True)])


def bessel_functions(x: Array, count: int) -> list[Array]:
    """J_0 ... J_(count - 1): orders two and three by recurrence, below x = 1 by their series."""
    found = [scipy.special.j0(x), scipy.special.j1(x)]
    small = x < 1
    safe, y = np.where(small, 1.0, x), np.where(small, x, 0.0) ** 2
    for m in range(2, count):
        series = np.ones_like(x)
        for s in range(6, 0, -1):
            series = 1 - y / (4 * s * (m + s)) * series
        lead = (np.where(small, x, 0.0) / 2) ** m / (2 if m == 2 else 6)
        found.append(np.where(small, lead * series, 2 * (m - 1) / safe * found[m - 1] - found[m - 2]))
    return found


def wavenumbers(last: float, reach: float, longest: float) -> tuple[Array, Array]:
    """Gauss nodes and weights over (0, last): panels grow from small k on until they hold a few oscillations.

    They begin at the same k whatever the reach: where a layer slides, friction moves it by a distance that grows like the
    logarithm of the reach and is known up to a constant only, which must not differ between panels.
    """
    # smallest wavenumber times the largest length of layers and load; displacements change by no more than this share below it
    edges = [0.0, 1e-8 / longest]
    while edges[-1] < last:
        # radians of k (r + a) on a panel of 16 Gauss nodes in k
        edges.append(min(edges[-1] + min(4 * edges[-1], 10.0 / reach), last))
    x, w = gauss(16)
    low, half = np.array(edges[:-1])[:, None], np.diff(edges)[:, None] / 2
    return (low + half * (1 + x)).ravel(), (half * w).ravel()


def _combined(table: Array, of_radius: Array, of_depth: Array) -> Array:
    """Interpolate a table (functions, nr, nz) at n points; shape (functions, n)."""
    functions, nr, nz = table.shape
    flat = np.moveaxis(table, 1, 0).reshape(nr, functions * nz)
    result = np.empty((functions, of_radius.shape[0]))
    for start in range(0, of_radius.shape[0], 8192):
        some = slice(start, start + 8192)
        along = (of_radius[some] @ flat).reshape(-1, functions, nz)
        result[:, some] = np.einsum("nfz,nz->fn", along, of_depth[some])
    return result
