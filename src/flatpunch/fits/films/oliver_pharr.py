"""Contact depth and radius after Oliver and Pharr, point by point: h_c = h - epsilon P/S, pi a^2 = A(h_c)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from flatpunch._support.checks import TINY, Array, Flags, non_negative, positive, shown, values
from flatpunch._support.readable import readable
from flatpunch.fits.measured.curve import Curve, CurveError
from flatpunch.media import HalfSpace

DIAMOND = HalfSpace(young=1141e9, poisson=0.07)
"""Handbook values of the tip's material."""


@readable
@dataclass(frozen=True)
class Tip:
    """Indenter of a nanoindentation test.

    Parameters
    ----------
    area : callable
        Contact depth [m], shape (n,) -> projected area [m^2].
    beta : float
        Stiffness over that of the circular punch of the same area.
    epsilon : float
        Of h_c = h - epsilon P/S; 0.75 for a paraboloid of revolution.
    material : HalfSpace
        What the tip is made of.

    See Also
    --------
    flatpunch.fits.tip_in_workbook : From the file of an instrument.
    flatpunch.AreaFunction : The same numbers as an indenter.

    Examples
    --------
    >>> from flatpunch.fits import Tip
    >>> tip = Tip.from_coefficients([24.5, 500.0])  # nm^2 over h in nm
    >>> print(f"{float(tip.area(np.array(100e-9))) * 1e12:.3f} um^2")
    0.295 um^2
    """

    area: Callable[[Array], Array]
    beta: float = 1.034
    epsilon: float = 0.75
    material: HalfSpace = DIAMOND

    def __post_init__(self) -> None:
        if not callable(self.area):
            raise TypeError(
                f"Tip.area = {shown(self.area)} must be a function of depths [m], such as Tip.from_coefficients(...)."
            )
        object.__setattr__(self, "beta", positive("Tip.beta", self.beta, unit="1"))
        object.__setattr__(self, "epsilon", non_negative("Tip.epsilon", self.epsilon, unit="1"))

    def stiffness(self, radius: Array, modulus: Array) -> Array:
        """Stiffness of contacts of these radii on half-spaces of these plane-strain moduli, the tip's own in series [N/m]."""
        return np.asarray(2 * self.beta * radius / (1 / modulus + 1 / self.material.surface_modulus))

    def modulus(self, radius: Array, stiffness: Array) -> Array:
        """Plane-strain modulus of half-spaces on which contacts of these radii have these stiffnesses [Pa]."""
        return np.asarray(1 / (2 * self.beta * radius / stiffness - 1 / self.material.surface_modulus))

    @classmethod
    def from_coefficients(cls, coefficients: Any, unit: float = 1e-9, **rest: Any) -> Tip:
        """Tip with A = C0 h^2 + C1 h + C2 h^(1/2) + C3 h^(1/4) + ...

        Parameters
        ----------
        coefficients : sequence of float
            C0, C1, ... for h and A in units of `unit` and its square.
        unit : float
            [m]; nanometres are usual.
        **rest
            Further fields.
        """
        numbers = values("coefficients", coefficients, minimum=-np.inf, unit="1")
        unit = positive("unit", unit, unit="m")
        powers = np.array([2.0, *(2.0**-k for k in range(numbers.size - 1))])

        def area(depth: Array) -> Array:
            h = np.maximum(np.asarray(depth, dtype=float), 0.0)[..., None] / unit
            return np.asarray((numbers * h**powers).sum(axis=-1) * unit**2)

        return cls(area, **rest)


@dataclass(frozen=True, eq=False)
class OliverPharr:
    """Point-by-point analysis; arrays of shape (n,).

    Attributes
    ----------
    depth, contact_depth, radius : ndarray
        h, h_c, a [m].
    stiffness : ndarray
        S with the frame taken out [N/m].
    apparent : ndarray
        Plane-strain modulus of a homogeneous sample with this stiffness, the tip's own taken out [Pa].
    hardness : ndarray
        P/A [Pa].
    """

    depth: Array
    contact_depth: Array
    radius: Array
    stiffness: Array
    apparent: Array
    hardness: Array

    def taken(self, chosen: Flags) -> OliverPharr:
        """Some of the points."""
        return OliverPharr(*(getattr(self, each.name)[chosen] for each in fields(self)))


def oliver_pharr(curve: Curve, tip: Tip, frame: float = 0.0) -> OliverPharr:
    """Contact depth, radius, apparent modulus and hardness at every point with a stiffness.

    Parameters
    ----------
    curve : Curve
        With `stiffness`; depth counted from the surface.
    tip : Tip
        Area function and constants.
    frame : float
        Compliance of the load frame that the instrument has not taken out [m/N].

    See Also
    --------
    flatpunch.fits.fit_film : The modulus of a film.
    flatpunch.fits.unloading : Stiffness from one load cycle.

    Examples
    --------
    >>> from flatpunch.fits import Tip
    >>> film = fp.Layer(young=20e9, poisson=0.25, thickness=1e-6)
    >>> film = fp.Medium([film], base=fp.HalfSpace(young=130e9, poisson=0.28))
    >>> tip = Tip.from_coefficients([24.5], beta=1.0, material=fp.HalfSpace(young=1e15, poisson=0.0))  # nearly rigid
    >>> cone = fp.Cone(inclination=np.arctan(np.sqrt(np.pi / 24.5)))
    >>> contact = fp.indent(film, cone, depth=np.linspace(50e-9, 500e-9, 20))
    >>> test = fp.Curve(depth=contact.depth, force=contact.force, stiffness=contact.stiffness)
    >>> from flatpunch.fits import oliver_pharr
    >>> points = oliver_pharr(test, tip)
    >>> print((points.apparent[[0, -1]] / 1e9).round(1))  # E* of film and substrate together [GPa]
    [23.5 50.3]
    """
    frame = non_negative("frame", frame, unit="m/N")
    if not isinstance(tip, Tip):
        raise TypeError(f"tip = {shown(tip)} must be a Tip, for example Tip.from_coefficients([24.5, 300.0]).")
    if not isinstance(curve, Curve):
        raise TypeError(f"curve = {shown(curve)} must be a Curve.")
    if curve.stiffness is None:
        raise CurveError(
            f"{curve.name}: no column of contact stiffness; hard films need it (continuous stiffness or unloading)."
        )
    found = analysed(curve, tip, frame)
    return found.taken(np.isfinite(found.radius))


def analysed(curve: Curve, tip: Tip, frame: float) -> OliverPharr:
    """Every point of a curve; nan where there is no stiffness, force or area."""
    assert curve.stiffness is not None
    h, force = curve.depth, curve.force
    with np.errstate(invalid="ignore", divide="ignore"):
        good = (curve.stiffness > 0) & np.isfinite(curve.stiffness) & (force > 0) & (h > 0)
        stiffness = 1 / np.maximum(1 / np.where(good, curve.stiffness, np.nan) - frame, TINY)
        contact_depth = h - frame * force - tip.epsilon * force / stiffness
        good &= contact_depth > 0
        area = np.full(h.size, np.nan)
        area[good] = tip.area(contact_depth[good])
        radius = np.sqrt(np.where(area > 0, area, np.nan) / np.pi)
        return OliverPharr(h, contact_depth, radius, stiffness, tip.modulus(radius, stiffness), force / area)
