"""Synthetic cycles of a contact line that is pinned: approach without adhesion, retract at a held radius until it opens."""

import numpy as np

from flatpunch.contact import indent, pull_off
from flatpunch.fits import Curve


def pinned(medium, tip, work, deepest, *, noise=0.01, seed=1, points=400):
    """Force over depth: the line of a flat punch of the outline at the deepest point down to the JKR branch.

    The stiffness of that punch is the slope of the approach, whatever the outline.
    """
    plain = np.linspace(0, deepest, 400)[1:]
    approach = indent(medium, tip, depth=plain, angles=8)
    lost = pull_off(medium, tip, work_of_adhesion=work).depth_minimum.depth
    depth = np.linspace(lost * (1 - 1e-6), deepest, 3000)
    sticking = indent(medium, tip, depth=depth, work_of_adhesion=work, angles=8)
    top, slope = float(approach.force[-1]), float(approach.stiffness[-1])
    line = top + (depth - deepest) * slope
    opening = depth[np.flatnonzero(line < sticking.force.values)[-1]]
    retract = np.where(depth > opening, line, sticking.force)
    way = np.linspace(-deepest, deepest, points)
    load = np.concatenate(
        [np.interp(way, plain, approach.force, left=0.0), np.interp(way, depth, retract, left=0.0)[::-1]]
    )
    load = load + noise * top * np.random.default_rng(seed).normal(size=load.size)
    return Curve(np.concatenate([way, way[::-1]]), load, name=f"pinned-{seed}")
