"""Pressure as the superposition of flat-punch pressures over the indentation history (paper section 2.3).

While the depth grows by dd, the contact of mean radius a with outline a s(phi) gains the pressure of a flat punch of that
outline, (P9): E*/(pi a) pbar(r/(a s)) dd. From the radius a1 at which the outline reaches the point, with a = a1 cosh v,

    p(r, phi) = (E*/pi) int_0^V pbar(r/(a s)) tanh v w d'(a) dv,

whose integrand is smooth. The share w = a^2/<(a s)^2> makes each increment carry exactly the force K(a) dd of the method,
so that p integrates to F; it differs
from 1 by the square of the asymmetry, which a first-order theory does not see. For round indenters s = w = 1 and p is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from flatpunch._support.checks import AT_ONCE, ROUNDING, Array, Indices
from flatpunch.compliances import Kernel
from flatpunch.contact.round.radius_search import PER_DECADE, Loading
from flatpunch.numerics.gauss import NODES, gauss
from flatpunch.punch.basis import normalisation
from flatpunch.punch.family import punch_family
from flatpunch.punch.matrix import effective_beta

_DECADES = 8.0
"""Decades of the radius back to which the history counts."""

NEAREST = 10 ** (1 - _DECADES)
"""Distance from the axis over the radius below which the pressure is taken as constant."""


_DEGREE = 7
"""Degree of splines: 36 nodes per decade leave 1e-11 of functions smooth in ln a."""


@dataclass(frozen=True, slots=True)
class History:
    """Smooth functions of x = ln a along the loading path up to the radius `radius`.

    Attributes
    ----------
    radius : float
        Mean radius at the end [m].
    rate : callable
        x -> d'(a) [-], depth per radius.
    outline : callable
        (x, phi) -> (s, dln s/dx), the outline over its mean radius.
    share : callable
        x -> w.
    rough : callable
        The rate from half as many samples, for estimates of the error.
    rings : tuple of float
        Values of x beyond which the rate is a series in (x - ring)^(1/2), but for power-law half-spaces: where the slope of the
        profile jumps it begins like (x - ring)^(-1/2), where the curvature does like (x - ring)^(1/2); ascending.
    """

    radius: float
    rate: Callable[[Array], Array]
    outline: Callable[[Array, Array], tuple[Array, Array]]
    share: Callable[[Array], Array]
    rough: Callable[[Array], Array]
    rings: tuple[float, ...] = ()


def log_radii(radius: float) -> Array:
    """Nodes of ln a over the eight decades below `radius` that matter for the pressure.

    Within the last factor e they move together towards the end, down to a thousandth of it: a sphere, up to 0.95 of its
    radius, and other shapes that end soon beyond `radius` vary fastest there.
    """
    # nodes of the spline over the history: 1e-11 of functions smooth in ln a
    step = np.log(10) / (3 * PER_DECADE)
    far = np.arange(_DECADES * np.log(10), 1, -step)
    near = np.geomspace(1, 1e-3, int(np.log(1e3) / step) + 1)
    last = np.linspace(1e-3, 0, int(1 / step) + 1)
    return np.asarray(np.log(radius) - np.concatenate([far, near, last[1:]]))


def spline(x: Array, values: Array) -> scipy.interpolate.BSpline:
    """Spline through samples at ascending x."""
    return scipy.interpolate.make_interp_spline(x, values, k=_DEGREE)


def spline_outline(x: Array, relative: Array) -> Callable[[Array, Array], tuple[Array, Array]]:
    """Outline of a history from samples s at nodes x and at equal angles beginning with -pi, shape (nodes, angles).

    Cubic in both directions and periodic in the angle (by overlap): 720 angles leave 1e-9 of smooth outlines, 1e-5 beside a
    corner.
    """
    overlap, count = 10, relative.shape[1]
    step = 2 * np.pi / count
    angles = -np.pi + step * np.arange(-overlap, count + overlap + 1)
    wrapped = np.concatenate([relative[:, -overlap:], relative, relative[:, : overlap + 1]], axis=1)
    surface = scipy.interpolate.RectBivariateSpline(x, angles, wrapped)

    def shape(at: Array, angle: Array) -> tuple[Array, Array]:
        turned = np.mod(angle + np.pi, 2 * np.pi) - np.pi
        s = surface.ev(at, turned)
        return s, surface.ev(at, turned, dx=1) / s

    return shape


def round_history(evaluate: Callable[[Array], Loading], radius: float, exponent: float = 0.0) -> History:
    """History of a round contact (or of the mean profile) with an unchanged circular outline.

    `exponent` is that of a power-law half-space, 0 for all other media.
    """
    rings = getattr(evaluate(np.array([radius])), "rings", ())
    end = np.log(radius)
    within = tuple(x for x in np.log(sorted(rings)) if end - _DECADES * np.log(10) < x < end)
    rate, rough = _rates(evaluate, radius, within, (1 - exponent) / 2)
    return History(
        radius=radius,
        rate=rate,
        outline=lambda x, phi: (np.ones_like(x), np.zeros_like(x)),
        share=np.ones_like,
        rough=rough,
        rings=within,
    )


def _rates(
    evaluate: Callable[[Array], Loading], radius: float, rings: tuple[float, ...], power: float
) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """x -> d'(a): one spline of x up to the first ring, beyond each ring one of (x - ring)^(power/2), times s^2.

    The second is from every other sample.
    """

    def sample(x: Array) -> Array:
        a = np.exp(x)
        return np.asarray(evaluate(a).depth_slope / a)

    # the end is kept, and the last node stays below the ring, whose logarithm is rounded
    x = log_radii(np.exp(rings[0]) if rings else radius)
    starts, widths = np.array(rings), np.diff([*rings, np.log(radius)])
    # nodes of the splines beyond rings: a hundred an e-fold of the radius, and half of them are enough for a spline
    counts = 2 * (_DEGREE + 1) + (100 * np.minimum(widths, 1.0)).astype(int)
    # not at s = 0, where the rate may be infinite; the spline reaches there
    nodes = [x, *(w ** (power / 2) * (np.arange(n) + 0.5) / (n - 0.5) for w, n in zip(widths, counts, strict=True))]
    values = [sample(x - ROUNDING if rings else x)]
    if rings:
        s = np.concatenate(nodes[1:])
        values += np.split(s**2 * sample(np.repeat(starts, counts) + s ** (2 / power)), np.cumsum(counts)[:-1])

    def rate(every: int) -> Callable[[Array], Array]:
        splines = [spline(own[::-every][::-1], value[::-every][::-1]) for own, value in zip(nodes, values, strict=True)]

        def of(x: Array) -> Array:
            piece = np.searchsorted(starts, x)
            result = np.asarray(splines[0](np.minimum(x, starts[0]) if rings else x))
            for i in np.unique(piece[piece > 0]):
                here = piece == i
                s = (x[here] - starts[i - 1]) ** (power / 2)
                result[here] = splines[i](s) / s**2
            return result

        return of

    return rate(1), rate(2)


def grown_pressure(
    kernel: Kernel, evaluate: Callable[[Array], Loading], radius: float, r: Array
) -> tuple[Array, Array]:
    """Pressure of a round contact that has grown to a radius, and its error [Pa], shape (n,) each.

    The error is the larger difference to two others with half as many samples of the history, fewer nodes in it and fewer
    terms of the punches: one difference alone passes through zero at places.
    """
    if radius == 0:
        return np.zeros_like(r), np.zeros_like(r)
    # a square grid has each distance eight times
    distances, place = np.unique(r, return_inverse=True)
    history, angles = round_history(evaluate, radius, kernel.exponent), np.zeros_like(distances)
    fine, *others = (superpose(kernel, history, distances, angles, coarse=each)[place] for each in range(3))
    return fine, np.abs(np.array(others) - fine).max(axis=0)


def superpose(kernel: Kernel, history: History, r: Array, phi: Array, *, coarse: int = 0) -> Array:
    """Pressure at polar coordinates (r, phi), each of shape (n,); zero outside the contact [Pa].

    With `coarse` = 1 or 2 samples, nodes and terms are fewer, for estimates of the error.
    """
    pressure = np.zeros_like(r)
    x_end = np.full_like(r, np.log(history.radius))
    edge = history.radius * history.outline(x_end, phi)[0]
    inside = np.flatnonzero(r < edge)
    # each point needs about a hundred pressures of punches, and ten for each ring
    at_once = AT_ONCE // (1000 + 100 * len(history.rings))
    for i in range(0, inside.size, at_once):
        chosen = inside[i : i + at_once]
        pressure[chosen] = _chunk(kernel, history, r[chosen], phi[chosen], edge[chosen], coarse)
    return pressure


def _chunk(kernel: Kernel, history: History, r: Array, phi: Array, edge: Array, coarse: int) -> Array:
    r = np.maximum(r, edge * NEAREST)
    start = _first_touch(history, r, phi)
    top = np.arccosh(np.exp(np.log(history.radius) - start))
    rate = history.rough if coarse else history.rate
    point, v, spread = _nodes(kernel, history, start, top, coarse)
    # ln a = start + ln cosh v starts like v^2, which takes the square root out of the edge
    lift = np.log1p(2 * np.sinh(v / 2) ** 2)
    x = start[point, None] + lift
    first = history.outline(start, phi)[0][point, None]
    passed = lift + np.log(history.outline(x, np.broadcast_to(phi[point, None], x.shape))[0] / first)
    # sqrt(1 - (r/distance)^2) from the logarithm of distance/r: no cancellation at the edge
    height = np.sqrt(np.maximum(-np.expm1(-2 * passed), 1e-30))
    smooth = punch_pressure(kernel, np.exp(x).ravel(), height.ravel(), fewer=coarse > 0).reshape(v.shape)
    # pbar goes like height^(2 alpha); on power-law half-spaces alpha = (k - 1)/2 is not -1/2
    integrand = smooth * np.tanh(v) * height ** (kernel.exponent - 1) * history.share(x) * rate(x)
    total = np.bincount(point, (integrand * spread).sum(axis=1), minlength=r.size)
    return np.asarray(kernel.modulus / np.pi * total)


def _nodes(kernel: Kernel, history: History, start: Array, top: Array, coarse: int) -> tuple[Indices, Array, Array]:
    """Panels of the history of each point: the point, shape (panels,), Gauss nodes v on (0, top) and weights, (panels, nodes).

    The pressure under a punch changes over a part of its radius, whatever the radius, so panels in v = ln(2 a/r) are at most 1
    wide. Next to its edge it changes over the shortest length h of the medium, which is v = sqrt(2h/a), so panels next to
    v = 0 and to rings are halved down to that. The first of them is in a power of v that makes (v - ring)^alpha, and v^k on
    power-law half-spaces, smooth.
    """
    beta = 0.0 if kernel.homogeneous else effective_beta(kernel, history.radius / kernel.length)
    halvings = int(np.ceil(np.log2(max(beta, 1.0)) / 2))
    widths = np.concatenate([[0.0], 0.5 ** np.arange(halvings, 0, -1), np.arange(1, np.ceil(top.max()) + 1)])
    origins = [np.zeros_like(top)]
    for ring in history.rings:
        lift = np.maximum(ring - start, 0)
        origins.append(np.minimum(np.log(np.exp(lift) + np.sqrt(np.expm1(2 * lift))), top))
    power = 4 / (1 + kernel.exponent) if kernel.exponent else 2.0 if history.rings else 1.0
    panels = []
    for origin, end in pairwise([*origins, top]):
        cuts = np.minimum(origin[:, None] + widths, end[:, None])
        point, panel = np.nonzero(cuts[:, 1:] > cuts[:, :-1])
        low, high = cuts[point, panel], cuts[point, panel + 1]
        panels.append((point, low, high - low, np.where(panel == 0, power, 1.0)))
    point, low, width, q = (np.concatenate(each) for each in zip(*panels, strict=True))
    # they leave 1e-7 of the pressure, under layers of any ratio
    t, weights = gauss(2 * NODES // (2 + coarse))
    u, own, length = (t + 1) / 2, q[:, None], width[:, None]
    return point, low[:, None] + length * u**own, length * own * u ** (own - 1) * weights / 2


def _first_touch(history: History, r: Array, phi: Array) -> Array:
    """Value of ln a at which the growing outline reaches each point, by Newton's method; shape (n,)."""
    wanted = np.log(r)
    low, high = np.log(history.radius) - _DECADES * np.log(10), np.log(history.radius)
    x = np.clip(wanted, low, high)
    for _ in range(30):
        s, growth = history.outline(x, phi)
        step = (wanted - x - np.log(s)) / (1 + growth)
        x = np.clip(x + step, low, high)
        if np.abs(step).max() < ROUNDING:
            break
    return x


def flat_pressure(kernel: Kernel, radius: float, depth: float, r: Array) -> tuple[Array, Array]:
    """Pressure of a flat punch at distances r, infinite at the edge, and its error from fewer terms; shape (n,) each [Pa]."""
    field, error = np.zeros_like(r), np.zeros_like(r)
    inside = r <= radius
    rho = r[inside] / radius
    height = np.sqrt((1 - rho) * (1 + rho))
    smooth, rough = (punch_pressure(kernel, np.full_like(rho, radius), height, fewer=each) for each in (False, True))
    with np.errstate(divide="ignore"):
        scale = kernel.modulus * depth / (np.pi * radius) * height ** (kernel.exponent - 1)
    field[inside] = scale * smooth
    # infinite at the edge, and known to be
    error[inside] = np.abs(np.where(rho < 1, scale, 0.0) * (smooth - rough))
    return field, error


def punch_pressure(kernel: Kernel, radius: Array, height: Array, *, fewer: bool = False) -> Array:
    """P = pbar height^(1 - k) of flat punches of `radius` at `height` = sqrt(1 - rho^2), shape (n,); k = 0 but for power laws.

    `fewer` leaves out a quarter of the terms, for estimates of the error.
    """
    flat = punch_family(kernel).flat(radius / kernel.length)
    if kernel.exponent:
        return np.asarray(np.pi * (1 + kernel.exponent) * flat[:, 0])
    terms = flat.shape[1] - (flat.shape[1] // 4 if fewer else 0)
    flat = flat[:, :terms]
    coefficients = np.pi * flat / normalisation(terms)
    # Legendre recurrence for P_2n(height), summed as it goes
    total = coefficients[:, 0].copy()
    before, current = np.ones_like(height), height
    for n in range(1, terms):
        before = ((4 * n - 1) * height * current - (2 * n - 1) * before) / (2 * n)
        total += coefficients[:, n] * before
        current = ((4 * n + 1) * height * before - 2 * n * current) / (2 * n + 1)
    return np.asarray(total)
