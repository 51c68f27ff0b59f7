"""One medium of a family, solved directly: the work that making and checking tables hands to worker processes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from flatpunch._support.checks import Array, Indices, values
from flatpunch._support.paths import Plain
from flatpunch.compliances import Kernel, compliance
from flatpunch.numerics.chebyshev import nodal_transform, nodes
from flatpunch.punch.basis import power_edge, power_moments
from flatpunch.punch.family import check_resolution
from flatpunch.punch.harmonics import harmonic_size, solve_edges
from flatpunch.punch.matrix import solve_round, sufficient_terms


def panel_edges(low: float, high: float) -> list[tuple[float, float]]:
    """Intervals of beta: half decades, whole ones below 0.1 where a contact is small against the layer."""
    width = np.log(10) / 2
    first, last = round(np.floor(np.log(low) / width + 1e-9)), round(np.ceil(np.log(high) / width - 1e-9))
    edges = [first]
    while edges[-1] < last:
        wide = edges[-1] % 2 == 0 and edges[-1] + 2 <= min(last, round(np.log(0.1) / width))
        edges.append(edges[-1] + (2 if wide else 1))
    ends = [float(np.exp(edge * width)) for edge in edges]
    return list(pairwise(ends))


def solve_medium(point: Plain) -> Plain:
    """Chebyshev coefficients over ln beta of everything the atlas holds of one medium.

    Parameters
    ----------
    point : dict
        `medium`; `low` and `high`, the range of beta; `responses`, whether those to non-round outlines are wanted;
        `terms`, the number of coefficients on each panel, as many as the medium needs if it is not there.

    Returns
    -------
    dict
        For panel i "i/flat", shape (24, terms): column 0 is ln Kbar, column n is c_n/c_0. With responses, over the harmonics
        "i/orders": "i/stiffening" is k_m - (m - 1)/2, "i/edge_1" and "i/edge_2" are S[A_m^-1 b[r^n]]/(pi e S0_m).
    """
    kernel = compliance(point["medium"])
    check_resolution(kernel, point["high"])
    found: Plain = {}
    for i, (low, high) in enumerate(panel_edges(point["low"], point["high"])):
        beta = nodes(float(np.log(low)), float(np.log(high)))
        responses = solve_round(kernel, beta, point["terms"][i] if "terms" in point else sufficient_terms(kernel, high))
        flat = responses.flat / responses.flat[:, :1]
        flat[:, 0] = np.log(np.pi * responses.flat[:, 0])
        found[f"{i}/flat"] = nodal_transform() @ flat
        if point["responses"]:
            strength = (1 + np.pi * responses.edge[:, 0]) / np.pi
            found |= {f"{i}/{name}": value for name, value in _responses(kernel, beta, high, strength).items()}
    return found


def _responses(kernel: Kernel, beta: Array, high: float, strength: Array) -> Plain:
    orders = felt_orders(2 * harmonic_size(kernel, high))
    edges = solve_edges(kernel, beta, orders)
    transform = nodal_transform()
    found = {"orders": orders, "stiffening": transform @ (edges.stiffening(orders) - (orders - 1) / 2)}
    # indenters r^n psi(phi) whose responses are tabulated: cones and pyramids, paraboloids
    for n in (1, 2):
        half_space = np.array([power_edge(n, int(m)) for m in orders])
        found[f"edge_{n}"] = transform @ (edges.power_edge(n, orders) / (np.pi * strength[:, None] * half_space))
    return found


def felt_orders(reach: int) -> Indices:
    """Harmonics m = 1, 2, ... 24 and on to `reach`, eight to an octave."""
    # the responses are smooth functions of ln m
    every = 24
    steps = np.arange(1, int(np.ceil(8 * np.log2(max(reach, 2 * every) / every))) + 1)
    more = np.unique(np.round(every * 2 ** (steps / 8)).astype(int))
    return np.concatenate([np.arange(1, every + 1), more])


def solve_directly(point: Plain) -> dict[str, float]:
    """Kbar, kappa_1, kappa_2 and the edge coefficient of one punch, without a table."""
    kernel = compliance(point["medium"])
    beta = values("beta", point["beta"])
    responses = solve_round(kernel, beta, sufficient_terms(kernel, float(beta[0])))
    flat = responses.flat[0]
    moments = {f"kappa_{n}": float((n + 1) * np.pi * power_moments(n, 0, flat.size) @ flat) for n in (1, 2)}
    return {"Kbar": float(np.pi * flat[0]), **moments, "edge": float(1 + np.pi * responses.edge[0, 0])}
