"""Derivatives of the surface compliance by the elastic constants and thicknesses of one body, all of them from one solution.

Under a unit load wave the sagittal state y = (k u, s) = (k u_l, k u_z, s_lz, s_zz) obeys y' = k A y (see `depth`), A depends on
the constants, and J A is symmetric, J = [[0, -1], [1, 0]]. A change of A changes the compliance by

    k dC = k int y.J dA y dz,

so no second solution is needed. The eigenvalues of an isotropic A are +-1 (double) whatever the constants, hence
dA = A G - G A with a matrix G of the material alone, y.J dA y is a total derivative, and a homogeneous layer contributes the
difference of y.J G y between its faces. For dA = dA/dln(mu) this is s.ku, twice the energy. A layer that is thicker by dh adds
k y.J A y dh. In graded layers the integrand is kept at Gauss points in depth: it is the derivative by the constants at that
depth. In transversely isotropic layers the constants change the eigenvalues, and the integral is the sum over such points; of
such a base it is t.dH t, t the tractions.

See (T15.2) to (T15.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.compliance.depth import waves_at
from flatpunch.compliance.layered import sagittal_system, shear_modulus
from flatpunch.compliance.stack import Body, plane_at
from flatpunch.compliance.transverse import Solid
from flatpunch.media import (
    AnyLayer,
    ElasticBase,
    GradedLayer,
    HalfSpace,
    Interface,
    Layer,
    Medium,
    RigidBase,
    TransverselyIsotropicHalfSpace,
    TransverselyIsotropicLayer,
)
from flatpunch.media.transverse import Plane, exponent_slopes, exponents, plane_of, plane_slopes
from flatpunch.numerics.gauss import gauss


@dataclass(frozen=True, slots=True)
class PartDerivatives:
    """Derivatives of C(k) by the constants of one layer or of the base.

    Attributes
    ----------
    depths : ndarray, shape (nz,)
        Depths below the layer's top at which its constants count [m]: Gauss points of a graded layer, else the top alone.
    constants : dict of str to ndarray, shape (nz, nk)
        Change of C(k) by each elastic constant, the others fixed, at each depth: "young" and "poisson" of isotropic parts
        [m/Pa^2], [m/Pa]; "normal spring" and "shear spring" of the lower face.
    thickness : ndarray, shape (nk,)
        Derivative by the thickness, what lies below moving down [1/Pa]; zero for a base.
    """

    depths: Array
    constants: dict[str, Array]
    thickness: Array


def compliance_derivatives(body: Body, k: Array) -> list[PartDerivatives]:
    """Derivatives of C(k) by all constants of a body: its layers from the surface down, then the base if it is elastic."""
    layers = body.layers if isinstance(body, Medium) else ()
    base = body.base if isinstance(body, Medium) else body
    rules, tops = [], np.cumsum([0.0, *(layer.thickness for layer in layers)])
    z, owner = [], []
    for i, layer in enumerate(layers):
        own, weight = _depth_rule(layer, float(k.max()))
        rules.append((own, weight))
        z.append(tops[i] + own)
        owner += [i] * own.size
    if not isinstance(base, RigidBase):
        z.append(tops[-1:])
        owner.append(len(layers))
    waves = waves_at(body, k, np.concatenate(z), np.array(owner), shear=False).normal[:4]
    found, start = [], 0
    for layer, (own, weight) in zip(layers, rules, strict=True):
        here = waves[..., start : start + own.size]
        if isinstance(layer, GradedLayer):
            found.append(_of_graded(layer, own, weight, here, k))
        else:
            found.append(_of_layer(layer, here, k) if isinstance(layer, Layer) else _of_sheet(layer, weight, here))
        start += own.size
    for part, layer, end in zip(found, layers, np.cumsum([own.size for own, _ in rules]), strict=True):
        if isinstance(layer.bonded, Interface):
            part.constants.update(_of_springs(layer.bonded, waves[2:, :, end - 1]))
    if not isinstance(base, RigidBase):
        found.append(_of_base(base, waves[..., -1], k))
    return found


def energy_density(body: Body, k: Array, z: Array, layer: Indices) -> Array:
    """Energy density of the unit load wave, -dC/dln E(z) per length: shape (nk, nz) [1/Pa].

    It is s.A12 s + ku.A21 ku, a sum of squares whose integral over all depths is C(k).
    """
    u_l, _, s_lz, s_zz = waves_at(body, k, z, layer, shear=False).normal[:4]
    plane = plane_at(body, z, layer)
    return np.asarray(plane.shear * s_lz**2 + plane.oedometric * s_zz**2 + plane.stiffness * u_l**2)


def _depth_rule(layer: AnyLayer, largest: float) -> tuple[Array, Array]:
    """Depths in a layer at which states are wanted, and weights: both faces, or a Gauss rule that resolves every wave."""
    if isinstance(layer, Layer):
        return np.array([0.0, layer.thickness]), np.zeros(2)
    h = layer.thickness
    fastest = Solid(plane_of(layer)).fastest if isinstance(layer, TransverselyIsotropicLayer) else 1.0
    octaves = h / 2.0 ** np.arange(max(1, int(np.ceil(np.log2(4 * largest * fastest * h))) + 1))
    # eight panels at least, as the law varies over the thickness; fields of two rates are steep at the lower face as well
    inner = layer.breaks if isinstance(layer, GradedLayer) else h - octaves
    edges = np.unique(np.concatenate([[0.0], octaves, np.linspace(0, h, 9), inner]))
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-9 * h])]
    edges[-1] = h
    # Gauss points on an octave of depth in a graded layer
    x, w = gauss(12)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    # the last depth is the lower face, where the thickness counts
    return np.append(middle + half * x, h), np.append(half * w, 0.0)


def _of_layer(layer: Layer, states: Array, k: Array) -> PartDerivatives:
    above, below = (_of_face(layer, states[..., i], k) for i in (0, 1))
    constants = {name: (above[name] - below[name])[None] for name in above}
    system = sagittal_system(shear_modulus(layer), layer.poisson)
    return PartDerivatives(np.zeros(1), constants, _form(_turned(system), states[..., 0]))


def _of_sheet(layer: TransverselyIsotropicLayer, weights: Array, states: Array) -> PartDerivatives:
    constants = {
        name: np.einsum("inz,ij,jnz,z->n", states, _turned(_matrix(change)), states, weights, optimize=True)[None]
        for name, change in plane_slopes(layer).items()
    }
    return PartDerivatives(np.zeros(1), constants, _form(_turned(Solid(plane_of(layer)).system), states[..., -1]))


def _of_springs(springs: Interface, traction: Array) -> dict[str, Array]:
    """dC = s^2 d(1/stiffness) for the tractions (2, nk) at the interface."""
    stiffness = {"shear spring": springs.shear, "normal spring": springs.normal}
    return {
        name: -((s / value) ** 2)[None] for s, (name, value) in zip(traction, stiffness.items(), strict=True) if value
    }


def _of_base(base: ElasticBase, state: Array, k: Array) -> PartDerivatives:
    if isinstance(base, HalfSpace):
        constants = {name: face[None] for name, face in _of_face(base, state, k).items()}
    else:
        constants = {
            name: -np.einsum("ik,ij,jk->k", state[2:], change, state[2:])[None] / k
            for name, change in _flexibility_slopes(base).items()
        }
    return PartDerivatives(np.zeros(1), constants, np.zeros(k.size))


def _flexibility_slopes(base: TransverselyIsotropicHalfSpace) -> dict[str, Array]:
    """Derivatives of the flexibility H = [[-s, d - q], [d - q, -s d]]/M by each constant."""
    plane = plane_of(base)
    s, d = exponents(plane)
    flexibility, found = Solid(plane).flexibility, {}
    for name, change in plane_slopes(base).items():
        of_s, of_d = exponent_slopes(plane, change)
        mixed = of_d - change.coupling
        part = np.array([[-of_s, mixed], [mixed, -of_s * d - s * of_d]]) / plane.stiffness
        found[name] = part - flexibility * (change.stiffness / plane.stiffness)
    return found


def _matrix(change: Plane) -> Array:
    """Change of A for a change of its coefficients."""
    return np.asarray(Solid(change).system - Solid(Plane(0.0, 0.0, 0.0, 0.0, 0.0)).system)


def _of_graded(layer: GradedLayer, depths: Array, weights: Array, states: Array, k: Array) -> PartDerivatives:
    young, nu = layer.young_at(depths), layer.poisson_at(depths)
    by_young, by_poisson = np.empty((2, depths.size - 1, k.size))
    for j in range(depths.size - 1):
        of_modulus, of_poisson = _slopes(young[j], nu[j])
        by_young[j] = weights[j] * _form(_turned(of_modulus), states[..., j])
        by_poisson[j] = weights[j] * _form(_turned(of_poisson), states[..., j])
    system = sagittal_system(young[-1] / (2 * (1 + nu[-1])), nu[-1])
    constants = {"young": by_young, "poisson": by_poisson}
    return PartDerivatives(depths[:-1], constants, _form(_turned(system), states[..., -1]))


def _of_face(body: Layer | HalfSpace, state: Array, k: Array) -> dict[str, Array]:
    """y.J G y/k for a change of E and of nu: what a face contributes."""
    mu = shear_modulus(body)
    system = sagittal_system(mu, body.poisson)
    # A G - G A = dA: one of its solutions, all of which give the same difference between the faces
    commutator = np.kron(system, np.eye(4)) - np.kron(np.eye(4), system.T)
    unit = np.array([1.0, 1.0, mu, mu])
    scale = np.outer(unit, 1 / unit).ravel()
    found = {}
    for name, change in zip(("young", "poisson"), _slopes(body.young, body.poisson), strict=True):
        balanced = commutator * scale[None, :] / scale[:, None]
        generator = np.linalg.lstsq(balanced, change.ravel() / scale, rcond=1e-10)[0]
        found[name] = _form(_turned(np.asarray(generator * scale).reshape(4, 4)), state) / k
    return found


def _slopes(young: float, nu: float) -> tuple[Array, Array]:
    """Derivatives of the matrix A by E at fixed nu, and by nu at fixed E."""
    mu = young / (2 * (1 + nu))
    by_young, by_poisson = np.zeros((2, 4, 4))
    by_young[0, 2] = -1 / (mu * young)
    by_young[1, 3] = -(1 - 2 * nu) / (2 * mu * (1 - nu) * young)
    by_young[2, 0] = 2 * mu / ((1 - nu) * young)
    # notation: A12 = diag(2 (1 + nu), (1 + nu)(1 - 2 nu)/(1 - nu))/E, A21 = E/(1 - nu^2)
    by_poisson[0, 2] = 2 / young
    by_poisson[1, 0] = -1 / (1 - nu) ** 2
    by_poisson[1, 3] = 2 * nu * (nu - 2) / ((1 - nu) ** 2 * young)
    by_poisson[2, 0] = 2 * nu * young / (1 - nu * nu) ** 2
    by_poisson[2, 3] = 1 / (1 - nu) ** 2
    return by_young, by_poisson


def _turned(matrix: Array) -> Array:
    """J times a matrix."""
    return np.concatenate([-matrix[2:], matrix[:2]])


def _form(matrix: Array, states: Array) -> Array:
    """y.M y of states (4, nk)."""
    return np.asarray(np.sum(states * (matrix @ states), axis=0))
