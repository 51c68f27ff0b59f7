"""What a stack of layers is at each depth: the layer, its elastic constants and the rates at which load waves decay there."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, Indices
from flatpunch.compliance.layered import shear_modulus
from flatpunch.compliance.transverse import Solid
from flatpunch.media import (
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
from flatpunch.media.transverse import plane_of

Side = Literal["above", "below"]


Body = ElasticBase | Medium
"""Bodies whose fields are found by two sweeps."""


class PlaneAt(NamedTuple):
    """Plane-strain coefficients at points; see `media.transverse.Plane`."""

    coupling: Array
    shear: Array
    oedometric: Array
    stiffness: Array
    across: Array

    @classmethod
    def isotropic(cls, mu: Array, nu: Array) -> PlaneAt:
        """Coefficients of isotropic material."""
        return cls(nu / (1 - nu), 1 / mu, (1 - 2 * nu) / (2 * mu * (1 - nu)), 2 * mu / (1 - nu), mu)


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


def plane_at(medium: Body, z: Array, layer: Indices) -> PlaneAt:
    """Plane-strain coefficients at depths z of the given layers, arrays of shape (nz,) [Pa]; NaN in a rigid base."""
    found = np.full((len(PlaneAt._fields), z.size), np.nan)
    tops = np.concatenate([[0.0], interfaces(medium)])
    for i in np.unique(layer):
        here = layer == i
        body = _body_of(medium, int(i))
        if isinstance(body, (TransverselyIsotropicLayer, TransverselyIsotropicHalfSpace)):
            found[:, here] = np.array(plane_of(body))[:, None]
        elif isinstance(body, GradedLayer):
            own = np.clip(z[here] - tops[i], 0.0, body.thickness)
            nu = body.poisson_at(own)
            found[:, here] = PlaneAt.isotropic(body.young_at(own) / (2 * (1 + nu)), nu)
        elif isinstance(body, (Layer, HalfSpace)):
            count = int(here.sum())
            found[:, here] = PlaneAt.isotropic(np.full(count, shear_modulus(body)), np.full(count, body.poisson))
    return PlaneAt(*found)


def _body_of(medium: Body, i: int) -> object:
    """Layer i from the surface down; the base comes last."""
    if not isinstance(medium, Medium):
        return medium
    return medium.layers[i] if i < len(medium.layers) else medium.base


def attenuation(medium: Body | PowerLawHalfSpace, z: Array) -> Array:
    """Depths over which load waves decay as exp(-k depth) at least [m]: z itself, but of anisotropic layers a multiple.

    The fields of a wave decay at the slower rate of each transversely isotropic layer.
    """
    faces = np.concatenate([[0.0], interfaces(medium), [np.inf]])
    found = z.copy()
    for i, solid in _anisotropic(medium):
        found += (solid.slowest - 1) * (np.clip(z, faces[i], faces[i + 1]) - faces[i])
    return found


def fastest_rate(medium: Body | PowerLawHalfSpace, layer: int) -> float:
    """Larger rate of decay of load waves in a layer: 1 where it is isotropic."""
    return max([1.0, *(solid.fastest for i, solid in _anisotropic(medium) if i == layer)])


def _anisotropic(medium: Body | PowerLawHalfSpace) -> list[tuple[int, Solid]]:
    """The transversely isotropic layers, and the base after them."""
    bodies = (*medium.layers, medium.base) if isinstance(medium, Medium) else (medium,)
    return [
        (i, Solid.of(body, body.shear))
        for i, body in enumerate(bodies)
        if isinstance(body, (TransverselyIsotropicLayer, TransverselyIsotropicHalfSpace))
    ]
