"""Asperities that feel each other: each sinks into what its neighbours have pressed down.

By reciprocity the depth of asperity i is reduced by the displacement that asperity j makes, averaged with the pressure of the
flat punch under contact i,

    w_ij = (1/2 pi) int k C(k) J0(k r_ij) P*_i P_j dk / K_i

exact for round contacts to first order. The transforms P are taken to fourth order in k, so that only the Green's function G(r)
of the surface, its Laplacian and the second and fourth moments of the pressures are needed:

    w_ij = F_j [G + (s_i + m_j) lap G/4 + (s4_i + 4 s_i m_j + m4_j) lap lap G/64]

with mean r^2 and r^4 of punch (s) and contact (m). The contact is the sum of punches over its history, hence F m_j = int K s dd.
To second order the surface that neighbours have pressed down has a gradient t_i: a paraboloid of radius R touches by R t_i uphill
of its apex, where it is deeper by R t_i^2/2, and acts on the others from there. For other tips R is the contact radius over the
slope at the rim. Newton's method solves for all depths at once.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline, PchipInterpolator, make_interp_spline
from scipy.special import gamma

from flatpunch._support.ceilings import OUTLINES
from flatpunch._support.checks import ROUNDING, Array, Flags, Values, numbers, refused_overflow, shown, values
from flatpunch._support.record import record
from flatpunch._version import __version__
from flatpunch.bem.operator.influence import power_exponent
from flatpunch.bem.operator.radial import remainder_table
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.curve import control_from, first_failure
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.indentation import indent
from flatpunch.indenters.profile import Indenter, check_indenter, check_rising
from flatpunch.media import Body
from flatpunch.punch import flat_punch

if TYPE_CHECKING:
    import xarray as xr

_DECADES, _POINTS = 6, 181
"""Depths of the curve of one asperity, downwards from the largest, and their number: cubics between them are exact to 1e-7."""

_RADII = 24
"""Radii at which flat punches are solved for their moments, which vary slowly."""

_CLOSE = 0.5
"""Gap between contacts over the larger radius below which the force was off by more than 1 % of boundary elements."""

_STEPS = 60
"""Most steps of Newton's method; ten are usual."""


@refused_overflow()
def asperities(
    medium: Body,
    tips: Indenter | Sequence[Indenter],
    positions: ArrayLike,
    heights: Values = 0.0,
    *,
    depth: Values | None = None,
    force: Values | None = None,
) -> xr.Dataset:
    """Press many asperities of one rigid body into a medium, each sinking into what the others press down.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body.
    tips : Indenter or sequence of them
        Shape of each asperity, or one for all: round tips are exact, others are solved by the default method of `indent` and act
        on their neighbours as round ones of their mean radius.
    positions : array, shape (n, 2)
        Places (x, y) of their apexes [m].
    heights : float or array, shape (n,)
        Heights of the apexes over a common plane [m], peaks positive.
    depth, force : float or array, shape (steps,)
        One of them: depth of the highest apex below the undeformed surface [m], or the total force [N].

    Returns
    -------
    xarray.Dataset
        Along `step`: depth [m], force (total) [N], stiffness dF/dd [N/m], contacts (number of asperities that touch), gap (the
        smallest between two contacts [m], negative where they overlap) and valid (False there). Along `step` and `asperity`:
        asperity_force [N], radius [m] and asperity_depth [m], of the apex below the surface that the others have pressed down.

    Raises
    ------
    ValueError, TypeError
        On bad input, before any work.

    See Also
    --------
    rough_contact : Boundary elements, for contacts that merge.
    surfaces.Summits : Places, heights and curvatures of the summits of a surface.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=20e-6)], base=fp.RigidBase())
    >>> beads = [(0.0, 0.0), (15e-6, 0.0), (0.0, 15e-6)]
    >>> three = fp.asperities(gel, fp.Sphere(radius=10e-6), beads, depth=1e-6)
    >>> one = fp.indent(gel, fp.Sphere(radius=10e-6), depth=1e-6)
    >>> print((three.asperity_force.values[0] / float(one.force[0])).round(3))
    [0.996 1.014 1.014]
    """
    places = numbers("positions", positions, "m")
    if places.ndim != 2 or places.shape[1:] != (2,) or not places.size or not np.isfinite(places).all():
        raise ValueError(
            f"positions has shape {places.shape}; it must be finite places (n, 2) in metres, x and y of each asperity."
        )
    n = len(places)
    tops = values("heights", heights, minimum=-np.inf, unit="m", smallest=0.0)
    if tops.size not in (1, n):
        raise ValueError(f"heights has {tops.size} values for {n} positions; give one for each, or one for all.")
    if not isinstance(tips, (Indenter, list, tuple)):
        raise TypeError(f"tips = {shown(tips)} must be an indenter such as Sphere(radius=...), or a list of them.")
    given = n * [tips] if isinstance(tips, Indenter) else list(tips)
    if len(given) != n:
        raise ValueError(f"tips has {len(given)} entries for {n} positions; give one for each, or one for all.")
    for tip in given:
        check_indenter(tip)
        check_rising(tip)
    control = control_from(depth=depth, force=force, radius=None)
    if control.values.size * n > OUTLINES:
        raise ValueError(
            f"{control.values.size} steps of {n} asperities make more than {OUTLINES:.0e} numbers. Solve fewer at once."
        )
    distance = np.hypot(*(places[:, None] - places).T)
    np.fill_diagonal(distance, np.inf)
    if n > 1 and distance.min() == 0:
        i, j = (int(k) for k in np.argwhere(distance == 0)[0])
        raise ValueError(f"positions[{i}] and positions[{j}] are equal; two asperities cannot be at one place.")
    kernel, lower = compliance(medium), np.broadcast_to(tops.max() - tops, (n,))
    shapes = list(dict.fromkeys(given))
    influence = _influence(kernel, distance)
    away = (places[:, None] - places) / distance[..., None]
    # incompressible layers rise beside a contact, which presses neighbours deeper than the depth prescribed
    beyond = 1.5 if influence[0].min() < 0 else 1.0
    laws = [_Law.of(medium, tip, control.name, float(control.values.max()), beyond) for tip in shapes]
    kind = np.array([shapes.index(tip) for tip in given])
    group = _Group(laws, kind, lower, influence, away)
    steps, start = [], None
    for target in control.values:
        found = group.solve(float(target), start, by_depth=control.name == "depth")
        start = found[0]
        steps.append(found)
    return _dataset(medium, shapes, group, steps, distance, control.name)


@dataclass(frozen=True, slots=True)
class _Law:
    """One asperity alone: logarithms of force and radius over that of depth, and shape factors.

    These are mean r^2 and r^4 of punch and contact over a^2 and a^4, and the radius of curvature over a^2.

    Below the smallest depth they are powers; above the largest nothing is known.
    """

    force: CubicSpline
    radius: CubicSpline
    moments: PchipInterpolator
    first: float
    last: float

    @classmethod
    def of(cls, medium: Body, tip: Indenter, name: str, largest: float, beyond: float) -> _Law:
        """The law of a tip up to `beyond` times a depth [m] or that of a force [N]."""
        if largest == 0:
            name, largest = "depth", 1e-9
        deepest = largest if name == "depth" else float(indent(medium, tip, force=largest)["depth"][0])
        depth = beyond * deepest * np.geomspace(10.0**-_DECADES, 1.0, _POINTS)
        curve = indent(medium, tip, depth=depth)
        x, a, force = np.log(depth), curve["radius"].values, curve["force"].values
        phi = 2 * np.pi * np.arange(36) / 36
        slope = np.mean(np.broadcast_to(tip.slope(a[:, None], phi), (a.size, phi.size)), axis=1)
        if not ((slope > 0).all() and (np.diff(a) > 0).all()):
            raise ValueError(
                f"tips contains {type(tip).__name__}, which has a flat end: asperities take tips that are curved or pointed at "
                "their apex. rough_contact takes flat tops."
            )
        radii = np.geomspace(a[0], a[-1], _RADII)
        punches = [flat_punch(medium, float(radius)) for radius in radii]
        own = [[punch.moment(k) / ((k + 1) * punch.normalized_stiffness) for punch in punches] for k in (2, 4)]
        punch = PchipInterpolator(np.log(radii), np.transpose(own))(np.log(a))
        # F m = int K s dd, K dd = dF; powers below the first depth
        powers = np.gradient(np.log(force), x)[0] / np.gradient(np.log(a), x)[0]
        contact = []
        for k, shape in zip((2, 4), punch.T, strict=True):
            grown = shape * a**k
            steps = (grown[1:] + grown[:-1]) / 2 * np.diff(force)
            total = np.cumsum(np.append(grown[0] * force[0] * powers / (powers + k), steps))
            contact.append(total / (force * a**k))
        moments = PchipInterpolator(x, np.column_stack([punch, *contact, 1 / (slope * a)]))
        return cls(CubicSpline(x, np.log(force)), CubicSpline(x, np.log(a)), moments, float(x[0]), float(x[-1]))

    def __call__(self, depth: Array) -> tuple[Array, ...]:
        """Force [N], stiffness [N/m], radius [m], d ln a/dd [1/m] and moments, shape (n, 5), at depths > 0 [m]."""
        x = np.log(depth)
        inside = np.clip(x, self.first, self.last)
        slope, growth = self.force(inside, 1), self.radius(inside, 1)
        force = np.exp(self.force(inside) + slope * (x - inside))
        radius = np.exp(self.radius(inside) + growth * (x - inside))
        return force, force * slope / depth, radius, growth / depth, np.asarray(self.moments(inside))


@dataclass(frozen=True, slots=True)
class _Group:
    """Asperities with their laws and distances below the highest [m], G with Laplacians and slope, and directions, (n, n, 2)."""

    laws: list[_Law]
    kind: Array
    lower: Array
    influence: tuple[Array, ...]
    away: Array

    def state(self, depths: Array) -> tuple[Array, ...]:
        """What laws give at all depths, with moments and radii of curvature in powers of length; zero without contact."""
        n = depths.size
        found = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, 5))
        for i, law in enumerate(self.laws):
            mine = np.flatnonzero((self.kind == i) & (depths > 0))
            if mine.size:
                for values, own in zip(found, law(depths[mine]), strict=True):
                    values[mine] = own
        return *found[:4], found[4] * found[2][:, None] ** np.array([2, 4, 2, 4, 2])

    def sunk(self, depths: Array) -> tuple[Array, Array, Array, Array]:
        """Forces, stiffnesses, the depths taken by the neighbours [m], and their derivatives by all depths, shape (n, n)."""
        force, stiffness, _, growth, (s, s4, m, m4, curved) = (*(values := self.state(depths))[:4], values[4].T)
        g, lap, twice, slope = self.influence

        def coupled(r2: Array, r4: Array) -> Array:
            return np.asarray(g + (s[:, None] + r2) * lap / 4 + (s4[:, None] + 4 * s[:, None] * r2 + r4) * twice / 64)

        # d(F m) = K s dd, and s, s4 grow with the contact
        own = growth * ((2 * s * (lap @ force) / 4) + (4 * s4 * (twice @ force) + 8 * s * (twice @ (force * m))) / 64)
        # gradients of the displacement per force, all gradients, and how far contacts move downwards
        per_force = np.moveaxis(slope[..., None] * self.away, 2, 0)
        gradient = per_force @ force
        moved = curved * gradient
        second = ((per_force * force) @ moved[..., None])[..., 0].sum(axis=0) - (gradient * moved).sum(axis=0) / 2
        change = per_force * (moved[:, None, :] - moved[:, :, None]) + (per_force * (force * curved)) @ per_force
        first = coupled(s, s4) + change.sum(axis=0)
        return force, stiffness, coupled(m, m4) @ force + second, first * stiffness + np.diag(own)

    def solve(self, target: float, start: Array | None, *, by_depth: bool) -> tuple[Array, float, float, bool]:
        """Depths of all asperities [m], that of the highest, dF/dd, and whether Newton's method converged."""
        n = self.lower.size
        if target == 0:
            return -self.lower, 0.0, 0.0, True
        deepest = float(np.exp(max(law.last for law in self.laws)))
        depth = target if by_depth else (deepest / 2 if start is None else float((start + self.lower).max()))
        depths = depth - self.lower if start is None else np.where(start > 0, start, depth - self.lower)
        for _ in range(_STEPS):
            # a law ends at the largest depth that it can need
            depths = np.minimum(depths, deepest)
            force, stiffness, sunk, change_of_sunk = self.sunk(depths)
            system = np.eye(n) + change_of_sunk
            short = depth - self.lower - depths - sunk
            if by_depth:
                change, rise = np.linalg.solve(system, short), 0.0
            else:
                steps = np.linalg.solve(system, np.column_stack([short, np.ones(n)]))
                slope = float(stiffness @ steps[:, 1])
                missing = target - float(force.sum()) - float(stiffness @ steps[:, 0])
                rise = missing / slope if slope > 0 else float(-depths.max()) + deepest / 2
                change = steps[:, 0] + rise * steps[:, 1]
            depths, depth = depths + change, depth + rise
            if max(np.abs(change).max(), abs(rise)) <= ROUNDING * deepest:
                break
        else:
            return depths, depth, np.nan, False
        _, stiffness, _, change_of_sunk = self.sunk(depths)
        return depths, depth, float(stiffness @ np.linalg.solve(np.eye(n) + change_of_sunk, np.ones(n))), True


def _influence(kernel: Kernel, distance: Array) -> tuple[Array, ...]:
    """Green's function G [m/N] at distances, its Laplacian, that of the latter, and dG/dr; zero on the diagonal."""
    off = np.isfinite(distance)
    r = distance[off]
    parts: list[Array] = []
    exponent = power_exponent(kernel)
    if not r.size:
        parts = [r, r, r, r]
    elif exponent:
        scale = (
            float(kernel(1.0)[0]) / (2 * np.pi) * 2**exponent * gamma((1 + exponent) / 2) / gamma((1 - exponent) / 2)
        )
        first, second = (1 + exponent) ** 2, (3 + exponent) ** 2
        parts = [
            factor * scale * r ** -(power + exponent)
            for factor, power in ((1.0, 1), (first, 3), (first * second, 5), (-1 - exponent, 2))
        ]
    else:
        parts = [1 / r, 1 / r**3, 9 / r**5, -1 / r**2]
        if not kernel.homogeneous:
            table = remainder_table(kernel, 0.9 * r.min(), 1.1 * r.max())
            t = np.log(r)
            points = table.first + np.arange(table.values.size) / 64
            spline = make_interp_spline(points, table.values, k=7)
            d = [spline(t, order) for order in range(5)]
            more = d[0], d[2] / r**2, (d[4] - 4 * d[3] + 4 * d[2]) / r**4, d[1] / r
            parts = [part + added for part, added in zip(parts, more, strict=True)]
        parts = [part / (np.pi * kernel.modulus) for part in parts]
    found = []
    for part in parts:
        whole = np.zeros(distance.shape)
        whole[off] = part
        found.append(whole)
    return tuple(found)


def _dataset(
    medium: Body,
    shapes: list[Indenter],
    group: _Group,
    steps: list[tuple[Array, float, float, bool]],
    distance: Array,
    control: str,
) -> xr.Dataset:
    states = [group.state(depths) for depths, *_ in steps]
    force, radius = (np.array([state[i] for state in states]) for i in (0, 2))
    depth = np.array([step[1] for step in steps])
    gap, close = np.full(depth.size, np.inf), np.zeros(depth.size, dtype=bool)
    for row, a in enumerate(radius):
        touching = (a[:, None] > 0) & (a > 0) & np.isfinite(distance)
        between = np.where(touching, distance - a[:, None] - a, np.inf)
        gap[row] = between.min(initial=np.inf)
        close[row] = bool((between < _CLOSE * np.maximum(a[:, None], a)).any())
    converged: Flags = np.array([step[3] for step in steps])
    merged = gap < 0
    both = ("step", "asperity")
    data: dict[str, Column] = {
        "depth": ("step", depth, {"units": "m", "long_name": "depth of the highest apex below the undeformed surface"}),
        "force": ("step", force.sum(axis=1), {"units": "N", "long_name": "total normal force"}),
        "stiffness": ("step", np.array([step[2] for step in steps]), {"units": "N/m", "long_name": "dF/dd"}),
        "contacts": ("step", (force > 0).sum(axis=1), {"units": "1", "long_name": "asperities in contact"}),
        "gap": ("step", gap, {"units": "m", "long_name": "smallest gap between two contacts"}),
        "valid": ("step", converged & ~merged, {"long_name": "whether no two contacts overlap"}),
        "asperity_force": (both, force, {"units": "N", "long_name": "normal force of each asperity"}),
        "radius": (both, radius, {"units": "m", "long_name": "mean contact radius of each asperity"}),
        "asperity_depth": (
            both,
            np.array([step[0] for step in steps]),
            {"units": "m", "long_name": "depth of the apex below the surface that the others have pressed down"},
        ),
    }
    notes = first_failure(merged, depth, "contacts overlap: neighbours have merged. rough_contact solves the surface.")
    notes += first_failure(
        close & ~merged,
        depth,
        "contacts are closer than half of a radius; forces may be off by more than 1 %.",
    )
    notes += first_failure(~converged, depth, "Newton's method did not converge.")
    coordinates = {
        "step": (np.arange(depth.size), {"long_name": "step of the curve"}),
        "asperity": (np.arange(group.lower.size), {"long_name": "asperity, in the order given"}),
    }
    attributes = {
        "title": "Asperities computed by flatpunch",
        "control": control,
        "medium": json.dumps(record(medium)),
        "tips": json.dumps([record(tip) for tip in shapes]),
        "flatpunch_version": __version__,
        "notes": "\n".join(notes),
    }
    return dataset(data, coordinates, attributes)
