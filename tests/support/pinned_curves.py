"""Synthetic cycles of a contact line that is pinned: approach without adhesion, retract at a held radius until it opens."""

import numpy as np

from flatpunch.contact import indent, pull_off
from flatpunch.fits import Curve


def pinned(medium, tip, work, deepest, *, noise=0.01, seed=1, points=400):
    """Force over depth: the line of a flat punch from the deepest point down to the JKR contact of the same radius."""
    plain = np.linspace(0, deepest, 400)[1:]
    approach = indent(medium, tip, depth=plain, angles=8)
    lost = pull_off(medium, tip, work_of_adhesion=work).depth_minimum.depth
    depth = np.linspace(lost * (1 - 1e-6), deepest, 3000)
    sticking = indent(medium, tip, depth=depth, work_of_adhesion=work, angles=8)
    top, radius = float(approach.force[-1]), float(approach.radius[-1])
    opening = float(np.interp(radius, sticking.radius, depth))
    line = top + (depth - deepest) * (top - np.interp(radius, sticking.radius, sticking.force)) / (deepest - opening)
    retract = np.where(depth > opening, line, sticking.force)
    way = np.linspace(-deepest, deepest, points)
    load = np.concatenate(
        [np.interp(way, plain, approach.force, left=0.0), np.interp(way, depth, retract, left=0.0)[::-1]]
    )
    load = load + noise * top * np.random.default_rng(seed).normal(size=load.size)
    return Curve(np.concatenate([way, way[::-1]]), load, name=f"pinned-{seed}")
