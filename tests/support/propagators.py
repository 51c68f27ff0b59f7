"""Load waves in stacks of isotropic and transversely isotropic layers by matrix exponentials in multiprecision.

Sagittal state (k u_l, k u_z, s_lz, s_zz), transverse state (k u_t, s_tz). Half-spaces follow from the matrix sign function, and
nothing is computed by the package.
"""

import mpmath as mp
import numpy as np

import flatpunch as fp

DIGITS = 500
"""Enough for exp(+-500) beside 1."""


def constants(body):
    """E and E_z, nu and nu_z, G."""
    if isinstance(body, (fp.Layer, fp.HalfSpace)):
        young, nu = mp.mpf(body.young), mp.mpf(body.poisson)
        return young, young, nu, nu, young / (2 * (1 + nu))
    names = ("young_in_plane", "young_axial", "poisson_in_plane", "poisson_axial", "shear")
    return tuple(mp.mpf(getattr(body, name)) for name in names)


def systems(body):
    """Matrices of the sagittal and of the transverse state over kz."""
    young, axial, nu, nu_axial, shear = constants(body)
    coupling = young / axial * nu_axial / (1 - nu)
    soft = (1 - nu - 2 * nu_axial**2 * young / axial) / ((1 - nu) * axial)
    if abs(soft * axial) < 1e-14:  # incompressible up to the rounding of the constants
        soft = mp.mpf(0)
    stiff = young / (1 - nu**2)
    sagittal = mp.matrix([[0, 1, 1 / shear, 0], [-coupling, 0, 0, soft], [stiff, 0, 0, coupling], [0, 0, -1, 0]])
    return sagittal, mp.matrix([[0, 1 / shear], [young / (2 * (1 + nu)), 0]])


def split(states):
    """Upper and lower half."""
    half = states.rows // 2
    return states[:half, :], states[half:, :]


def flexibility(states):
    """Displacements over tractions of the states in the columns."""
    upper, lower = split(states)
    return upper * lower**-1


def half_space(matrix):
    """Flexibility of the decaying states: the kernel of 1 + sign(A), by Newton's iteration."""
    sign = matrix
    while True:
        following = (sign + sign**-1) / 2
        if mp.norm(following - sign) < mp.mpf(10) ** (-DIGITS // 2):
            break
        sign = following
    size = matrix.rows // 2
    upper, lower = (mp.eye(2 * size) + following)[:size, :size], (mp.eye(2 * size) + following)[:size, size:]
    return -(upper**-1) * lower


def up(matrix, x, states):
    """States at a height x above."""
    return mp.expm(-matrix * mp.mpf(x), method="taylor") * states


def stiffened(layer, below, k):
    """Flexibility of what lies below the springs of a lower face, with the membrane on it."""
    membrane = getattr(layer.bonded, "membrane", None)
    if membrane is None:
        return below, mp.eye(below.rows)
    tension, along, across, bend = (mp.mpf(getattr(membrane, n)) for n in ("tension", "stretching", "shear", "bending"))
    own = [across * k] if below.rows == 1 else [along * k, tension * k + bend * k**3]
    passed = (mp.eye(below.rows) - mp.diag(own) * below) ** -1
    return below * passed, passed


def admitted(layer, below, k):
    """States that the lower face of a layer admits."""
    shear, normal = 0, 0
    bonded = layer.bonded
    if isinstance(bonded, fp.Interface):
        spring, bonded = bonded, bonded.shear != 0
        shear = k / mp.mpf(spring.shear) if spring.shear else 0
        normal = k / mp.mpf(spring.normal) if spring.normal else 0
    if below.rows == 1:
        return mp.matrix([[below[0, 0] - shear], [1]]) if bonded else mp.matrix([[1], [0]])
    h = below - mp.diag([shear, normal])
    if bonded:
        return mp.matrix([[h[0, 0], h[0, 1]], [h[1, 0], h[1, 1]], [1, 0], [0, 1]])
    return mp.matrix([[1, 0], [0, h[1, 1]], [0, 0], [0, 1]])


def wave(medium, k, z, layer, load):
    """State at the depth z in a layer under a load (s_lz, s_zz), or (s_tz,), on the surface, as floats."""
    which = 0 if len(load) == 2 else 1
    with mp.workdps(DIGITS):
        k = mp.mpf(float(k))
        elastic = not isinstance(medium.base, fp.RigidBase)
        below = half_space(systems(medium.base)[which]) if elastic else mp.zeros(len(load))
        faces, lifted, passed = [], [], []
        for each in reversed(medium.layers):
            below, jump = stiffened(each, below, k)
            passed.insert(0, jump)
            faces.insert(0, admitted(each, below, k))
            lifted.insert(0, up(systems(each)[which], k * mp.mpf(each.thickness), faces[0]))
            below = flexibility(lifted[0])
        traction, top = mp.matrix(load), mp.mpf(0)
        for i, each in enumerate(medium.layers):
            amplitude = split(lifted[i])[1] ** -1 * traction
            if i == layer:
                height = top + mp.mpf(each.thickness) - mp.mpf(float(z))
                found = up(systems(each)[which], k * height, faces[i]) * amplitude
                return np.array([float(value) for value in found])
            traction = passed[i] * split(faces[i])[1] * amplitude
            top += mp.mpf(each.thickness)
        state = mp.matrix([*(half_space(systems(medium.base)[which]) * traction), *traction])
        found = up(systems(medium.base)[which], -k * (mp.mpf(float(z)) - top), state)
        return np.array([float(value) for value in found])


def random_material(rng):
    """Five constants of a stable material, a fifth of them incompressible along z."""
    young, ratio = 10 ** rng.uniform(-2, 2), 10 ** rng.uniform(-1.5, 1.5)
    nu = rng.uniform(-0.3, 0.8)
    limit = np.sqrt((1 - nu) / 2 / ratio) * (1 - 1e-15)
    nu_axial = limit if rng.random() < 0.2 else rng.uniform(-0.5, 0.99) * limit
    return young, young / ratio, nu, nu_axial, young * 10 ** rng.uniform(-2, 1)


def random_stack(rng, springs=False, membranes=False):
    """One to five layers, isotropic ones among them, a fifth sliding, on all kinds of bases."""
    layers = []
    for _ in range(rng.integers(1, 6)):
        thickness, bonded = 10 ** rng.uniform(-1, 1), bool(rng.random() < 0.8)
        if springs:
            bonded = [bonded, fp.Interface(*(10 ** rng.uniform(-3, 3, 2))), fp.Interface(1.0, 0.0)][rng.integers(0, 3)]
        if membranes:
            attached = [{}, {"shear": 0.0}, {"normal": 10 ** rng.uniform(-3, 3)}][rng.integers(0, 3)]
            own = 10 ** rng.uniform(-3, 3, 4) * (rng.random(4) < 0.6)
            bonded = fp.Interface(**attached, membrane=fp.Membrane(*own))
        if rng.random() < 0.7:
            layers.append(fp.TransverselyIsotropicLayer(*random_material(rng), thickness, bonded))
        else:
            layers.append(fp.Layer(10 ** rng.uniform(-2, 2), float(rng.choice([0.5, 0.3])), thickness, bonded))
    bases = [fp.RigidBase(), fp.HalfSpace(1.0, 0.3), fp.TransverselyIsotropicHalfSpace(*random_material(rng))]
    return fp.Medium(layers, bases[rng.integers(0, 3)])
