"""Theories of rough contact beside the numerical solution: Persson, Greenwood and Williamson, bearing area, full contact.

Full contact is linear: a wave of height h_q needs the pressure h_q/C(q). Its variance is all that Persson's theory knows of the
surface, and its elastic energy needs the power spectrum alone. Greenwood and Williamson press each summit on its own. The bearing
area is the share of the surface above a level. On layers the first two take the compliance of the layers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.fft
from scipy.optimize import brentq
from scipy.special import erf

from flatpunch._support.checks import Array, Values, follows, instance, numbers, shown, values
from flatpunch._support.readable import readable
from flatpunch.compliances import Kernel, compliance
from flatpunch.contact.dataset import Column, dataset
from flatpunch.contact.indentation import indent
from flatpunch.indenters import Paraboloid
from flatpunch.media import Body
from flatpunch.numerics.gauss import gauss
from flatpunch.surfaces import Topography

if TYPE_CHECKING:
    import xarray as xr

Spectrum = Topography | tuple[Values, Values]
"""A periodic surface, or wavenumbers [1/m] and its isotropic power spectral density C(q) [m^4]."""


@readable
@dataclass(frozen=True, slots=True)
class FullContact:
    """A surface pressed flat.

    Attributes
    ----------
    rms_pressure : float
        Standard deviation of the pressure [Pa].
    energy : float
        Elastic energy over the nominal area [J/m^2].
    rms_height, rms_slope : float
        Of the surface, from its spectrum [m], [-].

    See Also
    --------
    flatpunch.full_contact : Makes it.

    Examples
    --------
    >>> rough = fp.self_affine(64, 10e-9, rms_slope=0.1)
    >>> full = fp.full_contact(fp.HalfSpace(young=5e6, poisson=0.5), rough)
    >>> print(f"{100 * full.area_fraction(0.1e6):.0f} % in contact at 0.1 MPa")
    22 % in contact at 0.1 MPa
    """

    rms_pressure: float
    energy: float
    rms_height: float
    rms_slope: float

    def area_fraction(self, pressure: Values) -> Array | float:
        """Persson's share of the area in contact at mean pressures [Pa], erf(p/sqrt(2 V)), V the variance of full contact."""
        p = numbers("pressure", pressure, "Pa")
        values("pressure", p.ravel())
        # a flat surface touches as a whole under any pressure
        over = np.divide(
            p, np.sqrt(2) * self.rms_pressure, out=np.where(p > 0, np.inf, 0.0), where=self.rms_pressure > 0
        )
        share: Array | float = erf(over)
        return share


def full_contact(medium: Body, spectrum: Spectrum) -> FullContact:
    """Pressure and elastic energy of a surface that is pressed flat, straight from its spectrum.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them.
    spectrum : Topography or (array, array)
        A surface that repeats in both directions, or wavenumbers q [1/m], ascending, and the isotropic power spectral density
        C(q) [m^4], with mean square height (1/2 pi) int C q dq. Between its points C is a power of q, outside it is zero.

    Returns
    -------
    FullContact
        rms_pressure [Pa], energy [J/m^2], rms_height [m], rms_slope [-].

    Raises
    ------
    ValueError, TypeError
        If the surface ends, or the table is none.

    See Also
    --------
    rough_theories : Persson's theory beside a numerical solution.
    rough_contact : The whole curve.

    References
    ----------
    B. N. J. Persson, J. Chem. Phys. 115, 3840 (2001); Surf. Sci. Rep. 61, 201 (2006).

    Examples
    --------
    >>> q = np.geomspace(1e5, 1e8, 50)
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1e-5)], base=fp.RigidBase())
    >>> full = fp.full_contact(gel, (q, 1e-29 * (q / 1e6) ** -3.6))
    >>> print(f"{full.rms_pressure:.3g} Pa, {full.energy:.3g} J/m^2")
    17.2 Pa, 2.81e-08 J/m^2
    """
    kernel = compliance(medium, membrane=True)
    if isinstance(spectrum, Topography):
        return _of_surface(kernel, spectrum)
    if not follows(spectrum, tuple) or len(spectrum) != 2:
        raise TypeError(
            f"spectrum = {shown(spectrum)} must be a Topography, or the pair (wavenumbers, power spectral density)."
        )
    q = values("spectrum wavenumbers", spectrum[0], strict=True, unit="1/m")
    density = values("spectrum density", spectrum[1], unit="m**4", smallest=0.0)
    if q.size != density.size or q.size < 2 or (np.diff(q) <= 0).any():
        raise ValueError(
            f"spectrum has {q.size} wavenumbers and {density.size} densities; it must have equally many, two or more, the "
            "wavenumbers ascending."
        )
    nodes, weights = gauss()
    logarithm = np.log(q)
    half = np.diff(logarithm)[:, None] / 2
    at = (logarithm[:-1, None] + half * (nodes + 1)).ravel()
    known = np.log(np.maximum(density, np.finfo(float).tiny))
    k = np.exp(at)
    # (1/2 pi) C q dq = (1/2 pi) C q^2 d ln q
    return _summed(kernel, k, np.exp(np.interp(at, logarithm, known)) * k**2 * (half * weights).ravel() / (2 * np.pi))


def _of_surface(kernel: Kernel, rough: Topography) -> FullContact:
    if not all(rough.periodic):
        raise ValueError(
            "spectrum is a Topography that ends, whose waves do not fit on it. Make it periodic, or give a power spectral "
            "density (SurfaceTopography computes one)."
        )
    (ny, nx), spacing = rough.shape, rough.spacing
    k = 2 * np.pi * np.hypot(scipy.fft.fftfreq(ny, spacing)[:, None], scipy.fft.rfftfreq(nx, spacing))
    power = np.abs(scipy.fft.rfft2(rough.heights) / (ny * nx)) ** 2
    # waves of negative kx are not kept
    power[:, 1 : (nx + 1) // 2] *= 2
    return _summed(kernel, k.ravel()[1:], power.ravel()[1:])


def _summed(kernel: Kernel, k: Array, power: Array) -> FullContact:
    """Sums over waves with mean squares `power` [m^2]."""
    softness = kernel(k)
    return FullContact(
        rms_pressure=float(np.sqrt(np.sum(power / softness**2))),
        energy=float(np.sum(power / softness)) / 2,
        rms_height=float(np.sqrt(np.sum(power))),
        rms_slope=float(np.sqrt(np.sum(power * k**2))),
    )


def rough_theories(contact: xr.Dataset, medium: Body, topography: Topography) -> xr.Dataset:
    """What theories say of a solved rough contact, at its pressures and gaps.

    Parameters
    ----------
    contact : xarray.Dataset
        What `rough_contact` returned.
    medium, topography
        What it was solved for; the surface repeats in both directions.

    Returns
    -------
    xarray.Dataset
        Along `step`: mean_pressure [Pa], area_fraction (the numerical one, corrected), and the shares of the area in contact by
        theory: persson; greenwood_williamson, at the same pressure, with the mean radius of the summits; bearing_area, the share
        of the surface above the mean gap. Also greenwood_williamson_gap [m].

    See Also
    --------
    full_contact : The variance of Persson's theory.
    plot_rough : The picture.

    References
    ----------
    J. A. Greenwood, J. B. P. Williamson, Proc. R. Soc. A 295, 300 (1966).

    Examples
    --------
    >>> rough = fp.self_affine(64, 10e-9, rms_slope=0.1, cut_off=80e-9)
    >>> steel = fp.HalfSpace(young=210e9, poisson=0.3)
    >>> theories = fp.rough_theories(fp.rough_contact(steel, rough, pressure=1e9), steel, rough)
    >>> print([f"{100 * float(theories[name][0]):.0f} %" for name in ("area_fraction", "persson", "bearing_area")])
    ['9 %', '7 %', '14 %']
    """
    if not {"mean_pressure", "mean_gap", "area_fraction_corrected"} <= set(getattr(contact, "variables", ())):
        raise TypeError(f"contact = {shown(contact)} must be a result of rough_contact.")
    instance("topography", topography, (Topography,), "a Topography")
    full = full_contact(medium, topography)
    pressure, gap = contact["mean_pressure"].values, contact["mean_gap"].values
    ordered = np.sort(topography.heights.ravel()) - topography.heights.mean()
    asperities = _greenwood_williamson(medium, topography, pressure)
    shares = {
        "area_fraction": (contact["area_fraction_corrected"].values, "numerical share of the area in contact"),
        "persson": (full.area_fraction(pressure), "Persson's share of the area in contact"),
        "greenwood_williamson": (asperities[0], "Greenwood and Williamson's share of the area in contact"),
        "bearing_area": (1 - np.searchsorted(ordered, gap) / ordered.size, "share of the surface above the mean gap"),
    }
    data: dict[str, Column] = {
        "mean_pressure": ("step", pressure, {"units": "Pa", "long_name": "force over nominal area"}),
        **{name: ("step", share, {"units": "1", "long_name": words}) for name, (share, words) in shares.items()},
        "greenwood_williamson_gap": (
            "step",
            asperities[1],
            {"units": "m", "long_name": "Greenwood and Williamson's gap"},
        ),
    }
    coordinates = {"step": (contact["step"].values, {"long_name": "step of the curve"})}
    return dataset(data, coordinates, {"title": "Theories of rough contact", "rms_pressure": full.rms_pressure})


def _greenwood_williamson(medium: Body, rough: Topography, pressure: Array) -> tuple[Array, Array]:
    """Share of the area, and distance of the mean planes [m], of summits that carry the pressures without feeling each other."""
    summits = rough.summits()
    if not summits.heights.size:
        return np.full(pressure.size, np.nan), np.full(pressure.size, np.nan)
    radius = 1 / float(np.mean(np.sqrt(summits.curvatures.prod(axis=1))))
    top = float(summits.heights.max())
    # force and area over the depth of one summit, as powers between points of one curve
    depth = np.ptp(rough.heights) * np.geomspace(1e-6, 4.0, 200)
    one = indent(medium, Paraboloid(radius), depth=depth)
    laws = [np.log(one[name].values) for name in ("force", "area")]

    def summed(gap: float, law: Array) -> float:
        deep = summits.heights[summits.heights > gap] - gap
        return float(np.exp(np.interp(np.log(np.maximum(deep, depth[0])), np.log(depth), law)).sum()) / rough.area

    found = np.zeros((2, pressure.size))
    for i, wanted in enumerate(pressure):
        if wanted == 0:
            found[:, i] = 0.0, top
            continue
        low = top - depth[-1]
        if summed(low, laws[0]) < wanted:
            found[:, i] = np.nan
            continue
        gap = float(brentq(lambda gap, wanted=wanted: summed(gap, laws[0]) - wanted, low, top, xtol=1e-9 * depth[-1]))
        found[:, i] = min(summed(gap, laws[1]), 1.0), gap
    return found[0], found[1]
