"""`finite_strain=` of `indent`: curves of linear theory, corrected, and what linear theory is off by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flatpunch._support.checks import Array, BadValue
from flatpunch._support.prefixes import text
from flatpunch.contact.curve import Control, Curve
from flatpunch.contact.finite_strain.caps import place_of
from flatpunch.contact.finite_strain.tables import SETTLED, Place
from flatpunch.contact.physics import NEO_HOOKEAN, Physics
from flatpunch.media import Body, underlying


def checked(physics: Physics, medium: Body, indenter: object, control: str) -> Place | None:
    """Place of a case in the table, or None where no law is asked for; refuses what cannot be corrected."""
    name = physics.finite_strain
    if name is None:
        return None
    if underlying(medium).free:
        raise BadValue("finite_strain", repr(name), "does not go with a FreeLayer, which lifts off.")
    if control == "radius":
        raise BadValue(
            "finite_strain",
            repr(name),
            "goes with depth or force: the contact radius at large strain is not tabulated.",
        )
    return place_of(medium, indenter)


def solve(place: Place, linear: Callable[[Control], Curve], control: Control) -> Curve:
    """Curve of linear theory, its forces and stiffnesses corrected.

    Parameters
    ----------
    place : Place
        Where in the table.
    linear : callable
        Linear theory.
    control : Control
        Depths or forces.

    Raises
    ------
    BadValue
        For steps beyond the table.
    """
    if control.name == "depth":
        _in_table(place, control, control.values)
    curve = linear(control)
    ratio, rate, error = place.ratio(curve.depth)
    for _ in range(100 if control.name == "force" else 0):
        # Newton's method on the logarithms; without contact nothing moves
        found, slope = curve.force * ratio, curve.stiffness * ratio + curve.force * rate
        live = found > 0
        step = np.log(np.divide(control.values, found, out=np.ones_like(found), where=live))
        step *= np.divide(found, curve.depth * slope, out=np.zeros_like(found), where=live)
        curve = linear(Control("depth", curve.depth * np.exp(step)))
        ratio, rate, error = place.ratio(curve.depth)
        if np.abs(step).max(initial=0.0) <= SETTLED:
            break
    _in_table(place, control, curve.depth)
    before = curve.extra["force_error"][1].astype(float) if "force_error" in curve.extra else 0.0
    extra = {
        **curve.extra,
        "force_error": (("step",), before + error / ratio, "1", "estimated relative error of the force"),
        "strain_factor": (("step",), ratio, "1", "force at large strain over that of linear theory"),
    }
    return replace(
        curve,
        force=control.values if control.name == "force" else curve.force * ratio,
        stiffness=curve.stiffness * ratio + curve.force * rate,
        extra=extra,
        notes=curve.notes + place.notes,
    )


def _in_table(place: Place, control: Control, depth: Array) -> None:
    far = np.flatnonzero(depth > place.deepest * (1 + SETTLED**2))
    if far.size:
        i = int(far[0])
        unit = {"depth": "m", "force": "N"}[control.name]
        raise BadValue(
            f"{control.name}[{i}]",
            text(float(control.values[i]), unit),
            f"is a depth of {text(float(depth[i]), 'm')}; {place.end} Ask for less, or leave finite_strain out.",
        )


REMEDY = f"; finite_strain = '{NEO_HOOKEAN}' corrects it"
"""What a note on large strain advises where adhesion and relaxation do not exclude it."""


def overestimate(medium: Body, indenter: object, depth: Array, *, corrects: bool) -> tuple[str, bool] | None:
    """What linear theory is off by at the largest depth, as the end of a note, and whether the table ends before."""
    try:
        place = place_of(medium, indenter)
    except BadValue:
        return None
    largest = np.minimum(np.array([np.nanmax(depth, initial=0.0)]), place.deepest)
    if not largest[0] > 0:
        return None
    off = 100 * (float(place.ratio(largest)[0][0]) - 1)
    side = "less" if off < 0 else "more"
    beyond = bool(largest[0] == place.deepest)
    end = ", where the table ends," if beyond else ""
    found = f"at {text(float(largest[0]), 'm')}{end} a neo-Hookean solid takes {abs(off):.2g} % {side} force than linear theory"
    remedy = f"{REMEDY}{' up to there' if beyond else ''}" if corrects else ""
    return f"{found}{remedy}.", beyond
