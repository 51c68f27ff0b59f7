"""What a stack of layers is at each depth: the layer, its elastic constants and the rates at which load waves decay there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch.media import (
    AnyLayer,
    ElasticBase,
    GradedLayer,
    HalfSpace,
    Layer,
    Medium,
    PowerLawHalfSpace,
    RigidBase,
    TransverselyIsotropicHalfSpace,
    TransverselyIsotropicLayer,
)
from flatpunch.media.transverse import Plane, isotropic_plane, plane_of, rates_of

Side = Literal["above", "below"]


Body = ElasticBase | Medium
"""Bodies whose fields are found by two sweeps."""

Homogeneous = Layer | TransverselyIsotropicLayer | ElasticBase


def interfaces(medium: Body | PowerLawHalfSpace) -> Array:
    """Depths of the lower faces of all layers [m], shape (layers,)."""
    layers = medium.layers if isinstance(medium, Medium) else ()
    return np.cumsum([each.thickness for each in layers]) if layers else np.zeros(0)


def layer_at(body: Body | PowerLawHalfSpace, depth: Array, side: Side) -> Indices:
    """Layer of each depth; at an interface the one on that side."""
    faces = interfaces(body)
    slack = ROUNDING * faces * (1 if side == "above" else -1)
    layer = np.searchsorted(faces + slack, depth, side="right")
    if isinstance(body, Medium) and isinstance(body.base, RigidBase):
        # a rigid base has no stresses: its surface shows those of the layer on it
        layer = np.minimum(layer, len(body.layers) - 1)
    return np.asarray(layer)


def plane_at(medium: Body, z: Array, layer: Indices) -> Plane[Array]:
    """Plane-strain coefficients at depths z of the given layers, arrays of shape (nz,) [Pa]; NaN in a rigid base."""
    found = np.full((len(Plane._fields), z.size), np.nan)
    tops = np.concatenate([[0.0], interfaces(medium)])
    for i in np.unique(layer):
        here = layer == i
        body = _bodies(medium)[i]
        if isinstance(body, GradedLayer):
            found[:, here] = body.plane_at(np.clip(z[here] - tops[i], 0.0, body.thickness))
        elif isinstance(body, Homogeneous):
            found[:, here] = np.array(material(body))[:, None]
    return Plane(*found)


def material(body: Homogeneous) -> Plane[float]:
    """Plane-strain coefficients of a homogeneous layer or base [Pa]."""
    if isinstance(body, (Layer, HalfSpace)):
        return isotropic_plane(body.young, body.poisson)
    return plane_of(body)


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
    def of(cls, body: object) -> Decay:
        """Rates of a body."""
        if isinstance(body, GradedLayer) and body.anisotropic:
            depths = body.sampled_depths
            slow, fast = rates_of(body.plane_at(depths))
            return cls(depths, slow, fast, scipy.integrate.cumulative_trapezoid(slow, depths, initial=0.0))
        ones, depths = np.ones(2), np.array([0.0, body.thickness if isinstance(body, AnyLayer) else np.inf])
        slow, fast = ones, ones
        if isinstance(body, (TransverselyIsotropicLayer, TransverselyIsotropicHalfSpace)):
            slow, fast = rates_of(Plane(*(each * ones for each in plane_of(body))))
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


def attenuation(medium: Body | PowerLawHalfSpace, z: Array) -> Array:
    """Depths over which load waves decay as exp(-k depth) at least [m]: z itself, but of anisotropic layers a multiple.

    The fields of a wave decay at the slower rate of each transversely isotropic layer, and in the top layer those of the
    half-space of its surface, which are split off there, at that of the surface.
    """
    faces = np.concatenate([[0.0], interfaces(medium), [np.inf]])
    found = z.copy()
    for i, body in enumerate(_bodies(medium)):
        if not _anisotropic(body):
            continue
        own, decay = np.clip(z, faces[i], faces[i + 1]) - faces[i], Decay.of(body)
        reached = decay.down_to(own)
        if i == 0:
            reached = np.where(z <= faces[1], np.minimum(reached, decay.slow[0] * own), reached)
        found += reached - own
    return found


def fastest_rate(medium: Body | PowerLawHalfSpace, layer: int) -> float:
    """Larger rate of decay of load waves in a layer: 1 where it is isotropic."""
    return max(1.0, float(Decay.of(_bodies(medium)[layer]).fast.max()))


def _anisotropic(body: object) -> bool:
    if isinstance(body, GradedLayer):
        return body.anisotropic
    return isinstance(body, (TransverselyIsotropicLayer, TransverselyIsotropicHalfSpace))


def _bodies(medium: Body | PowerLawHalfSpace) -> tuple[object, ...]:
    """The layers, and the base after them."""
    return (*medium.layers, medium.base) if isinstance(medium, Medium) else (medium,)
