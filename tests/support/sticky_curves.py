"""Synthetic adhesive cycles: jump into contact at depth 0, snap off where the cantilever lets go (or at the last depth)."""

import numpy as np

from flatpunch.contact import indent, pull_off
from flatpunch.fits import Curve


def sticky(medium, tip, work, deepest, *, spring=None, noise=0.01, seed=1, points=400, contact=30e-9, **more):
    """Approach and retract; noise over the largest absolute force, behind a cantilever also in the tip's position.

    `more` is a range of action or a strength.
    """
    lost = pull_off(medium, tip, work_of_adhesion=work, **more).depth_minimum.depth
    depth = np.linspace(lost * (1 - 1e-6), deepest, 3000)
    force = indent(medium, tip, depth=depth, work_of_adhesion=work, angles=8, **more)["force"].values
    piezo = depth if spring is None else depth + force / spring
    snap = int(np.argmin(piezo))
    way = np.linspace(piezo[snap] - 0.6 * (piezo[-1] - piezo[snap]), piezo[-1], points)
    stuck = np.where(way >= piezo[snap], np.interp(way, piezo[snap:], force[snap:]), 0.0)
    pressed = np.where(way >= 0, stuck, 0.0)
    load = np.concatenate([pressed, stuck[::-1]])
    load = load + noise * np.abs(force).max() * np.random.default_rng(seed).normal(size=load.size)
    cycle = np.concatenate([way, way[::-1]]) + contact
    if spring is None:
        return Curve(cycle, load, name=f"sticky-{seed}")
    return Curve.from_piezo(cycle, load, spring, name=f"sticky-{seed}")
