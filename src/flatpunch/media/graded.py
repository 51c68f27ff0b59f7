"""Layers whose elastic constants vary with depth.

Depth z is measured from the layer's own upper face. Modulus and Poisson ratio are laws of z (see `laws` and `formula`),
any function of z, or tables; so are the five constants where the layer is transversely isotropic. All are checked over the whole
thickness when the layer is built.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, Array, BadValue, real, shown, values
from flatpunch._support.declared import Number, a_pressure, a_ratio, number_of
from flatpunch._support.messages import brief
from flatpunch._support.paths import Plain
from flatpunch._support.prefixes import text
from flatpunch._support.readable import quantity_of, readable
from flatpunch.media.laws import Constant, DepthTable, Law, times
from flatpunch.media.material import POISSON, YOUNG, AnyLayer, Interface, Thickness
from flatpunch.media.plane import (
    Plane,
    contact_modulus,
    isotropic_plane,
    isotropic_slopes,
    plane_of_arrays,
    plane_slopes,
)
from flatpunch.media.transverse import summary

CONTRAST = 1e25
"""Ratio of moduli, or of lengths, beyond which solutions overflow or do not end; fits try media of 1e18 on their way."""

_AXIAL = ("young_axial", "poisson_axial", "shear")
"""Constants that only transversely isotropic layers have."""

_TABLE = "a table is a pair (depths, entries), depths ascending from 0 to at least the thickness"

_VANISHES = (
    "A modulus that starts from zero at the free surface is PowerLawHalfSpace; otherwise end the layer before it "
    "vanishes."
)
_IN_PLANE = a_ratio(
    "Poisson ratio in the plane",
    above=-1.0,
    below=1.0,
    law=True,
    outside="must lie in -1 < poisson < 1 in a transversely isotropic layer.",
)

YoungLaw = Annotated[object, replace(YOUNG, law=True, remedy=_VANISHES)]
PoissonLaw = Annotated[object, replace(POISSON, law=True)]
AxialYoungLaw = Annotated[object, a_pressure("Young's modulus along z", law=True, remedy=_VANISHES)]
AxialPoissonLaw = Annotated[object, a_ratio("Poisson ratio along z", law=True)]
ShearLaw = Annotated[object, a_pressure("shear modulus along z", law=True, remedy=_VANISHES)]


@readable
@dataclass(frozen=True, slots=True)
class GradedLayer(AnyLayer):
    """Elastic layer whose constants vary with depth: isotropic, or transversely isotropic about z.

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
    young_axial, shear : law, function, table or float, optional
        Young's modulus along z and shear modulus between the plane and z, C44 [Pa], > 0 everywhere. With `poisson_axial` they
        make the layer transversely isotropic; `young` and `poisson` are then those in the plane, and -1 < poisson < 1.
    poisson_axial : float, law, function or table, optional
        Contraction in the plane under a stress along z [-].

    Raises
    ------
    ValueError, TypeError
        If a value is outside its range, or the body would not be stable; the message names it, and the depth at which it happens.

    See Also
    --------
    LinearModulus, ExponentialModulus, PowerModulus, DepthTable, Formula : Laws of the modulus over depth.
    Layer, TransverselyIsotropicLayer : Constants that do not vary.

    Examples
    --------
    >>> layer = fp.GradedLayer(young=fp.LinearModulus(1e9, 2e9, 1e-6), poisson=0.3, thickness=1e-6)
    >>> print(f"{layer.surface_modulus:.4g} Pa")
    1.099e+09 Pa
    >>> columns = fp.GradedLayer(
    ...     young=250e9, poisson=0.25, thickness=1e-6, young_axial=([0, 1e-6], [400e9, 250e9]), poisson_axial=0.2, shear=100e9
    ... )
    >>> print(f"{columns.surface_modulus / 1e9:.0f} GPa")
    333 GPa
    """

    young: YoungLaw
    poisson: PoissonLaw
    thickness: Thickness
    bonded: bool | Interface = True
    young_axial: AxialYoungLaw = None
    poisson_axial: AxialPoissonLaw = None
    shear: ShearLaw = None

    def _together_(self) -> None:
        self._check_kind()
        for name in self.numbers:
            law = _as_law(f"GradedLayer.{name}", getattr(self, name), self.thickness, self._number(name).converted)
            object.__setattr__(self, name, law)
        self._check_range(self.sampled_depths)

    @property
    def _declared_(self) -> dict[str, Number]:
        return {"poisson": _IN_PLANE} if self.anisotropic else {}

    def _number(self, name: str) -> Number:
        number = self._declared_.get(name) or number_of(GradedLayer, name)
        assert number is not None
        return number

    @property
    def sampled_depths(self) -> Array:
        """Depths over the whole layer, with those of its kinks, at which ranges of its moduli are sought [m]."""
        return np.unique(np.concatenate([np.linspace(0.0, self.thickness, 2049), self.breaks]))

    @property
    def varies(self) -> bool:
        """True."""
        return True

    @property
    def anisotropic(self) -> bool:
        """Whether the layer is transversely isotropic, not isotropic."""
        return self.shear is not None

    @property
    def _absent_(self) -> tuple[str, ...]:
        return () if self.anisotropic else _AXIAL

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the constants, each a law of depth: two, or five in the order of `TransverselyIsotropicLayer`."""
        return (
            ("young", "young_axial", "poisson", "poisson_axial", "shear") if self.anisotropic else ("young", "poisson")
        )

    def young_at(self, z: Array) -> Array:
        """Young's modulus [Pa], in the plane, at depths z [m], 0 <= z <= thickness, any shape."""
        return self._at("young", z)

    def poisson_at(self, z: Array) -> Array:
        """Poisson ratio [-], in the plane, at depths z [m], any shape."""
        return self._at("poisson", z)

    def constants_at(self, z: Array) -> tuple[Array, ...]:
        """The constants named by `numbers` at depths z [m], any shape."""
        return tuple(self._at(name, z) for name in self.numbers)

    def _at(self, name: str, z: Array) -> Array:
        return _evaluate(getattr(self, name), z)

    def plane_at(self, z: Array) -> Plane[Array]:
        """Plane-strain coefficients at depths z [m], any shape.

        A ValueError says that the constants leave their ranges between the depths at which the layer was checked.
        """
        constants = self.constants_at(z)
        with np.errstate(all="ignore"):  # what is not finite is refused below
            if self.anisotropic:
                plane = plane_of_arrays(constants)
                stable = np.isfinite(plane.oedometric)
            else:
                young, nu = constants
                plane = isotropic_plane(young, nu)
                stable = (young > 0) & np.isfinite(young) & (nu > -1) & (nu <= 0.5)
        if not stable.all():
            i = int(np.argmin(stable))
            found = ", ".join(f"{name} = {each.flat[i]:g}" for name, each in zip(self.numbers, constants, strict=True))
            raise ValueError(
                f"GradedLayer has {found} at depth z = {text(float(np.asarray(z).flat[i]), 'm')}, of which no stable material "
                "can be made; moduli must be > 0 and Poisson ratios within their limits at every depth."
            )
        return plane

    @property
    def breaks(self) -> tuple[float, ...]:
        """Depths inside the layer at which a table changes from one cubic to the next [m]."""
        inner = {z for name in self.numbers for z in getattr(getattr(self, name), "breaks", ())}
        return tuple(sorted(z for z in inner if 0 < z < self.thickness))

    @property
    def surface_modulus(self) -> float:
        """Plane-strain modulus E* at the upper face [Pa]; of a transversely isotropic layer the contact modulus."""
        plane = self.plane_at(np.zeros(1))
        return float((contact_modulus(plane) if self.anisotropic else plane.stiffness)[0])

    @property
    def softest(self) -> float:
        """Largest 1/E* over the depth [1/Pa]."""
        return float(np.max(1 / contact_modulus(self.plane_at(np.linspace(0.0, self.thickness, 100)))))

    def slopes_at(self, z: Array) -> dict[str, Plane[Array]]:
        """Derivatives of the coefficients by the constants at depths z, of the shape of z."""
        constants = self.constants_at(z)
        slopes = plane_slopes(constants) if self.anisotropic else isotropic_slopes(*constants)
        return dict(zip(self.numbers, slopes.values(), strict=True))

    def times(self, factor: float) -> GradedLayer:
        """The layer with all moduli multiplied by a factor."""
        moduli: Plain = {
            name: times(getattr(self, name), factor) for name in self.numbers if not name.startswith("poisson")
        }
        return replace(self, **moduli)

    def elasticity(self) -> tuple[str, str]:
        """Laws of the moduli and Poisson ratios in words."""
        if self.anisotropic:
            return summary([getattr(self, name) for name in self.numbers])
        return quantity_of(self.young, "Pa"), quantity_of(self.poisson, "")

    def _check_kind(self) -> None:
        missing = [name for name in _AXIAL if getattr(self, name) is None]
        if missing and len(missing) < len(_AXIAL):
            raise BadValue(
                f"GradedLayer.{missing[0]}",
                "None",
                "is missing: young_axial, poisson_axial and shear together make the layer transversely isotropic; give all three "
                "or none.",
            )

    def _check_range(self, z: Array) -> None:
        moduli = []
        for name in self.numbers:
            number, law = self._number(name), partial(_evaluate, getattr(self, name))
            _check_profile(f"GradedLayer.{name}", z, law, number.fault)
            if number.unit == "Pa":
                moduli.append(law(z))
        if np.max(moduli) > CONTRAST * np.min(moduli):
            raise BadValue(
                "GradedLayer.young",
                f"{np.min(moduli):.3g} to {np.max(moduli):.3g} Pa",
                f"must not differ by more than a factor of {CONTRAST:.0e} over the depth. Check the units.",
            )
        if self.anisotropic:
            self._check_stability(z)

    def _check_stability(self, z: Array) -> None:
        """Refuse a contraction along z that makes the body unstable, at the depths z or at the worst depth between them."""

        def excess(depth: Array) -> Array:
            """Share by which the square of the axial ratio exceeds its limit."""
            young, axial, nu, nu_axial, _ = self.constants_at(depth)
            return np.asarray(2 * nu_axial**2 * young / (axial * (1 - nu)) - 1)

        worst = int(np.argmax(excess(z)))
        around = z[max(worst - 1, 0)], z[min(worst + 1, z.size - 1)]
        between = scipy.optimize.minimize_scalar(
            lambda depth: -excess(np.array([depth]))[0], bounds=around, method="bounded"
        )
        deepest = np.array([z[worst], between.x])
        at = deepest[np.argmax(excess(deepest))]
        if excess(np.array([at]))[0] > ROUNDING:
            young, axial, nu, nu_axial, _ = (float(each[0]) for each in self.constants_at(np.array([at])))
            raise BadValue(
                "GradedLayer.poisson_axial",
                f"{nu_axial:g}",
                f"at depth z = {text(float(at), 'm')} makes the body unstable: its square must not exceed "
                f"(1 - poisson)/2 young_axial/young = {(1 - nu) / 2 * axial / young:.4g} there.",
            )


def _as_law(name: str, value: object, thickness: float, unit: str | None) -> Law:
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
