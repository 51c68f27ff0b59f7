"""What every contact method takes and returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal
from warnings import warn

import numpy as np

from flatpunch._support.checks import ROUNDING, STEPS, Array, BadValue, Flags, FlatpunchWarning, values
from flatpunch._support.prefixes import text
from flatpunch.indenters.profile import Indenter

ControlName = Literal["depth", "force", "radius"]

NOTABLE_FORCE, NOTABLE_OUTLINE = 0.01, 0.05
"""Estimated errors of the force, and of the outline over the mean radius, above which a result has a note about them."""

FEW_ANGLES = 8
"""Polar angles of outlines that are of no interest."""

FORCE_ERROR = 5e-4
"""Relative error of the force of the solutions that come with the package, and of `Refined` unless another is asked for."""

UNITS = {"depth": "m", "force": "N", "radius": "m"}
"""SI units of what may be prescribed."""

Extra = Mapping[str, tuple[tuple[str, ...], Array | Flags, str, str]]
"""Further arrays of a result: name -> (dimensions, values, unit, description)."""


@dataclass(frozen=True, slots=True)
class Control:
    """The quantity that is prescribed and its values, shape (n,), SI."""

    name: ControlName
    values: Array


@dataclass(frozen=True, slots=True)
class Curve:
    """A solved indentation: arrays of shape (n,), outline of shape (n, p), and sentences about its limits.

    `valid` is False at steps where the theory does not hold (the notes say why); `extra` holds further arrays of a method,
    each with its dimensions, unit and description. `pressing` is the force without adhesion at the same radius, where it differs.
    """

    depth: Array
    force: Array
    radius: Array
    area: Array
    stiffness: Array
    contour: Array
    valid: Flags
    notes: tuple[str, ...] = ()
    extra: Extra = field(default_factory=dict)
    pressing: Array | None = None


def control_from(*, depth: object, force: object, radius: object) -> Control:
    """Exactly one of depth, force and radius, checked."""
    name, value = prescribed(depth=depth, force=force, radius=radius)
    return Control(name, few(name, values(name, value, unit=UNITS[name])))


def few(name: str, steps: Array) -> Array:
    """Return the steps, or refuse more than a result can hold."""
    if steps.size > STEPS:
        raise ValueError(f"{name} has {steps.size} values; a curve has at most {STEPS} steps. Solve it in parts.")
    return steps


def prescribed(*, depth: object, force: object, radius: object) -> tuple[ControlName, object]:
    """The only one of the three that is given, by name."""
    three: tuple[tuple[ControlName, object], ...] = (("depth", depth), ("force", force), ("radius", radius))
    given = [(name, value) for name, value in three if value is not None]
    if len(given) != 1:
        what = " and ".join(name for name, _ in given) or "none"
        raise ValueError(
            f"Give exactly one of depth, force and radius; got {what}. The other two are part of the result."
        )
    return given[0]


def check_reach(indenter: Indenter, radius: Array) -> None:
    """Refuse radii at which the indenter has no shape."""
    if radius.size and radius.max() > indenter.reach * (1 + ROUNDING):
        i = int(np.argmax(radius))
        raise BadValue(
            f"radius[{i}]",
            text(float(radius[i]), "m"),
            f"is beyond this indenter, whose shape is defined up to {text(indenter.reach, 'm')}. Ask for a "
            "smaller contact, or give the shape further out.",
        )


def uncertain(curve: Curve) -> tuple[str, ...]:
    """Sentences about steps whose estimated errors exceed a bound; contacts without an outline have their own."""
    found: tuple[str, ...] = ()
    bounds = (("force_error", NOTABLE_FORCE, "the force"), ("contour_error", NOTABLE_OUTLINE, "the outline"))
    for name, bound, what in bounds:
        error = np.asarray(curve.extra[name][1] if name in curve.extra else np.zeros(0), dtype=float)
        large = np.isfinite(error) & (error > bound)
        if large.any():
            whole = " of the mean radius" if name == "contour_error" else ""
            found += first_failure(
                large,
                curve.depth,
                f"{what} is expected to be off by up to {percent(float(error[large].max()))}{whole}.",
            )
    return found


def percent(share: float) -> str:
    """A relative error in words, with two digits."""
    if not np.isfinite(share):
        return "an unknown amount"
    return f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def first_failure(bad: Flags, along: Array, sentence: str, called: tuple[str, str] = ("depth", "m")) -> tuple[str, ...]:
    """One sentence that says at which depths, or values of another name and unit, something fails, or nothing."""
    known = np.isfinite(along)
    if not (bad & known).any():
        return ("At every step: " + sentence,) if bad.any() else ()
    name, unit = called
    first, last = (text(float(each), unit) for each in (along[bad & known].min(), along[bad & known].max()))
    if (~bad & known & (along > along[bad & known].max())).any():
        if first == last:
            return (f"At a {name} of {first}: {sentence}",)
        return (f"Between {name}s of {first} and {last}: {sentence}",)
    return (f"At {name}s of {first} and more: {sentence}",)


@dataclass(frozen=True, slots=True)
class PressureField:
    """Contact pressure at points, and its estimated error there; shape (n,) each [Pa]."""

    pressure: Array
    error: Array


SUPERPOSED = 0.02
"""Differences that count, of a superposed pressure to boundary elements (median over mean) and of its integral to the force."""


def superposed(field: Array, cells: PressureField) -> PressureField:
    """A pressure superposed from flat punches; its error is the difference to boundary elements. Warns where that is large."""
    difference = np.abs(field - cells.pressure)
    touched = cells.pressure > 0
    if touched.any():
        share = difference[touched] / cells.pressure[touched].mean()
        if np.median(share) > SUPERPOSED:
            warn(
                "First-order pressures under a tip that is not round are those of stretched flat punches: at these points they "
                f"differ from boundary elements by {np.median(share):.0%} of the mean pressure (median; 95 % of the points by "
                f"less than {np.quantile(share, 0.95):.0%}). All other methods take pressures from boundary elements.",
                FlatpunchWarning,
                stacklevel=5,
            )
    return PressureField(field, difference + cells.error)
