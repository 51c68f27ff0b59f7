"""Flat-punch responses as smooth functions of the punch radius, sampled once on Chebyshev panels of log(beta) and kept.

All properties of a medium's flat punches are analytic in log(beta). Panels are a decade wide where the contact is small against
every length of the medium and a quarter of one where it is large: larger radii cost more, and a panel should not reach far beyond
what is read. They are halved until their series end.

The responses of `solve_round` are kept with the kernel, so that a whole curve costs a few dozen small linear systems.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array, Indices
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.numerics.chebyshev import NODES, polynomials, tail
from flatpunch.numerics.piecewise import Piece, PiecewiseChebyshev
from flatpunch.punch.basis import OUTWARDS, RELATIVE, node_count, power_edge, power_moments, projection, regular_part
from flatpunch.punch.matrix import (
    RESOLVED,
    Responses,
    edge_strength,
    effective_beta,
    fewer_terms,
    largest_beta,
    solve_round,
    solve_with_fewer,
    sufficient_terms,
)
from flatpunch.punch.power_law import power_law_punch

TOLERANCE = 1e-10
"""Tail above which a panel is halved; a tenth of it is below rounding, ten times as much shows in slopes."""


_WIDTHS = np.array([8, 4, 2, 1, 4])
"""Widths of panels in eighths of a decade, with growing radius; twice as wide they are halved, half as wide solves more radii."""

_DECADE = int(_WIDTHS[0])

_UNIT = np.log(10) / _DECADE
"""Unit of the widths in ln beta."""

_NODES = {_DECADE: NODES, 4: NODES, 2: 16, 1: 12}
"""Nodes by width: 16 and 12 leave as little on narrow panels, 1e-14 to 1e-12 of flat and edge responses."""


_ENDS = np.array([0.1, 4.0, 12.0, 1.06 * RESOLVED])
"""Effective beta at the end of a half decade above which panels have the next of the widths."""


def panels(
    kernel: Kernel,
    sample: Callable[[Array], Array],
    judge: Callable[[Array], float] = tail,
    floor: Callable[[Array], float] = lambda series: 0.0,
) -> PiecewiseChebyshev:
    """A function of x = log(beta) for one medium, whose shortest length decides where panels may be wide.

    `sample` maps the radii at the nodes of one panel, shape (n,), to values, shape (n, outputs); `judge` maps Chebyshev
    coefficients, shape (nodes, outputs), to the relative size of their tail, which decides on halving, and `floor` to the tail
    that is rounding, which no halving removes.
    """
    bounds = _bounds(kernel)

    def edges(x: Array) -> Array:
        first, last = (np.floor(end / (_DECADE * _UNIT)) for end in (x.min(), x.max()))
        unit = np.arange(_DECADE * first, _DECADE * (last + 1))
        width = _WIDTHS[np.searchsorted(bounds, unit // 4, side="right")]
        return np.asarray(np.append(np.unique(unit // width * width), unit[-1] + 1) * _UNIT)

    def beyond(low: float) -> bool:
        """Whether the contacts of a panel that begins here are too wide to resolve the shortest length."""
        return bool(low > (4 * bounds[-1] - 0.5) * _UNIT)

    def nodes(low: float, high: float) -> int:
        # nodes beyond the resolved lengths, where functions are nearly powers of beta and 1e-8 is enough
        return 10 if beyond(low) else _NODES[round((high - low) / _UNIT)]

    def rough(piece: Piece) -> bool:
        # more on graded media, whose responses are interpolated to 2e-12 and differentiated for edges, and beyond the resolved
        # lengths, where truncation leaves as much of radii; forces at given depth have its square
        tolerance = 1e-9 if kernel.graded else 1e-5 if beyond(piece.low) else TOLERANCE
        return piece.error > max(tolerance, floor(piece.series)) and piece.high - piece.low > _UNIT / 2

    # responses of steep gradings have noise far below this, poles of outlines have tails far above it
    noise = 1e-5 if kernel.graded else 0.0
    return PiecewiseChebyshev(lambda x: sample(np.exp(x)), edges, nodes, judge=judge, rough=rough, noise=noise)


def _bounds(kernel: Kernel) -> Array:
    if kernel.graded:
        # radii of any size cost the same
        return np.full(_ENDS.size, np.inf)
    with np.errstate(divide="ignore"):
        return np.asarray(np.ceil(np.log(_ENDS / np.float64(effective_beta(kernel, 1.0))) / (4 * _UNIT) - 1))


def polynomials_on(parts: list[tuple[Piece, Indices]], logs: Array) -> Array:
    """Chebyshev polynomials at many log(beta), each of its own panel, shape (nodes, n): once for all panels, which is faster."""
    x = np.empty_like(logs)
    for panel, inside in parts:
        x[inside] = panel.unit(logs[inside])
    return polynomials(x, max((panel.nodes for panel, _ in parts), default=1) - 1)


SMALLEST = 1e-16
"""beta below which every medium is its own surface's half-space: Kbar differs from 1 by 6e-14 on a base 1e4 times softer."""

_KINKS = 3e-8
"""What truncation leaves of depth and force under cones and sharper tips on graded surfaces: 2e-8 is the largest found, for
r^(1/2) on a surface 1e4 times stiffer than its base; 1e-9 under cones, 1e-10 under paraboloids."""


class PunchFamily:
    """All cylindrical flat punches on one medium.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    """

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self._panels = panels(kernel, self._sample, _judge, _rounding)
        self._lowest: dict[tuple[float, float], float] = {}

    def at(self, beta: Array, *, nodes: bool = False) -> Responses:
        """Responses of the unit-disc matrices at radii beta = a/l.

        Parameters
        ----------
        beta : ndarray, shape (n,)
            Punch radii in units of the medium's length, >= 0 (any value on a half-space).
        nodes : bool
            Whether they are nodes of a panel, which may end a little above the largest radius that is let through.

        Returns
        -------
        Responses
            Arrays of shape (n, terms), padded with zeros to the largest number of terms needed.

        Raises
        ------
        ValueError
            If a radius is too large for the resolution of the thinnest layer.
        """
        values = self._gather(beta, 3, nodes=nodes)
        return Responses(values[:, 0], values[:, 1], values[:, 2], np.full(beta.size, np.finfo(float).eps))

    def flat(self, beta: Array) -> Array:
        """Coefficients c* of the flat punch alone, shape (n, terms)."""
        return self._gather(beta, 1)[:, 0]

    def _gather(self, beta: Array, kinds: int, *, nodes: bool = False) -> Array:
        """The first `kinds` responses (flat, edge, slope), shape (n, kinds, terms)."""
        if self.kernel.exponent:
            return self._power_law(beta)[:, :kinds]
        live = self._live(beta)
        parts = self._parts(beta[live], nodes=nodes)
        terms = max((_terms(panel) for panel, _ in parts), default=1)
        values = np.zeros((beta.size, kinds, terms))
        values[:, 0, 0] = 1 / np.pi
        basis = polynomials_on(parts, np.log(beta[live]))
        for panel, inside in parts:
            n = _terms(panel)
            found = basis[: panel.nodes, inside].T @ panel.series[:, : kinds * n]
            values[live[inside], :, :n] = found.reshape(-1, kinds, n)
        return values

    def _power_law(self, beta: Array) -> Array:
        """Responses of a power-law half-space, (n, 3, 1): one term p_0 = 2 (1 + alpha)(1 - r^2)^alpha, and Krein's e."""
        stiffness = power_law_punch(self.kernel).normalized_stiffness(
            np.where(beta > 0, beta, 1.0) * self.kernel.length
        )
        strength = np.sqrt((1 + self.kernel.exponent) * stiffness) / np.pi
        return np.stack([stiffness / np.pi, strength - 1 / np.pi, np.zeros_like(beta)], axis=1)[:, :, None]

    def rule(self, beta: Array) -> tuple[Array, Array]:
        """Nodes rho, shape (nodes,), and weights, shape (n, nodes), with int_0^1 f p* rho drho = weights.f(rho)."""
        flat = self.flat(beta)
        if self.kernel.exponent:
            punch = power_law_punch(self.kernel)
            rho, weight = punch.rule(100)
            return rho, flat * (2 * (1 + punch.alpha) * weight)
        rho, matrix = projection(0, flat.shape[1], node_count(flat.shape[1]))
        return rho, flat @ matrix

    def error(self, beta: Array) -> tuple[float, float]:
        """Relative errors of forces at given depth (or depths at given force), and of radii, at `beta`.

        Those of the responses count: the Chebyshev tail over their panels. Under graded surfaces, and where layers are
        thin beyond `RESOLVED`, also what terms beyond the last leave, of cones too. Forces at given depth are stationary in the
        radius, and feel the error of the stiffness and the square of the radius' own.
        """
        beta = beta[self._live(beta)]
        if not beta.size:
            return 0.0, 0.0
        panels = [panel for panel, _ in self._parts(beta)]
        interpolation, largest = max(panel.error for panel in panels), float(beta.max())
        if self.kernel.solution is not None and self.kernel.solution.covers(beta):
            return (interpolation + self.kernel.solution.error,) * 2
        if self.kernel.graded:
            return (interpolation + self._truncation(largest),) * 2
        if effective_beta(self.kernel, largest) <= RESOLVED:
            return interpolation, interpolation
        force, radius = self._skin(largest)
        return force + interpolation**2 + max(tail(p.series[:, : _terms(p)]) for p in panels), radius + interpolation

    def _skin(self, beta: float) -> tuple[float, float]:
        """Changes of stiffness and force at given depth, and of depth at given radius, under a cone, with fewer terms."""
        terms, found = sufficient_terms(self.kernel, beta), []
        for responses in solve_with_fewer(self.kernel, np.array([beta]), terms, fewer_terms(self.kernel, beta, terms)):
            b = power_moments(1.0, 0, responses.flat.shape[1])
            depth = (power_edge(1.0, 0) + b @ responses.edge[0]) / edge_strength(responses)[0]
            found.append((responses.flat[0, 0], depth, depth * responses.flat[0, 0] - b @ responses.flat[0]))
        (stiffness, depth, whole), (stiff, shallow, force) = found
        at_depth = (force + stiff * (depth - shallow)) / whole - 1
        return float(max(abs(stiff / stiffness - 1), abs(at_depth))), float(abs(shallow / depth - 1))

    def _truncation(self, beta: float) -> float:
        """Change of flat punch and edge strength when a quarter of the terms is left out; it grows with the radius."""
        assert self.kernel.series is not None
        # largest radius, in units of the surface's own length E/E', for which the terms are known to suffice
        if beta * self.kernel.series.sharpness < 100.0:
            return _KINKS
        terms = sufficient_terms(self.kernel, beta)
        many, few = solve_with_fewer(self.kernel, np.array([beta]), terms, 3 * terms // 4)
        stiffness = abs(few.flat[0, 0] / many.flat[0, 0] - 1)
        edge = abs((1 + np.pi * few.edge[0, 0]) / (1 + np.pi * many.edge[0, 0]) - 1)
        # the force F ~ d^3 of thin layers has three times the error of its depth
        return float(_KINKS + 3 * max(stiffness, edge))

    def lowest_pressure(self, beta: Array) -> float:
        """Smallest punch pressure times sqrt(1 - rho^2) over its mean, over `beta` and between; < 0 is tension.

        It is taken on the panels that hold `beta`; far beyond the shortest length, where these are expensive, at some of `beta`.
        """
        beta = np.sort(beta[self._live(beta)])
        if beta.size and effective_beta(self.kernel, float(beta[-1])) > RESOLVED and not self.kernel.graded:
            return self._lowest_at(beta)
        return min((self._lowest_on(panel) for panel, _ in self._parts(beta[self._live(beta)])), default=1.0)

    def _live(self, beta: Array) -> Indices:
        return np.flatnonzero((beta > SMALLEST) & (not self.kernel.homogeneous and not self.kernel.exponent))

    def _parts(self, beta: Array, *, nodes: bool = False) -> list[tuple[Piece, Indices]]:
        if not beta.size:
            return []
        # a panel may end half a decade above the largest radius; tables of graded surfaces do not grow with it
        slack = 1.0 if not nodes else np.inf if self.kernel.graded else 10**0.5
        check_resolution(self.kernel, float(beta.max()) / slack)
        return self._panels.parts(np.log(beta))

    def _sample(self, beta: Array) -> Array:
        known = self.kernel.solution
        if known is not None and known.covers(beta):
            return np.hstack(known.round(beta))
        responses = solve_round(self.kernel, beta, sufficient_terms(self.kernel, float(beta.max())))
        return np.hstack([responses.flat, responses.edge, responses.slope])

    def _lowest_at(self, beta: Array) -> float:
        """Lowest pressure at ascending radii, from the largest to the first that pulls; at every fourth where unresolved."""
        far = np.searchsorted(beta, RESOLVED / effective_beta(self.kernel, 1.0))
        lowest = np.inf
        for group in (*np.split(beta[:far], np.arange(4, far, 4)), beta[::-1][: beta.size - far : 4][::-1])[::-1]:
            if group.size and lowest >= 0:
                terms = sufficient_terms(self.kernel, float(group[-1]))
                flat = solve_round(self.kernel, group, terms).flat
                lowest = min(lowest, float((flat @ regular_part(0, terms, OUTWARDS) / flat[:, :1]).min()))
        return lowest

    def _lowest_on(self, panel: Piece) -> float:
        key = (panel.low, panel.high)
        if key not in self._lowest:
            terms = _terms(panel)
            flat = panel.at(np.linspace(panel.low, panel.high, panel.nodes))[:, :terms]
            self._lowest[key] = float((flat @ regular_part(0, terms, OUTWARDS) / flat[:, :1]).min())
        return self._lowest[key]


class UnresolvedLayer(ValueError):
    """A contact is so large that the shortest length of the medium cannot be resolved; the message gives the ratio."""


def check_resolution(kernel: Kernel, beta: float) -> None:
    """Refuse radii so large that the thinnest layer cannot be resolved."""
    if effective_beta(kernel, beta) > largest_beta(kernel):
        raise UnresolvedLayer(
            f"The contact radius {text(beta * kernel.length, 'm')} is {effective_beta(kernel, beta):.3g} times the shortest "
            f"length of the medium; {unresolved_advice(kernel)}"
        )


def unresolved_advice(kernel: Kernel) -> str:
    """Limit of the contact radius and remedy, as the end of a message."""
    shortest, largest = kernel.length / effective_beta(kernel, 1.0), largest_beta(kernel)
    return (
        f"up to {largest:g} of them, {text(largest * shortest, 'm')}, are solved (length {text(shortest, 'm')}: a "
        "layer's thickness, or "
        "less where the modulus varies faster). Check the units of thickness and contact. On an elastic body so thin a skin may "
        "be left out: it changes the force by about thickness/radius times the ratio of the moduli. On a rigid base use the "
        "thin-layer limit instead."
    )


def _terms(panel: Piece) -> int:
    return int(panel.series.shape[1]) // 3


def _judge(series: Array) -> float:
    """Tails of the flat and the edge responses; edge strengths are 1/pi and more where the medium hardly matters."""
    terms = series.shape[1] // 3
    edge = series[:, terms : 2 * terms]
    return max(tail(series[:, :terms]), tail(edge) * min(1.0, np.pi * float(np.abs(edge).max())))


def _rounding(series: Array) -> float:
    """L - 1 is known to eps, and the smallest eigenvalue of A is about 1/Kbar (thin incompressible layers)."""
    return float(RELATIVE * np.pi * np.abs(series[0, 0]))


@byte_cached
def punch_family(kernel: Kernel) -> PunchFamily:
    """The family of a kernel; solutions already computed are shared."""
    return PunchFamily(kernel)
