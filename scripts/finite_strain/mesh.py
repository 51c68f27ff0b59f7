"""Graded meshes: fine cells at the edge of the contact, cells that grow geometrically away from it."""

from __future__ import annotations

import numpy as np
from skfem import MeshQuad

FAR = 1500.0
"""Extent of a half-space over the contact radius: faces held there make linear forces 0.1 % larger, and leave ratios alone."""
DOWN = 0.1
"""Height of the cells at the surface under cones over the contact radius: half or twice of it moves forces by less than 2e-5."""


def growing(start: float, end: float, first: float, growth: float, largest: float = np.inf) -> np.ndarray:
    """Points from start to end, either way, whose steps begin with about `first` and grow to at most `largest`."""
    steps = [first]
    while sum(steps) < abs(end - start):
        steps.append(min(steps[-1] * growth, largest))
    points = np.cumsum([0.0, *steps]) / sum(steps)
    return start + (end - start) * points


def mesh(contact: float, thickness: float, cells: int) -> MeshQuad:
    """Mesh of a layer, or of a half-space where the thickness is infinite.

    Parameters
    ----------
    contact : float
        Expected contact radius.
    thickness : float
        Thickness of the layer in the same unit; inf for a half-space.
    cells : int
        Cells across the contact radius if they were as wide as the widest below it.
    """
    growth = 1 + 4.5 / cells
    wide, narrow = contact / cells, contact / (5 * cells)
    bottom, end = min(thickness, FAR * contact), min(1.05 * contact + 12 * thickness, FAR * contact)
    layered = thickness < 4 * contact
    inner = growing(0.95 * contact, 0, narrow, growth, wide)
    edge = np.linspace(0.95, 1.05, int(np.ceil(0.1 * contact / narrow)) + 1) * contact
    outer = growing(1.05 * contact, end, narrow, growth, max(6 * thickness / cells, wide))
    thickest = 1.6 * bottom / cells if layered else np.inf
    down = growing(0, -bottom, min(wide / 2, bottom / cells), growth, thickest)
    return MeshQuad.init_tensor(np.unique(np.concatenate([inner, edge[1:-1], outer])), np.sort(down))


def cone_mesh(contact: float, thickness: float, cells: int, apex: float) -> MeshQuad:
    """Mesh under a cone, with a node at the contact radius; parameters as of `mesh`.

    Parameters
    ----------
    apex : float
        Width of the cell at the apex over the contact radius. Stretches grow without bound there; narrow cells need small steps.
    """
    growth = 1 + 3 / cells
    wide, narrow = contact / cells, contact / (10 * cells)
    bottom, end = min(thickness, FAR * contact), min(contact + 12 * thickness, FAR * contact)
    thickest = 1.6 * bottom / cells if thickness < 4 * contact else np.inf
    inner = growing(0, contact / 2, apex * contact, growth, wide)
    edge = growing(contact, contact / 2, narrow, growth, wide)
    outer = growing(contact, end, narrow, growth, max(6 * thickness / cells, wide))
    down = growing(0, -bottom, min(DOWN * contact, bottom / cells), growth, thickest)
    return MeshQuad.init_tensor(np.unique(np.concatenate([inner[:-1], edge, outer])), np.sort(down))
