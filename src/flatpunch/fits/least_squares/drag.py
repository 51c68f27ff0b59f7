"""Speed of the cantilever's base, and the drag of the liquid in proportion to it: whether curves show it, and how large it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from flatpunch._support.checks import TINY, Array, Flags, Indices
from flatpunch._support.prefixes import text
from flatpunch.fits.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fits.measured.orientation import Approach, pieces
from flatpunch.fits.measured.signal import CLEAR, EXACT, wander, white_noise
from flatpunch.fits.parameters.settings import Settings


def speed_of(curve: Curve, settings: Settings) -> Array | None:
    """Speed of the cantilever's base [m/s] where the drag counts, of each segment its own; CurveError without times."""
    if settings.drag == 0:
        return None
    if curve.time is None:
        raise CurveError(
            f"{curve.name}: drag is a force per speed, and the curve has no times. {curve.meta.get('no time', '')} "
            "Name the column of times, or leave drag out."
        )
    position, speed = curve.position, np.zeros(curve.time.size)
    for piece in pieces(curve):
        width, _ = _window(position[piece], curve.time[piece])
        if width:
            # a parabola through each window: exact to second order at the ends too
            way, time = (scipy.signal.savgol_filter(c[piece], width, 2, deriv=1) for c in (position, curve.time))
            speed[piece] = way / np.maximum(time, TINY)
    return speed


def _window(position: Array, time: Array) -> tuple[int, float]:
    """Readings through which a parabola is laid, 0 where there are too few for a speed, and the noise that is left in the speed.

    Three where position and time are exact, so that a sudden change of the speed stays one; at most a fifth of the readings.
    """
    if time.size < 3:
        return 0, 0.0
    step = max(float(np.median(np.diff(time))), TINY)
    way = max(float(np.median(np.abs(np.diff(position)))), TINY)
    noise = float(np.hypot(wander(position) / way, wander(time) / step))
    most = min(2 * max(time.size // 10, 2) + 1, time.size - 1 + time.size % 2)
    # slopes of parabolas have the variance 12/(w (w^2 - 1)) of the readings; 1 % of the speed adds 1 % of the drag to the noise
    square = 12 * noise**2
    width = int(np.clip(2 * np.ceil((square / 0.01**2) ** (1 / 3) / 2) + 1, 3, most))
    return width, float(np.sqrt(square / (width * (width**2 - 1)))) * way / step


def before_turn(curve: Curve, settings: Settings) -> Curve:
    """An approach without its last readings if drag is fitted or given: the tip slows down there before it turns.

    The window of the speed is cut by the end of the approach, so that the speed of half a window is extrapolated.
    """
    if settings.drag == 0 or curve.time is None:
        return curve
    width, _ = _window(curve.position, curve.time)
    return curve.taken(slice(0, curve.depth.size - width // 2))


def shows_drag(curves: Sequence[Curve], settings: Settings) -> bool:
    """Whether drag as large as the whole range of the force would be clear of noise, beside the other terms of the background.

    At one speed drag is a constant force, the baseline. What the speed varies by counts as far as it is clear of its own noise.
    """
    varying, noise, places = [], [], []
    for curve in curves:
        speed = speed_of(curve, settings)
        assert speed is not None
        assert curve.time is not None
        for piece in pieces(curve):
            width, own = _window(curve.position[piece], curve.time[piece])
            # where a window is cut by the end of the segment the speed is extrapolated
            inner = slice(piece.start + width // 2, piece.stop - width // 2)
            if not width or inner.stop <= inner.start:
                continue
            varying.append(speed[inner])
            noise.append(np.full(varying[-1].size, own))
            places.append(curve.position[inner])
    if not varying:
        return False
    left, unclear, place = (np.concatenate(column) for column in (varying, noise, places))
    fastest = float(np.abs(left).max())
    terms = [np.ones(left.size)] if settings.baseline != "none" else []
    if settings.baseline == "linear":
        terms.append((place - place.mean()) / max(float(np.ptp(place)), TINY))
    if terms:
        columns = np.array(terms).T
        left = left - columns @ np.linalg.lstsq(columns, left, rcond=None)[0]
    varies = float(np.linalg.norm(left))
    if not varies > CLEAR * float(np.linalg.norm(unclear)):
        return False
    force = max(wander(curve.force) for curve in curves)
    # force range over which drag is judged; speeds that differ by rounding, 1e-9, are one
    span = max(float(np.ptp(curve.force)) for curve in curves)
    return span * varies > CLEAR * force * fastest and varies > EXACT * fastest


def no_drag(curve: Curve, settings: Settings, why: str) -> CurveError:
    """Refusal of a free drag that the curve cannot show."""
    speed = speed_of(curve, settings)
    assert speed is not None
    usual = text(float(np.median(np.abs(speed))), "m/s")
    return CurveError(
        f"{curve.name}: drag = 'free' cannot be fitted: the tip moves at one speed, {usual}, at which drag is a constant force, "
        f"like the baseline{why}. Give drag as a number [N s/m], add a segment at another speed or a retraction "
        "that ends without contact, or leave drag out: a constant force changes no modulus."
    )


def with_speed(curve: Curve, settings: Settings) -> tuple[Curve, Array | None]:
    """A curve, all of which is fitted, with its speed where drag counts; refused where it cannot show a drag that is free."""
    if (speed := speed_of(curve, settings)) is None:
        return curve, None
    if settings.drag == "free" and not shows_drag([curve], settings):
        raise no_drag(curve, settings, "")
    return replace(curve, meta={**curve.meta, "speed": speed}), speed


@dataclass(frozen=True, eq=False)
class FreeOfContact:
    """Points of a retraction without contact, and the drag that they show beside the approach.

    Attributes
    ----------
    points : ndarray of int
        Indices into the cycle.
    speed : ndarray
        Of the approach and of these points [m/s].
    level, drag : float
        Baseline [N] and drag [N s/m] through all that is free of contact.
    """

    points: Indices
    speed: tuple[Array, Array]
    level: float
    drag: float


def free_of_contact(
    cycle: Approach, part: Curve, before: Flags, background: Callable[[Curve], Array], settings: Settings
) -> FreeOfContact | None:
    """What the parts of approach and retraction without contact show of a drag that is free; None if they do not.

    `part` is the approach in `cycle`, `before` marks its readings without contact; the retraction has none as far out as these,
    unless the tip still sticks there, which bends the force. `background` gives its force at a curve's positions, without level
    and drag [N].
    """
    curve, begin = cycle.cycle, cycle.leaves - cycle.begin
    if before.sum() < FEWEST or curve.depth.size - begin < FEWEST:
        return None
    out = curve.position[begin:] <= float(part.position[before].max())
    found = np.arange(begin + int(np.argmax(out)), curve.depth.size) if out.any() else np.zeros(0, dtype=np.intp)
    if found.size < FEWEST:
        return None
    back, here = curve.taken(found), part.taken(before)
    left = [c.force - np.polynomial.Polynomial.fit(c.position, c.force, 1)(c.position) for c in (here, back)]
    # rounding of clean data bends it by 1e-9
    least = EXACT * float(np.ptp(part.force)) + white_noise(here.force, 0.0)
    if not np.std(left[1]) < 2 * max(float(np.std(left[0])), least) or not shows_drag([here, back], settings):
        return None
    speeds = [speed_of(c, settings) for c in (part, back)]
    assert speeds[0] is not None
    assert speeds[1] is not None
    over = np.concatenate([c.force - background(c) for c in (here, back)])
    moving = np.concatenate([speeds[0][before], speeds[1]])
    level, drag = np.linalg.lstsq(np.array([np.ones(moving.size), moving]).T, over, rcond=None)[0]
    return FreeOfContact(found, (speeds[0], speeds[1]), float(level), float(drag))
