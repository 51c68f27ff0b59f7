"""Layers whose elastic constants vary with depth.

z is measured from the layer's own top. Young's modulus and Poisson ratio are laws of z (see `laws` and `formula`),
any function of z, or tables. Both are checked over the whole thickness when the layer is built.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from flatpunch._support.checks import Array, BadValue, brief, positive, real, shown, values
from flatpunch._support.prefixes import text
from flatpunch._support.readable import readable
from flatpunch.media.interface import Interface, lower_face
from flatpunch.media.laws import Constant, DepthTable, Law

CONTRAST = 1e25
"""Ratio of moduli, or of lengths, beyond which solutions overflow or do not end; fits try media of 1e18 on their way."""

_TABLE = "a table is a pair (depths, entries), depths ascending from 0 to at least the thickness"


@readable
@dataclass(frozen=True, slots=True)
class GradedLayer:
    """Isotropic elastic layer whose constants vary with depth.

    Parameters
    ----------
    young : law, function, table or float
        Young's modulus E(z) [Pa], > 0 everywhere. A named law (LinearModulus, ExponentialModulus, PowerModulus,
        Formula), any function of depths (n,) -> (n,), a table (depths, moduli), or one number. Functions are given
        apart by identity, everything else by value: layers made with two equal lambdas are two media.
    poisson : float, law, function or table
        Poisson ratio nu(z) [-], -1 < nu <= 0.5 everywhere.
    thickness : float
        Thickness h [m], > 0.
    bonded : bool or Interface
        Whether the lower face sticks to what lies below; otherwise it slides without friction (and does not lift off), or
        yields like the springs of an Interface.

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range; the message names it, and the depth at which it happens.

    See Also
    --------
    LinearModulus, ExponentialModulus, PowerModulus, DepthTable, Formula : Laws of the modulus over depth.
    Layer : A constant modulus.

    Examples
    --------
    >>> layer = fp.GradedLayer(young=fp.LinearModulus(1e9, 2e9, 1e-6), poisson=0.3, thickness=1e-6)
    >>> print(f"{layer.surface_modulus:.4g} Pa")
    1.099e+09 Pa
    """

    young: Any
    poisson: Any
    thickness: float
    bonded: bool | Interface = True

    def __post_init__(self) -> None:
        hint = "Layers run from the free surface down; what lies below them all is the base."
        object.__setattr__(self, "thickness", positive("GradedLayer.thickness", self.thickness, hint, unit="m"))
        object.__setattr__(self, "young", _as_law("GradedLayer.young", self.young, self.thickness, "Pa"))
        object.__setattr__(self, "poisson", _as_law("GradedLayer.poisson", self.poisson, self.thickness, "1"))
        object.__setattr__(self, "bonded", lower_face("GradedLayer.bonded", self.bonded))
        z = np.unique(np.concatenate([np.linspace(0.0, self.thickness, 2049), self.breaks]))
        _check_profile("GradedLayer.young", z, self.young_at, _young_fault)
        _check_profile("GradedLayer.poisson", z, self.poisson_at, _poisson_fault)
        moduli = self.young_at(z)
        if moduli.max() > CONTRAST * moduli.min():
            raise BadValue(
                "GradedLayer.young",
                f"{moduli.min():.3g} to {moduli.max():.3g} Pa",
                f"must not differ by more than a factor of {CONTRAST:.0e} over the depth. Check the units.",
            )

    def young_at(self, z: Array) -> Array:
        """Young's modulus [Pa] at depths z [m], 0 <= z <= thickness, any shape."""
        return _evaluate(self.young, z)

    def poisson_at(self, z: Array) -> Array:
        """Poisson ratio [-] at depths z [m], any shape."""
        return _evaluate(self.poisson, z)

    @property
    def breaks(self) -> tuple[float, ...]:
        """Depths inside the layer at which a table changes from one cubic to the next [m]."""
        inner = {z for law in (self.young, self.poisson) for z in getattr(law, "breaks", ())}
        return tuple(sorted(z for z in inner if 0 < z < self.thickness))

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* at the upper face [Pa]."""
        young, poisson = self.young_at(np.zeros(1))[0], self.poisson_at(np.zeros(1))[0]
        return float(young / (1 - poisson**2))


def _as_law(name: str, value: object, thickness: float, unit: str) -> Law:
    if isinstance(value, str):
        raise TypeError(
            f"{name} = {shown(value)} must be a number, a function of depth, a named law or a table; a formula is "
            f"Formula({shown(value)})."
        )
    if callable(value):
        return _hashable(name, value)
    if isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim):
        if len(value) != 2:
            raise TypeError(
                f"{name} = {shown(value)} must be a number, a function of depth, a named law or a table; {_TABLE}."
            )
        depths = values(f"{name}.depths", value[0], unit="m")
        entries = values(f"{name}.entries", value[1], minimum=-np.inf, unit=unit)
        if depths.size != entries.size:
            raise BadValue(name, "", f"has {depths.size} depths and {entries.size} entries; {_TABLE}.")
        table = DepthTable(tuple(depths), tuple(entries))
    else:
        return Constant(real(name, value, unit))
    if table.depths[0] != 0.0 or table.depths[-1] < thickness * (1 - 1e-9):
        raise BadValue(
            name,
            "",
            f"is a table from {table.depths[0]:g} to {table.depths[-1]:g} m "
            f"in a layer of thickness {thickness:g} m; {_TABLE}.",
        )
    return table


def _hashable(name: str, law: Law) -> Law:
    try:
        hash(law)
    except TypeError:
        raise TypeError(
            f"{name} = {shown(law)} cannot be hashed, so solutions of this medium could not be cached. "
            "Give a function, or a frozen dataclass with __call__."
        ) from None
    return law


def _evaluate(law: Law, z: Array) -> Array:
    """Value of a law at any shape of z; functions written for one depth only are called depth by depth."""
    z = np.asarray(z, dtype=float)
    flat = z.ravel()
    with np.errstate(all="ignore"):  # a value that is not finite is refused with its depth, by the check of the profile
        try:
            result = np.asarray(law(flat), dtype=float)
        except (TypeError, ValueError):
            result = _one_by_one(law, flat)
    if result.shape != flat.shape:
        result = np.broadcast_to(result, flat.shape).copy() if result.ndim == 0 else _one_by_one(law, flat)
    return result.reshape(z.shape)


def _one_by_one(law: Law, z: Array) -> Array:
    return np.array([float(np.asarray(law(np.asarray(depth)))) for depth in z])


def _young_fault(value: float) -> str:
    if np.isfinite(value) and value > 0:
        return ""
    return (
        "must be finite and > 0. A modulus that starts from zero at the free surface is PowerLawHalfSpace; "
        "otherwise end the layer before it vanishes."
    )


def _poisson_fault(value: float) -> str:
    if -1 < value <= 0.5:
        return ""
    return "must lie in -1 < poisson <= 0.5. 0.5 is incompressible and allowed; above it an isotropic body is unstable."


def _check_profile(name: str, z: Array, law: Callable[[Array], Array], fault: Callable[[float], str]) -> None:
    """Raise with the shallowest depth at which `law` leaves its range."""
    try:
        sampled = law(z)
    except Exception as error:  # a function of the user's own raises anything
        raise TypeError(
            f"{name}: the function fails with {type(error).__name__} ({brief(str(error))}). It takes an array of depths [m] and "
            "returns the values there."
        ) from error
    bad = [i for i, value in enumerate(sampled.tolist()) if fault(value)]
    if not bad:
        return
    first = bad[0]
    good, wrong = float(z[max(first - 1, 0)]), float(z[first])
    while wrong - good > 1e-9 * wrong:
        middle = (good + wrong) / 2
        if fault(float(law(np.array([middle]))[0])):
            wrong = middle
        else:
            good = middle
    value = float(sampled[first])
    raise BadValue(
        name,
        f"{value:g}",
        f"at depth z = {text(float(z[first]), 'm')} (out of range from z = {text(float(wrong), 'm')}) {fault(value)}",
    )
