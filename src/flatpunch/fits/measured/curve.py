"""A measured curve: checked columns of depth and force.

`depth` is the position of the tip, growing into the sample, from any zero: where the contact begins is fitted. A curve that
cannot be evaluated is refused with the reason; nothing is repaired silently.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, numbers, positive, shown, values
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import Table, readable

_COLUMNS = {"depth": "m", "force": "N", "stiffness": "N/m", "time": "s", "segment": "1"}
FEWEST, FEWEST_STIFF = 12, 4
"""Points that a curve must have, and points with a stiffness, which come from an unloading each; fewer determine nothing."""

_OPTIONAL = ("stiffness", "time", "segment")


class CurveError(ValueError):
    """A curve that cannot be evaluated; the message says why and what to do.

    See Also
    --------
    read_curve, fit : Raise it.

    Examples
    --------
    >>> try:
    ...     fp.read_curve("missing.csv")
    ... except fp.CurveError as error:
    ...     print(error)
    missing.csv: no such file.
    """


@readable
@dataclass(frozen=True, eq=False)
class Curve:
    """Force over tip position.

    Parameters
    ----------
    depth : array, shape (n,)
        Position of the tip [m], growing into the sample, any zero.
    force : array, shape (n,)
        [N], positive when pressing.
    spring_constant : float, optional
        Of the cantilever [N/m]. `depth` then is piezo minus deflection: noise in the force is noise in the depth as well, and
        the fit weighs for it.
    stiffness : array, shape (n,), optional
        Measured contact stiffness [N/m] (nanoindentation); NaN where there is none.
    time : array, shape (n,), optional
        [s]; fits of relaxation need it.
    segment : array, shape (n,), optional
        Number of the segment (approach, pause, retract) that each point belongs to, ascending, where the file knows it.
    name : str
        For tables and messages.
    meta : dict
        What else the file says. "read": lines about where the numbers come from; "calibration": relative standard deviations
        of "spring_constant" and "sensitivity".

    Raises
    ------
    CurveError
        If lengths differ, points are too few, or entries are no finite numbers.

    See Also
    --------
    read_curve : From a file.

    Examples
    --------
    >>> depth = np.linspace(-1e-7, 3e-7, 200)
    >>> fp.Curve(depth=depth, force=np.maximum(depth, 0.0) ** 1.5)
    Curve('curve': 200 points, depth -100 nm to 300 nm, force 0 N to 164.3 pN)
    """

    depth: Array
    force: Array
    spring_constant: float | None = None
    stiffness: Array | None = None
    name: str = "curve"
    meta: Plain = field(default_factory=dict, repr=False)
    time: Array | None = None
    segment: Array | None = None

    def __post_init__(self) -> None:
        columns = {"depth": self.depth, "force": self.force}
        for name in _OPTIONAL:
            if getattr(self, name) is not None:
                columns[name] = getattr(self, name)
        for name, column in columns.items():
            array = numbers(f"Curve.{name}", column, _COLUMNS[name])
            array.setflags(write=False)
            object.__setattr__(self, name, array)
            if array.ndim != 1 or array.shape != np.shape(self.depth):
                raise CurveError(
                    f"{self.name}: {name} has shape {array.shape}, depth {np.shape(self.depth)}; both need (n,)."
                )
            if name != "stiffness":
                _check_finite(self.name, name, array)
        if self.spring_constant is not None:
            k = positive("Curve.spring_constant", self.spring_constant, unit="N/m")
            object.__setattr__(self, "spring_constant", k)
        fewest = FEWEST if self.stiffness is None else FEWEST_STIFF
        if self.depth.size < fewest:
            raise CurveError(f"{self.name}: {self.depth.size} points; a fit needs {fewest} or more.")

    def _line_(self) -> str:
        depth, force = (
            f"{text(float(column.min()), unit)} to {text(float(column.max()), unit)}"
            for column, unit in ((self.depth, "m"), (self.force, "N"))
        )
        return f"Curve({self.name!r}: {self.depth.size} points, depth {depth}, force {force})"

    def _table_(self) -> Table:
        rows = tuple(
            (name, text(float(np.nanmin(column)), unit), text(float(np.nanmax(column)), unit))
            for name, unit in _COLUMNS.items()
            if (column := getattr(self, name)) is not None and name != "segment"
        )
        if self.spring_constant is not None:
            rows += (("spring constant", text(self.spring_constant, "N/m"), ""),)
        return Table(f"Curve {self.name}, {self.depth.size} points", ("", "from", "to"), rows)

    @classmethod
    def from_piezo(cls, piezo: Any, force: Any, spring_constant: float, **rest: Any) -> Curve:
        """Curve of a cantilever: the tip's position is the piezo's minus the deflection force/k.

        Parameters
        ----------
        piezo : array, shape (n,)
            Position of the cantilever's base [m], growing towards the sample.
        force : array, shape (n,)
            [N].
        spring_constant : float
            k [N/m].
        **rest
            Further fields of `Curve`.
        """
        k = positive("spring_constant", spring_constant, unit="N/m")
        position, force = numbers("piezo", piezo, "m"), numbers("force", force, "N")
        # which of the two positions was measured decides what turning a sign means
        rest["meta"] = {**rest.get("meta", {}), "piezo": True}
        if position.shape != force.shape:
            raise CurveError(
                f"piezo has {position.size} values and force {force.size}: there must be one of each a point."
            )
        for name, column in (("piezo", position), ("force", force)):
            _check_finite(rest.get("name", "curve"), name, column)
            values(name, column, minimum=-np.inf, unit="m" if name == "piezo" else "N", smallest=0.0)
        depth = position - force / k
        return cls(depth, force, spring_constant=k, **rest)

    def taken(self, chosen: Any) -> Curve:
        """The curve at some of its points: a mask, a slice or indices."""
        more = {name: c[chosen] for name in _OPTIONAL if (c := getattr(self, name)) is not None}
        return replace(self, depth=self.depth[chosen], force=self.force[chosen], **more)

    @property
    def position(self) -> Array:
        """Position of the cantilever's base, depth + force/k [m]; the depth itself where there is no cantilever."""
        return self.depth if self.spring_constant is None else self.depth + self.force / self.spring_constant

    def turned(self, depth: float = 1.0, force: float = 1.0) -> Curve:
        """The curve with the sign conventions of depth and force turned.

        Parameters
        ----------
        depth, force : float
            1, or -1 to turn the sign; of a curve made by `from_piezo` it is the piezo's position that is turned.
        """
        if depth == force == 1:
            return self
        if self.spring_constant is None or not self.meta.get("piezo"):
            return replace(self, depth=depth * self.depth, force=force * self.force)
        turned = force * self.force
        return replace(self, depth=depth * self.position - turned / self.spring_constant, force=turned)


def _check_finite(curve: str, name: str, column: Array) -> None:
    """Refuse a column with gaps, and name their rows."""
    bad = np.flatnonzero(~np.isfinite(column))
    if bad.size:
        rows = ", ".join(map(str, bad[:5])) + (", ..." if bad.size > 5 else "")
        raise CurveError(
            f"{curve}: {bad.size} of {column.size} values of {name} are no finite numbers (rows {rows}, counted from 0). Drop "
            "these rows, or read the file with skip_nan=True."
        )


def check_curves(curves: Any) -> None:
    """Refuse what holds no curves."""
    try:
        if isinstance(curves, (str, bytes, Mapping)):
            raise TypeError
        iter(curves)
    except TypeError:
        raise TypeError(f"curves = {shown(curves)} must be a list of curves; for a single one write [curve].") from None


def read_lines(curve: Curve, points: int) -> tuple[str, ...]:
    """Where the numbers of a fitted curve come from: what the reader noted, and the segment."""
    lines = tuple(curve.meta.get("read", ()))
    if curve.segment is not None:
        first, last = curve.segment[0], curve.segment[-1]
        numbers = ", ".join(f"{v:g}" for v in (np.unique(curve.segment) if first != last else [first]))
        lines += (f"segment {numbers} of the file",)
    elif lines:
        lines += (f"segment found from the positions: {points} points",)
    return lines
