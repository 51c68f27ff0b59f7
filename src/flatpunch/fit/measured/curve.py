"""A measured curve: checked, and cut to the approach.

`depth` is the position of the tip, growing into the sample, from any zero: where the contact begins is fitted. A curve that
cannot be evaluated is refused with the reason; nothing is repaired silently.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from flatpunch._support.checks import Array, Flags, numbers, positive, values

Adhesion = Literal["refuse", "above", "ignore"]

_COLUMNS = {"depth": "m", "force": "N", "stiffness": "N/m", "time": "s"}
FEWEST = 12
_FAR = 0.2
"""Share of the points, at the start, that is taken for free of contact where noise is judged."""
_DIP = (6.0, 0.03)
"""A dip below the baseline counts as adhesion from six times the noise and 3 % of the force range on."""
_PLATEAU = (8, 0.01)
"""So many equal readings at the maximum, and this share of the points, make a saturated detector."""


class CurveError(ValueError):
    """A curve that cannot be evaluated; the message says why and what to do."""


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
    name : str
        For tables and messages.
    meta : dict
        What else the file says.

    Raises
    ------
    CurveError
        If lengths differ, points are too few, or entries are no finite numbers.
    """

    depth: Array
    force: Array
    spring_constant: float | None = None
    stiffness: Array | None = None
    name: str = "curve"
    meta: dict[str, Any] = field(default_factory=dict, repr=False)
    time: Array | None = None

    def __post_init__(self) -> None:
        columns = {"depth": self.depth, "force": self.force}
        for name in ("stiffness", "time"):
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
            bad = np.flatnonzero(~np.isfinite(array))
            if bad.size and name != "stiffness":
                rows = ", ".join(map(str, bad[:5])) + (", ..." if bad.size > 5 else "")
                raise CurveError(
                    f"{self.name}: {bad.size} of {array.size} values of {name} are no finite numbers (rows {rows}, counted "
                    "from 0). Drop these rows, or read the file with skip_nan=True."
                )
        if self.spring_constant is not None:
            k = positive("Curve.spring_constant", self.spring_constant, unit="N/m")
            object.__setattr__(self, "spring_constant", k)
        if self.depth.size < FEWEST:
            raise CurveError(f"{self.name}: {self.depth.size} points; a fit needs {FEWEST} or more.")

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
        force = values("force", force, minimum=-np.inf, unit="N", smallest=0.0)
        return cls(
            values("piezo", piezo, minimum=-np.inf, unit="m", smallest=0.0) - force / k,
            force,
            spring_constant=k,
            **rest,
        )

    def taken(self, chosen: Any) -> Curve:
        """The curve at some of its points: a mask, a slice or indices."""
        more = {name: c[chosen] for name in ("stiffness", "time") if (c := getattr(self, name)) is not None}
        return replace(self, depth=self.depth[chosen], force=self.force[chosen], **more)

    @property
    def noise(self) -> float:
        """Standard deviation of the force noise [N], from differences of neighbours in the first fifth of the curve."""
        far = self.force[: max(int(_FAR * self.force.size), FEWEST)]
        # 1.4826 MAD is the standard deviation of normal noise; a difference has twice the variance
        return float(1.4826 * np.median(np.abs(np.diff(far))) / np.sqrt(2))


def approach(curve: Curve) -> Curve:
    """Cut a curve to its approach: everything up to the largest force, if the force falls after it.

    The largest force is looked for in a moving average: the largest single reading is one with positive noise, and to end
    there would bias the fit.

    Raises
    ------
    CurveError
        If there is no approach, or the depth has the wrong sign.
    """
    n, span = curve.force.size, float(np.ptp(curve.force))
    if span == 0:
        raise CurveError(f"{curve.name}: the force is {curve.force[0]:.4g} N at every point; is this the right column?")
    if np.ptp(curve.depth) == 0:
        raise CurveError(f"{curve.name}: the depth is {curve.depth[0]:.4g} m at every point; is this the right column?")
    window = max(n // 100, 1)
    smooth = np.convolve(curve.force, np.full(window, 1 / window), "valid")
    top = int(np.argmax(smooth))
    falls = smooth[top] - smooth[top:].min() > 0.1 * span
    if not falls:
        part = curve
    elif top + window < max(0.02 * n, FEWEST):
        raise CurveError(
            f"{curve.name}: the force only falls (largest at point {top} of {n}): this is a retract. Give the approach, or the "
            "whole cycle."
        )
    else:
        part = curve.taken(slice(0, top + (window + 1) // 2))
    _check_direction(part)
    return part


def _check_direction(curve: Curve) -> None:
    """Over the upper half of the force, where noise does not decide, depth must grow with force."""
    upper = curve.force > curve.force.max() - 0.5 * float(np.ptp(curve.force))
    depth, force = curve.depth[upper], curve.force[upper]
    if (depth - depth.mean()) @ (force - force.mean()) < 0 and depth.size > 2:
        raise CurveError(
            f"{curve.name}: the force grows while the depth falls. depth must grow into the sample: change its sign, or, if it "
            "is a piezo height, read it as 'piezo' with the spring constant."
        )


def check_saturation(curve: Curve) -> None:
    """Refuse curves in which many points read the same largest force.

    Raises
    ------
    CurveError
        If the detector is saturated.
    """
    force = curve.force
    held = int(np.sum(force >= force.max() - 1e-9 * float(np.ptp(force))))
    if held >= max(_PLATEAU[0], _PLATEAU[1] * force.size):
        raise CurveError(
            f"{curve.name}: {held} points read the same largest force {force.max():.4g} N: the detector is saturated. Cut the "
            "curve below it (force_to=...), or measure again with a smaller setpoint."
        )


def check_signal(curve: Curve, adhesion: Adhesion) -> tuple[Flags, tuple[str, ...]]:
    """Judge an approach: which points can be used, and notes.

    Parameters
    ----------
    curve : Curve
        An approach.
    adhesion : {"refuse", "above", "ignore"}
        What to do about a dip below the baseline: refuse the curve, leave out the dip up to where the force is back at the
        baseline, or fit it as it is.

    Raises
    ------
    CurveError
        If the detector is saturated, the force does not rise above its noise, or it dips (adhesion).
    """
    force, n = curve.force, curve.force.size
    noise = curve.noise
    check_saturation(curve)
    far = force[: max(int(_FAR * n), FEWEST)]
    baseline = float(np.median(far))
    if force.max() - baseline < 6 * noise:
        raise CurveError(
            f"{curve.name}: the force rises {force.max() - baseline:.3g} N above its baseline, the noise is {noise:.3g} N. "
            "Nothing can be fitted; press deeper or average."
        )
    keep = np.ones(n, dtype=bool)
    lowest = int(np.argmin(force))
    dip = baseline - float(force[lowest])
    limit = max(_DIP[0] * noise, _DIP[1] * (force.max() - baseline))
    if dip <= limit or lowest <= 0.02 * n or adhesion == "ignore":
        return keep, ()
    if adhesion == "refuse":
        raise CurveError(
            f"{curve.name}: the force dips {dip:.3g} N below the baseline before it rises, "
            f"{dip / (force.max() - baseline):.1%} of the largest force and {dip / max(noise, 1e-300):.0f} times the noise: the "
            "tip is pulled in. A model without adhesion would put the contact point wrong. Use adhesion='above' to fit the part "
            "above the baseline only (the modulus is then still biased by the adhesive force), or measure in a liquid that "
            "screens it. If the curve has a retract, work_of_adhesion fits the adhesion with the rest."
        )
    back = lowest + int(np.argmax(force[lowest:] >= baseline))
    start = lowest
    while start > 0 and force[start] < baseline - 3 * noise:
        start -= 1
    keep[start:back] = False
    note = (
        f"Adhesion: {dip:.3g} N below the baseline; {back - start} points of the dip are left out. The modulus is biased by the "
        "adhesive force that remains."
    )
    return keep, (note,)
