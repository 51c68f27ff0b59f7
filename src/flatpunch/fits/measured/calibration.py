"""Spring constant and sensitivity: those that a file was written with, and those that the user gives in their place.

A deflection is measured as a signal s: the sensitivity c makes it a length d = c s, the spring constant k a force F = k d. Other
constants leave the signal and the position of the cantilever's base as they are:

    F' = F (k'/k) (c'/c),    depth' = depth + F/k - F'/k'
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from flatpunch._support.checks import Array
from flatpunch.files import units
from flatpunch.fits.measured.columns import SIGNALS, STIFFNESS, WORDS, Constants, listed, scale_of, words
from flatpunch.fits.measured.curve import Curve, CurveError

PRINTED = 1e-3
"""Relative differences that the rounding of printed numbers explains; ten times as much hides a tilt that was taken off."""

_LINE = re.compile(
    r"^[^A-Za-z]*([A-Za-z][A-Za-z _.]*?)\s*(?:[(\[]([^)\]]*)[)\]])?\s*[:=\t;,]\s*"
    r"([-+]?[0-9]*[.,]?[0-9]+(?:[eE][-+]?[0-9]+)?)\s*\"?([A-Za-zµμ]\S*)?\"?\s*$"
)


def constants_in(lines: Sequence[str]) -> Constants:
    """Constants in the lines above the numbers of a text file: "# springConstant: 0.02", "k (N/m) 0.019", "invOLS = 60 nm/V"."""
    found: dict[str, float] = {}
    for name, title, number, unit in _numbers_in(lines, "constants"):
        # a k alone may be anything
        if unit or words(title) != ("k",):
            value = _in_si(name, number, unit)
            found |= {name: value} if value else {}
    return Constants(found.get("spring_constant"), found.get("sensitivity"))


def place_in(lines: Sequence[str]) -> dict[str, float]:
    """Where a curve was taken [m], by the lines above its numbers: "# xPosition: 1.2e-05", "Stage X (mm): 3.5"."""
    found: dict[str, float] = {}
    for name, _, number, unit in _numbers_in(lines, "positions"):
        value = number * ((scale_of(unit, units.LENGTH) or np.inf) if unit else 1.0)
        # metres that no stage has are another unit that is not given
        found |= {name: value} if abs(value) < 1 else {}
    return found


def _numbers_in(lines: Sequence[str], kind: str) -> Iterator[tuple[str, str, float, str | None]]:
    """Yield what lines give of the numbers of a section of `columns.toml`: name, title in the file, number and unit."""
    for match in filter(None, map(_LINE.match, lines)):
        entries = ((name, [f"= {entry}" for entry in known]) for name, known in WORDS[kind].items())
        name = next((name for name, known in entries if listed(match[1], known)), None)
        if name is not None:
            yield name, match[1], float(match[3].replace(",", ".")), match[2] or match[4]


def _in_si(name: str, number: float, unit: str | None) -> float | None:
    """A constant in N/m, m/V or m/A; None where its unit is another, or the number is none of such."""
    if not number > 0 or unit is None:
        return number if number > 0 else None
    length, _, signal = unit.partition("/")
    if name == "spring_constant":
        return number * (scale_of(unit, STIFFNESS) or 0.0)
    return number * (scale_of(length, units.LENGTH) or 0.0) / (scale_of(signal, *SIGNALS) or np.inf)


def ratio_of(force: Array, deflection: Array) -> float | None:
    """Spring constant that forces were computed from deflections with [N/m]; None where they are not proportional."""
    good = np.isfinite(force) & np.isfinite(deflection)
    f, d = force[good] - force[good].mean(), deflection[good] - deflection[good].mean()
    if good.sum() < 2 or not d @ d > 0 or not f @ f > 0:
        return None
    ratio = float(f @ d) / float(d @ d)
    return abs(ratio) if np.linalg.norm(f - ratio * d) < PRINTED * np.linalg.norm(f) else None


def calibrated(
    curve: Curve, own: Constants, spring_constant: float | None, sensitivity: float | None, *, inwards: bool
) -> Curve:
    """A curve with the constants that the user gives, and a line for each constant that is known.

    Parameters
    ----------
    curve : Curve
        As the file has it, with the spring constant of the file if that is known, else the given one.
    own : Constants
        Of the file.
    spring_constant, sensitivity : float or None
        Given by the user [N/m], [m/V] or [m/A].
    inwards : bool
        Whether the depth is known to grow into the sample, or comes from a position of the piezo.

    Raises
    ------
    CurveError
        If a constant that is given cannot act.
    """
    if sensitivity is not None and own.sensitivity is None:
        raise CurveError(
            f"{curve.name}: the sensitivity cannot act: no column of a signal (V, A) is in use, and the file does not say with "
            "which sensitivity its forces were made. Leave it out, or name the columns of the signal and of the piezo, "
            "[curve.columns] deflection = '...' and piezo = '...'."
        )
    k = spring_constant or own.spring_constant
    stiffer, lines = _change("spring constant", "N/m", spring_constant, own.spring_constant, own.origin)
    larger, more = _change("sensitivity", "m/V or m/A", sensitivity, own.sensitivity, own.origin)
    force, depth = stiffer * larger * curve.force, curve.depth
    if larger != 1:
        if not inwards:
            raise CurveError(
                f"{curve.name}: another sensitivity changes the depth as well, and which way the depth goes is not in the file. "
                "Name the column of the piezo's position, [curve.columns] piezo = '...'."
            )
        if k is not None:
            depth = curve.position - force / k
    meta = {**curve.meta, "read": (*curve.meta.get("read", ()), *lines, *more)}
    return replace(curve, depth=depth, force=force, spring_constant=k, meta=meta)


def _change(name: str, unit: str, given: float | None, known: float | None, origin: str) -> tuple[float, list[str]]:
    """Factor from the constant of a file to the one that is given, and the line about it."""
    if given is None:
        return 1.0, [f"{name} {known:.4g} {unit} ({origin})"] if known else []
    if known is None or given == known:
        return 1.0, [f"{name} {given:.4g} {unit} (given)"]
    factor = given / known
    return factor, [f"{name} {given:.4g} {unit} (given; {known:.4g} {origin}: its forces times {factor:.4g})"]
