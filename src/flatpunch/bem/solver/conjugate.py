"""Removing the gap on a given contact by preconditioned conjugate gradients, a linear problem.

The pressure p on a contact that makes displacements u there has the energy u p/2. It is the least that u can have, however it is
extended beyond the contact: A^-1 = min E' C^-1 E over extensions E. The preconditioner is E' C^-1 E with one extension. Extension
by zero is adequate on half-spaces and compressible layers, but forces bending within one cell under stiff films, where it stores
a hundred times the least energy. A mean of u in the contact with weights 1/(r^2 + h^2)^(3/2), which favour near cells, stores
three to twelve times the least, and costs two convolutions on the grid itself.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flatpunch.bem.grid import Cells, Namespace
from flatpunch.bem.operator.convolution import Operator


def remove_gap(
    operator: Operator, contact: Cells, gap: Cells, drop: float, limit: int, *, extended: bool = False
) -> tuple[Cells, int]:
    """Pressure on `contact` that reduces the gap there by the factor `drop`, by preconditioned conjugate gradients.

    The gap [cells], shape (ny, nx), is zero outside `contact`; `extended` displacements go on there, else they are zero.
    Returns the change of pressure [E*], in the operator's precision, and the iterations: fewer than needed where rounding or
    the limit end them.
    """
    xp, dtype = operator.xp, operator.spectrum.dtype
    scale = largest(xp, gap)
    if scale == 0.0:
        return xp.astype(gap, dtype), 0
    mask = xp.astype(contact, dtype)
    r = xp.astype(gap / scale, dtype)
    p, t, rz_old = xp.zeros_like(r), xp.zeros_like(r), np.inf
    precondition = preconditioner(operator, mask, extended=extended)
    for n in range(limit):
        z = precondition(r)
        rz = dot(xp, r, z)
        t *= rz / rz_old
        t += z
        q = operator.apply(t)
        curvature = dot(xp, t, q)
        if not (rz > 0 and curvature > 0):
            return p * scale, n
        step = rz / curvature
        p -= step * t
        q *= step * mask
        r -= q
        rz_old = rz
        if largest(xp, r) <= drop:
            return p * scale, n + 1
    return p * scale, limit


def preconditioner(operator: Operator, mask: Cells, *, extended: bool) -> Callable[[Cells], Cells]:
    """Pressure on a contact that approximately removes a gap there, E' C^-1 E; `mask` is 1 on the contact and else 0."""
    if not extended:
        return lambda gap: operator.precondition(gap) * mask
    # weight of zero in that mean over the sum of all weights, as displacements vanish far away; at twice or half, as many steps
    weight = (1 - mask) / (operator.xp.abs(operator.spread(mask)) + 0.01)

    def precondition(gap: Cells) -> Cells:
        pressure = operator.precondition(gap + weight * operator.spread(gap))
        return (pressure + operator.spread(weight * pressure)) * mask

    return precondition


def dot(xp: Namespace, a: Cells, b: Cells) -> float:
    """Sum of a b over the grid."""
    return float(xp.vecdot(xp.reshape(a, (-1,)), xp.reshape(b, (-1,))))


def largest(xp: Namespace, a: Cells) -> float:
    """Largest |a| over the grid, without an array of all of them."""
    return max(float(xp.max(a)), -float(xp.min(a)))
