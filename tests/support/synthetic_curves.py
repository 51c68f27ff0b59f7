"""Synthetic curves: exact force of a case, a contact point, a baseline and noise."""

import numpy as np

from flatpunch.contact import indent
from flatpunch.fits import Curve


def synthetic(medium, indenter, deepest, *, noise=0.01, seed=1, points=500, contact=0.0, baseline=0.0, method=None):
    """Half of the deepest indentation is approach without contact; noise as a share of the largest force."""
    rng = np.random.default_rng(seed)
    z = np.linspace(-0.5 * deepest, deepest, points)
    touching = z > 0
    force = np.zeros(points)
    method = method or ("first-order" if indenter.round else "fourth-order")
    force[touching] = indent(medium, indenter, depth=z[touching], method=method, angles=8)["force"].values
    top = force.max()
    return Curve(z + contact, force + noise * top * rng.normal(size=points) + baseline * top, name=f"synthetic-{seed}")
