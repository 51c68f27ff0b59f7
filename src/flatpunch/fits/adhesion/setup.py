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
from flatpunch.fits.adhesion.segments import oriented, segments_of
from flatpunch.fits.judge.record import Background, likeliest
from flatpunch.fits.least_squares.drag import with_speed
from flatpunch.fits.least_squares.minimum import RATIOS, ROUGH, minimise, tried
from flatpunch.fits.least_squares.objective import Objective
from flatpunch.fits.least_squares.problem import Setup, contact_ends, enough, with_nuisance
from flatpunch.fits.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fits.measured.orientation import approach_of
from flatpunch.fits.measured.signal import CLEAR, LITTLE, NODES, converter_step, white_noise
from flatpunch.fits.parameters.sample import WORK
from flatpunch.fits.parameters.settings import Settings
from flatpunch.fits.parameters.unknowns import frame_of

_PINNED = "The contact line is pinned"


def adhesive_setup(curve: Curve, model: AdhesiveModel, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """The retract, or the whole cycle, against a model with adhesion."""
    found, notes = oriented(approach_of(curve, settings.direction, back=True), settings)
    curve, segments = found.cycle, segments_of(found, settings)
    learnt = Background()
    if settings.baseline == "auto":
        far = np.sort(np.concatenate([s.free for s in segments]))
        far = far[np.argsort(curve.position[far], kind="stable")]
        learnt = _learnt(curve, far)
        settings = replace(settings, baseline="linear" if learnt.tilt else "constant")
        segments = segments_of(found, settings) if learnt.tilt else segments
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
    approach = curve.taken(slice(0, found.end - found.begin))
    start = _Start(
        part, in_contact, approach, model, limits, settings, max(s.dip for s in segments), found.turned, learnt
    )
    return start.setup(used, notes)


def _learnt(curve: Curve, far: Indices) -> Background:
    """The background that readings without contact show, in order of their positions."""
    position, force, span = curve.position[far], curve.force[far], float(np.ptp(curve.force))
    x = (position - position[0]) / max(float(np.ptp(curve.position)), TINY)
    noise = white_noise(force, converter_step(curve.force)) / span
    return likeliest(x, (force - np.median(force)) / span, np.full(x.size, noise**2 + TINY))


@dataclass(frozen=True, eq=False)
class _Start:
    """What is needed to set the problem up, and to set it up again with fewer points.

    Where the contact line is pinned, as by adhesion with hysteresis, the contact keeps its radius a when the tip turns back. The
    retract then begins as the unloading of a flat punch of that radius, a straight line, until it meets the JKR contact of a.
    """

    part: Curve
    in_contact: Flags
    approach: Curve
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
        force = (objective.force - free_force(objective))[objective.loaded]
        pressing = depth[force > 0]
        low = float(depth.min())
        high = float(pressing.min()) if pressing.size else float(depth.max())
        return low, max(high, low + LITTLE * float(np.ptp(depth)))

    def _again(
        self, whole: tuple[Objective, Flags], used: Flags, notes: tuple[str, ...], x: Array, *, begun: bool
    ) -> Setup | None:
        """The setup behind its cantilever, without what is too close to its instability and what is pinned; None if it stands."""
        (objective, all_used), spring = whole, self.part.spring_constant
        assert objective.loaded is not None
        places = np.flatnonzero(all_used)
        # a first fit behind a cantilever takes positions of the tip as they are, and is off by their noise
        early = self._pinned(objective, x) if begun or spring is None else np.zeros(objective.loaded.size, dtype=bool)
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
                else f"{self.part.name}: fewer than {FEWEST} points are left of the retract once the contact opens. {_PINNED} "
                "nearly all the way, or the fit has missed the curve: give other starts, or a range of action that suits it."
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
        by_depth, stiffness, _ = objective.model.evaluate(depth, theta)
        spring = self.part.spring_constant
        # over the position of the cantilever's base, which has no noise; a straight line over the depth is one over it too
        way, give = (depth, np.ones(1)) if spring is None else (depth + force / spring, 1 + stiffness / spring)
        above = force - np.polynomial.Polynomial.fit(way[early], force[early], 1)(way)
        by_line = float(np.sum(above[early] ** 2))
        by_model = float(np.sum(((force - by_depth) / give)[early] ** 2))
        noise = np.sqrt(by_line / (n - 2))
        # ratio of likelihoods, in the noise that the line leaves; where the approach shows hysteresis the likelier one is taken
        needed = 0.0 if self._hysteresis(objective.split(x)[1]["contact"]) else (CLEAR * noise) ** 2
        if by_model - by_line <= needed:
            return np.zeros(early.size, dtype=bool)
        # parameters that were fitted to the line too may let it open too early: it goes on to where readings rise above it
        later = np.flatnonzero(~early)[np.argsort(-depth[~early], kind="stable")]
        risen = np.cumsum(above[later]) > CLEAR * noise * np.sqrt(np.arange(1, later.size + 1))
        early[later[: risen.argmax() if risen.any() else None]] = True
        return np.asarray(early)

    def _hysteresis(self, contact: float) -> bool:
        """Whether the approach presses harder than the way back does, from a reading of the depth on."""
        on, back = self.approach.taken(self.approach.depth >= contact), self.part.taken(self.in_contact)
        if on.depth.size < FEWEST:
            return False
        order = np.argsort(back.depth, kind="stable")
        above = on.force - np.interp(on.depth, back.depth[order], back.force[order])
        return bool(above.mean() > CLEAR * above.std() / np.sqrt(above.size))

    def _readings(self, objective: Objective, x: Array) -> tuple[Array, Array, Array]:
        """Depth and force of readings in contact over contact point and background, and theta."""
        theta, rest = objective.split(x)
        spring = self.part.spring_constant
        position = objective.depth + (0.0 if spring is None else objective.force / spring)
        moving = objective.background(rest, position, objective.speed)
        # a background that moves no tip is taken out of its position too
        depth = objective.depth - rest["contact"] + (0.0 if spring is None else moving / spring)
        at = objective.loaded
        return depth[at], (objective.force - rest["baseline"] - moving)[at], theta

    def _giving(self, objective: Objective, x: Array, spring: float) -> Flags:
        """Points in contact that are past dF/dd = -k/2; judged by the piezo's position, which has no noise."""
        depth, force, theta = self._readings(objective, x)
        last = objective.model.about_to_snap(theta, float(depth.max()), spring)
        if last is None:
            return np.zeros(depth.size, dtype=bool)
        return np.asarray(depth + force / spring < last[0] + last[1] / spring)


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

    theta = _matched(model, (moduli, works), depth - np.mean(between), (coarse.force - free_force(coarse))[loaded])
    thetas = np.repeat(theta[None], RATIOS if works or moduli else 1, axis=0)
    thetas[:, works or moduli] += np.log(10) * np.linspace(-1, 1, len(thetas))[:, None]
    found = tried(coarse, thetas, between, force, [*moduli, *works] if works and moduli else ())
    # three ratios: the valley has more than one end
    starts = (np.clip(x, lower, upper) for x in found[:3])
    return min((minimise(coarse.evaluate, x, lower, upper, settled=ROUGH) for x in starts), key=lambda end: end.cost).x


def free_force(objective: Objective) -> Array:
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
