"""The unknowns of a fit: free parameters of a model by name, and all of them in one vector.

Outside, parameters are named and in SI. Inside, x = (theta, contact, and the coefficients of the background as far as they are
free) with theta the free parameters in their internal form. The background is what the force reads without contact, over the
position p of the cantilever's base (of the tip where there is no cantilever):

    B = baseline + tilt (p - p_1) + drag v,

with v the speed of p. contact is in units of the depth range from the first point, forces in units of the force range, so that
all of x are of order one; the baseline counts from the median of the measured force, so that no offset of it is large.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

import numpy as np
import xarray as xr

from flatpunch._support.checks import ROUNDING, Array, BadValue
from flatpunch._support.declared import Place
from flatpunch._support.prefixes import text
from flatpunch.fits.measured.curve import Curve
from flatpunch.fits.parameters.sample import BESIDE, Numbers, Sample, Scale, ends
from flatpunch.fits.parameters.settings import Free
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body

_NEAR = 4.0
"""Fits are taken for near each other where rounded internal parameters and ln of the depth, times this, are the same."""


FAR = 1e6
"""A free parameter without limits may leave its start by this factor."""


class ExactForce(NamedTuple):
    """Force without tables [N], the notes of the method, and its own relative error."""

    force: Array
    notes: str
    error: float

    @classmethod
    def of(cls, curve: xr.Dataset, notes: Iterable[str]) -> Self:
        """That of a contact; exact methods estimate no error."""
        error = float(curve["force_error"].max()) if "force_error" in curve else 0.0
        return cls(np.asarray(curve["force"].values), "\n".join(notes), error)


class FreeParameters(ABC):
    """What all forward models know of their free parameters.

    Attributes
    ----------
    free : tuple of str
        Their names, in the order of theta.
    adhesive : bool
        Whether the tip holds on below the surface; the model then has `pull_off`.
    over_time : bool
        Whether the force is fitted over time, with the memory of the sample.
    """

    free: tuple[str, ...]
    adhesive: ClassVar[bool] = False
    over_time: ClassVar[bool] = False

    @property
    def tabulated(self) -> bool:
        """Whether forces come from tables, so that an evaluation costs no solution of the contact."""
        return True

    if TYPE_CHECKING:  # properties here would be taken for defaults of fields

        @property
        def sample(self) -> Sample:
            """The case; free parameters have their starting values in it."""

        @property
        def knots(self) -> Mapping[str, tuple[float, float]]:
            """Internal values between which there are knots of a table, where these end."""

    @property
    def numbers(self) -> Numbers:
        """All numbers of the case by name, with their values in it."""
        return self.sample.numbers

    def case(self, values: Mapping[str, float]) -> tuple[Body, Indenter]:
        """Medium and indenter with these values."""
        sample = self.sample.replaced(values)
        return sample.medium, sample.indenter

    @abstractmethod
    def force(self, depth: Array, values: Mapping[str, float] | None = None) -> Array:
        """Force [N] at depths [m] by the tables."""

    @abstractmethod
    def exact(self, depth: Array, values: Mapping[str, float]) -> ExactForce:
        """Force at depths [m] without tables."""

    def off(self, exact: ExactForce, depth: Array, values: Mapping[str, float]) -> tuple[float, float]:
        """Largest difference of the table over the force at the last of depths, and what may be left of it."""
        difference = float(np.abs(self.force(depth, values) - exact.force).max())
        # interpolation leaves less than 1e-6
        return difference / float(exact.force[-1]), max(1e-5, exact.error)

    def off_once(self, deepest: float, values: Mapping[str, float]) -> tuple[float, float]:
        """The same at one depth, solved once for fits that are near each other."""
        place = np.append(self.internals(values), np.log(deepest))
        key = tuple(np.rint(_NEAR * place).tolist())
        if key not in self._offs:
            depth = np.array([deepest])
            self._offs[key] = self.off(self.exact(depth, values), depth, values)
        return self._offs[key]

    @cached_property
    def _offs(self) -> dict[tuple[float, ...], tuple[float, float]]:
        return {}

    @cached_property
    def scales(self) -> dict[str, Scale]:
        """How the free parameters follow from their internal values."""
        return {name: Scale.of(self.numbers[name]) for name in self.free}

    @property
    def moduli(self) -> list[int]:
        """Places of the moduli among the free parameters, with which the force grows."""
        return [j for j, name in enumerate(self.free) if self.numbers[name].number.unit == "Pa"]

    def ends(self, name: str) -> tuple[float, float]:
        """Internal values between which a free parameter has a meaning."""
        (low, high), (first, last) = ends(self.numbers[name]), self.knots.get(name, (-np.inf, np.inf))
        return max(low, first), min(high, last)

    def bounds(self, free: Mapping[str, Free]) -> tuple[Array, Array]:
        """Limits of the free parameters, internal."""
        pairs = [_between(self.numbers[n], self.numbers[n].value, free[n], self.ends(n)) for n in self.free]
        return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])

    def start(self) -> Array:
        """Internal values of the free parameters in the case."""
        return np.array([scale.internal(self.numbers[name].value) for name, scale in self.scales.items()])

    def internals(self, values: Mapping[str, float] | None = None) -> Array:
        """Internal values of the free parameters by name, SI; missing ones as in the case."""
        theta = self.start()
        for name, value in (values or {}).items():
            theta[self.free.index(name)] = self.scales[name].internal(value)
        return theta

    def externals(self, theta: Array) -> dict[str, float]:
        """Free parameters by name, SI."""
        return {name: float(scale.external(t)) for (name, scale), t in zip(self.scales.items(), theta, strict=True)}

    def linear(self, weights: Mapping[str, float]) -> tuple[float, Array]:
        """Constant part of a linear form, from the fixed parameters, and its coefficients of the free ones."""
        known = {name: self.numbers[name] for name in weights if name not in self.free}
        fixed = sum(weights[name] * Scale.of(each).internal(each.value) for name, each in known.items())
        return fixed, np.array([weights.get(name, 0.0) for name in self.free])


def check_free(sample: Sample, free: Mapping[str, Free]) -> None:
    """Refuse limits that a start does not lie between, without making a model."""
    sample.check(free)
    for name, what in free.items():
        number = sample.numbers[name]
        _between(number, number.value if what.start is None else what.start, what, ends(number))


def _between(number: Place, start: float, limits: Free, ends: tuple[float, float]) -> tuple[float, float]:
    scale, name = Scale.of(number), number.path
    begin, far = scale.internal(start), np.log(FAR)
    low, high = (end if np.isfinite(end) else begin + way for end, way in zip(ends, (-far, far), strict=True))
    if limits.minimum is not None:
        low = max(_limit(number, "minimum", limits.minimum), ends[0])
    if limits.maximum is not None:
        high = min(_limit(number, "maximum", limits.maximum), ends[1])
    # the start has been there and back
    slack = ROUNDING * max(1.0, abs(begin))
    if not low - slack <= begin <= high + slack or low == high:
        words = [
            text(v, number.number.unit or "") if v is not None else "none"
            for v in (start, limits.minimum, limits.maximum)
        ]
        raise BadValue(name, "", f": the start {words[0]} must lie between minimum {words[1]} and maximum {words[2]}.")
    return low, high


def _limit(number: Place, which: str, value: float) -> float:
    scale, words = Scale.of(number), f": {which} {text(value, number.number.unit or '')}"
    if scale.form != "plain" and value <= 0:
        raise BadValue(number.path, "", f"{words} must be > 0.")
    if scale.form == "slope" and value > np.pi / 2:
        raise BadValue(number.path, "", f"{words} must not exceed pi/2.")
    return scale.internal(value)


class Frame(NamedTuple):
    """Units of x: first depth and depth range [m], force range and median [N], first position and range [m], speed [m/s]."""

    origin: float
    width: float
    span: float
    level: float
    first: float
    way: float
    speed: float = 1.0


def frame_of(depth: Array, force: Array, position: Array | None = None, speed: Array | None = None) -> Frame:
    """Units of x for a curve."""
    way = depth if position is None else position
    fastest = float(np.abs(speed).max()) if speed is not None and speed.size else 1.0
    return Frame(
        float(depth.min()),
        float(np.ptp(depth)),
        float(np.ptp(force)),
        float(np.median(force)),
        float(way.min()),
        float(np.ptp(way)),
        fastest or 1.0,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class Unknowns(ABC):
    """A least-squares problem of one curve, and what x stands for in it.

    Parameters
    ----------
    model : object
        Forward model; its `free` names the entries of theta.
    nuisance : tuple of str
        Which of `NUISANCE` are free, in the order of x.
    held : dict of str to float
        The others, SI.
    frame : Frame
        Units.
    depth, force : ndarray, shape (n,)
        Readings [m, N].
    weight : ndarray, shape (n,), optional
        Factors of the residuals.
    spring : float, optional
        Stiffness of the cantilever [N/m].
    speed : ndarray, shape (n,), optional
        Speed of the cantilever's base [m/s].
    counts : ndarray, shape (n,), optional
        Readings behind each entry, where entries are means.
    turned : float
        -1 where the depth of the file has the other sign.
    """

    model: Any
    nuisance: tuple[str, ...]
    held: dict[str, float]
    frame: Frame
    depth: Array
    force: Array
    weight: Array | None = None
    spring: float | None = None
    speed: Array | None = None
    counts: Array | None = None
    turned: float = 1.0
    position: Array = field(init=False, repr=False)
    """Of the cantilever's base, of the tip where there is no cantilever [m]."""
    _units: dict[str, tuple[float, float]] = field(init=False, repr=False)
    _before: dict[int | str, Array] = field(default_factory=dict, repr=False)  # where the next evaluation starts

    @abstractmethod
    def evaluate(self, x: Array) -> tuple[Array, Array]:
        """Residuals, shape (n,), and derivatives, shape (parameters, n), both over the force range."""

    @abstractmethod
    def residuals(self, x: Array) -> Array:
        """Residuals over the force range, shape (n,)."""

    @abstractmethod
    def over(self, curve: Curve, x: Array) -> Array:
        """Fitted force at all points of the curve that is shown [N]."""

    @abstractmethod
    def indentation(self, curve: Curve, x: Array) -> Array:
        """Indentation depth at all points of the curve that is shown [m]."""

    def __post_init__(self) -> None:
        f = self.frame
        scales = {
            "contact": (f.origin, f.width),
            "baseline": (f.level, f.span),
            "tilt": (0.0, f.span / f.way),
            "drag": (0.0, f.span / f.speed),
        }
        object.__setattr__(self, "_units", scales)
        object.__setattr__(self, "position", self.depth)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all entries of x."""
        return (*self.model.free, *self.nuisance)

    @property
    def zero(self) -> Array:
        """x at the starting values of the model, contact and background in the middle of their units."""
        return np.append(self.model.start(), np.zeros(len(self.nuisance)))

    @property
    def units(self) -> dict[str, tuple[float, float]]:
        """Offset and unit of contact and of the coefficients of the background in x, SI."""
        return self._units

    @property
    def numbers(self) -> dict[str, Place]:
        """Records of all entries of x, by name."""
        known = {**self.model.numbers, **BESIDE}
        return {name: known[name] for name in self.names}

    def scales(self) -> dict[str, Scale]:
        """How all of x reads in reports: the contact point has the sign of the file."""
        offset, unit = self._units["contact"]
        units = {**self._units, "contact": (self.turned * offset, self.turned * unit)}
        return {**self.model.scales, **{name: Scale("plain", *units[name]) for name in self.nuisance}}

    def split(self, x: Array) -> tuple[Array, dict[str, float]]:
        """Free parameters (internal) and all of contact and background in SI."""
        count = len(self.model.free)
        values = dict(self.held)
        for name, value in zip(self.nuisance, x[count:], strict=True):
            offset, unit = self._units[name]
            values[name] = offset + unit * float(value)
        return x[:count], values

    def background(self, rest: Mapping[str, Any], position: Array, speed: Array | None) -> Array:
        """Background without its baseline [N]; for several vectors at once the coefficients are columns, shape (vectors, 1)."""
        result = np.zeros_like(position)
        if np.any(rest.get("tilt", 0.0)):
            result = result + rest["tilt"] * (position - self.frame.first)
        if speed is not None and np.any(rest.get("drag", 0.0)):
            result = result + rest["drag"] * speed
        return result

    def column(self, name: str) -> Array:
        """Derivative of the background over an entry of x, over the force range."""
        if name == "baseline":
            return np.ones_like(self.position)
        if name == "tilt":
            return (self.position - self.frame.first) / self.frame.way
        return np.zeros_like(self.position) if self.speed is None else self.speed / self.frame.speed
