"""A relaxing film on a relaxing or elastic base against another road: convolution quadrature on rings of uniform pressure.

The weights of Lubich's quadrature (BDF2) come from Burmister's kernel with complex moduli, with no retardation times fitted;
half-space parts are elliptic integrals.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.special import ellipe, ellipk, j0, j1

import flatpunch as fp
from flatpunch.reference.layers import bonded_on_half_space

PSI, FASTER = fp.Prony([0.3, 0.4], [0.1, 2.0]), fp.Prony([0.5], [0.3])
MAXWELL = fp.Prony([1.0], [1.0])
BALL = fp.Paraboloid(10e-6)
RINGS, STEPS = 80, 200


def _operational(relaxation, s):
    if relaxation is None:
        return 1.0
    return relaxation.equilibrium + sum(
        w * s * t / (1 + s * t) for w, t in zip(relaxation.weights, relaxation.times, strict=True)
    )


def _under_discs(r, a):
    """Displacement at r times E* under unit pressure on discs of radius a."""
    r, a = r[:, None], a[None, :]
    with np.errstate(all="ignore"):
        inside = 4 * a / np.pi * ellipe((r / a) ** 2)
        outside = 4 * r / np.pi * (ellipe((a / r) ** 2) - (1 - (a / r) ** 2) * ellipk((a / r) ** 2))
    return np.where(a == 0, 0.0, np.where(r < a, inside, outside))


def _weights(film, relaxation, edges, step):
    """Matrices from pressures of all steps to displacements, shape (steps, rings, rings)."""
    (layer,), base = film.layers, film.base
    middle = (edges[1:] + edges[:-1]) / 2
    half_space = np.diff(_under_discs(middle, edges), axis=1)
    panel = min(1.0, 2 * layer.thickness / edges[-1])
    x, w = np.polynomial.legendre.leggauss(12)
    kappa, weight = np.concatenate(
        [
            ((low + high) / 2 + (high - low) / 2 * x, (high - low) / 2 * w)
            for low, high in pairwise([0.0, *np.geomspace(1e-4, panel, 12), *np.arange(2 * panel, 26, panel)])
        ],
        axis=1,
    )
    k = kappa / layer.thickness
    of_rings = np.diff(edges * j1(np.outer(k, edges)) / k[:, None], axis=1)
    at_rings = j0(np.outer(middle, k)) * weight / layer.thickness * k
    count = 2 * (STEPS + 1)
    shrink = 1e-8 ** (1 / count)
    z = shrink * np.exp(2j * np.pi * np.arange(count) / count)
    s = (1 - z + (1 - z) ** 2 / 2) / step
    values = np.empty((count, RINGS, RINGS), dtype=complex)
    for i in range(count // 2 + 1):
        young, below = (
            body.young * _operational(one, s[i]) for body, one in zip((layer, base), relaxation, strict=True)
        )
        modulus = young / (1 - layer.poisson**2)
        more = 2 / (modulus * k) * (bonded_on_half_space(kappa, young, layer.poisson, below, base.poisson) - 1)
        values[i] = half_space / modulus + (at_rings * more) @ of_rings
        values[-i] = values[i].conj()
    found = np.fft.fft(values, axis=0) / count * shrink ** -np.arange(count)[:, None, None]
    return found.real[: STEPS + 1]


def in_time(film, relaxation, radius, time, depth):
    """Force at all times; rings join at the border where the tip is below the surface, and leave where they would pull."""
    edges = radius * np.arange(RINGS + 1) / RINGS
    weights = _weights(film, relaxation, edges, time[1])
    area, touch = np.pi * np.diff(edges**2), ((edges[1:] + edges[:-1]) / 2) ** 2 / (2 * BALL.radius)
    pressure, inside = np.zeros((time.size, RINGS)), 1
    for i in range(1, time.size):
        rest = depth[i] - touch - np.einsum("jab,jb->a", weights[i:0:-1], pressure[:i])
        inside, moved = max(inside, 1), 0
        while True:
            found = np.linalg.solve(weights[0][:inside, :inside], rest[:inside])
            if found[-1] < 0 and moved <= 0:
                inside, moved = inside - 1, -1
                if inside == 0:
                    break
            elif moved >= 0 and rest[inside] > weights[0][inside, :inside] @ found:
                inside, moved = inside + 1, 1
            else:
                break
        pressure[i, :inside] = found[:inside]
    return pressure @ area


@pytest.mark.long
@pytest.mark.parametrize(
    ("film", "relaxation", "corners"),
    [
        ((5e3, 0.4, 20e3), [PSI, None], [0, 2, 2, 0.5, 1.8, 0]),
        ((5e3, 0.4, 20e3), [PSI, FASTER], [0, 2, 2, 0.5, 1.8, 0]),
        ((5e3, 0.4, 20e3), [None, FASTER], [0, 1, 2, 1, 2, 0.5]),
        ((5e3, 0.5, 20e3), [MAXWELL, None], [0, 2, 2, 2, 2, 2]),
        ((20e3, 0.4, 5e3), [MAXWELL, PSI], [0, 2, 2, 1.5, 2, 2]),
    ],
    ids=["film", "both", "base", "flowing", "flowing-both"],
)
def test_against_convolution_quadrature(film, relaxation, corners):
    young, poisson, below = film
    medium = fp.Medium([fp.Layer(young, poisson, 2e-6)], fp.HalfSpace(below, 0.3))
    time = np.linspace(0, 5, STEPS + 1)
    depth = 1e-7 * np.interp(time, np.arange(6), corners)
    found = fp.indent(medium, BALL, depth=depth, time=time, relaxation=relaxation)
    radius = 1.2 * float(found.radius.max())
    force = in_time(medium, relaxation, radius, time, depth)
    off = np.abs(force - found.force.values) / float(found.force.max())
    # most where the history has a corner, which the quadrature rounds
    assert off.max() < 1e-3
    assert np.median(off) < 2e-4
    if MAXWELL in relaxation:
        # to the end of its decay, to a few per cent of the largest force
        assert np.abs(force[-1] / float(found.force[-1]) - 1) < 2e-3
