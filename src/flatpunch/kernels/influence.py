"""Displacements under pressed cells of a grid, for codes that do not repeat."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from flatpunch.kernels.bodies import Tuples, body_of

if TYPE_CHECKING:
    from flatpunch._support.checks import Array
    from flatpunch.media import Body


def influence_coefficients(medium: Body | Tuples, spacing: float, shape: Sequence[int]) -> Array:
    """Normal displacement at the centre of a cell per uniform pressure without friction on another one.

    Parameters
    ----------
    medium : Body or tuple
        As for `surface_compliance`.
    spacing : float
        Side of the square cells [m].
    shape : sequence of two int
        Number of offsets along rows and columns, counted from zero.

    Returns
    -------
    ndarray, shape (rows, columns)
        Coefficients at offsets of (i, j) cells [m/Pa]: even in both, and the same for (j, i). The absolute error is below 1e-8 of
        that at zero offset of a half-space with the modulus of the surface.

    Raises
    ------
    ValueError, TypeError
        On bad input.

    See Also
    --------
    flatpunch.kernels.normal_compliance : Its transform, for surfaces that repeat.

    Examples
    --------
    >>> from flatpunch import kernels
    >>> g = kernels.influence_coefficients(fp.HalfSpace(1e9, 0.3), 1e-6, (128, 128))
    >>> print(g.shape, f"{g[0, 0] * np.pi * 1e9 / 0.91 / 1e-6:.4f}")  # 4 ln(1 + sqrt 2) on a half-space
    (128, 128) 3.5255
    """
    from flatpunch._support.checks import CELLS, positive, whole
    from flatpunch.bem.operator.influence import influence_coefficients as coefficients
    from flatpunch.compliances import compliance

    if len(shape) != 2:
        raise ValueError(f"shape = {shape!r} must be the numbers of rows and columns.")
    rows, columns = (whole("shape", n, 1, most=4 * CELLS) for n in shape)
    return coefficients(compliance(body_of(medium)), positive("spacing", spacing, unit="m"), (rows, columns))
