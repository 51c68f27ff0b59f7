"""Ways of the tip in an adhesive cycle: the points in contact, where the tip lets go, and those without contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.fits.measured.curve import FEWEST, Curve, CurveError
from flatpunch.fits.measured.orientation import FALLS, Approach
from flatpunch.fits.measured.signal import CLEAR, LITTLE, scatter
from flatpunch.fits.parameters.settings import Settings

_FREE = 0.2
"""Share of the points, at the far end, that shows the baseline and its noise."""
_LET_GO = 0.3
"""Below this share of the dip the tip is in contact; JKR lets go of a paraboloid at 5/9 of the largest tension."""
_NOT_GONE = "{name}: the {way} ends before the tip lets go: no baseline is left after the dip. Record further out."


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


def oriented(found: Approach, settings: Settings) -> tuple[Approach, tuple[str, ...]]:
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


def segments_of(found: Approach, settings: Settings) -> list[Segment]:
    """The retract, and with segment = "both" the approach."""
    curve = found.cycle
    n, force = curve.force.size, curve.force - _background(found, settings)
    top, leaves = found.end - found.begin - 1, found.leaves - found.begin
    out, back = np.arange(leaves, n), np.arange(top, -1, -1)
    if out.size < FEWEST or np.ptp(curve.position[leaves:]) < LITTLE * np.ptp(curve.position):
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
    m = int(np.clip(np.ceil((noise / (LITTLE * dip)) ** 2), 1, max(int(LITTLE * force.size), 1)))
    ahead = np.convolve(force, np.full(m, 1 / m), "full")[m - 1 :] if m > 1 else force
    gone = np.flatnonzero(ahead[lowest:] > baseline - _LET_GO * dip)
    if not gone.size or force.size - lowest - gone[0] < max(FEWEST, LITTLE * force.size):
        raise CurveError(_NOT_GONE.format(name=curve.name, way=name))
    jump = lowest + int(gone[0])
    settled = np.flatnonzero(ahead[jump:] > baseline - max(3 * noise / np.sqrt(m), LITTLE * dip))
    quiet = jump + m + (int(settled[0]) if settled.size else 0)
    end = jump - (m if m > 1 else 0)
    if end < FEWEST:
        raise CurveError(f"{curve.name}: {end} points of the {name} are in contact; a fit needs {FEWEST} or more.")
    return Segment(points, points[:end], points[quiet:], dip)
