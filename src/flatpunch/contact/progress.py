"""Curves through outlines along a loading path, which under stiff films grow needles within a tenth of the depth.

Over x = ln d the length of needles bends where they set in, and solutions hardly resolve it. Over that length x does not: so
outlines are interpolated over t = x + 4 ln(farthest point), and x(t) is a spline through the same solutions.
"""

from __future__ import annotations

import numpy as np
import scipy

from flatpunch._validation import Array, Indices
from flatpunch.contact.node_spline import Curve, Through, curve_through, spline_through

_LENGTH = 4.0
"""What ln(farthest point) counts for over ln d."""
_FINE = 64
"""Points in each gap at which t(x) is tabulated."""


def outlines_through(nodes: Array, outlines: Array, sectors: Indices, through: Through = curve_through) -> Curve:
    """Curve over x through ln a(phi), shape (nodes, angles), which follows the needles of each kind of edge as they grow.

    `sectors` are the kinds of edge that rays belong to, shape (angles,), counted from 0; over t curves are those of `through`.
    """
    kinds = [sectors == kind for kind in range(int(sectors.max()) + 1)]
    curves = [_following(nodes, outlines[:, rays], through) for rays in kinds]

    def outline(x: Array) -> Array:
        values = np.empty((x.size, sectors.size))
        for rays, curve in zip(kinds, curves, strict=True):
            values[:, rays] = curve(x)
        return values

    return outline


def _following(nodes: Array, outlines: Array, through: Through) -> Curve:
    """The same of rays beside one kind of edge."""
    length = np.maximum.accumulate(outlines.max(axis=1))
    along = nodes + _LENGTH * (length - length[0])
    gaps = np.arange(nodes.size)
    fine = np.interp(np.linspace(0, gaps[-1], _FINE * gaps[-1] + 1), gaps, along)
    places = spline_through(along, nodes)(fine)
    if np.any(np.diff(places) <= 0):
        places = scipy.interpolate.PchipInterpolator(along, nodes)(fine)
    curve = through(along, outlines)
    return lambda x: curve(np.interp(x, places, fine))
