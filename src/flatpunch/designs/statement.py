"""What a design is for, and what it varies: prescribed quantities, limits, the largest load; numbers as a vector between bounds.

Numbers with a unit are varied by their logarithm. A name without its last index stands for all of a list: "layers[0].young" for
the nodes of a tabulated grading. "indenter.slopes" stands for the heights of a RadialProfile by the slopes between them, which
are > 0: so the profile ascends.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from flatpunch._support.checks import (
    Array,
    BadValue,
    Flags,
    Values,
    follows,
    instance,
    non_negative,
    one_of,
    positive,
    shown,
    values,
)
from flatpunch._support.readable import readable
from flatpunch.contact.curve import Control
from flatpunch.indenters import RadialProfile
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.media.paths import with_values
from flatpunch.sensitivities.parameters import Parameter, parameters
from flatpunch.stresses.failure.strength import Strength

Quantity = Literal["force", "depth", "stiffness", "radius"]
UNITS = {"force": "N", "depth": "m", "stiffness": "N/m", "radius": "m"}
"""SI units of the quantities."""


@readable
@dataclass(frozen=True, eq=False)
class Target:
    """A quantity of the contact that is prescribed, at one depth or force or along a curve.

    Parameters
    ----------
    quantity : {"force", "depth", "stiffness", "radius"}
        What is prescribed.
    value : float or array, shape (n,)
        Its values [N], [m], [N/m], [m], > 0.
    depth, force : float or array, shape (n,)
        Exactly one: the depths [m] or forces [N] at which it is prescribed, > 0.

    Raises
    ------
    ValueError, TypeError
        On bad input.

    See Also
    --------
    Limit : What must be kept.
    LargestLoad : The largest force instead.
    design : Takes it.

    Examples
    --------
    >>> import flatpunch as fp
    >>> fp.Target("stiffness", 2e4, force=1e-3).control.name
    'force'
    """

    quantity: Quantity
    value: Any
    depth: Values | None = None
    force: Values | None = None
    control: Control = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "control", _control("Target", self.quantity, self.depth, self.force))
        wanted = values("Target.value", self.value, strict=True, unit=UNITS[self.quantity])
        if wanted.size != self.control.values.size:
            raise BadValue(
                "Target.value",
                "",
                f"has {wanted.size} values and {self.control.name} has {self.control.values.size}; they go "
                "together one by one.",
            )
        object.__setattr__(self, "value", wanted)


@readable
@dataclass(frozen=True, eq=False)
class Limit:
    """A bound on a quantity of the contact that a design must keep.

    Parameters
    ----------
    quantity : {"force", "depth", "stiffness", "radius"}
        What is bounded.
    minimum, maximum : float, optional
        Its bounds [N], [m], [N/m], [m], > 0; at least one.
    depth, force : float
        Exactly one: the depth [m] or force [N] at which it is bounded, > 0.

    Raises
    ------
    ValueError, TypeError
        On bad input.

    See Also
    --------
    Target : What is wanted.
    design : Takes it.

    Examples
    --------
    >>> limit = fp.Limit("radius", maximum=2e-6, force=1e-3)
    >>> print(limit.quantity, limit.maximum)
    radius 2e-06
    """

    quantity: Quantity
    minimum: float | None = None
    maximum: float | None = None
    depth: Values | None = None
    force: Values | None = None
    control: Control = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "control", _control("Limit", self.quantity, self.depth, self.force))
        if self.control.values.size != 1:
            raise BadValue(
                f"Limit.{self.control.name}", "", f"has {self.control.values.size} values; a limit is at one of them."
            )
        if self.minimum is None and self.maximum is None:
            raise ValueError("Limit has neither minimum nor maximum, so it bounds nothing. Give at least one of them.")
        for name in ("minimum", "maximum"):
            given = getattr(self, name)
            if given is not None:
                object.__setattr__(self, name, positive(f"Limit.{name}", given, unit=UNITS[self.quantity]))
        if self.minimum is not None and self.maximum is not None and self.minimum >= self.maximum:
            raise BadValue("Limit.minimum", f"{self.minimum:g}", f"must be below Limit.maximum = {self.maximum:g}.")

    @property
    def text(self) -> str:
        """The limit in words."""
        bounds = [
            f"{sign} {value:.6g} {UNITS[self.quantity]}"
            for sign, value in ((">=", self.minimum), ("<=", self.maximum))
            if value is not None
        ]
        place = f"{self.control.name} = {self.control.values[0]:.6g} {UNITS[self.control.name]}"
        return f"{self.quantity} {' and '.join(bounds)} at {place}"


@readable
@dataclass(frozen=True, eq=False)
class LargestLoad:
    """The largest force before the first layer or interface fails, as of `critical_load`.

    Parameters
    ----------
    strengths : Strength or sequence of Strength or None
        For each layer from the surface down, then the base.
    friction : float
        Coefficient of friction of a contact that slides along x.
    residual_stress : sequence of float, optional
        Biaxial stress of each layer (and the base) [Pa].

    See Also
    --------
    Target : Prescribed values instead.
    critical_load : The load of one case.
    Strength : What a layer bears.

    Examples
    --------
    >>> wanted = fp.LargestLoad([fp.Strength(yield_stress=5e9), fp.Strength(yield_stress=1e9)], friction=0.1)
    >>> print(wanted.friction)
    0.1
    """

    strengths: Strength | Sequence[Strength | None]
    friction: float = 0.0
    residual_stress: Sequence[float] | None = None

    def __post_init__(self) -> None:
        kinds = (Strength, type(None))
        for each in self.strengths if isinstance(self.strengths, Sequence) else [self.strengths]:
            instance("LargestLoad.strengths", each, kinds, "a Strength, or a list of them (None: bears all)")
        object.__setattr__(self, "friction", non_negative("LargestLoad.friction", self.friction, unit="1"))


def _control(owner: str, quantity: Quantity, depth: Values | None, force: Values | None) -> Control:
    one_of(f"{owner}.quantity", quantity, get_args(Quantity), wrong="is no quantity of a contact")
    if (depth is None) == (force is None):
        raise ValueError(f"{owner} takes exactly one of depth and force, at which {quantity} is meant.")
    name: Literal["depth", "force"] = "force" if depth is None else "depth"
    if name == quantity:
        raise ValueError(f"{owner} prescribes {quantity} at given {name}: give the other of depth and force.")
    return Control(name, values(f"{owner}.{name}", depth if force is None else force, strict=True, unit=UNITS[name]))


_SLOPES = "indenter.slopes"


@dataclass(frozen=True, eq=False)
class Variables:
    """The vector u of a design.

    Attributes
    ----------
    start, low, high : ndarray, shape (n,)
        Values in the case and bounds [SI].
    radii : ndarray or None
        Radii of a RadialProfile whose slopes are the last entries.
    listed : ndarray of bool, shape (n,)
        Whether an entry came with a whole list, some of which a contact may not reach.
    """

    medium: Body
    indenter: Indenter
    names: tuple[str, ...]
    units: tuple[str, ...]
    start: Array
    low: Array
    high: Array
    logarithmic: Flags
    wanted: tuple[Parameter, ...]
    radii: Array | None
    listed: Flags

    def internal(self, value: Array) -> Array:
        """u of values, the logarithm of those that are varied by it."""
        return np.where(self.logarithmic, np.log(np.where(self.logarithmic, value, 1.0)), value)

    @cached_property
    def ranges(self) -> Array:
        """Bounds of u, shape (2, n)."""
        return np.stack([self.internal(self.low), self.internal(self.high)])

    def external(self, u: Array) -> Array:
        """Values of u, never beyond the bounds by rounding."""
        return np.clip(np.where(self.logarithmic, np.exp(np.where(self.logarithmic, u, 0.0)), u), self.low, self.high)

    def case(self, u: Array) -> tuple[Body, Indenter]:
        """Medium and tip at u."""
        value = self.external(u)
        if self.radii is None:
            return with_values(self.medium, self.indenter, dict(zip(self.names, value.tolist(), strict=True)))
        plain = value.size - (self.radii.size - 1)
        changes = dict(zip(self.names[:plain], value[:plain].tolist(), strict=True))
        heights = np.cumsum(value[plain:] * np.diff(self.radii))
        changes |= {f"indenter.f[{j}]": float(height) for j, height in enumerate(heights, 1)}
        return with_values(self.medium, self.indenter, changes)

    def by_u(self, derivatives: Array, u: Array) -> Array:
        """Derivatives by u of those by the wanted parameters, shape (..., parameters) -> (..., n)."""
        value = self.external(u)
        scale = np.where(self.logarithmic, value, 1.0)
        if self.radii is None:
            return np.asarray(derivatives * scale)
        plain = value.size - (self.radii.size - 1)
        # a slope lifts all heights beyond it
        tail = np.cumsum(derivatives[..., plain:][..., ::-1], axis=-1)[..., ::-1] * np.diff(self.radii)
        return np.asarray(np.concatenate([derivatives[..., :plain], tail], axis=-1) * scale)

    def renewed(self, medium: Body, indenter: Indenter) -> list[Parameter]:
        """The wanted parameters with the values and laws of a new case."""
        known = {each.path: each for each in parameters(medium, indenter)}
        return [known[each.path] for each in self.wanted]


class _Varied(NamedTuple):
    """One number that is varied: its bounds, the parameter whose derivative is taken, and whether a list named it."""

    name: str
    unit: str
    start: float
    low: float
    high: float
    parameter: Parameter
    listed: bool

    @property
    def logarithmic(self) -> bool:
        return bool(self.unit) or self.name.startswith(_SLOPES)


def variables(medium: Body, indenter: Indenter, vary: Mapping[str, tuple[float, float]]) -> Variables:
    """Read what is varied; an error for names that are not there, and bounds that are none or do not hold the present value."""
    if not follows(vary, Mapping) or not vary:
        raise TypeError(
            f"vary = {shown(vary)} must name the numbers to vary with their bounds, e.g. {{'layers[0].thickness': (1e-7, 1e-5)}}."
        )
    known = {each.path: each for each in parameters(medium, indenter)}
    rows: list[_Varied] = []
    radii: Array | None = None
    slopes: list[_Varied] = []
    for name, bounds in vary.items():
        pair = _bounds(name, bounds)
        if name == _SLOPES:
            radii, slopes = _slopes(indenter, known, pair)
            continue
        chosen = _chosen(name, known)
        rows += [_Varied(each.path, each.unit, each.value, *pair, each, name not in known) for each in chosen]
    if len({each.name for each in rows}) < len(rows):
        raise ValueError("vary names a number twice: a list by its name, and one of its entries.")
    rows += slopes
    for each in rows:
        _check(medium, indenter, each)
    start, low, high = np.array([(each.start, each.low, each.high) for each in rows], dtype=float).T
    return Variables(
        medium,
        indenter,
        tuple(each.name for each in rows),
        tuple(each.unit for each in rows),
        start,
        low,
        high,
        np.array([each.logarithmic for each in rows]),
        tuple(each.parameter for each in rows),
        radii,
        np.array([each.listed for each in rows]),
    )


def _slopes(
    indenter: Indenter, known: Mapping[str, Parameter], pair: tuple[float, float]
) -> tuple[Array, list[_Varied]]:
    """Radii of a profile, and the slopes between them, of each of which the derivative by the height at its end is taken."""
    if not isinstance(indenter, RadialProfile):
        raise ValueError(f"vary: {shown(_SLOPES)} goes with a RadialProfile, whose heights it varies.")
    radii = np.asarray(indenter.r, dtype=float)
    present = np.diff(np.asarray(indenter.f, dtype=float)) / np.diff(radii)
    return radii, [
        _Varied(f"{_SLOPES}[{j}]", "", slope, *pair, _height(known, indenter, j + 1), True)
        for j, slope in enumerate(present.tolist())
    ]


def unit_of(medium: Body, indenter: Indenter, name: str) -> str:
    """SI unit of a number, or of the entries of a list; empty without one."""
    if name == _SLOPES:
        return ""
    known = {each.path: each for each in parameters(medium, indenter)}
    return _chosen(name, known)[0].unit


def _height(known: Mapping[str, Parameter], indenter: RadialProfile, j: int) -> Parameter:
    name = f"indenter.f[{j}]"
    if name not in known:
        raise ValueError(
            f"vary: {_SLOPES!r} needs a profile that ascends everywhere; its height {j} is {indenter.f[j]:g} m."
        )
    return known[name]


def _bounds(name: object, bounds: object) -> tuple[float, float]:
    if not isinstance(name, str):
        raise TypeError(f"vary: {shown(name)} must be the name of a number, a text.")
    pair = values(f"vary[{name!r}]", bounds, minimum=-np.inf)
    if pair.size != 2 or not pair[0] < pair[1]:
        raise BadValue(f"vary[{shown(name)}]", shown(bounds), "must be two bounds, the smaller one first.")
    return float(pair[0]), float(pair[1])


def _chosen(name: str, known: Mapping[str, Parameter]) -> list[Parameter]:
    if name in known:
        return [known[name]]
    inside = [each for each in known.values() if each.path.startswith((f"{name}[", f"{name}.entries["))]
    if not inside:
        near = difflib.get_close_matches(name, known, n=1)
        advice = f"; did you mean {near[0]!r}?" if near else "."
        raise ValueError(
            f"vary: {shown(name)} is not a number of this medium or tip{advice} It has {shown(', '.join(known), 1000)}."
        )
    return inside


def _check(medium: Body, indenter: Indenter, varied: _Varied) -> None:
    """Refuse bounds that do not hold the start, that have no logarithm, or at which there is no such medium or tip."""
    name, start, low, high = varied.name, varied.start, varied.low, varied.high
    if not low <= start <= high:
        raise ValueError(
            f"vary: {name} = {start:.6g} starts outside its bounds {low:.6g} to {high:.6g}. Change the case or the bounds."
        )
    if varied.logarithmic and low <= 0:
        raise ValueError(f"vary: the lower bound {low:g} of {name} must be > 0.")
    for bound in () if varied.listed else (low, high):
        try:
            with_values(medium, indenter, {name: bound})
        except ValueError as error:
            raise ValueError(f"vary: the bound {bound:g} of {name} is impossible: {error}") from None
