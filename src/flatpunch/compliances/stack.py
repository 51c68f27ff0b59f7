"""What a stack of layers is at each depth: the layer, its elastic constants and the rates at which load waves decay there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch.media import Material, Stack
from flatpunch.media.plane import Plane, rates_of

Side = Literal["above", "below"]


def interfaces(medium: Stack) -> Array:
    """Depths of the lower faces of all layers [m], shape (layers,)."""
    return np.cumsum([each.thickness for each in medium.layers]) if medium.layers else np.zeros(0)


def layer_at(body: Stack, depth: Array, side: Side) -> Indices:
    """Layer of each depth; at an interface the one on that side."""
    faces = interfaces(body)
    slack = ROUNDING * faces * (1 if side == "above" else -1)
    layer = np.searchsorted(faces + slack, depth, side="right")
    if body.base.rigid:
        # a rigid base has no stresses: its surface shows those of the layer on it
        layer = np.minimum(layer, len(body.layers) - 1)
    return np.asarray(layer)


def plane_at(medium: Stack, z: Array, layer: Indices) -> Plane[Array]:
    """Plane-strain coefficients at depths z of the given layers, arrays of shape (nz,) [Pa]; NaN in a rigid base."""
    found = np.full((len(Plane._fields), z.size), np.nan)
    tops = np.concatenate([[0.0], interfaces(medium)])
    for i in np.unique(layer):
        here = layer == i
        part = medium.parts[i]
        found[:, here] = part.plane_at(np.clip(z[here] - tops[i], 0.0, part.extent))
    return Plane(*found)


@dataclass(frozen=True, slots=True)
class Decay:
    """Rates at which load waves decay with k z in a layer or base: 1 where it is isotropic.

    Attributes
    ----------
    depths : ndarray, shape (n,)
        Depths below its top [m].
    slow, fast : ndarray, shape (n,)
        The slower rate there, and the magnitude of the faster one.
    reached : ndarray, shape (n,)
        Integral of the slower rate down to there: a wave has decayed by exp(-k reached) at least [m].
    """

    depths: Array
    slow: Array
    fast: Array
    reached: Array

    @classmethod
    def of(cls, part: Material) -> Decay:
        """Rates of a layer or base."""
        if part.anisotropic and part.varies:
            depths = part.sampled_depths
            slow, fast = rates_of(part.plane_at(depths))
            return cls(depths, slow, fast, scipy.integrate.cumulative_trapezoid(slow, depths, initial=0.0))
        depths = np.array([0.0, part.extent])
        slow = fast = np.ones(2)
        if part.anisotropic:
            slow, fast = rates_of(part.plane_at(depths))
        return cls(depths, slow, fast, slow * depths)

    def down_to(self, z: Array) -> Array:
        """Integral of the slower rate down to depths z below the top [m]."""
        if self.depths.size == 2:
            return np.asarray(self.slow[0] * z)
        return np.asarray(np.interp(z, self.depths, self.reached))

    def depth_of(self, reached: Array) -> Array:
        """Depth at which the integral has a value; the thickness where it is never reached [m]."""
        if self.depths.size == 2:
            return np.asarray(np.minimum(self.depths[1], reached / self.slow[0]))
        return np.asarray(np.interp(reached, self.reached, self.depths))


def attenuation(medium: Stack, z: Array) -> Array:
    """Depths over which load waves decay as exp(-k depth) at least [m]: z itself, but of anisotropic layers a multiple.

    The fields of a wave decay at the slower rate of each transversely isotropic layer, and in the top layer those of the
    half-space of its surface, which are split off there, at that of the surface.
    """
    faces = np.concatenate([[0.0], interfaces(medium), [np.inf]])
    found = z.copy()
    for i, part in enumerate(medium.parts):
        if not part.anisotropic:
            continue
        own, decay = np.clip(z, faces[i], faces[i + 1]) - faces[i], Decay.of(part)
        reached = decay.down_to(own)
        if i == 0:
            reached = np.where(z <= faces[1], np.minimum(reached, decay.slow[0] * own), reached)
        found += reached - own
    return found


def fastest_rate(medium: Stack, layer: int) -> float:
    """Larger rate of decay of load waves in a layer: 1 where it is isotropic."""
    return max(1.0, float(Decay.of(medium.parts[layer]).fast.max()))
