"""What was read from a file, and how a fit sees the curve: columns, segments, baseline, contact, what is left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from flatpunch._support.checks import Array, instance
from flatpunch._support.prefixes import text
from flatpunch.contact.physics import Physics
from flatpunch.fits.adhesion.setup import free_force
from flatpunch.fits.fitting import descended, model_of, setup_of
from flatpunch.fits.least_squares.objective import Objective
from flatpunch.fits.least_squares.problem import Setup
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.fits.measured.orientation import Approach, approach_of
from flatpunch.fits.parameters.sample import WORK, Sample
from flatpunch.fits.parameters.settings import Settings, as_free
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace
from flatpunch.plots.style import BLUE, GREY, ORANGE, PALE, THIN, StyleName, axes_or_new, scale_of, sheet, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flatpunch.fits.case import FitCase

OVERRIDES = (
    "Overrides: direction = 'growing' or 'falling' (which way the depth goes on the approach), depth_to and force_to (fit less "
    "of the curve), segment, baseline; in a case file under [fit]."
)


_PARTS = ("before", "approach", "hold", "retract", "further cycles")
"""Names of the parts of a curve, in order."""

_DOTS: dict[str, Any] = {"marker": ".", "ls": "", "ms": 3}
_DRAWN: dict[str, dict[str, Any]] = {
    "measured": {**_DOTS, "color": PALE},
    **{n: {**_DOTS, "color": c} for n, c in zip(_PARTS, (GREY, PALE, "black", ORANGE, GREY), strict=True)},
    "baseline": {"color": BLUE, "lw": 1.0},
    "contact": {"color": GREY, "lw": THIN, "ls": ":"},
    "left out": {"marker": "x", "ls": "", "ms": 4, "color": GREY},
}
"""How a picture draws what it shows."""


@dataclass(frozen=True, eq=False)
class Reading:
    """How a fit sees a curve.

    Attributes
    ----------
    curve : Curve
        As measured.
    approach : Approach or None
        Its parts; None where they were not found.
    setup : Setup or None
        What would be fitted; None where it is refused.
    lines : tuple of str
        Columns, units and calibration with their origin, segments, baseline, contact, points that are left out, and why a curve
        is refused.
    """

    curve: Curve
    approach: Approach | None
    setup: Setup | None
    lines: tuple[str, ...]


def reading_of(curve: Curve, case: FitCase | None = None) -> Reading:
    """Find what a fit would find before it searches; by default with a paraboloid on a half-space, enough for the contact.

    Of tips with a range of action the contact begins where JKR theory has it.
    """
    sample = Sample(HalfSpace(1e3, 0.5), Paraboloid(1e-6)) if case is None else case.sample
    free = as_free(["base.young"]) if case is None else case.free
    settings = Settings() if case is None else case.settings
    assumed = " (for a paraboloid on a half-space)" if case is None else ""
    if sample.physics.within is not None:
        # whose tables take minutes
        sample, assumed = replace(sample, physics=Physics(sample.value(WORK))), " (without the range of action)"
        free = {name: free[name] for name in free if name in sample.numbers}
    lines = list(curve.meta.get("read", ()))
    found = setup = None
    try:
        found = approach_of(curve, settings.direction, back=sample.adhesive)
        lines += found.found
        model = model_of(sample, free, settings.method)
        setup = setup_of(curve, model, model.bounds(free), settings)
        lines += _about(setup, found, assumed)
    except CurveError as error:
        lines += [f"refused: {error}", OVERRIDES]
    return Reading(curve, found, setup, tuple(lines))


def _start(setup: Setup) -> dict[str, float]:
    """Contact point, baseline and tilt, SI, on the axes of the curve that is shown: by a fit where that takes seconds."""
    x = setup.start()
    if setup.coarse is not None or setup.objective.model.over_time:
        x = descended(setup, x, replace(setup.settings, quick=True)).x
    rest, objective = dict(setup.objective.split(x)[1]), setup.objective
    if isinstance(objective, Objective) and objective.loaded is not None and "baseline" in objective.nuisance:
        # a contact that is not fitted yet must not move the background
        level, way = free_force(objective), objective.position - objective.frame.first
        tilt, first = np.polyfit(way, level, 1) if rest["tilt"] else (0.0, level[0])
        rest |= {"baseline": float(first), "tilt": float(tilt)}
    return rest


def _about(setup: Setup, found: Approach, assumed: str) -> list[str]:
    start, settings = _start(setup), setup.settings
    baseline = f"baseline: {settings.baseline}"
    if settings.baseline != "none":
        baseline += f", {text(start['baseline'], 'N')} at the first point"
    if start["tilt"]:
        baseline += f", tilt {text(start['tilt'], 'N/m')}"
    out = setup.part.depth.size - int(setup.used.sum())
    fitted = f"fitted: {int(setup.used.sum())} of {found.whole.depth.size} points"
    return [
        baseline,
        f"contact: begins at {text(found.turned * start['contact'], 'm')} of the tip's position{assumed}",
        f"{fitted}, {out} of the fitted part left out" if out else fitted,
        *(note for note in setup.notes if note not in found.found),
    ]


def plot_measured(curve: Curve, case: FitCase | None = None, axes: Axes | None = None) -> Axes:
    """Draw a curve as it was read: approach, hold and retract, the baseline and where the contact begins.

    Parameters
    ----------
    curve : Curve
        From `read_curve`, or of arrays.
    case : FitCase, optional
        The case of the fit; a paraboloid on a half-space by default.
    axes : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes

    See Also
    --------
    read_curve : From a file.
    plot_fit : After the fit.

    Examples
    --------
    >>> depth = np.linspace(-100e-9, 200e-9, 300)
    >>> force = 1e-9 * (np.maximum(depth, 0.0) / 1e-7) ** 1.5
    >>> axes = fp.plot_measured(fp.Curve(depth=depth, force=force))
    >>> axes.get_xlabel()
    'position of the tip (nm)'
    """
    instance("curve", curve, (Curve,), "a Curve, as `read_curve` returns it")
    reading = reading_of(curve, case)
    drawn = axes_or_new(axes)
    (far, length), (strong, newton) = scale_of(curve.depth, "m"), scale_of(curve.force, "N")
    for name, depth, force in traces(reading):
        drawn.plot(depth * far, force * strong, label=name, **_DRAWN[name])
    drawn.set(xlabel=f"position of the tip ({length})", ylabel=f"normal force $F$ ({newton})")
    drawn.set_title(curve.name if reading.setup is not None else f"{curve.name}: refused")
    drawn.legend(loc="best")
    return drawn


def measured_figure(curve: Curve, case: FitCase | None = None, *, style: StyleName | str = "screen") -> Figure:
    """Picture of a curve as it was read, see `plot_measured`."""
    with styled(style) as chosen:
        figure = Figure(figsize=sheet(chosen), layout="constrained")
        plot_measured(curve, case, figure.add_subplot())
    return figure


def traces(reading: Reading) -> list[tuple[str, Array, Array]]:
    """Names, positions [m] and forces [N] of what a picture of a reading shows: parts, baseline, contact, what is left out."""
    found = reading.approach
    if found is None:
        return [("measured", reading.curve.depth, reading.curve.force)]
    whole = found.whole
    ends = [0, found.begin, found.end, found.leaves, found.stop, whole.depth.size]
    shown = [(n, whole.depth[i:j], whole.force[i:j]) for n, (i, j) in zip(_PARTS, pairwise(ends), strict=True) if j > i]
    if reading.setup is None:
        return shown
    start, part, left = _start(reading.setup), reading.setup.part, ~reading.setup.used
    # the fit may have turned the sign of the force
    sign = 1.0 if part.force[0] in whole.force else -1.0
    level = start["baseline"] + start["tilt"] * (part.position - part.position.min())
    ends_of_force = np.array([whole.force.min(), whole.force.max()])
    shown += [("baseline", part.depth, sign * level), ("contact", np.full(2, start["contact"]), ends_of_force)]
    unused = [(part.depth[left], sign * part.force[left])]
    rest = slice(found.begin + part.depth.size, found.end)
    if np.array_equal(whole.depth[found.begin : rest.start], part.depth):
        # behind a drop, or cut off
        unused.append((whole.depth[rest], whole.force[rest]))
    depth, force = map(np.concatenate, zip(*unused, strict=True))
    return shown + ([("left out", depth, force)] if depth.size else [])
