"""The response of a surface to tractions of all directions, and the mean displacement along x as a kernel: medium -> C_T(k).

With l along the wave and t across it, u = C t has C = [[a, 0, i d], [0, c, 0], [-i d, 0, n]]: four functions of the wavenumber.

A round traction tau(r) along x moves the surface along x by u_0(r) + u_2(r) cos 2 phi, with Hankel transforms of orders 0 and 2,

    u_0 = H_0[C_T tau^],    C_T = (C_ll + C_tt)/2,        u_2 = H_2[(C_ll - C_tt)/2 tau^],

C_ll and C_tt the compliances along the wave and across it. With C_T = rho C at short waves, C that under pressure, C_T/rho is
the compliance of a normal contact with the same modulus at the surface. Where u_0 is constant, the part of (C_ll - C_tt)/2 in
proportion to C_T leaves no u_2 (theory page 18), so that only the difference to it counts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.compliances.interpolant import Combined, Interpolant, interpolate
from flatpunch.compliances.kernel import Kernel, compliance
from flatpunch.compliances.layered import SATURATION
from flatpunch.compliances.power_law import power_law_waves
from flatpunch.compliances.response import surface_flexibility
from flatpunch.media import Body, underlying
from flatpunch.media.material import PowerLaw


class Radial(NamedTuple):
    """Entries n, a, c and d at wavenumbers [m/Pa], or their inverses [Pa/m]."""

    normal: Array
    along: Array
    across: Array
    coupling: Array


def radial_compliance(body: Body, k: Array) -> Radial:
    """The four functions at wavenumbers k > 0, shape (n,) each."""
    stack = body.single
    if not stack:
        return _of_pair(body, k)
    if law := stack.power_law:
        return _of_power_law(stack, law, k)
    along, across = surface_flexibility(stack, k)
    return Radial(-along[1, 1] / k, -along[0, 0] / k, -across / k, along[0, 1] / k)


def _of_pair(pair: Body, k: Array) -> Radial:
    total = Radial(*np.zeros((4, k.size)))
    for name, body in reversed(pair.sides):
        sign = -1 if name == "upper" else 1
        if not body.rigid:
            n, a, c, d = radial_compliance(body, k)
            # the upper body's z runs the other way, which turns the sign of the coupling
            total = Radial(total.normal + n, total.along + a, total.across + c, total.coupling + sign * d)
    return total


def _of_power_law(body: Body, law: PowerLaw, k: Array) -> Radial:
    if law.exponent >= 1:
        raise ValueError(
            f"medium has a modulus that vanishes at the surface like z^{law.exponent:g}: under shear tractions its displacement "
            "is infinite. `normal_compliance` exists."
        )
    with np.errstate(all="ignore"):  # stresses along the surface may be infinite; displacements are not
        waves = power_law_waves(law, k, np.zeros(1))
    normal, shear, across = (each[..., 0] for each in (waves.normal, waves.shear, waves.transverse))
    return Radial(np.asarray(compliance(body)(k)), -shear[0] / k, -across[0] / k, -normal[0] / k)


@dataclass(frozen=True, eq=False)
class TangentialResponse:
    """Mean response of a body to round tractions along the surface.

    Attributes
    ----------
    ratio : float
        rho = C_T/C at short waves [-]: (2 - nu)/(2 (1 - nu)) under an isotropic surface.
    kernel : Kernel
        C_T/rho. It is the kernel of the normal contact where their ratio is the same at all waves.
    turned : float
        (C_ll - C_tt)/(C_ll + C_tt) at short waves [-]: -nu/(2 - nu) under an isotropic surface.
    doubled : callable
        kappa = k l, shape (n,) -> E* k/2 times (C_ll - C_tt)/2 - turned C_T, over rho [-].
    """

    ratio: float
    kernel: Kernel
    turned: float
    doubled: Callable[[Array], Array] = np.zeros_like


@byte_cached
def tangential_response(medium: Body) -> TangentialResponse:
    """Response of a body; ValueError where nothing holds its surface."""
    body = underlying(medium)
    check_held(body)
    kernel = replace(compliance(body), solution=None)
    if kernel.homogeneous or kernel.exponent:
        k = np.ones(1) / (1.0 if kernel.homogeneous else kernel.length)
        waves = radial_compliance(body, k)
        along, across = float((waves.along / kernel(k))[0]), float((waves.across / kernel(k))[0])
        return TangentialResponse((along + across) / 2, kernel, (along - across) / (along + across))
    graded = any(part.layers and part.layers[0].varies for part in body.elastic)
    # the modulus at the surface: a wave this short feels nothing else, of graded ones to rounding
    short = np.array([1e12 if graded else _last(body, kernel)])
    surface = _scaled(body, kernel, short)[:, 0]
    start, power = min(kernel.floor, 0.1), int(all(part.base.rigid for part in body.elastic))

    def interpolated(direction: int) -> Interpolant:
        def response(kappa: Array) -> Array:
            return np.asarray(_scaled(body, kernel, kappa)[direction] / surface[direction])

        return interpolate(response, start, power, vanishing=not graded, last=float(short[0]))

    parts = interpolated(0), interpolated(1)
    ratio, (along, across) = float(surface.mean()), surface / surface.sum()
    series = Combined(((along, 1.0, parts[0]), (across, 1.0, parts[1])))
    mean = replace(
        kernel,
        response=_Mean(series),
        tail=series.tail if graded else 0.0,
        cutoff=kernel.cutoff if graded else float(short[0]),
        floor=series.floor,
        series=series if graded else None,
    )
    return TangentialResponse(ratio, mean, float(along - across), _Doubled(2 * along * across, parts[0], parts[1]))


@dataclass(frozen=True, slots=True)
class _Mean:
    series: Combined

    def __call__(self, kappa: Array) -> Array:
        return 1.0 + np.asarray(self.series.derivatives(kappa, 0)[0])


@dataclass(frozen=True, slots=True)
class _Doubled:
    factor: float
    along: Interpolant
    across: Interpolant

    def __call__(self, kappa: Array) -> Array:
        return self.factor * (self.along.remainder(kappa) - self.across.remainder(kappa))


def _scaled(body: Body, kernel: Kernel, kappa: Array) -> Array:
    """E* k/2 times C_ll and C_tt, shape (2, n)."""
    k = kappa / kernel.length
    waves = radial_compliance(body, k)
    return kernel.modulus * k / 2 * np.stack([waves.along, waves.across])


def _last(body: Body, kernel: Kernel) -> float:
    """Kappa from which homogeneous surface layers hide what lies below them from tractions of all directions."""
    found = [kernel.cutoff]
    for top in (part.layers[0] for part in body.elastic if part.layers):
        plane = top.plane_at(np.zeros(1))
        # waves across decay like exp(-k z sqrt(C66/C44))
        found.append(SATURATION / float(np.sqrt(plane.across * plane.shear)[0]) * kernel.length / top.thickness)
    return max(found)


def check_held(body: Body) -> None:
    """Refuse bodies with a layer that slides without friction."""
    for part in body.elastic:
        for layer in part.layers:
            if not layer.face:
                raise ValueError(
                    "medium has a layer that slides without friction on what lies below (bonded=False): nothing holds it, so a "
                    "force along its surface moves it without limit. Give it bonded=True, or a stiffness along its face, "
                    "Interface(shear=...)."
                )
