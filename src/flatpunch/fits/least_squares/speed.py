"""Speed of the cantilever's base, and whether a curve shows the drag of the liquid, a force in proportion to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy

from flatpunch._support.checks import TINY, Array
from flatpunch._support.prefixes import text
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.orientation import pieces
from flatpunch.fits.measured.signal import CLEAR, EXACT, wander
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
    width = int(np.clip(2 * np.ceil((12 * (noise / 0.01) ** 2) ** (1 / 3) / 2) + 1, 3, most))
    return width, float(np.sqrt(12 / (width * (width**2 - 1)))) * noise * way / step


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
