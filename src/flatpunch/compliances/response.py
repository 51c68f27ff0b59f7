"""Flexibility and response of a stack of layers of all kinds: the one place where the way through a layer is chosen.

Along a wave the surface has the 2 x 2 matrix H of `layered` and `graded`; across it the number w = k u_t/s_tz, which obeys

    w' = k (1/C44 - C66 w^2)     over the depth,

so that a homogeneous layer carries it up as w -> (w - t/Z)/(1 - t Z w), t = tanh(k h sqrt(C66/C44)), Z^2 = C66 C44, and graded
ones by Runge-Kutta steps.

Under a uniform pressure C(0) is that of uniaxial strain on a rigid base, the sum of thickness (1 + nu)(1 - 2 nu)/((1 - nu) E),
thickness/C33 where a layer is transversely isotropic, bonded or sliding, and of 1/stiffness of interfaces with springs. It is
zero where all layers are incompressible, and infinite on an elastic base: a half-space sinks without limit.

From what lies below a face to what lies above it: a membrane on the former stiffens it, springs above the membrane yield. A
membrane with tension T, in-plane stiffness A, shear stiffness G and bending stiffness B takes tractions of its own. Those above
it are less, in tension, than those below by

    [s_lz] = A k^2 u_l,    [s_zz] = (T k^2 + B k^4) u_z,    [s_tz] = G k^2 u_t,

so that the inverse of the flexibility H grows by K = diag(A k, T k + B k^3), H -> H M with M = (1 - K H)^-1, and M are the
tractions below per those above. -H is positive, so that no denominator is below one. Springs add their own flexibility.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import scipy

from flatpunch._support.checks import Array
from flatpunch.compliances.graded import TOLERANCE, carry_through_graded
from flatpunch.compliances.layered import SATURATION, Depths, carry, half_space_flexibility, states_below
from flatpunch.compliances.transverse import Sheet, Solid
from flatpunch.media import AnyLayer, Body, Interface, Material, Membrane, Stack
from flatpunch.media.plane import Plane, contact_modulus


def yielding(face: Interface, below: Array, k: Array, scale: float) -> Array:
    """Flexibility of what lies below a layer with what its lower face adds, times `scale`; shape (2, 2, n)."""
    below = stiffened(face.membrane, below, k, scale)[0]
    along, across = face.softness
    if not across and (not along or not face):
        return below
    below = below.copy()
    if face:
        below[0, 0] -= scale * along * k
    below[1, 1] -= scale * across * k
    return below


def yielding_across(face: Interface, below: Array, k: Array, scale: float) -> Array:
    """k u_t/s_tz of what lies below a layer that sticks, with what its lower face adds, times `scale`; shape (n,)."""
    return below * passed_across(face.membrane, below, k, scale) - scale * face.softness[0] * k


def stiffened(membrane: Membrane | None, below: Array, k: Array, scale: float) -> tuple[Array, Array]:
    """Flexibility of what lies below with a membrane on it, and tractions below per those above it; shape (2, 2, n) each."""
    if not membrane:
        return below, np.broadcast_to(np.eye(2)[:, :, None], below.shape)
    a, _, n = membrane.stiffness(k) / (k * scale)
    (p, q), (_, s) = below
    passed = np.array([[1 - n * s, a * q], [n * q, 1 - a * p]]) / ((1 - a * p) * (1 - n * s) - a * n * q * q)
    return np.einsum("ijn,jkn->ikn", below, passed), passed


def passed_across(membrane: Membrane | None, below: Array, k: Array, scale: float) -> Array:
    """Traction across the wave below a membrane per that above it, shape (n,)."""
    return 1 / (1 - membrane.stiffness(k)[1] / (k * scale) * below) if membrane else np.ones_like(k)


def layered_response(medium: Stack, k: Array) -> Array:
    """Dimensionless response L(k) = E* k C(k)/2 of a stack at wavenumbers k > 0 [1/m], shape (n,).

    Of homogeneous layers the relative error is below 1e-12 for 1e-4 <= kh <= 50 (tests compare with multiprecision). A ValueError
    says that the constants of a graded layer leave their ranges between the depths at which it was checked.
    """
    top = medium.parts[0]
    response = np.ones_like(k)
    whole = top.varies or bool(medium.membrane)
    inside = np.full(k.shape, whole) if whole or not medium.layers else k * top.extent < saturation(top)
    if inside.any():
        scale = top.rigidity
        flexibility = stack_flexibility(medium, k[inside], scale)
        response[inside] = -flexibility[1, 1] * (top.surface_modulus / (2 * scale))
    return response


def saturation(top: Material) -> float:
    """k h from which a surface layer hides what lies below it."""
    return SATURATION / Solid.of(top, 1.0).slowest if top.anisotropic and not top.varies else SATURATION


def stack_flexibility(medium: Stack, k: Array, scale: float) -> Array:
    """Flexibility H of the stack at its surface, times the shear modulus `scale`; shape (2, 2, n)."""
    order = np.argsort(k)
    flexibility = np.empty((2, 2, k.size))
    flexibility[..., order] = _sorted_flexibility(medium, k[order], scale)
    return stiffened(medium.membrane, flexibility, k, scale)[0]


def _sorted_flexibility(medium: Stack, k: Array, scale: float) -> Array:
    flexibility = half_space_flexibility(medium.base, scale, k.shape)
    # depth functions of a thickness are kept until its last layer
    left = Counter(layer.thickness for layer in medium.layers if layer.isotropic)
    known: dict[float, Depths] = {}
    for layer in reversed(medium.layers):
        flexibility = yielding(layer.face, flexibility, k, scale)
        if layer.isotropic:
            depths = known.pop(layer.thickness, None) or Depths.of(k * layer.thickness)
            carry(layer, flexibility, depths, scale)
            left[layer.thickness] -= 1
            if left[layer.thickness]:
                known[layer.thickness] = depths
        elif layer.varies:
            flexibility = carry_through_graded(layer, flexibility, k, scale)
        else:
            states = states_below(bool(layer.bonded), flexibility)
            flexibility = Sheet(Solid.of(layer, scale), layer.thickness, k, states).flexibility
    return flexibility


def long_wave_power(medium: Stack) -> int:
    """p of L ~ k^p at long waves: 0 on an elastic base, 3 if all is incompressible and sticks to a rigid one, else 1."""
    if not medium.base.rigid:
        return 0
    return 3 if all(_unyielding(layer) and _incompressible(layer) for layer in medium.layers) else 1


def _unyielding(layer: AnyLayer) -> bool:
    return bool(layer.face) and layer.face.normal is None


def _incompressible(layer: AnyLayer) -> bool:
    return bool(np.all(layer.plane_at(layer.sampled_depths).oedometric == 0))


def smallest_and_largest_modulus(medium: Stack) -> tuple[float, float]:
    """Range of the plane-strain modulus over all layers, the base and the interfaces [Pa].

    Springs count as their stiffness times the thickness of all layers, membranes by the distance over which they spread a load,
    which over that thickness is the ratio of both moduli.
    """
    found = []
    for part in medium.layers:
        if part.varies:
            moduli = contact_modulus(part.plane_at(part.sampled_depths))
            found += [float(moduli.min()), float(moduli.max())]
        else:
            found.append(part.surface_modulus)
    if not medium.base.rigid:
        found.append(medium.base.surface_modulus)
    faces = [layer.face for layer in medium.layers]
    found += [medium.thickness * value for face in faces for value in (face.normal, face.shear) if value]
    least, membranes = min(found), [medium.membrane, *(face.membrane for face in faces)]
    reach = max(each.reach(least) if each else 0.0 for each in membranes)
    return least, max(*found, least * reach / (medium.thickness or reach or 1.0))


def surface_flexibility(body: Stack, k: Array) -> tuple[Array, Array]:
    """Flexibilities of the surface.

    Parameters
    ----------
    body : HalfSpace, TransverselyIsotropicHalfSpace or Medium
        The body.
    k : ndarray, shape (n,)
        Wavenumbers [1/m], > 0.

    Returns
    -------
    along : ndarray, shape (2, 2, n)
        k (u_l, u_z) per (s_lz, s_zz) [1/Pa].
    across : ndarray, shape (n,)
        k u_t per s_tz [1/Pa].
    """
    scale = body.surface_modulus
    return stack_flexibility(body, k, scale) / scale, _across(body, k)


def _surface_plane(material: Material) -> Plane[Array]:
    return material.plane_at(np.zeros(1))


def _across(medium: Stack, k: Array) -> Array:
    base = medium.base
    w = np.zeros_like(k) if base.rigid else np.full(k.size, -1 / _impedance_at(_surface_plane(base))[0])
    for layer in reversed(medium.layers):
        slides = not layer.face
        if not slides:
            w = yielding_across(layer.face, w, k, 1.0)
        w = _through_graded(layer, w, k, slides) if layer.varies else _through(layer, w, k, slides)
    return w * passed_across(medium.membrane, w, k, 1.0)


def _through(layer: AnyLayer, w: Array, k: Array, slides: bool) -> Array:
    plane = _surface_plane(layer)
    impedance = _impedance_at(plane)
    t = np.tanh(k * layer.thickness * np.sqrt(plane.across * plane.shear))
    return np.asarray(-1 / (impedance * t) if slides else (w - t / impedance) / (1 - t * impedance * w))


def _through_graded(layer: AnyLayer, w: Array, k: Array, slides: bool) -> Array:
    """From the lower face, or from the depth that a wave reaches, where the layer is its own half-space."""
    samples = layer.plane_at(layer.sampled_depths)
    # waves decay like exp(-k z sqrt(C66/C44))
    slowest = float(np.sqrt(samples.across * samples.shear).min())
    depth = np.minimum(layer.thickness, SATURATION / (k * slowest))
    impedance = _impedance_at(layer.plane_at(depth))
    hidden = depth < layer.thickness
    # where the face slides 1/w is carried, which is zero there; elsewhere w times the impedance below it
    state = np.where(hidden, -1.0, 0.0 if slides else w * impedance)
    inverse = np.full(k.size, slides) & ~hidden

    def slope(share: float, y: Array) -> Array:
        plane = layer.plane_at(share * depth)
        shear, across = plane.shear * impedance, plane.across / impedance
        return np.asarray(k * depth * np.where(inverse, across - shear * y * y, shear - across * y * y))

    solved = scipy.integrate.solve_ivp(slope, (1.0, 0.0), state, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE / 100)
    y = solved.y[:, -1]
    return np.asarray(np.where(inverse, 1 / y, y) / impedance)


def _impedance_at(plane: Plane[Array]) -> Array:
    """Root of C66 C44 [Pa]."""
    return np.sqrt(plane.across / plane.shear)


def uniform_compliance(medium: Body) -> float:
    """C(0) [m/Pa] of a body; infinite on elastic bases and half-spaces."""
    if not all(body.base.rigid for body in medium.elastic):
        return float("inf")
    layers = [layer for body in medium.elastic for layer in body.layers]
    return sum(layer.face.softness[1] for layer in layers) + sum(_squeezed(layer) for layer in layers)


def _squeezed(layer: AnyLayer) -> float:
    """Shortening of a layer per pressure [m/Pa]; its sides do not move."""
    if layer.varies:
        return float(scipy.integrate.quad(lambda z: float(layer.plane_at(z).oedometric), 0.0, layer.thickness)[0])
    return layer.thickness * layer.plane.oedometric
