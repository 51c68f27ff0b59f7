"""What a map of cells in contact amounts to: area without the staircase of the cells, patches."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from flatpunch._support.checks import Array, Flags

STAIRCASE = (math.pi - 1 + math.log(2)) / 24
"""Area by which counted cells exceed a contact, over perimeter times side of a cell (Yastrebov, Anciaux, Molinari 2017)."""


def perimeter(contact: Flags, periodic: tuple[bool, bool]) -> int:
    """Sides of cells between contact and gap; the border of a surface that ends counts as gap."""
    sides = 0
    for axis in (0, 1):
        if periodic[1 - axis]:
            sides += int(np.count_nonzero(contact != np.roll(contact, 1, axis)))
        else:
            rim = [(1, 1) if axis == other else (0, 0) for other in (0, 1)]
            sides += int(np.count_nonzero(np.diff(np.pad(contact, rim), axis=axis)))
    return sides


def patch_sizes(contact: Flags, periodic: tuple[bool, bool]) -> Array:
    """Number of cells of each connected patch, cells joined by their sides, across the border where the surface repeats."""
    labels, count = label(contact)
    pairs = []
    for axis in (0, 1):
        if periodic[1 - axis]:
            ends = np.stack([np.take(labels, end, axis) for end in (0, -1)])
            pairs.append(ends[:, (ends > 0).all(axis=0)])
    if pairs and count:
        first, second = np.concatenate(pairs, axis=1) - 1
        graph = coo_array((np.ones(first.size, dtype=bool), (first, second)), shape=(count, count))
        count, joined = connected_components(graph, directed=False)
        labels = np.concatenate([[0], joined + 1])[labels]
    return np.asarray(np.bincount(labels.ravel(), minlength=count + 1)[1:])


def at_border(contact: Flags, periodic: tuple[bool, bool]) -> bool:
    """Whether the contact reaches a border at which the surface ends."""
    along_x, along_y = periodic
    return bool((not along_x and contact[:, [0, -1]].any()) or (not along_y and contact[[0, -1]].any()))
