"""Transversely isotropic layers and half-spaces, whose axis of symmetry is z: stiff along z or in the plane.

Columnar coatings, wood, tendon, graphite and stacks of thin layers are such bodies. Five constants describe one. They are kept as
engineering constants, which are finite for incompressible bodies too; `stiffnesses` gives the tensor. With E, nu in the plane,
E_z along the axis, nu_z the contraction in the plane under a stress along the axis, and G the shear modulus between both,

    e_xx = (s_xx - nu s_yy)/E - nu_z s_zz/E_z,    e_zz = (s_zz - nu_z (s_xx + s_yy))/E_z,    e_xz = s_xz/(2 G).

The strain energy is positive if E, E_z, G > 0, |nu| < 1 and 1 - nu - 2 nu_z^2 E/E_z >= 0, where zero is incompressible along z.
"""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, nan
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, positive, real, shown
from flatpunch._support.readable import quantity_of, readable
from flatpunch.media.interface import Interface, lower_face

N = TypeVar("N", float, Array)
"""One material, or one at each of many depths."""


class Stiffnesses(NamedTuple):
    """Stiffnesses of a transversely isotropic body [Pa], z = 3 its axis; C66 = (C11 - C12)/2."""

    c11: float
    c12: float
    c13: float
    c33: float
    c44: float

    @property
    def c66(self) -> float:
        """Shear modulus in the plane [Pa]."""
        return (self.c11 - self.c12) / 2


class Plane(NamedTuple, Generic[N]):
    """Coefficients of plane strain along a wave in a transversely isotropic body, and the shear stiffness across it.

    s_ll = stiffness e_ll + coupling s_zz,  e_zz = oedometric s_zz - coupling e_ll,  2 e_lz = shear s_lz,  s_ln = 2 across e_ln.
    """

    coupling: N
    shear: N
    oedometric: N
    stiffness: N
    across: N


@dataclass(frozen=True, slots=True)
class _Constants(ABC):
    """The five constants, which are checked, and what follows from them."""

    young_in_plane: float
    young_axial: float
    poisson_in_plane: float
    poisson_axial: float
    shear: float

    def __post_init__(self) -> None:
        _check(self)

    @property
    def stiffnesses(self) -> Stiffnesses:
        """C11, C12, C13, C33, C44 [Pa]; infinite where the body is incompressible."""
        q, shear, soft, stiff, across = plane_of(self)
        c33 = 1 / soft if soft else inf
        c13 = q * c33
        c11 = stiff + q * c13
        return Stiffnesses(c11, c11 - 2 * across, c13, c33, 1 / shear)

    @property
    def young(self) -> float:
        """Young's modulus in the plane [Pa]. A fit that varies `young` takes both other moduli along, at their ratios."""
        return self.young_in_plane

    @property
    def surface_modulus(self) -> float:
        """Contact modulus E* of the surface [Pa]: a frictionless rigid punch of radius a has the stiffness 2 E* a."""
        return contact_modulus(plane_of(self))


@readable
@dataclass(frozen=True, slots=True)
class TransverselyIsotropicHalfSpace(_Constants):
    """Homogeneous half-space that is transversely isotropic about z; a body by itself or the base under layers.

    Parameters
    ----------
    young_in_plane, young_axial : float
        Young's moduli along the surface and along z [Pa], > 0.
    poisson_in_plane : float
        Poisson ratio in the plane [-]: contraction along y under a stress along x.
    poisson_axial : float
        Contraction in the plane under a stress along z [-].
    shear : float
        Shear modulus between the plane and z, C44 [Pa], > 0.

    Raises
    ------
    ValueError, TypeError
        If the constants are outside their ranges or the body would not be stable.

    See Also
    --------
    TransverselyIsotropicLayer : A layer.
    HalfSpace : An isotropic one.

    Examples
    --------
    >>> graphite = fp.TransverselyIsotropicHalfSpace.from_stiffnesses(1060e9, 180e9, 15e9, 36.5e9, 4.5e9)
    >>> print(f"{graphite.surface_modulus / 1e9:.1f} GPa")
    25.0 GPa
    """

    @classmethod
    def from_stiffnesses(
        cls, c11: float, c12: float, c13: float, c33: float, c44: float
    ) -> TransverselyIsotropicHalfSpace:
        """Half-space with the stiffnesses C11, C12, C13, C33 and C44 [Pa]."""
        return cls(*_engineering(cls.__name__, Stiffnesses(c11, c12, c13, c33, c44)))

    @property
    def length(self) -> float:
        """Own length l [m]: infinite, a half-space has none."""
        return inf


@readable
@dataclass(frozen=True, slots=True)
class TransverselyIsotropicLayer(_Constants):
    """Homogeneous layer that is transversely isotropic about z.

    Parameters
    ----------
    young_in_plane, young_axial : float
        Young's moduli along the surface and along z [Pa], > 0.
    poisson_in_plane : float
        Poisson ratio in the plane [-]: contraction along y under a stress along x.
    poisson_axial : float
        Contraction in the plane under a stress along z [-].
    shear : float
        Shear modulus between the plane and z, C44 [Pa], > 0.
    thickness : float
        Thickness h [m], > 0.
    bonded : bool or Interface
        Whether the lower face sticks to what lies below; otherwise it slides without friction (no lift-off), or yields like
        the springs of an Interface.

    Raises
    ------
    ValueError, TypeError
        If the constants are outside their ranges or the body would not be stable.

    See Also
    --------
    TransverselyIsotropicHalfSpace : A base.
    Layer : An isotropic one.

    Examples
    --------
    >>> columns = fp.TransverselyIsotropicLayer(250e9, 400e9, 0.25, 0.2, 110e9, thickness=2e-6)
    >>> coated = fp.Medium([columns], base=fp.HalfSpace(210e9, 0.3))
    >>> print(f"{columns.surface_modulus / 1e9:.0f} GPa")
    344 GPa
    """

    thickness: float
    bonded: bool | Interface = True

    def __post_init__(self) -> None:
        _Constants.__post_init__(self)
        hint = "Layers run from the free surface down; what lies below them all is the base."
        name = f"{type(self).__name__}.thickness"
        object.__setattr__(self, "thickness", positive(name, self.thickness, hint, unit="m"))
        object.__setattr__(self, "bonded", lower_face(f"{type(self).__name__}.bonded", self.bonded))

    @classmethod
    def from_stiffnesses(
        cls,
        c11: float,
        c12: float,
        c13: float,
        c33: float,
        c44: float,
        thickness: float,
        bonded: bool | Interface = True,
    ) -> TransverselyIsotropicLayer:
        """Layer with the stiffnesses C11, C12, C13, C33 and C44 [Pa]."""
        return cls(*_engineering(cls.__name__, Stiffnesses(c11, c12, c13, c33, c44)), thickness, bonded)


TransverselyIsotropic = TransverselyIsotropicLayer | TransverselyIsotropicHalfSpace

CONSTANTS = ("young_in_plane", "young_axial", "poisson_in_plane", "poisson_axial", "shear")
"""Names of the five elastic constants."""


def scaled(body: TransverselyIsotropic, factor: float) -> TransverselyIsotropic:
    """The body with all moduli multiplied by a factor."""
    moduli = {name: factor * getattr(body, name) for name in ("young_in_plane", "young_axial", "shear")}
    return replace(body, **moduli)


def summary(constants: Sequence[object]) -> tuple[str, str]:
    """Moduli and Poisson ratios, numbers or laws of depth, in words."""
    young, young_axial, poisson, poisson_axial, shear = constants
    plane, axial, between = (quantity_of(value, "Pa") for value in (young, young_axial, shear))
    ratios = [quantity_of(value, "") for value in (poisson, poisson_axial)]
    return f"{plane} in plane, {axial} axial, shear {between}", f"{ratios[0]}, axial {ratios[1]}"


def plane_of(body: _Constants) -> Plane[float]:
    """Plane-strain coefficients of a body [Pa]."""
    return _plane(*constants_of(body), _slack(*constants_of(body)[:4]))


def plane_of_arrays(constants: Sequence[Array]) -> Plane[Array]:
    """Plane-strain coefficients of the five constants at many depths [Pa]; NaN where the body would not be stable."""
    young, axial, nu, nu_axial, shear = constants
    slack = 1 - nu - 2 * nu_axial * nu_axial * young / axial
    # zero where the body is incompressible along z, up to the rounding of the laws
    slack = np.where(np.abs(slack) <= ROUNDING * (1 - nu), 0.0, np.where(slack > 0, slack, nan))
    stable = (np.minimum(np.minimum(young, axial), shear) > 0) & (np.abs(nu) < 1)
    return _plane(young, axial, nu, nu_axial, shear, np.where(stable, slack, nan))


def constants_of(body: _Constants) -> tuple[float, float, float, float, float]:
    """The five constants of a body."""
    return body.young_in_plane, body.young_axial, body.poisson_in_plane, body.poisson_axial, body.shear


def _plane(young: N, axial: N, nu: N, nu_axial: N, shear: N, slack: N) -> Plane[N]:
    return Plane(
        coupling=young / axial * nu_axial / (1 - nu),
        shear=1 / shear,
        oedometric=slack / ((1 - nu) * axial),
        stiffness=young / (1 - nu * nu),
        across=young / (2 * (1 + nu)),
    )


def over(scale: float, plane: Plane[N]) -> Plane[N]:
    """Coefficients with stresses in units of a scale."""
    q, shear, soft, stiff, across = plane
    return Plane(q, shear * scale, soft * scale, stiff / scale, across / scale)


def isotropic_plane(young: N, nu: N) -> Plane[N]:
    """Plane-strain coefficients of isotropic material [Pa]."""
    mu = young / (2 * (1 + nu))
    return Plane(nu / (1 - nu), 1 / mu, (1 - 2 * nu) / (2 * mu * (1 - nu)), 2 * mu / (1 - nu), mu)


def from_plane(plane: Plane[float]) -> tuple[float, float, float, float, float]:
    """The five constants of a body with given coefficients."""
    nu = 1 - 2 * plane.across / plane.stiffness
    young = 2 * plane.across * (1 + nu)
    axial = 1 / (plane.oedometric + 2 * plane.coupling**2 * (1 - nu) / young)
    return young, axial, nu, plane.coupling * (1 - nu) * axial / young, 1 / plane.shear


def plane_slopes(constants: Sequence[N]) -> dict[str, Plane[N]]:
    """Derivatives of the coefficients by each of the five constants, all others fixed."""
    e, z, nu, nu_z, g = constants
    q, slack = e / z * nu_z / (1 - nu), 1 - nu - 2 * nu_z**2 * e / z
    soft = -2 * nu_z**2 / (z * z * (1 - nu))
    zero = 0 * e
    return {
        "young_in_plane": Plane(q / e, zero, soft, 1 / (1 - nu * nu), 1 / (2 * (1 + nu))),
        "young_axial": Plane(-q / z, zero, -slack / ((1 - nu) * z * z) - soft * e / z, zero, zero),
        "poisson_in_plane": Plane(
            q / (1 - nu),
            zero,
            soft * e / (1 - nu),
            2 * nu * e / (1 - nu * nu) ** 2,
            -e / (2 * (1 + nu) ** 2),
        ),
        "poisson_axial": Plane(e / (z * (1 - nu)), zero, -4 * nu_z * e / (z * z * (1 - nu)), zero, zero),
        "shear": Plane(zero, -1 / g**2, zero, zero, zero),
    }


def isotropic_slopes(young: N, poisson: N) -> dict[str, Plane[N]]:
    """Derivatives of the coefficients of isotropic material by Young's modulus and the Poisson ratio."""
    shear = young / (2 * (1 + poisson))
    in_plane, axial, nu, nu_axial, by_shear = plane_slopes((young, young, poisson, poisson, shear)).values()
    along = shear / young, -shear / (1 + poisson)
    return {
        "young": Plane(*(a + b + along[0] * c for a, b, c in zip(in_plane, axial, by_shear, strict=True))),
        "poisson": Plane(*(a + b + along[1] * c for a, b, c in zip(nu, nu_axial, by_shear, strict=True))),
    }


def _slack(young: float, axial: float, nu: float, nu_axial: float) -> float:
    """1 - nu - 2 nu_z^2 E/E_z: zero where the body is incompressible along z, up to rounding."""
    slack = 1 - nu - 2 * nu_axial * nu_axial * young / axial
    return 0.0 if abs(slack) <= 4 * np.finfo(float).eps * (1 - nu) else slack


def _check(body: _Constants) -> None:
    """Check the constants and the stability of the tensor."""
    kind = type(body).__name__
    for name in ("young_in_plane", "young_axial", "shear"):
        object.__setattr__(body, name, positive(f"{kind}.{name}", getattr(body, name), unit="Pa"))
    for name in ("poisson_in_plane", "poisson_axial"):
        object.__setattr__(body, name, real(f"{kind}.{name}", getattr(body, name)))
    nu, nu_axial, ratio = body.poisson_in_plane, body.poisson_axial, body.young_in_plane / body.young_axial
    if not -1 < nu < 1:
        raise ValueError(f"{kind}.poisson_in_plane = {nu:g} must lie in -1 < poisson_in_plane < 1.")
    if _slack(body.young_in_plane, body.young_axial, nu, nu_axial) < 0:
        raise ValueError(
            f"{kind}.poisson_axial = {nu_axial:g} makes the body unstable: its square must not exceed "
            f"(1 - poisson_in_plane)/2 young_axial/young_in_plane = {(1 - nu) / 2 / ratio:.4g}. If it is the contraction along z "
            f"under a stress in the plane, give {nu_axial / ratio:.4g}, its product with young_axial/young_in_plane."
        )


def _engineering(kind: str, given: Stiffnesses) -> tuple[float, float, float, float, float]:
    """Engineering constants of stiffnesses, which are checked."""
    c11, c12, c13, c33, c44 = (
        real(f"{kind}.{name}", value, "Pa") for name, value in zip(given._fields, given, strict=True)
    )
    bulk = c11 + c12
    if not (c11 > abs(c12) and c33 > 0 and c44 > 0 and bulk * c33 > 2 * c13 * c13):
        raise ValueError(
            f"{kind} with c11 = {shown(c11)}, c12 = {shown(c12)}, c13 = {shown(c13)}, c33 = {shown(c33)}, c44 = {shown(c44)} is "
            "not stable: c11 > |c12|, c33 > 0, c44 > 0 and (c11 + c12) c33 > 2 c13^2 must hold. The axis of symmetry is z = 3."
        )
    determinant = bulk * c33 - 2 * c13 * c13
    young = (c11 - c12) * determinant / (c11 * c33 - c13 * c13)
    return young, determinant / bulk, (c12 * c33 - c13 * c13) / (c11 * c33 - c13 * c13), c13 / bulk, c44


def exponents(plane: Plane[N]) -> tuple[N, N, N, N]:
    """Sum s and product d of the two rates at which fields decay with depth, per wavenumber, d - q, and e^2 = s^2/4 - d.

    The rates are the roots of p^2 - s p + d: real, equal or a complex pair; s and d are positive.
    """
    q, shear, soft, stiff, _ = plane
    d = (q * q + stiff * soft) ** 0.5
    # notation: d - q and d + q, of which one cancels, from the other
    large, upper = d + abs(q), 1.0 * (q > 0)
    small = stiff * soft / large
    less, more = small * upper + large * (1 - upper), large * upper + small * (1 - upper)
    return (stiff * shear + 2 * less) ** 0.5, d, less, (stiff * shear - 2 * more) / 4


def rates_of(plane: Plane[Array]) -> tuple[Array, Array]:
    """Rate at which waves decay with k z at least, along the wave and across it, and the magnitude of the largest rate."""
    s, d, _, square = exponents(plane)
    # of a complex pair the real part, and the magnitude
    fast = np.where(square > 0, s / 2 + np.sqrt(np.maximum(square, 0.0)), np.sqrt(d))
    across = np.sqrt(plane.across * plane.shear)
    return np.minimum(np.where(square > 0, d / fast, s / 2), across), np.maximum(fast, across)


def contact_modulus(plane: Plane[N]) -> N:
    """Contact modulus E* of a half-space [Pa]."""
    s, d, _, _ = exponents(plane)
    return 2 * plane.stiffness / (s * d)


def exponent_slopes(plane: Plane[N], change: Plane[N]) -> tuple[N, N]:
    """Changes of the sum s and the product d of both rates, d^2 = q^2 + M/C33 and s^2 = M/C44 + 2 (d - q)."""
    s, d, _, _ = exponents(plane)
    soft = change.stiffness * plane.oedometric + plane.stiffness * change.oedometric
    shear = change.stiffness * plane.shear + plane.stiffness * change.shear
    of_d = (2 * plane.coupling * change.coupling + soft) / (2 * d)
    return (shear + 2 * (of_d - change.coupling)) / (2 * s), of_d


def surface_slopes(constants: Sequence[float]) -> dict[str, float]:
    """Derivatives of ln E* by each of the five constants, all others fixed."""
    young, axial, nu, nu_axial, shear = constants
    plane = _plane(young, axial, nu, nu_axial, shear, _slack(young, axial, nu, nu_axial))
    s, d, _, _ = exponents(plane)
    found = {}
    for name, change in plane_slopes(constants).items():
        of_s, of_d = exponent_slopes(plane, change)
        found[name] = change.stiffness / plane.stiffness - of_s / s - of_d / d
    return found
