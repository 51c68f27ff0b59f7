"""What layers add to the half-space part of a round load, and all of it below the top layer.

In the top layer the half-space of its material is split off (`ring_sources`); the rest looks like the field of sources at the
depth 2h, seen from z: it decays like exp(-k (2h - z)) over the wavenumber, and is smooth over distances of that length. Below
the top layer all fields decay like exp(-kz). So Hankel integrals over a finite range of k are exact to rounding, and where
there are many points they are taken on Chebyshev nodes of panels in r and z whose lengths follow that smoothness.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch._support.prefixes import text
from flatpunch.compliances.power_law import power_law_waves
from flatpunch.compliances.stack import interfaces
from flatpunch.media import Stack
from flatpunch.numerics.gauss import gauss
from flatpunch.punch import UnresolvedLayer
from flatpunch.stresses.axisymmetric.anisotropic import surface_part
from flatpunch.stresses.axisymmetric.panels import REACH, Load, Points, nodes_in_depth, nodes_in_radius, panels_in_depth
from flatpunch.stresses.axisymmetric.radial import NORMAL_ORDERS, SHEAR_ORDERS, normal_waves, shear_waves
from flatpunch.stresses.axisymmetric.wave_table import waves_between

FADING = 0.6, 0.11
"""Middle and width of that window over its last wavenumber: 1e-7 is left there."""

_WINDOW = 140.0, 18.0
"""Middle and width of the window that ends integrals far from the load, in k times the distance: exp(-81) is left."""

_BLOCK = 1 << 16
"""Wavenumbers at once: the fields of their waves at 16 depths take 100 MB."""

_SHARED = 1.5
"""Largest ratio of distances within a panel, whose points share their wavenumbers."""


def split_off(medium: Stack, load: Load, z: Array, layer: Indices) -> Flags:
    """Points at which a part in closed form is split off, which `layered_part` therefore leaves out."""
    if medium.power_law:
        return np.asarray(z <= load.shallow)
    return np.asarray(layer == 0)


def layered_part(
    medium: Stack,
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
    medium : Stack
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
    # points on an interface may be outside their layer by rounding
    tops = np.concatenate([[0.0], interfaces(medium), [np.inf]])
    z = np.clip(z, tops[layer], tops[layer + 1])
    for group in panels_in_depth(medium, load, r, z, layer):
        _fill(result, medium, load, group, r, z, shear, reach)
    return result[:6], result[6:] if shear else None


def _fill(
    result: Array,
    medium: Stack,
    load: Load,
    parts: list[Points],
    r: Array,
    z: Array,
    shear: bool,
    reach: float,
) -> None:
    """Functions at the points of panels in depth that share their wavenumbers, into `result`, (functions, points)."""
    decay = min(part.decay for part in parts)
    rules = [nodes_in_depth(part, z) for part in parts]
    depths, layers = (
        np.concatenate([nodes for nodes, _ in rules]),
        np.concatenate([np.full(nodes.size, part.layer) for part, (nodes, _) in zip(parts, rules, strict=True)]),
    )
    points = np.concatenate([part.chosen for part in parts])
    first, node = (np.cumsum([0, *sizes]) for sizes in zip(*((w.shape) for _, w in rules), strict=True))
    panels: dict[float, list[tuple[Indices, Array, Array, float]]] = {}
    for chosen, radii, weights, many in nodes_in_radius(r[points], load.radius, decay):
        # panels share wavenumbers, and the fields of the waves, up to a few lengths each of their distance
        extent = load.radius * _SHARED ** np.ceil(np.log1p(float(radii.max()) / load.radius) / np.log(_SHARED))
        gap = min(float(radii.min()), extent / _SHARED - load.radius) - load.radius if many else 0.0
        panels.setdefault(extent, []).append((chosen, radii, weights, gap))
    for extent, those in panels.items():
        # with another reach all nodes differ, so that a second one gives an estimate of the error
        rule = (reach / decay, extent * REACH / reach, those[0][3], parts[0].faded)
        tables = [np.zeros((len(result), radii.size, depths.size)) for _, radii, _, _ in those]
        for spectrum in _spectra(medium, load, layers, depths, rule, shear):
            for table, (_, radii, _, _) in zip(tables, those, strict=True):
                table += _table(spectrum, radii)
        for table, (chosen, _, weights, _) in zip(tables, those, strict=True):
            for n, (_, depth_weights) in enumerate(rules):
                mine = (chosen >= first[n]) & (chosen < first[n + 1])
                there = chosen[mine]
                of_depth = depth_weights[there - first[n]]
                result[:, points[there]] = _combined(table[:, :, node[n] : node[n + 1]], weights[mine], of_depth)


def _spectra(
    medium: Stack,
    load: Load,
    layer: Indices,
    z: Array,
    rule: tuple[float, float, float, bool],
    shear: bool,
) -> Iterator[tuple[Array, Array, Array]]:
    """Wavenumbers and weights with the load's transform, (nk,), and amplitudes of the functions, (functions, nk, nz), in blocks.

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
    longest = max(medium.thickness, load.radius)
    k, weight = wavenumbers(last, extent, longest)
    if windowed:
        weight = weight * scipy.special.erfc((k * gap - _WINDOW[0]) / _WINDOW[1]) / 2
    elif faded:
        weight = weight * scipy.special.erfc((k / last - FADING[0]) / FADING[1]) / 2
    weight = weight * k * load.transform(k)
    for start in range(0, k.size, _BLOCK):
        some = slice(start, start + _BLOCK)
        fields = amplitudes(medium, k[some], z, layer, shear)
        if split_off(medium, load, z[:1], layer[:1])[0]:
            fields -= surface_part(medium).amplitudes(k[some], z, shear)
        yield k[some], weight[some], fields


def amplitudes(body: Stack, k: Array, z: Array, layer: Indices, shear: bool) -> Array:
    """Amplitudes of all functions under unit load waves, shape (functions, nk, nz)."""
    if law := body.power_law:
        waves = power_law_waves(law, k, z)
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
