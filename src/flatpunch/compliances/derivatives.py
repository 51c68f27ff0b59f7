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

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.compliances.depth import waves_at
from flatpunch.compliances.layered import constants_of, sagittal_system
from flatpunch.compliances.stack import Decay, interfaces, plane_at
from flatpunch.compliances.transverse import flexibility_of, system_of
from flatpunch.media import AnyLayer, Base, Interface, Material, Stack
from flatpunch.media.plane import N, Plane, exponent_slopes, exponents
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
        [m/Pa^2], [m/Pa]; those of the lower face by their path, "bonded.normal", "bonded.membrane.tension".
    thickness : ndarray, shape (nk,)
        Derivative by the thickness, what lies below moving down [1/Pa]; zero for a base.
    """

    depths: Array
    constants: dict[str, Array]
    thickness: Array


def compliance_derivatives(body: Stack, k: Array) -> list[PartDerivatives]:
    """Derivatives of C(k) by all constants of a body: its layers from the surface down, then the base if it is elastic."""
    layers, base = body.layers, body.base
    rules, tops = [], np.cumsum([0.0, *(layer.thickness for layer in layers)])
    z, owner = [], []
    for i, layer in enumerate(layers):
        own, weight = _depth_rule(layer, float(k.max()))
        rules.append((own, weight))
        z.append(tops[i] + own)
        owner += [i] * own.size
    if not base.rigid:
        z.append(tops[-1:])
        owner.append(len(layers))
    waves = waves_at(body, k, np.concatenate(z), np.array(owner), shear=False).normal[:4]
    found, start = [], 0
    for layer, (own, weight) in zip(layers, rules, strict=True):
        here = waves[..., start : start + own.size]
        if layer.varies:
            found.append(_of_graded(layer, own, weight, here))
        else:
            found.append(_of_layer(layer, here, k) if layer.isotropic else _of_sheet(layer, weight, here))
        start += own.size
    for part, layer, end in zip(found, layers, np.cumsum([own.size for own, _ in rules]), strict=True):
        part.constants.update(_of_springs(layer.face, waves[2:, :, end - 1]))
    for i, displacement in _membranes(body, k):
        found[i].constants.update(_of_membrane(displacement, k))
    if not base.rigid:
        found.append(_of_base(base, waves[..., -1], k))
    return found


def energy_density(body: Stack, k: Array, z: Array, layer: Indices) -> Array:
    """Energy density of the unit load wave, -dC/dln E(z) per length: shape (nk, nz) [1/Pa].

    It is s.A12 s + ku.A21 ku, a sum of squares whose integral over all depths is C(k).
    """
    u_l, _, s_lz, s_zz = waves_at(body, k, z, layer, shear=False).normal[:4]
    plane = plane_at(body, z, layer)
    return np.asarray(plane.shear * s_lz**2 + plane.oedometric * s_zz**2 + plane.stiffness * u_l**2)


def _depth_rule(layer: AnyLayer, largest: float) -> tuple[Array, Array]:
    """Depths in a layer at which states are wanted, and weights: both faces, or a Gauss rule that resolves every wave."""
    if layer.isotropic:
        return np.array([0.0, layer.thickness]), np.zeros(2)
    h = layer.thickness
    fastest = float(Decay.of(layer).fast.max())
    octaves = h / 2.0 ** np.arange(max(1, int(np.ceil(np.log2(4 * largest * fastest * h))) + 1))
    # fields of two rates are steep at the lower face as well
    lower = h - octaves if layer.anisotropic else octaves[:0]
    edges = np.unique(np.concatenate([[0.0], octaves, layer.breaks, lower]))
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-9 * h])]
    edges[-1] = h
    x, w = gauss()
    half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
    # the last depth is the lower face, where the thickness counts
    return np.append(middle + half * x, h), np.append(half * w, 0.0)


def _of_layer(layer: AnyLayer, states: Array, k: Array) -> PartDerivatives:
    above, below = (_of_face(layer, states[..., i], k) for i in (0, 1))
    constants = {name: (above[name] - below[name])[None] for name in above}
    system = sagittal_system(*constants_of(layer))
    return PartDerivatives(np.zeros(1), constants, _form(_turned(system), states[..., 0]))


def _of_sheet(layer: AnyLayer, weights: Array, states: Array) -> PartDerivatives:
    constants = {
        name: np.einsum("inz,ij,jnz,z->n", states, _turned(_matrix(change)), states, weights, optimize=True)[None]
        for name, change in layer.slopes_at(np.zeros(())).items()
    }
    return PartDerivatives(np.zeros(1), constants, _form(_turned(system_of(layer.plane)), states[..., -1]))


def _of_springs(springs: Interface, traction: Array) -> dict[str, Array]:
    """dC = s^2 d(1/stiffness) for the tractions (2, nk) at the interface."""
    stiffness = {"bonded.shear": springs.shear, "bonded.normal": springs.normal}
    return {
        name: -((s / value) ** 2)[None] for s, (name, value) in zip(traction, stiffness.items(), strict=True) if value
    }


def _membranes(body: Stack, k: Array) -> Iterator[tuple[int, Array]]:
    """Layers with a membrane on their lower faces, and its displacements (k u_l, k u_z): those of the face below it."""
    found = [i for i, layer in enumerate(body.layers) if layer.face.membrane]
    faces, owner = interfaces(body)[found], np.array(found, dtype=np.intp)
    moved = waves_at(body, k, faces, owner + 1, shear=False).normal[:2] if found else np.zeros((2, k.size, 0))
    yield from zip(found, np.moveaxis(moved, -1, 0), strict=True)


def _of_membrane(moved: Array, k: Array) -> dict[str, Array]:
    """dC = -u^2 d(stiffness): shear stiffness carries nothing under normal loads."""
    stretched, tilted = -(moved**2)
    slopes = {"tension": tilted, "stretching": stretched, "shear": 0 * tilted, "bending": k**2 * tilted}
    return {f"bonded.membrane.{name}": slope[None] for name, slope in slopes.items()}


def _of_base(base: Base, state: Array, k: Array) -> PartDerivatives:
    if base.isotropic:
        constants = {name: face[None] for name, face in _of_face(base, state, k).items()}
    else:
        constants = {
            name: -np.einsum("ik,ij,jk->k", state[2:], change, state[2:])[None] / k
            for name, change in _flexibility_slopes(base).items()
        }
    return PartDerivatives(np.zeros(1), constants, np.zeros(k.size))


def _flexibility_slopes(base: Base) -> dict[str, Array]:
    plane = base.plane
    s, d, _, _ = exponents(plane)
    flexibility, found = flexibility_of(plane), {}
    for name, change in base.slopes_at(np.zeros(())).items():
        of_s, of_d = exponent_slopes(plane, change)
        mixed = of_d - change.coupling
        part = np.array([[-of_s, mixed], [mixed, -of_s * d - s * of_d]]) / plane.stiffness
        found[name] = part - flexibility * (change.stiffness / plane.stiffness)
    return found


def _matrix(change: Plane[N]) -> Array:
    """Change of A for a change of its coefficients, shape (4, 4, ...)."""
    return np.asarray(system_of(change) - system_of(Plane(*(0 * each for each in change))))


def _of_graded(layer: AnyLayer, depths: Array, weights: Array, states: Array) -> PartDerivatives:
    inside = states[..., :-1]
    found = {
        kind: weights[:-1, None] * np.einsum("inz,ijz,jnz->zn", inside, _turned(_matrix(change)), inside, optimize=True)
        for kind, change in layer.slopes_at(depths[:-1]).items()
    }
    system = system_of(layer.plane_at(depths[-1]))
    return PartDerivatives(depths[:-1], found, _form(_turned(system), states[..., -1]))


def _of_face(body: Material, state: Array, k: Array) -> dict[str, Array]:
    """y.J G y/k for a change of each constant: what a face contributes."""
    mu, nu = constants_of(body)
    system = sagittal_system(mu, nu)
    # A G - G A = dA: one of its solutions, all of which give the same difference between the faces
    commutator = np.kron(system, np.eye(4)) - np.kron(np.eye(4), system.T)
    unit = np.array([1.0, 1.0, mu, mu])
    scale = np.outer(unit, 1 / unit).ravel()
    found = {}
    for name, change in body.slopes_at(np.zeros(())).items():
        balanced = commutator * scale[None, :] / scale[:, None]
        generator = np.linalg.lstsq(balanced, _matrix(change).ravel() / scale, rcond=1e-10)[0]
        found[name] = _form(_turned(np.asarray(generator * scale).reshape(4, 4)), state) / k
    return found


def _turned(matrix: Array) -> Array:
    return np.concatenate([-matrix[2:], matrix[:2]])


def _form(matrix: Array, states: Array) -> Array:
    return np.asarray(np.sum(states * (matrix @ states), axis=0))
