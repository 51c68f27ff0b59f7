"""What the cells of boundary element solutions leave: estimates of the relative error of the force, and of the outline.

The constants were read off the honesty catalogue (tests/catalogue). Cells are counted per side of a grid that holds the contact
with a rim of a quarter of its half-widths.
"""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array

_FORCE, _CORNER_FORCE, _APART = 0.6, 1.2, 9.0
"""Relative error of extrapolated forces times the square of the cells, of smooth tips and, over their reach, of those with edges,
which is taken for this where the contact has no outline."""
_EXTRAPOLATED = 1.4
"""Relative error of extrapolated forces over what extrapolation has added, of contacts in several parts (up to 1.4 found)."""
_SHARE, _FLOOR, _UNKNOWN = 0.6, 0.4, 2.0
"""The same of the forces of the cells themselves: share of what cells twice as wide change, what is added times the square of the
cells, and their error over that of extrapolated forces where wider cells are not known."""
_RIM, _END, _FLANK = 1.3, 1.5, 0.15
"""Error of outlines over the mean radius, times the cells per side: a third of a cell, what their ends add, and their flanks."""


def force_error(outline: Array, cells: Array | float, added: Array | float = 0.0, *, edges: bool) -> Array:
    """Relative error of forces extrapolated to vanishing cells, shape (n,): cells are wider where needles want a larger grid.

    Parameters
    ----------
    outline : array, shape (n, angles)
        ln(a(phi)/mean radius); not finite where a contact has none.
    cells : float or array, shape (n,)
        Cells per side.
    added : float or array, shape (n,)
        What extrapolation has added to ln F, if known.
    edges : bool
        Whether the tip has edges.
    """
    if not edges:
        return np.full(outline.shape[0], _FORCE) / np.square(cells)
    reach = np.exp(outline.max(axis=1))
    apart = np.maximum(_CORNER_FORCE * _APART / np.square(cells), _EXTRAPOLATED * np.abs(added))
    return np.asarray(np.where(np.isfinite(reach), _CORNER_FORCE * reach / np.square(cells), apart))


def own_force_error(change: Array, outline: Array, cells: Array, *, edges: bool) -> Array:
    """Relative error of forces as cells have them, shape (n,), by what cells twice as wide `change`: NaN if that is not known."""
    known = _SHARE * np.abs(change) + _FLOOR / cells**2
    return np.where(np.isfinite(change), known, _UNKNOWN * force_error(outline, cells, edges=edges))


def outline_error(outline: Array, cells: Array | float) -> Array:
    """Error of outlines over their mean radius, shape (n,); arguments as for `force_error`.

    It grows with the farthest point over the mean radius: contacts are drawn out into arms that are a few cells wide. Rays
    beside a needle meet its flank aslant: with dln a/dphi of up to 100 they move that much farther than it does.
    """
    far = np.exp(outline.max(axis=1)) - 1
    steepest = np.abs(np.diff(outline, append=outline[:, :1])).max(axis=1) * (outline.shape[1] / (2 * np.pi))
    far, steepest = np.where(np.isfinite(far), far, 1.0), np.where(np.isfinite(steepest), steepest, 0.0)
    return np.asarray(np.maximum(_RIM + _END * far, _FLANK * far * steepest) / cells)
