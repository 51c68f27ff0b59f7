"""Load waves in a graded transversely isotropic layer on a base by Chebyshev collocation, without code of the package.

It is the boundary-value problem of the state (k u_l, k u_z, s_lz, s_zz, k u_t, s_tz), dy/dz = k A(z) y, at the nodes of panels
that are joined by continuity. Moduli must be of order one, as the equations mix displacements and stresses.
"""

from itertools import pairwise

import numpy as np
import scipy

NODES = 24


def system(constants):
    """A of the constants (E, E_z, nu, nu_z, G) of one depth, from the inverse of Hooke's matrix."""
    young, axial, nu, nu_axial, shear = constants
    # plane strain across the wave: e_tt = 0 gives s_tt; then e_ll and e_zz of s_ll and s_zz
    s11, s12, s13, s33 = 1 / young, -nu / young, -nu_axial / axial, 1 / axial
    b11, b13, b33 = s11 - s12**2 / s11, s13 - s12 * s13 / s11, s33 - s13**2 / s11
    matrix = np.zeros((6, 6))
    # e_ll = u_l with the phases of the waves; s_ll from e_ll and s_zz
    matrix[0, 1], matrix[0, 2] = 1, 1 / shear
    matrix[1, 0], matrix[1, 3] = b13 / b11, b33 - b13**2 / b11
    matrix[2, 0], matrix[2, 3] = 1 / b11, -b13 / b11
    matrix[3, 2] = -1
    matrix[4, 5], matrix[5, 4] = 1 / shear, young / (2 * (1 + nu))
    return matrix


def flexibility(matrix):
    """Displacements over tractions of the decaying fields of a half-space, (3, 3)."""
    _, vectors, count = scipy.linalg.schur(matrix, sort="lhp")
    assert count == 3
    decaying = vectors[:, :3]
    order = [0, 1, 4, 2, 3, 5]
    upper, lower = decaying[order][:3], decaying[order][3:]
    return upper @ np.linalg.inv(lower)


def solve(constants_at, thickness, k, loads, base, springs=(0.0, 0.0), slides=False, panels=12):
    """Depths and states, shapes (n,) and (n, 6, loads), under tractions (s_lz, s_zz, s_tz) on the surface, shape (3, loads).

    `base` is the flexibility (3, 3) of what lies below, `springs` are jumps along and across the lower face per traction.
    """
    # panels that are shorter at both faces
    edges = thickness * (1 - np.cos(np.pi * np.arange(panels + 1) / panels)) / 2
    x = np.cos(np.pi * np.arange(NODES) / (NODES - 1))[::-1]
    c = np.where((np.arange(NODES) == 0) | (np.arange(NODES) == NODES - 1), 2.0, 1.0) * (-1.0) ** np.arange(NODES)
    gaps = x[:, None] - x[None] + np.eye(NODES)
    slope = np.outer(c, 1 / c) / gaps
    slope -= np.diag(slope.sum(axis=1))
    size = 6 * NODES
    matrix, right = np.zeros((panels * size,) * 2), np.zeros((panels * size, loads.shape[1]))
    depths = []
    for i, (low, high) in enumerate(pairwise(edges)):
        z = low + (high - low) * (1 + x) / 2
        depths.append(z)
        at = slice(i * size, (i + 1) * size)
        block = np.kron(slope * 2 / (high - low), np.eye(6))
        for j, depth in enumerate(z):
            block[6 * j : 6 * j + 6, 6 * j : 6 * j + 6] -= k * system(constants_at(depth))
        # the first node of a panel carries continuity, that of the first panel the six conditions of both faces
        block[:6] = 0
        matrix[at, at] = block
        if i:
            matrix[i * size : i * size + 6, i * size : i * size + 6] = np.eye(6)
            matrix[i * size : i * size + 6, i * size - 6 : i * size] = -np.eye(6)
    top, bottom = slice(0, 6), slice(panels * size - 6, panels * size)
    order = [0, 1, 4, 2, 3, 5]
    matrix[0:3, top] = np.eye(6)[order[3:]]
    right[0:3] = loads
    below = base - k * np.diag([springs[0], springs[1], springs[0]])
    matrix[3:6, bottom] = np.eye(6)[order[:3]] - below @ np.eye(6)[order[3:]]
    if slides:
        matrix[3:6, bottom] = np.eye(6)[[2, 1, 5]]
        matrix[4, bottom] = np.eye(6)[1] - (base[1, 1] - k * springs[1]) * np.eye(6)[3]
    return np.concatenate(depths), np.linalg.solve(matrix, right).reshape(-1, 6, loads.shape[1])
