"""Stresses under growing round contacts at fixed depths: the waves at depth are computed once for many contacts.

The amplitudes of load waves at depth belong to the body alone. On one set of wavenumbers, fine enough for the largest contact,
all depths of all layers take one sweep; a contact then costs its transform and one product of matrices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.checks import Array, Flags, Indices
from flatpunch.compliances.stack import attenuation, interfaces
from flatpunch.media import Stack
from flatpunch.stresses.axisymmetric.panels import REACH, SHORTEST, RoundLoad
from flatpunch.stresses.axisymmetric.radial import (
    NORMAL_ORDERS,
    NORMAL_POWERS,
    SHEAR_POWERS,
    orders,
    surface_part,
    under_pressure,
    under_traction,
)
from flatpunch.stresses.axisymmetric.round_load import FADING, amplitudes, bessel_functions, wavenumbers


@dataclass(frozen=True, slots=True)
class Section:
    """Waves at given depths of one body.

    Attributes
    ----------
    body : HalfSpace, Medium or PowerLawHalfSpace
        The body.
    depth : ndarray, shape (nz,)
        Depths [m].
    split : ndarray of bool, shape (nz,)
        Whether the part of the surface's half-space is taken in closed form there.
    k, weight : ndarray, shape (nk,)
        Wavenumbers [1/m] and weights of the integrals.
    waves : ndarray, shape (functions, nk, nz)
        Amplitudes under unit load waves, without that part; 6 functions, 15 with friction.
    """

    body: Stack
    depth: Array
    split: Flags
    k: Array
    weight: Array
    waves: Array

    @classmethod
    def of(
        cls,
        body: Stack,
        depth: Array,
        layer: Indices,
        radius: tuple[float, float],
        extent: float,
        *,
        shear: bool,
        reach: float,
    ) -> Section:
        """Waves for contacts whose radii are within a range, at points up to `extent` from all of the contact [m].

        `reach` is the wavenumber times the decay length at which the integrals end.
        """
        if not body.layers and not body.power_law:
            nothing, waves = np.zeros(0), np.zeros((len(orders(shear)), 0, depth.size))
            return cls(body, depth, np.ones(depth.size, dtype=bool), nothing, nothing, waves)
        varies = body.parts[0].varies
        top = layer == 0
        decay = attenuation(body, depth).copy()
        if not varies:
            decay[top] = 2 * float(attenuation(body, interfaces(body)[:1])[0]) - decay[top]
        shortest = float(decay.min())
        if varies:
            shortest = max(shortest, SHORTEST * radius[0] * REACH / reach)
        # largest wavenumber times the extent of the points: shorter waves fade out, which blurs 1/500 of the radius beside the
        # rim
        last = min(reach / shortest, 3e4 / extent)
        longest = max(body.thickness, radius[1])
        k, weight = wavenumbers(last, extent, longest)
        if varies or last * shortest < reach:
            weight = weight * scipy.special.erfc((k / last - FADING[0]) / FADING[1]) / 2
        waves = amplitudes(body, k, depth, layer, shear)
        if top.any():
            waves[..., top] -= surface_part(body).amplitudes(k, depth[top], shear)
        return cls(body, depth, top, k, weight, waves)

    def stress(self, load: RoundLoad, r: Array, theta: Array, traction: float) -> Array:
        """Stresses (xx, yy, zz, yz, xz, xy) at radii [m], polar angles to the sliding and all depths, (6, nr, ntheta, nz)."""
        which, pressed = orders(len(self.waves) > len(NORMAL_ORDERS)), len(NORMAL_ORDERS)
        functions = np.zeros((len(self.waves), r.size, self.depth.size))
        if self.k.size:
            weight = self.weight * self.k * load.transform(self.k)
            bessel = [each * weight for each in bessel_functions(np.outer(r, self.k), max(which) + 1)]
            # displacements are left out
            for row, (order, power) in enumerate(zip(which, NORMAL_POWERS + SHEAR_POWERS, strict=False)):
                if power:
                    functions[row] = bessel[order] @ self.waves[row]
        if self.split.any():
            at_r, at_z = (each.ravel() for each in np.meshgrid(r, self.depth[self.split], indexing="ij"))
            closed = surface_part(self.body).of_load(load, at_r, at_z, len(which) > pressed)
            functions[..., self.split] += closed.reshape(len(closed), r.size, -1)
        found = np.repeat(functions[:, :, None], theta.size, axis=2).reshape(len(functions), -1)
        angles = np.broadcast_to(theta[:, None], (r.size, theta.size, self.depth.size)).ravel()
        components = under_pressure(found[:pressed], angles)
        if len(which) > pressed:
            components += under_traction(traction * found[pressed:], angles)
        return components[:6].reshape(-1, r.size, theta.size, self.depth.size)
