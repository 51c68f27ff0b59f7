"""From a curve and a model without adhesion to a least-squares problem: approach, contact, and the range that is fitted."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch._support.prefixes import text
from flatpunch.contact.finite_strain.caps import place_of
from flatpunch.fits.elastic.model import ForwardModel
from flatpunch.fits.judge.fitted import MOST, SURE, Fit
from flatpunch.fits.judge.judgement import Judge, about_background, about_range, dip, no_contact
from flatpunch.fits.judge.record import Noise, Record
from flatpunch.fits.least_squares.drag import FreeOfContact, before_turn, free_of_contact, no_drag, shows_drag, speed_of
from flatpunch.fits.least_squares.objective import Objective, blocked
from flatpunch.fits.least_squares.problem import Setup, cut, enough, with_nuisance
from flatpunch.fits.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fits.measured.cycles import refuse_plastic
from flatpunch.fits.measured.orientation import FALLS, Approach, approaches, leap_note
from flatpunch.fits.measured.signal import IN_CONTACT, SHARE, converter_step, strays, thinned, white_noise
from flatpunch.fits.parameters.settings import Settings
from flatpunch.fits.parameters.unknowns import Frame, frame_of

FARTHEST = 10.0
"""Contact points are looked for this far before the first reading, over the range of depths; a ceiling."""
_SOLIDS = 1e-3, 1e13
"""Moduli between which those of all solids lie [Pa], a thousand times below the softest gels and ten times above diamond."""

DIP = 7.0
"""Standard deviations of the force without contact below it that are adhesion."""


@dataclass(frozen=True, eq=False)
class Approached:
    """An approach whose contact is found.

    Attributes
    ----------
    found : Approach
        With the sign of the force that grows while the tip presses.
    part : Curve
        The approach, as far as the user wants it fitted.
    out : ndarray of bool
        Its readings that jump away and back.
    fit : Fit
    settings : Settings
        As given.
    upright : float
        -1 where the sign of the force was turned.
    """

    found: Approach
    part: Curve
    out: Flags
    fit: Fit
    settings: Settings
    upright: float

    @property
    def contact(self) -> float:
        """Contact point on the oriented depth axis [m]."""
        return self.fit.objective.split(self.fit.x)[1]["contact"]

    @property
    def rise(self) -> float:
        """Rise of the contact in the fitted range [N]."""
        return self.fit.most * self.fit.record.range

    @property
    def before(self) -> Flags:
        """Readings of the approach without contact."""
        inside = self.fit.objective.indentation(self.part, self.fit.x)
        return np.asarray(inside < 0.5 * min(float(inside.min()), 0.0))

    def background(self, curve: Curve) -> Array:
        """Force without contact at the positions of a curve, without level and drag [N]."""
        rest = {**self.fit.objective.split(self.fit.x)[1], "drag": 0.0}
        return np.asarray(self.fit.objective.background(rest, curve.position, None))

    def over(self, curve: Curve) -> Array:
        """Force of an oriented curve over the background without its process [N]; drag left out."""
        return np.asarray(curve.force - self.fit.objective.split(self.fit.x)[1]["baseline"] - self.background(curve))


def elastic_setup(curve: Curve, model: ForwardModel, limits: tuple[Array, Array], settings: Settings) -> Setup:
    """The approach of a curve against a model without adhesion."""
    if settings.drag != "free":
        return _setup(approached(curve, model, limits, settings), model, limits, settings)
    # drag that the approach does not show is a constant there, and is left to the baseline
    still = approached(curve, model, limits, replace(settings, drag=0.0))
    before = still.before
    free = free_of_contact(still.found, still.part, before, still.background, settings)
    shown = shows_drag([still.part], settings)
    if free is None and not shown:
        retract = still.found.retract is not None
        why = "the retraction has no part without contact to compare with" if retract else "there is no retraction"
        raise no_drag(still.part, settings, f", and {why}")
    made = still
    if free is not None:
        made = approached(curve, model, limits, replace(settings, drag=free.drag))
    elif shown:
        made = approached(curve, model, limits, settings)
    return _setup(made, model, limits, settings, free)


def approached(curve: Curve, model: ForwardModel, limits: tuple[Array, Array], settings: Settings) -> Approached:
    """The first leg of a curve that shows a contact with readings before it, else the first that shows any.

    Raises
    ------
    CurveError
        If no leg shows a contact.
    """
    refused: CurveError | None = None
    begun: Approached | None = None
    for found in approaches(curve, settings.direction):
        try:
            made = _approached(found, model, limits, settings)
        except CurveError as error:
            refused = refused or error
            continue
        low, high = made.fit.record.contacts
        if (made.fit.touch > 2 and (begun is None or made.rise > MOST * begun.rise)) or low == high:
            return made
        begun = begun or made
    if _contact_backwards(curve, model, limits, settings):
        raise CurveError(
            f"{curve.name}: no contact is to be seen on the approach, but one where the record is read backwards: this is a "
            "retract. Give the approach, or the whole cycle."
        )
    if begun is not None:
        return begun
    assert refused is not None
    raise refused


def _contact_backwards(curve: Curve, model: ForwardModel, limits: tuple[Array, Array], settings: Settings) -> bool:
    """Whether a record without a contact on its way shows one in the opposite order of its readings.

    Over a tilt a force that bends upwards is a contact in both orders.
    """
    if settings.direction != "auto" or settings.contact != "free":
        return False
    if len(list(approaches(curve))) > 1:
        # the other ways were tried already
        return False
    for found in approaches(replace(curve, time=None, segment=None).taken(slice(None, None, -1))):
        try:
            fit = _approached(found, model, limits, settings).fit
            if fit.touch > 2 and not fit.noise.background.tilt:
                return True
        except CurveError:
            continue
    return False


def _approached(found: Approach, model: ForwardModel, limits: tuple[Array, Array], settings: Settings) -> Approached:
    signed = found.signed(found.pressing)
    part = before_turn(cut(signed.part, settings, found.turned, found.pressing), settings)
    # a row that is written again is one reading
    fresh = np.append(True, (np.diff(part.depth) != 0) | (np.diff(part.force) != 0))
    part = part if fresh.all() else part.taken(fresh)
    if part.depth.size < FEWEST or np.ptp(part.force) == 0:
        raise CurveError(
            f"{part.name}: {part.depth.size} readings are left of the approach; a fit needs {FEWEST} or more."
        )
    step, tilted = converter_step(part.force), settings.baseline == "linear"
    noise = white_noise(part.force, step, thinned(part.position, part.force, tilted=tilted))
    out = strays(part.force, noise)
    edges = thinned(part.position[~out], part.force[~out], tilted=tilted)

    def with_sign(sign: float) -> Record:
        clean = part.turned(force=sign).taken(~out)
        return _record(clean, edges, (noise, step), model, settings, found.turned)

    def between(objective: Objective) -> tuple[Array, Array]:
        lower, upper = with_nuisance(objective, limits, judge.record.contacts)
        # limits of moduli that nobody set are widened later
        lower[list(judge.record.moduli)], upper[list(judge.record.moduli)] = -np.inf, np.inf
        return lower, upper

    given = None if settings.baseline == "auto" else settings.baseline == "linear"
    whole = settings.depth_to is not None or settings.force_to is not None
    judge = Judge(with_sign, between, given, whole)
    fit = judge.best()
    if fit is None or fit.gain < SURE or fit.inside < IN_CONTACT or fit.foot or (given is None and not fit.stands_out):
        raise no_contact(part, fit, settings)
    upright = 1.0 if fit.record is judge.record else -1.0
    return Approached(signed.signed(upright), part.turned(force=upright), out, fit, settings, found.pressing * upright)


def _record(
    clean: Curve, edges: Indices, noise: tuple[float, float], model: ForwardModel, settings: Settings, turned: float
) -> Record:
    speed = speed_of(clean, settings)
    frame = frame_of(clean.depth, clean.force, clean.position, speed)
    objective = _objective(clean, frame, model, settings, settings.baseline == "linear", turned, speed)
    means = objective.averaged(np.repeat(np.arange(edges.size - 1), np.diff(edges)))
    return Record(means, edges, *noise, _contacts(objective, settings, turned), tuple(model.moduli))


def _objective(
    curve: Curve, frame: Frame, model: ForwardModel, settings: Settings, tilt: bool, turned: float, speed: Array | None
) -> Objective:
    held = settings.held
    held["contact"] *= turned
    chosen = replace(settings, baseline="linear" if tilt else settings.baseline)
    objective = Objective(
        model=model,
        depth=curve.depth,
        force=curve.force,
        nuisance=chosen.nuisance,
        held=held,
        frame=frame,
        turned=turned,
        spring=curve.spring_constant,
        speed=speed,
    )
    enough(curve, objective)
    return objective


def _contacts(objective: Objective, settings: Settings, turned: float) -> tuple[float, float]:
    """Contact points that are allowed: those of the user, or the whole curve and ten times as much before it."""
    if isinstance(settings.contact, float):
        return objective.held["contact"], objective.held["contact"]
    low, high = settings.contact_limits(turned)
    position, force, k = objective.position, objective.force, objective.spring
    bent = (0.0, 0.0) if k is None else (float(force.max()) / k, float(force.min()) / k)
    first, last = float(position.min()) - bent[0], float(position.max()) - bent[1]
    farthest = first - FARTHEST * (last - first)
    if (low is not None and low > last) or (high is not None and high < farthest):
        ends = sorted(turned * end for end in (first, last))
        given = " and ".join(text(v, "m") for v in settings.contact_limits(1.0) if v is not None)
        raise CurveError(
            f"contact: the limits {given} are outside the curve, whose positions go from {text(ends[0], 'm')} to "
            f"{text(ends[1], 'm')}. Limits have the sign of the file, as `fit` and `read` print the contact point."
        )
    return farthest if low is None else low, last if high is None else high


def _setup(
    made: Approached,
    model: ForwardModel,
    limits: tuple[Array, Array],
    settings: Settings,
    free: FreeOfContact | None = None,
) -> Setup:
    fit, found, part, record = made.fit, made.found, made.part, made.fit.record
    notes = [*found.notes, *leap_note(found.whole)]
    if made.upright < 0:
        notes.append(FALLS)
    if count := int(made.out.sum()):
        notes.append(f"{count} reading{'s jump' if count > 1 else ' jumps'} away and back: left out.")
    moduli = [float(np.exp(fit.x[j])) for j in record.moduli]
    _check_moduli(part, model, moduli)
    notes += refuse_plastic(part, found, made.over, max(moduli, default=0.0))
    # readings in the range
    place = np.flatnonzero(~made.out)
    last = int(place[record.edges[fit.end] - 1]) + 1
    used = ~made.out[:last]
    gone = np.repeat(fit.gone[: fit.end], np.diff(record.edges[: fit.end + 1]))
    used[place[: gone.size][gone]] = False
    keep, more = _adhesion(made, settings)
    used &= keep[:last]
    notes += more
    if left := int(gone.sum()):
        notes.append(
            f"{left} reading{'s' if left > 1 else ''} far off the fitted force {'are' if left > 1 else 'is'} left out."
        )
    notes += about_range(fit, part, last, found.turned)
    notes += about_background(fit)
    shown, tilt = part.taken(slice(0, last)), fit.noise.background.tilt
    chosen = settings if settings.baseline != "auto" else replace(settings, baseline="linear" if tilt else "constant")
    if free is not None:
        # the retraction's points without contact distinguish drag from the baseline
        cycle, size = found.cycle, shown.depth.size
        shown = cycle.taken(np.append(np.arange(size), free.points))
        used = np.append(used, np.ones(free.points.size, dtype=bool))
    speed = speed_of(shown, settings) if free is None else np.append(free.speed[0][:size], free.speed[1])
    if speed is not None:
        shown = replace(shown, meta={**shown.meta, "speed": speed})
    start, frame = fit.x, record.objective.frame
    if fit.noise.background.white or free is not None:
        rest = None if speed is None else speed[used]
        objective = _objective(shown.taken(used), frame, model, settings, tilt, found.turned, rest)
        place_of_contact = made.contact + fit.record.bent
        objective = objective if free is not None else fit.at_the_tip(objective)
        coarse, other = objective if objective.weight is not None else blocked(objective, place_of_contact), None
    else:
        objective = fit.whitened(fit.noise)
        coarse, other = objective, _other(fit)
    lower, upper = with_nuisance(objective, limits, record.contacts)
    if "drag" in objective.nuisance and "drag" not in fit.objective.nuisance:
        known = {**fit.objective.split(fit.x)[1], "drag": free.drag if free is not None else 0.0}
        known["baseline"] = free.level if free is not None else known["baseline"]
        scales, count = objective.units, len(model.free)
        start = np.append(
            fit.x[:count], [(known[name] - scales[name][0]) / scales[name][1] for name in objective.nuisance]
        )
    start = np.clip(start, lower, upper)
    setup = Setup(
        part=shown,
        used=used,
        objective=objective,
        lower=lower,
        upper=upper,
        start=lambda: start,
        settings=chosen,
        notes=tuple(notes),
        reached=float(part.depth[~made.out].max()),
        coarse=coarse if settings.loss == "linear" else objective,
        other=other,
        tilted=tilt
        if settings.baseline == "auto"
        else settings.baseline == "constant" and record.learnt(fit.touch).tilt,
        doubtful=settings.baseline == "auto" and not tilt and fit.noise.background.size == 0 and fit.touch > 0,
    )
    if model.finite_strain is None:
        return setup
    return replace(setup, again=lambda x: _in_strain_table(setup, made, model, limits, x))


def _check_moduli(part: Curve, model: ForwardModel, moduli: list[float]) -> None:
    """Refuse a force that no solid under this tip would give, before the descent looks for one."""
    if all(_SOLIDS[0] < each < _SOLIDS[1] for each in moduli):
        return
    tip = ", ".join(" ".join(line.split()) for line in str(model.indenter).splitlines())
    raise CurveError(
        f"{part.name}: under this tip the curve asks for a modulus of about {moduli[0]:.2g} Pa, which no solid has. "
        f"Check the size of the tip ({tip}) and the units of depth and force."
    )


def _other(fit: Fit) -> Objective | None:
    """The problem over a walk where the background is smooth: waves carry their slope on into the contact, a walk does not."""
    if not fit.noise.background.smooth:
        return None
    walk = replace(fit.record.learnt(fit.touch, smooth=False, tilt=False), tilt=fit.noise.background.tilt)
    return fit.whitened(Noise(walk, fit.noise.error))


def _adhesion(made: Approached, settings: Settings) -> tuple[Flags, list[str]]:
    """Which readings of the approach can be fitted in spite of a dip below the background, and notes."""
    keep, fit = np.ones(made.part.depth.size, dtype=bool), made.fit
    far, size, means = dip(fit.record, fit.objective, fit.noise, fit.x, fit.end)
    rise = made.fit.most
    if settings.adhesion == "ignore" or far < DIP or size < 2 * SHARE * max(rise, float(np.max(made.fit.record.y))):
        return keep, []
    force = size * made.fit.record.range
    if settings.adhesion == "refuse":
        raise CurveError(
            f"{made.part.name}: the force dips {force:.3g} N below the baseline before it rises, {size / rise:.1%} of the "
            f"largest force and {far:.0f} times what the force without contact does: the tip is pulled in. A model without "
            "adhesion would put the contact point wrong. Use adhesion='above' to fit the part above the baseline only (the "
            "modulus is then still biased by the adhesive force), or measure in a liquid that screens it. If the curve has a "
            "retract, work_of_adhesion fits the adhesion with the rest."
        )
    edges, place = made.fit.record.edges, np.flatnonzero(~made.out)
    first, last = int(edges[means.start]), int(edges[min(means.stop, edges.size - 1)])
    keep[place[first:last]] = False
    return keep, [
        f"Adhesion: {force:.3g} N below the baseline; {last - first} points of the dip are left out. The modulus is biased by "
        "the adhesive force that remains."
    ]


def _in_strain_table(
    setup: Setup, made: Approached, model: ForwardModel, limits: tuple[Array, Array], x: Array
) -> Setup | None:
    """The problem without the readings beyond the table of large strains; None where all are inside."""
    parameters, background = setup.objective.split(x)
    place = place_of(*model.case(model.externals(parameters)))
    beyond = setup.objective.depth > background["contact"] + place.deepest
    if not beyond.any():
        return None
    depth = setup.part.depth[setup.used]
    before = depth[depth <= background["contact"] + place.deepest]
    if not before.size:
        raise CurveError(
            f"{setup.part.name}: begins deeper than {text(place.deepest, 'm')}; {place.end} Leave finite_strain out."
        )
    settings = replace(made.settings, depth_to=made.found.turned * float(before.max()))
    whole = made.found.signed(made.upright).whole.turned(depth=made.found.turned)
    inside = _setup(approached(whole, model, limits, settings), model, limits, settings)
    note = f"Readings deeper than {text(place.deepest, 'm')} are left out: {place.end}"
    return replace(inside, notes=(*inside.notes, note))
