"""What was read from a file, and how a fit sees the curve: columns, segments, baseline, contact, what is left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from flatpunch._support.checks import Array
from flatpunch._support.kinds import instance
from flatpunch._support.prefixes import text
from flatpunch.fit.fitting import setup_of
from flatpunch.fit.least_squares.setup import Setup
from flatpunch.fit.measured.approach import Approach, approach_of
from flatpunch.fit.measured.curve import Curve, CurveError
from flatpunch.fit.models import bounds, model_of
from flatpunch.fit.parameters.sample import Sample
from flatpunch.fit.parameters.settings import Settings, as_free
from flatpunch.fit.search import descended
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace
from flatpunch.plots.style import BLUE, GREY, ORANGE, PALE, THIN, StyleName, axes_or_new, scale_of, sheet, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from flatpunch.fit.case import FitCase

OVERRIDES = (
    "Overrides: direction = 'growing' or 'falling' (which way the depth goes on the approach), depth_to and force_to (fit less "
    "of the curve), segment, baseline; in a case file under [fit]."
)


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
    """Find what a fit would find before it searches; by default with a paraboloid on a half-space, enough for the contact."""
    sample = Sample(HalfSpace(1e3, 0.5), Paraboloid(1e-6)) if case is None else case.sample
    free = as_free(["base.young"]) if case is None else case.free
    settings = Settings() if case is None else case.settings
    lines = list(curve.meta.get("read", ()))
    found = setup = None
    try:
        relaxing, sticking = sample.relaxation is not None, sample.work_of_adhesion is not None
        found = approach_of(curve, settings.direction, first=relaxing, back=sticking)
        lines += found.found
        model = model_of(sample, free, settings.method, settings.finite_strain)
        setup = setup_of(curve, model, bounds(model, free), settings)
        lines += _about(setup, found, "" if case is not None else " (for a paraboloid on a half-space)")
    except CurveError as error:
        lines += [f"refused: {error}", OVERRIDES]
    return Reading(curve, found, setup, tuple(lines))


def _start(setup: Setup) -> dict[str, float]:
    """Contact point, baseline and tilt, SI, on the axes of the curve that is shown: by a fit if that takes no time."""
    x = setup.start()
    if setup.coarse is not None:
        x = descended(setup, x, replace(setup.settings, quick=True)).x
    return dict(setup.objective.split(x)[1])


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
    found = reading.approach
    whole = curve if found is None else found.whole
    (far, length), (strong, newton) = scale_of(whole.depth, "m"), scale_of(whole.force, "N")
    for (begin, end), name, colour in _parts(whole, found):
        drawn.plot(whole.depth[begin:end] * far, whole.force[begin:end] * strong, ".", ms=3, color=colour, label=name)
    if reading.setup is not None:
        start, part = _start(reading.setup), reading.setup.part
        # the fit may have turned the sign of the force
        sign = 1.0 if part.force[0] in whole.force else -1.0
        level: Array = start["baseline"] + start["tilt"] * (part.position - part.position.min())
        drawn.plot(part.depth * far, sign * level * strong, color=BLUE, lw=1.0, label="baseline")
        drawn.axvline(start["contact"] * far, color=GREY, lw=THIN, ls=":", label="contact")
        left = ~reading.setup.used
        if left.any():
            drawn.plot(
                part.depth[left] * far, sign * part.force[left] * strong, "x", ms=4, color=GREY, label="left out"
            )
    drawn.set_xlabel(f"position of the tip ({length})")
    drawn.set_ylabel(f"normal force $F$ ({newton})")
    drawn.set_title(curve.name if reading.setup is not None else f"{curve.name}: refused")
    drawn.legend(loc="best")
    return drawn


def measured_figure(curve: Curve, case: FitCase | None = None, *, style: StyleName | str = "screen") -> Figure:
    """Picture of a curve as it was read, see `plot_measured`."""
    with styled(style) as chosen:
        figure = Figure(figsize=sheet(chosen), layout="constrained")
        plot_measured(curve, case, figure.add_subplot())
    return figure


def _parts(whole: Curve, found: Approach | None) -> list[tuple[tuple[int, int], str, str]]:
    """Points, names and colours of the parts of a curve."""
    if found is None:
        return [((0, whole.depth.size), "measured", PALE)]
    ends = [0, found.begin, found.end, found.leaves, found.stop, whole.depth.size]
    names = ["before", "approach", "hold", "retract", "further cycles"]
    colours = [GREY, PALE, "black", ORANGE, GREY]
    return [(span, n, c) for span, n, c in zip(pairwise(ends), names, colours, strict=True) if span[1] > span[0]]
