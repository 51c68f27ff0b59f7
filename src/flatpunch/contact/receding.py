"""Round contact on a layer that lies loosely on its base: it lifts off outside a disc of radius b around the axis.

Symmetric and antisymmetric pressures on the two faces of a free plate of thickness h have C = 2 L/(E* k), x = k h/2,

    L_s = 2 sinh^2 x/(sinh 2x + 2x),      L_a = 2 cosh^2 x/(sinh 2x - 2x)

With the pressures p1 on the disc a under the tip and p2 on the disc b on the base, in the basis of flat punches (T3.1),

    M11 c1 + M12 c2 = (d - w) e0 - b[f],     M12' c1 + M22 c2 = w e0,     equal forces,     S[c1] = 0,     S[c2] = 0

M11 = int (L_s + L_a) j j dk, M12 = int (L_s - L_a) j j dk; M22 as M11, with the compliance of an elastic base. L_a ~ k^-3 at
long waves is felt by loads of no net force alone, so that j_0 is taken less j_0(ks) there; any length s gives the same result.
S[c2] = 0 is a root search for b, its smallest root; the rest is linear. Superposition over the history does not hold, as b
changes: every radius is solved by itself, and depth and force are interpolated over the depth of a layer that is held down.

Radii are in units of h.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import factorial

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliances import compliance
from flatpunch.compliances.layered import SATURATION
from flatpunch.contact.curve import Control, Curve
from flatpunch.contact.round.mean_profile import mean_contact, mean_profile
from flatpunch.contact.round.profile import Moments
from flatpunch.contact.round.round_contact import RoundContact
from flatpunch.indenters.profile import Indenter
from flatpunch.media.stack import LooseBody
from flatpunch.numerics.gauss import NODES, gauss
from flatpunch.punch.basis import edge_signs
from flatpunch.punch.wavenumbers import spherical_bessel

WIDEST = 20.0
"""Largest contact radius over the thickness; beyond, the force is that of a sliding layer that cannot lift off, within 1e-4."""

_FARTHEST = 2 * SATURATION
"""Largest k h at which the response of the layer differs from that of a half-space: beyond, its half hides the rest."""

_FIRST = 0.1
"""Distance beyond the contact under the tip, over the thickness, at which the search for that with the base begins."""

_PER_DECADE = 10
"""Contacts that are solved per decade of depth, cubics between leave 1e-6 of the force. Twice as many take twice the time."""

_MORE = 8
"""Terms, and nodes of the quadrature, that the contacts have beyond the others which those are checked against."""


@dataclass(frozen=True, slots=True)
class _Plate:
    """Matrices of one layer on its base; `softness` is E* of the layer over that of the base, zero for a rigid one.

    `more` terms and nodes make the matrices for a check.
    """

    softness: float
    more: int = 0

    def solved(self, a: float, b: float, gap: Moments | None) -> tuple[float, float, float]:
        """Depth, force over E* h, and edge strength at b over the force, for discs a and b in units of h.

        `gap` is None for a flat end, under which the depth is one.
        """
        n1, n2 = self.terms(a), self.terms(b)
        n = n1 + n2
        system, right = np.zeros((n + 2, n + 2)), np.zeros(n + 2)
        system[:n, :n] = self._matrix(a, b, n1, n2)
        # unknowns: c1, c2, depth d, displacement w of the plate
        system[0, n], system[0, n + 1], system[n1, n + 1] = -1.0, 1.0, -1.0
        system[n, 0], system[n, n1] = 1.0, -1.0
        if gap is None:
            system[n + 1, n], right[n + 1] = 1.0, 1.0
        else:
            right[:n1] = -gap.b[0]
            system[n + 1, :n1] = edge_signs(n1)
            # terms beyond the last are those of a half-space, whose sum is known: a ring in the profile has many
            right[n + 1] = a * gap.edge[0] - edge_signs(n1) @ (gap.b[0] / _half_space(a, n1))
        c = np.linalg.solve(system, right)
        return float(c[n]), float(2 * np.pi * c[0]), float(edge_signs(n2) @ c[n1:n] / c[0])

    def terms(self, radius: float) -> int:
        """Terms of the basis on a disc: the pressure varies over a thickness."""
        return int(14 + 4 * radius) + self.more

    def _matrix(self, a: float, b: float, n1: int, n2: int) -> Array:
        s, step = 1.0, np.pi / max(a, b, 1.0)
        edges = np.concatenate([[0.0], np.geomspace(1e-3, step, 8), np.arange(2, _FARTHEST / step + 1) * step])
        t, v = gauss(NODES + self.more)
        half = np.diff(edges)[:, None] / 2
        k, w = (edges[:-1, None] + half * (t + 1)).ravel(), (half * v).ravel()
        j = np.vstack([spherical_bessel(2 * n, k * disc)[::2] for n, disc in ((n1, a), (n2, b))])
        less = j.copy()
        less[[0, n1]] -= np.sinc(k * s / np.pi)
        less[n1:] *= -1
        symmetric, antisymmetric = _responses(k / 2)
        matrix = (j * (w * (symmetric - 1))) @ j.T + (less * (w * (antisymmetric - 1))) @ less.T
        diagonal = [_half_space(a, n1), _half_space(b, n2) * (1 + self.softness)]
        return np.asarray(matrix + np.diag(np.concatenate(diagonal)))

    def contact(self, a: float, gap: Moments | None) -> tuple[float, float, float]:
        """Radius b on the base, depth and force over E* h of a contact of radius a."""

        @cache
        def at(b: float) -> tuple[float, float, float]:
            return self.solved(a, b, gap)

        def edge(b: float) -> float:
            return at(b)[2]

        # distances beyond a, over which the edge strength varies: by the thickness, or far away by themselves
        low, high = a, a + _FIRST
        if edge(low) <= 0:
            # pressures that fall off steeply from the axis leave the base within the contact
            low, high = 0.2 * (1 + a), a
        # to the smallest root; those beyond are contacts with tension
        while edge(high) > 0:
            low, high = high, a + 1.5 * (high - a)
        # the force is stationary in b
        b = float(brentq(edge, low, high, xtol=1e-8))
        depth, force, _ = at(b)
        return b, depth, force


def solve(medium: LooseBody, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """Round tips and flat punches at depths, forces or radii, with `base_radius` and the estimated error of the force."""
    h, modulus = medium.thickness, medium.surface_modulus
    softness = modulus * medium.base.softest
    plate, finer = _Plate(softness), _Plate(softness, _MORE)
    depths = depths_held_down(medium, indenter, control)
    if indenter.flat:
        b, _, stiffness = plate.contact(indenter.reach / h, None)
        error = abs(stiffness / finer.contact(indenter.reach / h, None)[2] - 1)
        k = stiffness * modulus * h
        depth = control.values if control.name == "depth" else control.values / k
        ones = np.ones_like(depth)
        return _curve(phi, depth, k * depth, indenter.reach * ones, k * ones, b * h * ones, error)
    live = control.values > 0
    # where depth or force are given, those of the layer that lifts off lie well within
    x = np.log(_solved_depths(medium, indenter, depths, 1.1 if control.name == "radius" else 1.5))
    names = ("base", "depth", "force", "radius")
    solved = _contacts(plate, medium, indenter, x)
    laws = {name: CubicSpline(x, np.log(column)) for name, column in zip(names, solved, strict=True)}
    at = np.log(np.where(live, depths, np.exp(x[0])))
    if control.name != "radius":
        law, wanted = laws[control.name], np.log(control.values[live])
        at[live] = [brentq(lambda t, aim=aim: float(law(t)) - aim, x[0], x[-1]) for aim in wanted]
    found = {name: np.where(live, np.exp(law(at)), 0.0) for name, law in laws.items()}
    slope = laws["force"](at, 1) / laws["depth"](at, 1)
    # at contacts between, which the cubics have not seen
    between = (x[1:] + x[:-1]) / 2
    _, depth, force, _ = np.log(_contacts(finer, medium, indenter, between))
    steepness = laws["force"](between, 1) / laws["depth"](between, 1)
    off = laws["force"](between) - force - steepness * (laws["depth"](between) - depth)
    error = float(np.abs(off).max())
    tangent = np.where(live, found["force"] / np.where(live, found["depth"], 1.0) * slope, 0.0)
    return _curve(phi, found["depth"], found["force"], found["radius"], tangent, found["base"], error)


def depths_held_down(medium: LooseBody, indenter: Indenter, control: Control) -> Array:
    """Depths of the steps on a layer that is held down [m], which differ by some per cent; refuses what cannot be solved."""
    if indenter.flat:
        if control.name == "radius":
            raise ValueError(
                "radius cannot control a cylinder, whose contact radius never changes. Give depth or force."
            )
        widest, depths = indenter.reach, control.values
    else:
        held = _held_down(medium, indenter, control)
        widest, depths = float(held.radius.max()), held.depth
    if widest > WIDEST * medium.thickness:
        raise ValueError(
            f"The contact radius of {text(widest, 'm')} is more than {WIDEST:g} thicknesses of the FreeLayer. It hardly lifts "
            "off there: take Medium([Layer(..., bonded=False)], base=...)."
        )
    return depths


def _solved_depths(medium: LooseBody, indenter: Indenter, depths: Array, margin: float) -> Array:
    """Depths on the layer held down [m] at whose radii contacts are solved, a margin beyond those of the steps."""
    live = depths[depths > 0] if (depths > 0).any() else np.array([medium.thickness / 100])
    low, high = live.min() / margin, live.max() * margin
    if np.isfinite(indenter.reach):
        high = min(high, float(_held_down(medium, indenter, Control("radius", np.array([indenter.reach]))).depth[0]))
    return np.geomspace(low, high, 6 + int(np.ceil(_PER_DECADE * np.log10(high / low))))


def _held_down(medium: LooseBody, indenter: Indenter, control: Control) -> RoundContact:
    return mean_contact(compliance(medium.held_down), indenter, control)[1]


def _contacts(plate: _Plate, medium: LooseBody, indenter: Indenter, x: Array) -> Array:
    """Radius on the base, depth, force and radius, a row each, of contacts as wide as on a layer held down at depths exp(x)."""
    h, modulus, profile = medium.thickness, medium.surface_modulus, mean_profile(indenter)
    radii = _held_down(medium, indenter, Control("depth", np.exp(x))).radius
    solved = [plate.contact(float(a), profile.moments(np.array([a * h]), plate.terms(a))) for a in radii / h]
    return np.vstack([np.transpose(solved) * np.array([[h], [1.0], [modulus * h]]), radii])


def _curve(phi: Array, depth: Array, force: Array, radius: Array, stiffness: Array, base: Array, error: float) -> Curve:
    return Curve(
        depth=depth,
        force=force,
        radius=radius,
        area=np.pi * radius**2,
        stiffness=stiffness,
        contour=np.repeat(radius[:, None], phi.size, axis=1),
        valid=np.ones(depth.size, dtype=bool),
        notes=(),
        extra={
            "base_radius": (("step",), base, "m", "radius of the contact between layer and base"),
            "force_error": (("step",), np.full(depth.size, error), "1", "estimated relative error of the force"),
        },
    )


def _half_space(radius: float, terms: int) -> Array:
    return np.asarray(np.pi / (radius * (4 * np.arange(terms) + 1)))


def _responses(x: Array) -> tuple[Array, Array]:
    y = 2 * x
    # sinh y - y by its series, where the difference would be rounding
    few = y**3 * np.polynomial.polynomial.polyval(y**2, [1 / factorial(2 * j + 3) for j in range(6)])
    return 2 * np.sinh(x) ** 2 / (np.sinh(y) + y), 2 * np.cosh(x) ** 2 / np.where(y < 1, few, np.sinh(y) - y)
