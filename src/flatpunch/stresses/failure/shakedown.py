"""`shakedown_load`: the load that a contact may pass over a body with for ever, after it has yielded a few times (Melan).

A body of elastic and perfectly plastic layers comes to rest where some residual stress, in equilibrium by itself, keeps
elastic stresses below yield at all times. Under contacts that pass along x on many tracks it depends on the depth alone:
r_xx, r_yy and r_xy. So at each depth the largest von Mises stress over a plane is made least by the choice of r, and the
largest of these over the depth is at the limit.

The square of the von Mises stress is r.Qr + g.r + c, with g and c of each point of the plane and one Q. Its largest value is
least where four points at most decide: they are found one by one, and each set of them gives a bound from below.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, Array
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.contact import indent
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.stresses.bodies import Side
from flatpunch.stresses.failure.critical_load import Strengths, found_by, limits_at, search_of
from flatpunch.stresses.failure.events import Judged
from flatpunch.stresses.failure.strength import Strength
from flatpunch.stresses.points import fields, von_mises

_WIDTH, _ACROSS = 2.5, 51
"""Half side of the planes over the contact radius, and points along it."""

_DEPTHS = 24
"""Depths of each layer, from which the largest is refined."""

_INSIDE = 1 - 2 * ROUNDING
"""Depth of the lowest plane of a layer over that of its lower face, which counts as the layer below."""

_METRIC = np.array([[1.0, -0.5, 0.0], [-0.5, 1.0, 0.0], [0.0, 0.0, 3.0]])
"""Q of (r_xx, r_yy, r_xy)."""


@readable
@dataclass(frozen=True, slots=True)
class ShakedownLoad:
    """The largest load under which a body comes to rest.

    Attributes
    ----------
    force, depth, radius : float
        Load [N], depth and (mean) contact radius [m]; zero under tips that are sharp, infinite where nothing ever yields.
    layer : int
        Layer that is at its limit, counted from the surface from 0; the base comes last.
    z : float
        Depth at which it is [m], negative in the upper of two bodies.
    residual : (float, float, float)
        Residual stress xx, yy and xy there [Pa].
    first_yield : float
        Load at which something yields for the first time [N].
    error : float
        Estimated relative error of the stress: bounds from both sides, the upper one on planes and points between those that
        were used.
    notes : tuple of str
        Why the contact at that load is not valid or beyond small strains, as of `critical_load`.

    See Also
    --------
    flatpunch.shakedown_load : Makes it.

    Examples
    --------
    >>> found = fp.shakedown_load(fp.HalfSpace(210e9, 0.3), fp.Sphere(10e-3), fp.Strength(yield_stress=1e9))
    >>> print(f"{found.force / found.first_yield:.1f} times the load of first yield")
    4.6 times the load of first yield
    """

    force: float
    depth: float
    radius: float
    layer: int
    z: float
    residual: tuple[float, float, float]
    first_yield: float
    error: float
    notes: tuple[str, ...] = ()


@one_blas_thread()
def shakedown_load(medium: Body, indenter: Indenter, strengths: Strengths, *, friction: float = 0.0) -> ShakedownLoad:
    """Load with which a contact may roll or slide over a body for ever: it yields at first, and is elastic after that.

    Parameters
    ----------
    medium : Medium, HalfSpace or TwoBodies
        The elastic body, or two of them.
    indenter : Indenter
        What rolls or slides along x. Round tips take seconds, others minutes, as each load is solved on cells.
    strengths : Strength or sequence of Strength or None
        As of `critical_load`; their yield stresses count.
    friction : float
        Coefficient of friction of a contact that slides along x; 0 of one that rolls freely.

    Returns
    -------
    ShakedownLoad
        Load, place, residual stress, the load of first yield, and the error of the stress.

    Raises
    ------
    ValueError, TypeError
        On bad input, and where no yield stress is given.

    See Also
    --------
    critical_load : The first failure of a single contact.
    stresses.ShakedownLoad : What it returns.

    Notes
    -----
    Materials are perfectly plastic, and yield changes neither the shape of the surface nor the pressure, so that real contacts,
    which conform, bear more. Residual stresses of films add to those that form, and change nothing.

    Examples
    --------
    >>> coated = fp.Medium([fp.Layer(400e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
    >>> steel = [None, fp.Strength(yield_stress=1e9)]
    >>> found = fp.shakedown_load(coated, fp.Sphere(50e-6), steel)
    >>> print(f"{found.first_yield * 1e3:.1f} mN, {found.force * 1e3:.1f} mN")
    12.2 mN, 28.4 mN
    """
    search, named = search_of(medium, indenter, strengths, friction, None)
    search = replace(search, bodies=tuple(map(_yielding, search.bodies)))
    if not any(each.watched for each in search.bodies):
        raise ValueError("strengths has no yield stress; give Strength(yield_stress=...) for a layer.")
    first = found_by(search, medium, named)
    if not 0 < first.force < math.inf:
        none = (0.0, 0.0, 0.0)
        return ShakedownLoad(
            first.force,
            first.depth,
            first.radius,
            first.layer,
            first.place[2],
            none,
            first.force,
            first.error,
            first.notes,
        )
    problem = _Problem(medium, indenter, friction, search.bodies)
    at_load = cache(lambda log: problem.worst(math.exp(log)))
    low = high = math.log(first.force)
    # the limit is at the first yield or above; some multiples of it are usual
    while at_load(high).utilisation < 1:
        low, high = high, high + 1
    log = low if low == high else scipy.optimize.brentq(lambda at: at_load(at).utilisation - 1, low, high, xtol=1e-5)
    force = math.exp(log)
    worst, change = problem.refined(force, at_load(log))
    contact = indent(medium, indenter, force=force, angles=1)
    depth, radius = (float(contact[name][0]) for name in ("depth", "radius"))
    z = -worst.depth if worst.judged.upper else worst.depth
    xx, yy, xy = worst.residual.tolist()
    error = abs(worst.utilisation - 1) + change + first.error
    notes = limits_at(medium, indenter, force, depth, radius)
    return ShakedownLoad(force, depth, radius, worst.layer, z, (xx, yy, xy), first.force, error, notes)


def _yielding(judged: Judged) -> Judged:
    return replace(judged, strengths=tuple(Strength(yield_stress=each.yield_stress) for each in judged.strengths))


@dataclass(frozen=True, slots=True)
class _Worst:
    """Least of the largest von Mises stress on a plane, over the yield stress; where, and with which residual stress [Pa]."""

    utilisation: float
    judged: Judged
    layer: int
    depth: float
    residual: Array
    deciding: Array
    """Points of the plane that have it, over the half side of the plane; shape (2, n)."""


@dataclass(frozen=True, slots=True)
class _Problem:
    medium: Body
    indenter: Indenter
    friction: float
    bodies: tuple[Judged, ...]

    def worst(self, force: float) -> _Worst:
        """The worst of all planes in all layers with a yield stress."""
        radius = float(indent(self.medium, self.indenter, force=force, angles=1).radius[0])
        found: list[_Worst] = []
        for judged in self.bodies:
            ends, planes = np.append(judged.tops, np.inf), []
            for i in judged.watched:
                # stresses vary over depths of their own size, and those of the contact
                last = min(ends[i + 1] * _INSIDE, 2 * (ends[i] + radius))
                planes += [(i, float(z)) for z in ends[i] + (last - ends[i]) * np.linspace(0, 1, _DEPTHS) ** 2]
            found += self._on_planes(force, radius, judged, planes, _grid(_ACROSS))
        return max(found, key=lambda each: each.utilisation)

    def refined(self, force: float, worst: _Worst) -> tuple[_Worst, float]:
        """The worst of planes next to one: on twice as many points along a side, then also around those that decide.

        With what these change.
        """
        radius, i = float(indent(self.medium, self.indenter, force=force, angles=1).radius[0]), worst.layer
        top, bottom = np.append(worst.judged.tops, np.inf)[i : i + 2]
        step = 0.1 * min(radius + worst.depth, bottom - top)
        points = grid = _grid(2 * _ACROSS - 1)
        largest = []
        for _ in range(2):
            depths = np.clip(worst.depth + step * np.linspace(-1, 1, 9), top, bottom * _INSIDE)
            planes = [(i, float(z)) for z in np.unique(depths)]
            found = self._on_planes(force, radius, worst.judged, planes, points)
            worst = max(found, key=lambda each: each.utilisation)
            largest.append(worst.utilisation)
            around = worst.deciding[..., None] + _grid(9)[:, None] / (_ACROSS - 1)
            points, step = np.hstack([grid, around.reshape(2, -1)]), step / 4
        return worst, float(np.ptp(largest))

    def _on_planes(
        self, force: float, radius: float, judged: Judged, planes: list[tuple[int, float]], points: Array
    ) -> list[_Worst]:
        """Planes of one body, by layer and depth, on points over their half sides."""
        depth = np.array([z for _, z in planes])
        half = _WIDTH * np.hypot(radius, depth)
        z = np.broadcast_to((-depth if judged.upper else depth)[:, None], (depth.size, points.shape[1]))
        x, y = half[:, None] * points[:, None]
        side: Side = "above" if judged.upper else "below"
        inside = fields(self.medium, self.indenter, x, y, z, force=force, friction=self.friction, side=side)
        result = []
        for (i, at), stress in zip(
            planes, inside.stress.transpose("axis_0", "component", "axis_1").values, strict=True
        ):
            strength = judged.strengths[i].yield_stress
            assert strength is not None
            size, residual, deciding = least_of_largest(stress / strength)
            result.append(_Worst(size, judged, i, at, strength * residual, points[:, deciding]))
        return result


def _grid(across: int) -> Array:
    """Points of the square from -1 to 1, shape (2, across^2)."""
    return np.stack(np.meshgrid(*2 * [np.linspace(-1, 1, across)])).reshape(2, -1)


def least_of_largest(stress: Array) -> tuple[float, Array, list[int]]:
    """Least, over residual stresses, of the largest von Mises stress of points, shape (6, n).

    With that residual stress (3,), and the points that decide.
    """
    size = float(np.abs(stress).max())
    if not np.isfinite(size):
        return math.inf, np.zeros(3), []
    # of unit size, as the equations mix stresses with weights
    stress = stress / (size or 1.0)
    xx, yy, zz, _, _, xy = stress
    slope = np.stack([2 * xx - yy - zz, 2 * yy - xx - zz, 6 * xy], axis=1)
    level = von_mises(stress) ** 2
    chosen, before = [int(np.argmax(level))], -math.inf
    while True:
        residual, bound, chosen = _solved(slope, level, chosen)
        sizes = residual @ _METRIC @ residual + slope @ residual + level
        worst = int(np.argmax(sizes))
        # each point that decides raises the bound, until rounding is larger
        if bound <= before or sizes[worst] <= bound * (1 + ROUNDING):
            return size * math.sqrt(max(sizes[worst], 0.0)), size * residual, chosen
        chosen, before = [*chosen, worst], bound


def _solved(slope: Array, level: Array, points: list[int]) -> tuple[Array, float, list[int]]:
    """Residual stress that makes the largest of a few points least, that value, and the points that decide."""
    best = (np.zeros(3), -math.inf, points)
    for count in range(1, min(len(points), 4) + 1):
        for some in combinations(points, count):
            chosen = list(some)
            # stationary, equal at all of them, weights that sum up to one
            matrix, wanted = np.zeros((3 + count + 1,) * 2), np.zeros(3 + count + 1)
            matrix[:3, :3], matrix[:3, 3:-1] = 2 * _METRIC, slope[chosen].T
            matrix[3:-1, :3], matrix[3:-1, -1] = slope[chosen], -1.0
            matrix[-1, 3:-1] = 1.0
            wanted[3:-1], wanted[-1] = -level[chosen], 1.0
            solved = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
            residual, weights = np.asarray(solved[:3]), solved[3:-1]
            value = float(residual @ _METRIC @ residual + solved[-1])
            # of the sets with weights >= 0 that of the largest value holds for all points
            if weights.min() >= -ROUNDING and value > best[1]:
                best = residual, value, chosen
    return best
