"""Adhesive curves: the retract, where the tip lets go, and where a fit starts.

Which points are in contact is read off the curve, not left to the fit: on the retract everything up to the jump by which the
force returns to its baseline, on the approach everything after the jump into contact. What comes after (before) it is baseline.
The model then needs no discontinuity at its pull-off, which no least-squares method could handle. Behind a cantilever the jump
comes where dF/dd = -k; points with dF/dd < -k/2 are left out, as there the noise moves the tip by more than it shows. Which these
are is known once a first fit has ended, that takes the positions of the tip as they are; the second takes the cantilever
into account.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import ROUNDING, TINY, Array, Flags, Indices
from flatpunch._support.prefixes import text
from flatpunch.fits.adhesion.model import AdhesiveModel
from flatpunch.fits.judge.background import Background, likeliest
from flatpunch.fits.least_squares.drag import with_speed
from flatpunch.fits.least_squares.minimum import RATIOS, ROUGH, minimise, tried
from flatpunch.fits.least_squares.objective import Objective
from flatpunch.fits.least_squares.problem import Setup, contact_ends, enough, with_nuisance
from flatpunch.fits.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fits.measured.orientation import FALLS, Approach, approach_of
from flatpunch.fits.measured.signal import CLEAR, NODES, converter_step, scatter, white_noise
from flatpunch.fits.parameters.sample import WORK
from flatpunch.fits.parameters.settings import Settings
from flatpunch.fits.parameters.unknowns import frame_of

_FREE = 0.2
"""Share of the points, at the far end, that shows the baseline and its noise."""
_LITTLE = 0.02
"""Share of the readings, of their range or of the dip that is next to nothing."""
_LET_GO = 0.3
"""Below this share of the dip the tip is in contact; JKR lets go of a paraboloid at 5/9 of the largest tension."""
_NOT_GONE = "{name}: the {way} ends before the tip lets go: no baseline is left after the dip. Record further out."
_PINNED = "The contact line is pinned"


@dataclass(frozen=True, eq=False)
class Segment:
    """One way of the tip, from contact outwards.

    Attributes
    ----------
    points : ndarray of int
        Its points, from the deepest to the furthest.
    held, free : ndarray of int
        Those in contact, and those without.
    dip : float
        Tension below the baseline [N].
    """

    points: Indices
    held: Indices
    free: Indices
    dip: float


def adhesive_setup(curve: Curve, model: AdhesiveModel, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """The retract, or the whole cycle, against a model with adhesion."""
    found, notes = _oriented(approach_of(curve, settings.direction, back=True), settings)
    curve, segments = found.cycle, _segments(found, settings)
    learnt = Background()
    if settings.baseline == "auto":
        far = np.sort(np.concatenate([s.free for s in segments]))
        far = far[np.argsort(curve.position[far], kind="stable")]
        learnt = _learnt(curve, far)
        settings = replace(settings, baseline="linear" if learnt.tilt else "constant")
        segments = _segments(found, settings) if learnt.tilt else segments
    chosen = np.sort(np.concatenate([s.points for s in segments]))
    part = curve.taken(chosen)
    place = {int(i): j for j, i in enumerate(chosen)}
    loaded = np.sort([place[int(i)] for s in segments for i in s.held])
    free = np.sort([place[int(i)] for s in segments for i in s.free])
    used = np.zeros(chosen.size, dtype=bool)
    used[loaded] = used[free] = True
    in_contact = np.zeros(chosen.size, dtype=bool)
    in_contact[loaded] = True
    for name, column, limit in (
        ("depth_to", part.depth, settings.depth_to),
        ("force_to", part.force, settings.force_to),
    ):
        if limit is not None:
            used &= ~in_contact | (column <= limit)
            if int((used & in_contact).sum()) < FEWEST:
                raise CurveError(
                    f"{curve.name}: fewer than {FEWEST} points in contact are left by {name} = {limit:.4g}."
                )
    start = _Start(part, in_contact, model, limits, settings, max(s.dip for s in segments), found.turned, learnt)
    return start.setup(used, notes)


def _learnt(curve: Curve, far: Indices) -> Background:
    """The background that readings without contact show, in order of their positions."""
    position, force, span = curve.position[far], curve.force[far], float(np.ptp(curve.force))
    x = (position - position[0]) / max(float(np.ptp(curve.position)), TINY)
    noise = white_noise(force, converter_step(curve.force)) / span
    return likeliest(x, (force - np.median(force)) / span, np.full(x.size, noise**2 + TINY))


def _oriented(found: Approach, settings: Settings) -> tuple[Approach, tuple[str, ...]]:
    """The cycle with a force that is positive when pressing, as far as it shows it, and notes."""
    curve = found.cycle
    force = curve.force - _background(found, settings)
    noise = scatter(force, 1)
    deepest = float(np.median(force[np.argsort(curve.position)[-max(force.size // 200, 3) :]]))
    # pressed and pulled the other way round
    if deepest < -CLEAR * noise and force.max() > CLEAR * noise and force.max() < -force.min():
        return found.signed(-1.0), (*found.notes, FALLS)
    return found, found.notes


def _background(found: Approach, settings: Settings) -> Array:
    """Force without contact [N], from the far ends of the curve: a constant, or a straight line where one is fitted."""
    curve, top = found.cycle, found.end - found.begin - 1
    n = curve.force.size
    far = np.zeros(n, dtype=bool)
    far[top + int((1 - _FREE) * (n - top)) :] = True
    position = curve.position
    if settings.baseline != "linear":
        return np.full(n, float(np.median(curve.force[far])))
    if top > _FREE * n:
        far[: int(_FREE * top)] = True
    slope, level = np.polyfit(position[far], curve.force[far], 1)
    return np.asarray(slope * position + level)


def _segments(found: Approach, settings: Settings) -> list[Segment]:
    curve = found.cycle
    n, force = curve.force.size, curve.force - _background(found, settings)
    top, leaves = found.end - found.begin - 1, found.leaves - found.begin
    out, back = np.arange(leaves, n), np.arange(top, -1, -1)
    if out.size < FEWEST or np.ptp(curve.position[leaves:]) < _LITTLE * np.ptp(curve.position):
        raise CurveError(
            f"{curve.name}: the work of adhesion is fitted to the retract, and this curve ends at its deepest point. Give the "
            "whole cycle (read all segments of the file), or leave work_of_adhesion out."
        )
    # the start of a whole cycle knows the force without contact
    reference = float(np.median(force[: max(n // 20, FEWEST)])) if top > _FREE * n else -np.inf
    retract = _segment(curve, force, out, "retract", reference)
    if settings.segment != "both":
        return [retract]
    if back.size < FEWEST:
        raise CurveError(f"{curve.name}: segment = 'both' needs the approach as well; the curve begins at its maximum.")
    return [_segment(curve, force, back, "approach"), retract]


def _segment(curve: Curve, over: Array, points: Indices, name: str, reference: float = -np.inf) -> Segment:
    """Find the jump between contact and baseline on the way outwards, in the force over its background."""
    force, depth = over[points], curve.depth[points]
    if (depth[:FEWEST] - depth[-FEWEST:]).mean() <= 0:
        raise CurveError(
            f"{curve.name}: on the {name} the depth must fall from the largest force to the free end. depth must grow into the "
            "sample: change its sign."
        )
    far = force[-max(int(_FREE * force.size), FEWEST) :]
    baseline = float(np.median(far))
    noise = scatter(far, 1)
    lowest = int(np.argmin(force))
    dip = baseline - float(force[lowest])
    if reference - baseline > max(CLEAR * noise, _LET_GO * (reference - float(force[lowest]))):
        raise CurveError(_NOT_GONE.format(name=curve.name, way=name))
    if dip < CLEAR * noise or lowest < 3:
        raise CurveError(
            f"{curve.name}: the {name} dips {max(dip, 0):.3g} N below its baseline, the noise is {noise:.3g} N: no adhesion "
            + ("to be seen. Leave work_of_adhesion out." if name == "retract" else "to be seen. Use segment='retract'.")
        )
    # as many points as bring the noise of their mean to next to nothing of the dip
    m = int(np.clip(np.ceil((noise / (_LITTLE * dip)) ** 2), 1, max(int(_LITTLE * force.size), 1)))
    ahead = np.convolve(force, np.full(m, 1 / m), "full")[m - 1 :] if m > 1 else force
    gone = np.flatnonzero(ahead[lowest:] > baseline - _LET_GO * dip)
    if not gone.size or force.size - lowest - gone[0] < max(FEWEST, _LITTLE * force.size):
        raise CurveError(_NOT_GONE.format(name=curve.name, way=name))
    jump = lowest + int(gone[0])
    settled = np.flatnonzero(ahead[jump:] > baseline - max(3 * noise / np.sqrt(m), _LITTLE * dip))
    quiet = jump + m + (int(settled[0]) if settled.size else 0)
    end = jump - (m if m > 1 else 0)
    if end < FEWEST:
        raise CurveError(f"{curve.name}: {end} points of the {name} are in contact; a fit needs {FEWEST} or more.")
    return Segment(points, points[:end], points[quiet:], dip)


@dataclass(frozen=True, eq=False)
class _Start:
    """What is needed to set the problem up, and to set it up again with fewer points.

    Where the contact line is pinned, as by adhesion with hysteresis, the contact keeps its radius a when the tip turns back. The
    retract then begins as the unloading of a flat punch of that radius, a straight line, until it meets the JKR contact of a.
    """

    part: Curve
    in_contact: Flags
    model: AdhesiveModel
    limits: tuple[Array, Array]
    settings: Settings
    dip: float
    turned: float
    background: Background

    def setup(
        self,
        used: Flags,
        notes: tuple[str, ...],
        start: Array | None = None,
        whole: tuple[Objective, Flags] | None = None,
    ) -> Setup:
        """The problem with some points, `whole` being that with all; behind its cantilever once there is a start."""
        part, speed = with_speed(self.part, self.settings)
        taken, held = part.taken(used), self.settings.held
        # the same below which the model is continued by its tangent: nothing is measured beyond -1, where the tip lets go
        objective = Objective(
            model=self.model,
            depth=taken.depth,
            force=taken.force,
            nuisance=self.settings.nuisance,
            held={**held, "contact": self.turned * held["contact"]},
            turned=self.turned,
            frame=frame_of(part.depth, part.force, part.position, speed),
            spring=None if start is None else taken.spring_constant,
            softest=None if taken.spring_constant is None else -3 / 4 * taken.spring_constant,
            speed=speed[used] if speed is not None else None,
            loaded=np.flatnonzero(self.in_contact[used]),
            part_loaded=np.flatnonzero(self.in_contact),
        )
        enough(taken, objective)
        low, high = self._contacts(objective)
        ends = contact_ends(self.settings, self.turned, 2 * low - high, 2 * high - low)
        lower, upper = with_nuisance(objective, self.limits, ends)
        fitted = objective
        if self.background.size:
            assert objective.loaded is not None
            free = np.delete(objective.force, objective.loaded)
            fitted = _white(_means(objective), self.background, white_noise(free, 0.0) / objective.frame.span)
        return Setup(
            part,
            used,
            fitted,
            lower,
            upper,
            lambda: _start(objective, lower, upper, (low, high)) if start is None else start,
            self.settings,
            notes,
            again=lambda x: self._again(whole or (objective, used), used, notes, x, begun=start is not None),
        )

    def _contacts(self, objective: Objective) -> tuple[float, float]:
        """Depth 0 lies between where the tip lets go and where the force is back at the baseline."""
        assert objective.loaded is not None
        depth = objective.depth[objective.loaded]
        force = (objective.force - _free_force(objective))[objective.loaded]
        pressing = depth[force > 0]
        low = float(depth.min())
        high = float(pressing.min()) if pressing.size else float(depth.max())
        return low, max(high, low + _LITTLE * float(np.ptp(depth)))

    def _again(
        self, whole: tuple[Objective, Flags], used: Flags, notes: tuple[str, ...], x: Array, *, begun: bool
    ) -> Setup | None:
        """The setup behind its cantilever, without what is too close to its instability and what is pinned; None if it stands."""
        (objective, all_used), spring = whole, self.part.spring_constant
        assert objective.loaded is not None
        places = np.flatnonzero(all_used)
        early = self._pinned(objective, x)
        pinned = places[objective.loaded[early]]
        giving = np.zeros(0, dtype=np.intp)
        if spring is not None and not begun:
            giving = places[objective.loaded[self._giving(objective, x, spring)]]
        keep = used.copy()
        keep[pinned] = keep[giving] = False
        if (keep == used).all() and (begun or spring is None):
            return None
        if int((keep & self.in_contact).sum()) < FEWEST:
            raise CurveError(
                f"{self.part.name}: nearly all of the contact is on the verge of snapping off: the cantilever "
                f"({spring:.3g} N/m) is too soft for this adhesion. Take a stiffer one."
                if giving.size
                else f"{self.part.name}: fewer than {FEWEST} points are left of the retract once the contact opens. {_PINNED}."
            )
        if giving.size:
            notes = (
                *notes,
                f"{giving.size} points just before the tip lets go are left out: there the cantilever ({spring:.3g} N/m) is "
                "about to snap.",
            )
        if pinned.size:
            depth = self._readings(objective, x)[0][early]
            from_depth, to_depth = text(float(depth.max()), "m"), text(float(depth.min()), "m")
            notes = (
                *(note for note in notes if not note.startswith(_PINNED)),
                f"{_PINNED}: from a depth of {from_depth} to {to_depth} the force falls along the straight line of a flat "
                "punch of the largest radius (hysteresis of adhesion). These readings are left out; the work of adhesion is "
                "that of the contact as it opens.",
            )
        return self.setup(keep, notes, x, whole)

    def _pinned(self, objective: Objective, x: Array) -> Flags:
        """Readings in contact before the contact opens that a straight line describes better than the model does.

        The contact of radius a without adhesion at the largest depth opens where it meets the adhesive contact of that radius.
        """
        depth, force, theta = self._readings(objective, x)
        if self.settings.segment == "both" or not force.max() > 0:
            return np.zeros(depth.size, dtype=bool)
        early = depth > objective.model.opening(theta, float(depth.max()))
        n = int(early.sum())
        if n < FEWEST:
            return np.zeros(depth.size, dtype=bool)
        depth, force = depth[early], force[early]
        by_line = float(np.sum((force - np.polynomial.Polynomial.fit(depth, force, 1)(depth)) ** 2))
        by_model = float(np.sum((force - objective.model.evaluate(depth, theta)[0]) ** 2))
        # ratio of likelihoods, in the noise that the line leaves
        return early if by_model - by_line > CLEAR**2 * by_line / (n - 2) else np.zeros(early.size, dtype=bool)

    def _readings(self, objective: Objective, x: Array) -> tuple[Array, Array, Array]:
        """Depth and force of readings in contact over contact point and background, and theta."""
        theta, rest = objective.split(x)
        background = rest["baseline"] + objective.background(rest, objective.position, objective.speed)
        at = objective.loaded
        return objective.depth[at] - rest["contact"], (objective.force - background)[at], theta

    def _giving(self, objective: Objective, x: Array, spring: float) -> Flags:
        """Points in contact that are past dF/dd = -k/2; judged by the piezo's position, which has no noise."""
        depth, force, theta = self._readings(objective, x)
        way = np.linspace(objective.model.pull_off(theta)[0], float(depth.max()), 10_000)
        on_branch, stiffness, _ = objective.model.evaluate(way, theta)
        # stiffness over that of the cantilever below which points are left out: there the noise moves the tip by twice what it
        # shows
        past = np.flatnonzero(stiffness < -0.5 * spring)
        if not past.size:
            return np.zeros(depth.size, dtype=bool)
        limit = way[past[-1]] + on_branch[past[-1]] / spring
        return np.asarray(depth + force / spring < limit)


def _start(objective: Objective, lower: Array, upper: Array, between: tuple[float, float]) -> Array:
    """Starting x: many contact points and many works of adhesion or moduli.

    At given depth the force is proportional to modulus and work of adhesion together. The round tip of the same mean profile
    is enough to start with.
    """
    coarse, model = _means(objective), objective.model
    model = AdhesiveModel(model.sample, model.free, model.method, approximate=True)
    moduli = model.moduli
    works = [j for j, name in enumerate(model.free) if name == WORK]
    assert coarse.loaded is not None
    loaded, depth = coarse.loaded, coarse.depth[coarse.loaded]

    def force(theta: Array, contacts: Array) -> Array:
        # all contact points at once: the branch is the same
        rows = np.zeros((contacts.size, coarse.depth.size))
        rows[:, loaded] = model.evaluate((depth - contacts[:, None]).ravel(), theta)[0].reshape(contacts.size, -1)
        return rows

    theta = _matched(model, (moduli, works), depth - np.mean(between), (coarse.force - _free_force(coarse))[loaded])
    thetas = np.repeat(theta[None], RATIOS if works or moduli else 1, axis=0)
    thetas[:, works or moduli] += np.log(10) * np.linspace(-1, 1, len(thetas))[:, None]
    found = tried(coarse, thetas, between, force, [*moduli, *works] if works and moduli else ())
    # the best few, of different ratios where there are some: the valley has more than one end
    starts = [np.clip(x, lower, upper) for x in found[:: max(len(found) // 40, 1)][:3]]
    return min((minimise(coarse.evaluate, x, lower, upper, settled=ROUGH) for x in starts), key=lambda end: end.cost).x


def _free_force(objective: Objective) -> Array:
    """Background through the points without contact [N]."""
    fitted = [name for name in objective.nuisance if name != "contact"]
    if "baseline" not in fitted:
        return np.zeros_like(objective.force)
    assert objective.loaded is not None
    free = np.setdiff1d(np.arange(objective.force.size), objective.loaded)
    columns = np.array([objective.column(n) for n in fitted])
    return np.asarray(objective.force[free] @ np.linalg.pinv(columns[:, free], rcond=1e-9) @ columns)


def _matched(model: AdhesiveModel, places: tuple[list[int], list[int]], depth: Array, data: Array) -> Array:
    """Start whose largest force and largest tension are about those of the data; places of moduli and works of adhesion."""
    (moduli, works), theta, deepest = places, model.start(), float(depth.max())
    for _ in range(4):
        low = model.pull_off(theta)[0]
        force = model.evaluate(np.linspace(low, max(deepest, 0.1 * abs(low)), 100), theta)[0]
        tension, load = -float(force.min()), float(force[-1])
        if works and tension > 0:
            # the tension goes like w for paraboloids, like w^2 for cones: either way two thirds of a step leave a third
            theta[works] += 2 / 3 * np.log(np.clip(-float(data.min()) / tension, 1e-3, 1e3))
        if moduli and load > 0 and data.max() > 0:
            theta[moduli] += np.log(np.clip(float(data.max()) / load, 1e-3, 1e3))
    return theta


def _means(objective: Objective) -> Objective:
    """The problem on means over as many readings in contact each, and without contact."""
    assert objective.loaded is not None
    n, index = objective.depth.size, np.zeros(objective.depth.size, dtype=np.intp)
    free = np.delete(np.arange(n), objective.loaded)
    for places, count, first in ((objective.loaded, NODES, 0), (free, NODES // 4, NODES)):
        index[places] = first + np.arange(places.size) * min(count, places.size) // max(places.size, 1)
    return objective.averaged(index)


def _white(means: Objective, background: Background, noise: float) -> Objective:
    """The same over a background that is a process, with residuals as large as the noise of a reading over the force range."""
    assert means.counts is not None
    x = (means.position - means.frame.first) / means.frame.way
    covariance = background.covariance(x) + np.diag(noise**2 / means.counts + ROUNDING)
    factor = np.linalg.inv(np.linalg.cholesky(covariance))
    return replace(means, white=factor * noise)
