"""What is fitted and how: free parameters with their limits, and the settings of a fit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypedDict, get_args

from flatpunch._support.checks import BadValue, one_of, real, shown, switch
from flatpunch._support.readable import readable
from flatpunch.contact import Method, MethodName, method_of
from flatpunch.contact.physics import Physics, PhysicsOf
from flatpunch.fits.measured.orientation import Direction
from flatpunch.fits.parameters.sample import NUISANCE

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]
Baseline = Literal["auto", "constant", "linear", "none"]
Adhesion = Literal["refuse", "above", "ignore"]
"""What to do about a dip of the force below its background: refuse the curve, leave the dip out, or fit it."""
Segment = Literal["auto", "approach", "retract", "both"]
FitMethod = Literal["auto"] | MethodName | Method
"""A contact method, its short name, or the choice of one."""

Contact = Literal["free"] | float | tuple[float | None, float | None]
"""Contact point: fitted, known [m], or its limits."""


class SettingsOf(TypedDict, total=False):
    """Fields of `Settings` as keyword arguments."""

    contact: Contact
    baseline: Baseline
    loss: Loss
    adhesion: Adhesion
    depth_to: float | None
    force_to: float | None
    method: FitMethod
    level: float
    quick: bool
    segment: Segment
    direction: Direction
    drag: Literal["free"] | float


class Options(PhysicsOf, SettingsOf, total=False):
    """Arguments of `fit` for what acts beside elasticity, and how the curve is fitted."""


@readable
@dataclass(frozen=True, slots=True)
class Free:
    """A parameter to be fitted.

    Parameters
    ----------
    start : float, optional
        Starting value, SI; the case's own value if left out.
    minimum, maximum : float, optional
        Limits, SI.

    See Also
    --------
    fit : Takes one for each free parameter.
    fits.parameter_names : What can be free.

    Examples
    --------
    >>> fp.Free(start=5e3, minimum=1e2, maximum=1e5)
    Free(start=5000, minimum=100, maximum=100000)
    """

    start: float | None = None
    minimum: float | None = None
    maximum: float | None = None

    def __post_init__(self) -> None:
        for name in ("start", "minimum", "maximum"):
            given = getattr(self, name)
            # limits may be infinite, which is none
            none = given is None or (name != "start" and isinstance(given, float) and math.isinf(given))
            object.__setattr__(self, name, None if none else real(f"Free.{name}", given))


FreeNames = Iterable[str] | Mapping[str, Free | float | tuple[float | None, float | None] | None]
"""What is fitted: names of parameters, or with each a `Free`, its starting value or its limits."""


@readable
@dataclass(frozen=True, slots=True)
class Settings:
    """How a curve is fitted.

    Parameters
    ----------
    contact : "free", float, (minimum, maximum) or {"min": ..., "max": ...}
        Contact point: fitted, given [m] on the curve's own depth axis, or fitted between limits.
    baseline : "auto", "constant", "linear" or "none"
        Force without contact. By itself a constant or, where the readings before the contact show it, a tilt, and a random
        process (drift, waves of interference) of the size that these readings show, which widens the intervals; else a
        constant, a straight line, or zero, as the user says.
    drag : "free" or float
        Hydrodynamic drag of the cantilever [N s/m]: force per speed of its base, fitted or given. Needs times, and to
        be fitted another speed than one: of the approach, or of a retraction that ends without contact.
    loss : "linear", "soft_l1", "huber" or "cauchy"
        Least squares, or a loss that outliers disturb less.
    adhesion : "refuse", "above" or "ignore"
        What to do about a dip below the baseline, see `flatpunch.fits.measured.signal.adhesion_dip`.
    depth_to, force_to : float, optional
        Use the curve up to this tip position [m] or force [N] only.
    method : str or method
        Contact method, its short name or its configuration, or "auto".
    level : float
        Confidence level of intervals.
    segment : "auto", "approach", "retract" or "both"
        Which part of a cycle is fitted. By itself the approach; with adhesion the retract; with relaxation all of it.
    direction : "auto", "growing" or "falling"
        How the depth changes on the approach; by itself the long way decides.
    quick : bool
        For batches, several times faster: the minimum of means over a few readings each is taken for that of all, and the
        limits of the theory are not examined. Values change by less than a hundredth of their standard errors.

    See Also
    --------
    flatpunch.fit : Takes them as keywords.
    flatpunch.fits.read_fit_case : From a case file.

    Examples
    --------
    >>> from flatpunch.fits import Settings
    >>> print(Settings(baseline="linear", depth_to=400e-9).baseline)
    linear
    """

    contact: Contact = "free"
    baseline: Baseline = "auto"
    loss: Loss = "linear"
    adhesion: Adhesion = "refuse"
    depth_to: float | None = None
    force_to: float | None = None
    method: FitMethod = "auto"
    level: float = 0.95
    quick: bool = False
    segment: Segment = "auto"
    direction: Direction = "auto"
    drag: Literal["free"] | float = 0.0

    def __post_init__(self) -> None:
        choices = {"baseline": Baseline, "loss": Loss, "adhesion": Adhesion, "direction": Direction, "segment": Segment}
        for name, known in choices.items():
            one_of(name, getattr(self, name), get_args(known))
        if not isinstance(self.method, str) or self.method != "auto":
            method_of(self.method)
        object.__setattr__(self, "contact", _contact(self.contact))
        if not isinstance(self.drag, str) or self.drag != "free":
            real("drag", self.drag, "N*s/m")
        for name, unit in (("depth_to", "m"), ("force_to", "N")):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, real(name, getattr(self, name), unit))
        object.__setattr__(self, "quick", switch("quick", self.quick))
        if not 0 < real("level", self.level, "1") < 1:
            raise BadValue("level", repr(self.level), "must lie between 0 and 1, such as 0.95.")

    @property
    def nuisance(self) -> tuple[str, ...]:
        """Which of the contact point and the coefficients of the background are fitted."""
        wanted = {
            "contact": isinstance(self.contact, (str, tuple)),
            "baseline": self.baseline != "none",
            "tilt": self.baseline == "linear",
            "drag": self.drag == "free",
        }
        return tuple(name for name in NUISANCE if wanted[name])

    @property
    def held(self) -> dict[str, float]:
        """Contact point and coefficients of the background where they are not fitted, SI."""
        contact = self.contact if isinstance(self.contact, float) else 0.0
        drag = 0.0 if self.drag == "free" else float(self.drag)
        return dict.fromkeys(NUISANCE, 0.0) | {"contact": contact, "drag": drag}

    def contact_limits(self, turned: float) -> tuple[float | None, float | None]:
        """Limits of the contact point that the user set [m], on an axis whose sign is `turned`."""
        low, high = self.contact if isinstance(self.contact, tuple) else (None, None)
        return (low, high) if turned > 0 else (None if high is None else -high, None if low is None else -low)


def _contact(given: object) -> Contact:
    """Contact point as given: a word, a float, or a pair of limits."""
    if isinstance(given, str) and given == "free":
        return "free"
    if isinstance(given, Mapping):
        unknown = set(given) - {"min", "max"}
        if unknown:
            raise ValueError(
                f"contact.{min(unknown)} is no known field; limits are written {{ min = ..., max = ... }}."
            )
        given = (given.get("min"), given.get("max"))
    if isinstance(given, (tuple, list)):
        if len(given) != 2:
            raise BadValue("contact", shown(given), "must be 'free', a position, or a pair of limits.")
        low, high = (None if v is None else real("contact", v, "m") for v in given)
        if low is not None and high is not None and not low < high:
            raise ValueError(f"contact: the minimum {low!r} must be below the maximum {high!r}.")
        return (low, high)
    return real("contact", given, "m")


def as_free(free: object) -> dict[str, Free]:
    """What the user calls free, as one `Free` for each name."""
    if isinstance(free, str):
        raise TypeError(
            f"free = {shown(free)} must be a list of names or a mapping from names to limits; write [{shown(free)}]."
        )
    if not isinstance(free, Mapping):
        if not isinstance(free, (list, tuple, set, frozenset)) or not all(isinstance(name, str) for name in free):
            raise TypeError(f"free = {shown(free)} must be a list of names or a mapping from names to limits.")
        return {name: Free() for name in free}
    found = {}
    for name, what in free.items():
        if isinstance(what, Free):
            found[name] = what
        elif what is None:
            found[name] = Free()
        elif isinstance(what, (tuple, list)) and len(what) == 2:
            found[name] = Free(None, *what)
        else:
            found[name] = Free(real(f"free[{name!r}]", what))
    return found


def options_of(given: Options) -> tuple[Physics, Settings]:
    """What acts beside elasticity, and how the curve is fitted."""
    acts: dict[str, Any] = {name: value for name, value in given.items() if name in PhysicsOf.__annotations__}
    how: dict[str, Any] = {name: value for name, value in given.items() if name not in acts}
    return Physics(**acts), Settings(**how)


def segments(adhesive: bool, over_time: bool) -> tuple[str, ...]:
    """Parts of a cycle that can be fitted, the one that "auto" means first."""
    return ("retract", "both") if adhesive else ("both",) if over_time else ("approach",)


def check_segment(segment: str, known: Sequence[str]) -> None:
    """Refuse a part of a cycle that the physics has no use for."""
    if segment not in ("auto", *known):
        words = " or ".join(map(repr, ("auto", *known)))
        raise BadValue(
            "segment",
            repr(segment),
            f"does not go with this case; it is {words}. Retracts are fitted with work_of_adhesion, cycles with relaxation.",
        )
