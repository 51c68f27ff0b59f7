"""Round contact on a layer that lies loosely on its base: it lifts off outside a disc of radius b around the axis.

Symmetric and antisymmetric pressures on the two faces of a free plate of thickness h have C = 2 L/(E* k), x = k h/2,

    L_s = 2 sinh^2 x/(sinh 2x + 2x),      L_a = 2 cosh^2 x/(sinh 2x - 2x)

With the pressures p1 on the disc a under the tip and p2 on the disc b on the base, in the basis of flat punches (T3.1),

    M11 c1 + M12 c2 = (d - w) e0 - b[f],     M12' c1 + M22 c2 = w e0,     equal forces,     S[c1] = 0,     S[c2] = 0

M11 = int (L_s + L_a) j j dk, M12 = int (L_s - L_a) j j dk; M22 as M11, with the compliance of an elastic base. L_a ~ k^-3 at
long waves is felt by loads of no net force alone, so that j_0 is taken less j_0(ks) there; any length s gives the same result.
S[c2] = 0 is a root search for b, its smallest root; the rest is linear. Superposition over the history does not hold, as b
changes: every radius is solved by itself, and depth and force are interpolated over the radius.

Lengths are in units of h, pressures of E*.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliance import compliance
from flatpunch.contact.curve import Control, Curve, check_reach
from flatpunch.contact.round.mean_profile import mean_contact, mean_profile
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter
from flatpunch.media import FreeLayer, HalfSpace
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.basis import edge_signs
from flatpunch.punch.wavenumbers import spherical_bessel

WIDEST = 20.0
"""Largest contact radius over the thickness; beyond, the force is that of a sliding layer that cannot lift off, within 1e-4."""

_FARTHEST = 45.0
"""Largest k h at which the response of the layer differs from that of a half-space by more than rounding."""

_FIRST = 0.1
"""Distance beyond the contact under the tip, over the thickness, at which the search for that with the base begins."""

_PER_DECADE = 10
"""Radii that are solved per decade; cubics between them leave 1e-5 of the force."""


@dataclass(frozen=True, slots=True)
class _Plate:
    """Matrices of one layer on its base; `softness` is E* of the layer over that of the base, zero for a rigid one."""

    softness: float

    def solved(self, a: float, b: float, gap: Array | None) -> tuple[float, float, float]:
        """Depth and force for discs a and b, and the edge strength at b over the force; `gap` are b_l[f], None for a flat end.

        Under a flat end the depth is one.
        """
        n1, n2 = _terms(a) if gap is None else gap.size, _terms(b)
        n = n1 + n2
        system, right = np.zeros((n + 2, n + 2)), np.zeros(n + 2)
        system[:n, :n] = self._matrix(a, b, n1, n2)
        # unknowns: c1, c2, depth d, displacement w of the plate
        system[0, n], system[0, n + 1], system[n1, n + 1] = -1.0, 1.0, -1.0
        system[n, 0], system[n, n1] = 1.0, -1.0
        if gap is None:
            system[n + 1, n], right[n + 1] = 1.0, 1.0
        else:
            right[:n1] = -gap
            system[n + 1, :n1] = edge_signs(n1)
        c = np.linalg.solve(system, right)
        return float(c[n]), float(2 * np.pi * c[0]), float(edge_signs(n2) @ c[n1:n] / c[0])

    def _matrix(self, a: float, b: float, n1: int, n2: int) -> Array:
        s, step = 1.0, np.pi / max(a, b, 1.0)
        edges = np.concatenate([[0.0], np.geomspace(1e-3, step, 8), np.arange(2, _FARTHEST / step + 1) * step])
        t, v = gauss()
        half = np.diff(edges)[:, None] / 2
        k, w = (edges[:-1, None] + half * (t + 1)).ravel(), (half * v).ravel()
        j = np.vstack([spherical_bessel(2 * n, k * disc)[::2] for n, disc in ((n1, a), (n2, b))])
        less = j.copy()
        less[[0, n1]] -= np.sinc(k * s / np.pi)
        less[n1:] *= -1
        symmetric, antisymmetric = _responses(k / 2)
        matrix = (j * (w * (symmetric - 1))) @ j.T + (less * (w * (antisymmetric - 1))) @ less.T
        diagonal = [np.pi / (a * (4 * np.arange(n1) + 1)), np.pi / (b * (4 * np.arange(n2) + 1)) * (1 + self.softness)]
        return np.asarray(matrix + np.diag(np.concatenate(diagonal)))

    def contact(self, a: float, gap: Array | None, near: float | None) -> tuple[float, float, float]:
        """Radius b on the base, depth and force of a contact of radius a; `near` is b - a of a radius close by."""

        def edge(b: float) -> float:
            return self.solved(a, b, gap)[2]

        # distances beyond a, over which the edge strength varies: by the thickness, or far away by themselves
        low, high = (a, a + _FIRST) if near is None else (a + 0.6 * near, a + 1.6 * near)
        if near is not None and not edge(low) > 0 > edge(high):
            low, high = a, a + _FIRST
        if near is None and edge(low) <= 0:
            # pressures that fall off steeply from the axis leave the base within the contact
            low, high = 0.2 * (1 + a), a
        # to the smallest root; those beyond are contacts with tension
        while edge(high) > 0:
            low, high = high, a + 1.5 * (high - a)
        b = float(brentq(edge, low, high, xtol=1e-10))
        depth, force, _ = self.solved(a, b, gap)
        return b, depth, force


def solve(medium: FreeLayer, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """Round tips and flat punches at depths, forces or radii, with `base_radius`."""
    h, modulus = medium.thickness, medium.surface_modulus
    plate = _Plate(modulus / medium.base.surface_modulus if isinstance(medium.base, HalfSpace) else 0.0)
    if isinstance(indenter, Cylinder):
        if control.name == "radius":
            raise ValueError(
                "radius cannot control a cylinder, whose contact radius never changes. Give depth or force."
            )
        _check_width(np.array([indenter.radius]), h)
        b, _, stiffness = plate.contact(indenter.radius / h, None, None)
        k = stiffness * modulus * h
        depth = control.values if control.name == "depth" else control.values / k
        ones = np.ones_like(depth)
        return _curve(medium, phi, depth, k * depth, indenter.radius * ones, k * ones, b * h * ones)
    radii = _radii(medium, indenter, control)
    _check_width(radii, h)
    solved: list[tuple[float, float, float]] = []
    before = 0.0
    for a, gap in zip(radii / h, _moments(indenter, radii, h), strict=True):
        solved.append(plate.contact(float(a), gap, solved[-1][0] - before if solved else None))
        before = float(a)
    x = np.log(radii)
    columns = np.transpose([(*each, a) for each, a in zip(solved, radii, strict=True)])
    units = {"base": h, "depth": h, "force": modulus * h**2, "radius": 1.0}
    laws = {
        name: CubicSpline(x, np.log(column * unit)) for column, (name, unit) in zip(columns, units.items(), strict=True)
    }
    live = control.values > 0
    at = np.full(control.values.size, x[0])
    for i in np.flatnonzero(live):
        wanted = np.log(control.values[i])
        at[i] = brentq(lambda t, wanted=wanted: float(laws[control.name](t)) - wanted, x[0], x[-1], xtol=1e-13)
    found = {name: np.where(live, np.exp(law(at)), 0.0) for name, law in laws.items()}
    slope = laws["force"](at, 1) / laws["depth"](at, 1)
    tangent = np.where(live, found["force"] / np.where(live, found["depth"], 1.0) * slope, 0.0)
    return _curve(medium, phi, found["depth"], found["force"], found["radius"], tangent, found["base"])


def _curve(
    medium: FreeLayer, phi: Array, depth: Array, force: Array, radius: Array, stiffness: Array, base: Array
) -> Curve:
    return Curve(
        depth=depth,
        force=force,
        radius=radius,
        area=np.pi * radius**2,
        stiffness=stiffness,
        contour=np.repeat(radius[:, None], phi.size, axis=1),
        valid=np.ones(depth.size, dtype=bool),
        notes=(),
        extra={"base_radius": (("step",), base, "m", "radius of the contact between layer and base")},
    )


def _radii(medium: FreeLayer, indenter: Indenter, control: Control) -> Array:
    """Radii to be solved [m], around those at which the layer would be if it were held down, which differ by some per cent."""
    if control.name == "radius":
        check_reach(indenter, control.values)
        low, high = control.values[control.values > 0].min(initial=np.inf), control.values.max()
        low = min(low, high)
    else:
        found = mean_contact(compliance(medium.held_down), indenter, control)[1].radius
        low, high = found[found > 0].min(initial=np.inf) / 1.15, found.max() * 1.15
        high = min(high, indenter.reach)
    if not high > 0:
        low, high = medium.thickness / 100, medium.thickness / 50
    count = 6 + int(np.ceil(_PER_DECADE * np.log10(high / low)))
    return np.asarray(np.geomspace(low * (1 - 1e-9), high * (1 + 1e-9), count))


def _moments(indenter: Indenter, radii: Array, h: float) -> list[Array]:
    """b_l[f] of a tip on discs of given radii, in units of h."""
    profile = mean_profile(indenter)
    return [profile.moments(np.array([a]), _terms(a / h)).b[0] / h for a in radii]


def _terms(radius: float) -> int:
    """Terms of the basis on a disc: the pressure varies over a thickness."""
    return int(14 + 4 * radius)


def _check_width(radii: Array, h: float) -> None:
    if radii.max() > WIDEST * h:
        raise ValueError(
            f"The contact radius of {text(float(radii.max()), 'm')} is more than {WIDEST:g} thicknesses of the FreeLayer. It "
            "hardly lifts off there: take Medium([Layer(..., bonded=False)], base=...)."
        )


def _responses(x: Array) -> tuple[Array, Array]:
    """L_s and L_a at x = k h/2 > 0."""
    y = 2 * x
    # sinh y - y by its series, where the difference would be rounding
    few = y**3 / 6 * (1 + y**2 / 20 * (1 + y**2 / 42 * (1 + y**2 / 72 * (1 + y**2 / 110 * (1 + y**2 / 156)))))
    return 2 * np.sinh(x) ** 2 / (np.sinh(y) + y), 2 * np.cosh(x) ** 2 / np.where(y < 1, few, np.sinh(y) - y)
