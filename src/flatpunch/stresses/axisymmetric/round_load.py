"""Stress and displacement in one body under a round load: pressure, and a traction of the same shape in one direction.

In the top layer the half-space of its material is split off (`radial`, in closed form); the rest looks like the field of sources
at the depth 2h, seen from z: it decays like exp(-k (2h - z)) over the wavenumber, and is smooth over distances of that length.
Below the top layer all fields decay like exp(-kz). So Hankel integrals over a finite range of k are exact to rounding, and where
there are many points they are taken on Chebyshev nodes of panels in r and z whose lengths follow that smoothness.

The integrals need many wavenumbers; the fields of waves themselves are smooth over an octave of them, and graded layers are
crossed in a hundred steps, so that these fields are interpolated between few wavenumbers. Poles of the response lie away from
real k, at the inverse of the lengths over which layers bend, stretch and shear on what is below: below the smallest of these one
panel is enough. The fields at the nodes are kept: loads of different sizes, and points at different distances from them, share
depths and panels.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy
from numpy.polynomial import chebyshev

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import AT_ONCE, Array, Flags, Indices
from flatpunch._support.prefixes import text
from flatpunch.compliances.depth import Waves, waves_at
from flatpunch.compliances.power_law import power_law_waves
from flatpunch.compliances.response import smallest_and_largest_modulus
from flatpunch.compliances.stack import interfaces
from flatpunch.media import Stack
from flatpunch.numerics.chebyshev import nodal_transform, unit_nodes
from flatpunch.numerics.gauss import gauss
from flatpunch.punch import UnresolvedLayer
from flatpunch.stresses.axisymmetric.panels import (
    OCTAVE,
    REACH,
    Points,
    RoundLoad,
    nodes_in_depth,
    nodes_in_radius,
    panels_in_depth,
)
from flatpunch.stresses.axisymmetric.radial import (
    NORMAL_ORDERS,
    functions_of,
    orders,
    surface_part,
    turned,
    under_pressure,
    under_traction,
)
from flatpunch.stresses.bodies import Located

FADING = 0.6, 0.11
"""Middle and width of the window over its last wavenumber that ends integrals under graded surfaces: 1e-7 is left there."""

_WINDOW = 18.0
"""Width of the window that ends integrals far from the load, in k times the distance: its own transform is exp(-81) there."""

_PER_PANEL = 16
"""Gauss nodes on a panel of wavenumbers."""

_SHARED = 1.5
"""Largest ratio of distances within a panel, whose points share their wavenumbers."""

_LONG = 0.01
"""Wavenumber times the longest length of the response below which one panel of the fields of waves is enough."""

_RUNGS = 4
"""Largest wavenumbers per octave at which panels end: an integral and its check, which ends at 5/6 of it, have different ones."""


def round_fields(
    load: RoundLoad,
    at: Located,
    x: Array,
    y: Array,
    *,
    pressure: float = 1.0,
    traction: float = 0.0,
    direction: float = 0.0,
    reach: float = REACH,
) -> Array:
    """Fields at points of one body, in the coordinates in which its depth is positive.

    Parameters
    ----------
    load : RoundLoad
        The load, about the origin.
    at : Located
        Points of the body.
    x, y : ndarray, shape (n,)
        Their coordinates along the surface [m].
    pressure, traction : float
        Factors of the load as pressure and as traction [-].
    direction : float
        Polar angle of the traction [rad].
    reach : float
        Where integrals over the layers' response end, see `layered_part`.

    Returns
    -------
    ndarray, shape (9, n)
        Stress xx, yy, zz, yz, xz, xy [Pa] and displacement x, y, z [m].
    """
    shear = traction != 0
    r, z, layer, which = _distinct(np.hypot(x, y), at)
    functions = layered_part(at.body, load, r, z, layer, shear, reach)
    top = split_off(at.body, load, z, layer)
    if top.any():
        functions[:, top] += surface_part(at.body).of_load(load, r[top], z[top], shear)
    functions = functions[:, which]
    theta = np.arctan2(y, x) - direction
    found = under_pressure(pressure * functions[: len(NORMAL_ORDERS)], theta)
    if shear:
        found += under_traction(traction * functions[len(NORMAL_ORDERS) :], theta)
    return turned(found, direction)


def _distinct(r: Array, at: Located) -> tuple[Array, Array, Indices, Indices]:
    """Different (r, depth, layer), and which of them each point is: planes about the axis repeat them."""
    keys = np.empty(r.size, dtype=complex)
    keys.real, keys.imag = r, at.depth
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    return r[first], at.depth[first], at.layer[first], which.ravel()


def split_off(medium: Stack, load: RoundLoad, z: Array, layer: Indices) -> Flags:
    """Points at which a part in closed form is split off, which `layered_part` therefore leaves out."""
    if medium.power_law:
        return np.asarray(z <= load.shallow)
    return np.asarray(layer == 0)


def layered_part(
    medium: Stack,
    load: RoundLoad,
    r: Array,
    z: Array,
    layer: Indices,
    shear: bool,
    reach: float = REACH,
) -> Array:
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
    ndarray, shape (6, n), with a traction (15, n)
    """
    result = np.zeros((len(orders(shear)), r.size))
    # points on an interface may be outside their layer by rounding
    tops = np.concatenate([[0.0], interfaces(medium), [np.inf]])
    z = np.clip(z, tops[layer], tops[layer + 1])
    for group in panels_in_depth(medium, load, r, z, layer):
        _fill(result, medium, load, group, r, z, shear, reach)
    return result


def _fill(
    result: Array,
    medium: Stack,
    load: RoundLoad,
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
    for chosen, radii, weights in nodes_in_radius(r[points], load.radius, decay):
        # panels share wavenumbers, and the fields of the waves, up to a few lengths each of their distance
        extent = load.radius * _SHARED ** np.ceil(np.log1p(float(radii.max()) / load.radius) / np.log(_SHARED))
        gap = min(float(radii.min()), extent / _SHARED - load.radius) - load.radius
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
    load: RoundLoad,
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
    # widths from its middle at which that window is one or zero to rounding
    ends = float(scipy.special.erfcinv(np.finfo(float).eps))
    windowed = gap * last > 2 * ends * _WINDOW
    if windowed:
        last = 2 * ends * _WINDOW / gap
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
        weight = weight * scipy.special.erfc(k * gap / _WINDOW - ends) / 2
    elif faded:
        weight = weight * scipy.special.erfc((k / last - FADING[0]) / FADING[1]) / 2
    weight = weight * k * load.transform(k)
    count = max(AT_ONCE // z.size, 1)
    for start in range(0, k.size, count):
        some = slice(start, start + count)
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
    return functions_of(waves, k, shear)


def waves_between(medium: Stack, k: Array, z: Array, layer: Indices, *, shear: bool) -> Waves:
    """Fields as of `waves_at`, from panels of wavenumbers if these have fewer nodes than `k`, shape (nk,), ascending."""
    if not medium.varies:
        return waves_at(medium, k, z, layer, shear=shear)
    edges = _edges(medium, float(2.0 ** (np.ceil(_RUNGS * np.log2(k[-1])) / _RUNGS)))
    if OCTAVE * (edges.size - 1) >= k.size:
        return waves_at(medium, k, z, layer, shear=shear)
    found = _at_nodes(medium, tuple(edges.tolist()), tuple(z.tolist()), tuple(layer.tolist()), shear)
    which = np.searchsorted(edges, k) - 1
    low, high = edges[which], edges[which + 1]
    weights = chebyshev.chebvander((2 * k - low - high) / (high - low), OCTAVE - 1) @ nodal_transform(OCTAVE)

    def between(table: Array) -> Array:
        result = np.empty((*table.shape[:-2], k.size, table.shape[-1]))
        for i in np.unique(which) if table.size else ():
            mine = which == i
            result[..., mine, :] = weights[mine] @ table[..., OCTAVE * i : OCTAVE * (i + 1), :]
        return result / k[:, None] if table.size else table

    return Waves(between(found.normal), between(found.shear), between(found.transverse))


@byte_cached
def _at_nodes(
    medium: Stack, edges: tuple[float, ...], z: tuple[float, ...], layer: tuple[int, ...], shear: bool
) -> Waves:
    """Fields times k at the nodes of all panels: displacements of sliding layers grow like 1/k at long waves."""
    middle, half = np.array([edges[:-1], edges[1:]]).mean(axis=0), np.diff(edges) / 2
    k = (middle[:, None] + half[:, None] * unit_nodes(OCTAVE)).ravel()
    found = waves_at(medium, k, np.array(z), np.array(layer), shear=shear)
    return Waves(*(each * k[:, None] if each.size else each for each in (found.normal, found.shear, found.transverse)))


def _edges(medium: Stack, last: float) -> Array:
    """Panels of wavenumbers from zero: octaves below the last one, and one for all that are long."""
    smallest, largest = smallest_and_largest_modulus(medium)
    # layers that shear on a weak interface, the farthest-reaching case, respond over the root of the ratio of moduli
    longest = medium.thickness * np.sqrt(largest / smallest)
    count = max(int(np.ceil(np.log2(last * longest / _LONG))), 0)
    return np.append(0.0, last * 0.5 ** np.arange(count, -1, -1))


def _table(spectrum: tuple[Array, Array, Array], r: Array) -> Array:
    """Functions on the product of radii and depths, shape (functions, nr, nz)."""
    k, weight, fields = spectrum
    which = orders(len(fields) > len(NORMAL_ORDERS))
    bessel = [values * weight for values in bessel_functions(np.outer(r, k), max(which) + 1)]
    return np.stack([bessel[m] @ each for m, each in zip(which, fields, strict=True)])


def bessel_functions(x: Array, count: int) -> list[Array]:
    """J_0 ... J_(count - 1): orders two and three by recurrence, which cancels below x = 1."""
    found = [scipy.special.j0(x), scipy.special.j1(x)]
    small = x < 1
    for m in range(2, count):
        found.append(2 * (m - 1) / np.where(small, 1.0, x) * found[m - 1] - found[m - 2])
        found[m][small] = scipy.special.jv(m, x[small])
    return found


def wavenumbers(last: float, reach: float, longest: float) -> tuple[Array, Array]:
    """Gauss nodes and weights over (0, last): panels grow from small k on until they hold a few oscillations.

    They begin at the same k whatever the reach: where a layer slides, friction moves it by a distance that grows like the
    logarithm of the reach and is known up to a constant only, which must not differ between panels.
    """
    # smallest wavenumber times the largest length of layers and load; displacements change by no more than this share below it
    edges = [0.0, 1e-8 / longest]
    while edges[-1] < last:
        # radians of k (r + a) on a panel
        edges.append(min(edges[-1] + min(4 * edges[-1], 10.0 / reach), last))
    x, w = gauss(_PER_PANEL)
    low, half = np.array(edges[:-1])[:, None], np.diff(edges)[:, None] / 2
    return (low + half * (1 + x)).ravel(), (half * w).ravel()


def _combined(table: Array, of_radius: Array, of_depth: Array) -> Array:
    """Interpolate a table (functions, nr, nz) at n points; shape (functions, n)."""
    functions, nr, nz = table.shape
    flat = np.moveaxis(table, 1, 0).reshape(nr, functions * nz)
    result = np.empty((functions, of_radius.shape[0]))
    points = max(AT_ONCE // flat.shape[1], 1)
    for start in range(0, of_radius.shape[0], points):
        some = slice(start, start + points)
        along = (of_radius[some] @ flat).reshape(-1, functions, nz)
        result[:, some] = np.einsum("nfz,nz->fn", along, of_depth[some])
    return result
