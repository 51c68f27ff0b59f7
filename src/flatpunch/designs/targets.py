"""What a design is for: prescribed quantities, limits, the largest load before failure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from flatpunch._support.checks import Array, BadValue, Values, instance, non_negative, one_of, positive, values
from flatpunch._support.readable import readable
from flatpunch.contact.curve import Control
from flatpunch.sensitivities.gradient import Gradient
from flatpunch.stresses.failure.strength import Strength

Quantity = Literal["force", "depth", "stiffness", "radius"]

UNITS = {"force": "N", "depth": "m", "stiffness": "N/m", "radius": "m"}
"""SI units of the quantities."""

_ATTRIBUTES = {
    ("depth", "force"): "force",
    ("depth", "stiffness"): "stiffness",
    ("depth", "radius"): "radius",
    ("force", "depth"): "depth",
    ("force", "stiffness"): "stiffness_at_force",
    ("force", "radius"): "radius_at_force",
}
"""Control and quantity -> the attribute of a gradient that holds its derivatives."""


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
        given = self.strengths if isinstance(self.strengths, Sequence) else [self.strengths]
        for each in given:
            kinds = (Strength, type(None))
            instance("LargestLoad.strengths", each, kinds, "a Strength, or a list of them (None: bears all)")
        object.__setattr__(self, "friction", non_negative("LargestLoad.friction", self.friction, unit="1"))


def achieved(found: list[Gradient], control: Control, quantity: Quantity) -> tuple[Array, Array]:
    """Values of a quantity, shape (n,), and the derivatives of their logarithms by the parameters, shape (n, parameters)."""
    value = np.array([getattr(each.contact, quantity) for each in found])
    slope = np.array([getattr(each, _ATTRIBUTES[control.name, quantity]) for each in found])
    return value, slope / value[:, None]


def _control(owner: str, quantity: Quantity, depth: Values | None, force: Values | None) -> Control:
    one_of(f"{owner}.quantity", quantity, get_args(Quantity), wrong="is no quantity of a contact")
    if (depth is None) == (force is None):
        raise ValueError(f"{owner} takes exactly one of depth and force, at which {quantity} is meant.")
    name: Literal["depth", "force"] = "force" if depth is None else "depth"
    if name == quantity:
        raise ValueError(f"{owner} prescribes {quantity} at given {name}: give the other of depth and force.")
    found = values(f"{owner}.{name}", depth if force is None else force, strict=True, unit=UNITS[name])
    return Control(name, found)
