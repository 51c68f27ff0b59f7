"""Derivatives of the surface compliance by the elastic constants and thicknesses of one body, all of them from one solution.

Under a unit load wave the sagittal state y = (k u, s) = (k u_l, k u_z, s_lz, s_zz) obeys y' = k A y (see `depth`), A depends on
the constants, and J A is symmetric, J = [[0, -1], [1, 0]]. A change of A changes the compliance by

    k dC = k int y.J dA y dz,

so no second solution is needed. The eigenvalues of A are +-1 (double) whatever the constants, hence dA = A G - G A with a matrix
G of the material alone, y.J dA y is a total derivative, and a homogeneous layer contributes the difference of y.J G y between its
faces. For dA = dA/dln(mu) this is s.ku, twice the energy. A layer that is thicker by dh adds k y.J A y dh. In graded layers the
integrand is kept at Gauss points in depth: it is the derivative by the constants at that depth.

See (T15.2) to (T15.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.compliance.depth import waves_at
from flatpunch.compliance.layered import sagittal_system
from flatpunch.media import GradedLayer, HalfSpace, Layer, Medium
from flatpunch.numerics.gauss import gauss


@dataclass(frozen=True, slots=True)
class PartDerivatives:
    """Derivatives of C(k) by the constants of one layer or of the base.

    Attributes
    ----------
    depths : ndarray, shape (nz,)
        Depths below the layer's top at which its constants count [m]: Gauss points of a graded layer, else the top alone.
    young, poisson : ndarray, shape (nz, nk)
        Change of C(k) is the sum over the depths of young dE + poisson dnu, nu changed at fixed E; [m/Pa^2], [m/Pa].
    thickness : ndarray, shape (nk,)
        Derivative by the thickness, what lies below moving down [1/Pa]; zero for a base.
    """

    depths: Array
    young: Array
    poisson: Array
    thickness: Array


def compliance_derivatives(body: HalfSpace | Medium, k: Array) -> list[PartDerivatives]:
    """Derivatives of C(k) by all constants of a body.

    Parameters
    ----------
    body : HalfSpace or Medium
        The body.
    k : ndarray, shape (nk,)
        Wavenumbers [1/m], > 0.

    Returns
    -------
    list of PartDerivatives
        Layers from the surface down, then the base if it is elastic.
    """
    layers = body.layers if isinstance(body, Medium) else ()
    base = body.base if isinstance(body, Medium) else body
    rules, tops = [], np.cumsum([0.0, *(layer.thickness for layer in layers)])
    z, owner = [], []
    for i, layer in enumerate(layers):
        own, weight = _depth_rule(layer, float(k.max()))
        rules.append((own, weight))
        z.append(tops[i] + own)
        owner += [i] * own.size
    if isinstance(base, HalfSpace):
        z.append(tops[-1:])
        owner.append(len(layers))
    waves = waves_at(body, k, np.concatenate(z), np.array(owner), shear=False).normal[:4]
    found, start = [], 0
    for layer, (own, weight) in zip(layers, rules, strict=True):
        here = waves[..., start : start + own.size]
        found.append(
            _of_graded(layer, own, weight, here, k) if isinstance(layer, GradedLayer) else _of_layer(layer, here, k)
        )
        start += own.size
    if isinstance(base, HalfSpace):
        young, poisson = _of_homogeneous(base, waves[..., -1], k)
        found.append(PartDerivatives(np.zeros(1), young[None], poisson[None], np.zeros(k.size)))
    return found


def energy_density(body: HalfSpace | Medium, k: Array, z: Array, layer: Indices, mu: Array, nu: Array) -> Array:
    """Energy density of the unit load wave, -dC/dln E(z) per length: shape (nk, nz) [1/Pa].

    It is s.A12 s + ku.A21 ku, a sum of squares whose integral over all depths is C(k).
    """
    u_l, _, s_lz, s_zz = waves_at(body, k, z, layer, shear=False).normal[:4]
    return np.asarray(s_lz**2 / mu + (1 - 2 * nu) / (2 * mu * (1 - nu)) * s_zz**2 + 2 * mu / (1 - nu) * u_l**2)


def _depth_rule(layer: Layer | GradedLayer, largest: float) -> tuple[Array, Array]:
    """Depths in a layer at which states are wanted, and weights: both faces, or a Gauss rule that resolves every wave."""
    if isinstance(layer, Layer):
        return np.array([0.0, layer.thickness]), np.zeros(2)
    h = layer.thickness
    octaves = h / 2.0 ** np.arange(max(1, int(np.ceil(np.log2(4 * largest * h))) + 1))
    # eight panels at least, as the law varies over the thickness
    edges = np.unique(np.concatenate([[0.0], octaves, np.linspace(0, h, 9), layer.breaks]))
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-9 * h])]
    edges[-1] = h
    # Gauss points on an octave of depth in a graded layer
    x, w = gauss(12)
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    # the last depth is the lower face, where the thickness counts
    return np.append(middle + half * x, h), np.append(half * w, 0.0)


def _of_layer(layer: Layer, states: Array, k: Array) -> PartDerivatives:
    above, below = states[..., 0], states[..., 1]
    young, poisson = (
        top - bottom
        for top, bottom in zip(_of_homogeneous(layer, above, k), _of_homogeneous(layer, below, k), strict=True)
    )
    system = sagittal_system(layer.young / (2 * (1 + layer.poisson)), layer.poisson)
    return PartDerivatives(np.zeros(1), young[None], poisson[None], _form(_turned(system), above))


def _of_graded(layer: GradedLayer, depths: Array, weights: Array, states: Array, k: Array) -> PartDerivatives:
    young, nu = layer.young_at(depths), layer.poisson_at(depths)
    by_young, by_poisson = np.empty((2, depths.size - 1, k.size))
    for j in range(depths.size - 1):
        of_modulus, of_poisson = _slopes(young[j], nu[j])
        by_young[j] = weights[j] * _form(_turned(of_modulus), states[..., j])
        by_poisson[j] = weights[j] * _form(_turned(of_poisson), states[..., j])
    system = sagittal_system(young[-1] / (2 * (1 + nu[-1])), nu[-1])
    return PartDerivatives(depths[:-1], by_young, by_poisson, _form(_turned(system), states[..., -1]))


def _of_homogeneous(body: Layer | HalfSpace, state: Array, k: Array) -> tuple[Array, Array]:
    """y.J G y/k for a change of E and of nu: what a face contributes."""
    system = sagittal_system(body.young / (2 * (1 + body.poisson)), body.poisson)
    found = []
    for change in _slopes(body.young, body.poisson):
        # A G - G A = dA: one of its solutions, all of which give the same difference between the faces
        commutator = np.kron(system, np.eye(4)) - np.kron(np.eye(4), system.T)
        scale = _balance(body)
        generator = np.linalg.lstsq(commutator * scale[None, :] / scale[:, None], change.ravel() / scale, rcond=1e-10)[
            0
        ]
        found.append(_form(_turned((generator * scale).reshape(4, 4)), state) / k)
    return found[0], found[1]


def _balance(body: Layer | HalfSpace) -> Array:
    """Sizes of the entries of a 4 x 4 matrix between displacements and stresses, shape (16,)."""
    mu = body.young / (2 * (1 + body.poisson))
    unit = np.array([1.0, 1.0, mu, mu])
    return np.outer(unit, 1 / unit).ravel()


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
