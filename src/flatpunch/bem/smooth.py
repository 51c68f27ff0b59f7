"""Second part of the approximate inverse: pressures that are polynomials over the contact.

Dividing by the symbol (operator.py) forgets that the contact ends. What it gets wrong is smooth: a few pressures of low
order, those that bend a stiff film or drain a thin incompressible layer, are overestimated up to 80 times under a film
100 times stiffer than its base, and all the rest is right to some per cent. So these few are solved for and kept out of
the division (balancing, Mandel 1993). With Z the polynomials of degree 6 on the contact, Y what they displace, written as
polynomials of degree 10, and E = Z^T Y,

    M = (I - Z E^-1 Y^T) M0 (I - Y E^-1 Z^T) + Z E^-1 Z^T.

Y and E come from a grid of some 50 cells across, on which 28 convolutions cost next to nothing; M is symmetric and positive
whatever their error, which therefore costs iterations only. Sums with products of polynomials are two narrow matrix products.
On folded grids only even polynomials take part.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander

from flatpunch._validation import Array
from flatpunch.bem.operator import Operator, to_numpy

_DEGREE = 6
_RESPONSE_DEGREE = 10
"""Displacements under polynomials have a kink at the rim; four degrees more leave a few per cent of it."""

_SIZE = _RESPONSE_DEGREE + 1
_ORDER = np.array([n for n in range(_SIZE) for _ in range(n + 1)])
_POWER_X = np.concatenate([np.arange(n + 1) for n in range(_SIZE)])
_POWER_Y = _ORDER - _POWER_X
"""Products of Legendre polynomials by their total degree; those up to `_DEGREE` are pressures."""

_FEWEST = 3.0
"""Coarse cells in contact per polynomial below which there is no smooth part to speak of."""

_AT_ONCE = 4

_SINGULAR, _STIFFEST = 1e-10, 1e-5
"""Below which share of the largest a combination of polynomials is nothing but rounding, and in single precision useless."""


@dataclass(frozen=True, slots=True)
class SmoothModes:
    """Polynomial pressures on one contact and what they displace.

    Attributes
    ----------
    along_x, along_y : array, shapes (nx, n) and (ny, n)
        Legendre polynomials of the coordinates, scaled to the contact's box.
    flexible : array, shape (n n, n n)
        Y E^-1, from sums with Z to the coefficients of a displacement.
    stiff : array, shape (n n, n n)
        E^-1, from sums with Z to the coefficients of a pressure.
    xp : module
        Array namespace.
    """

    along_x: Any
    along_y: Any
    flexible: Any
    stiff: Any
    xp: Any

    def sums(self, values: Any) -> Any:
        """Sums of an array on the grid with all products of polynomials, shape (n n,)."""
        return self.xp.reshape(self.along_y.T @ values @ self.along_x, (-1,))

    def field(self, coefficients: Any) -> Any:
        """Polynomial with the given coefficients, shape (ny, nx)."""
        n = self.along_x.shape[1]
        return self.along_y @ self.xp.reshape(coefficients, (n, n)) @ self.along_x.T


def precondition(operator: Operator, modes: SmoothModes | None, mask: Any, gap: Any) -> Any:
    """Pressure [E*] on the cells of `mask` that about removes a gap error [cells] there; shape (ny, nx)."""
    if modes is None:
        return operator.precondition(gap) * mask
    smooth = modes.sums(gap)
    p = operator.precondition(gap - modes.field(modes.flexible @ smooth) * mask) * mask
    return p + modes.field(modes.stiff @ smooth - modes.flexible.T @ modes.sums(p)) * mask


def smooth_modes(guide: Operator, operator: Operator, contact: Any) -> SmoothModes | None:
    """Modes of a contact for an operator; None where the contact is too small to have any.

    Parameters
    ----------
    guide : Operator
        Operator of the same medium on a coarse grid that covers the contact.
    operator : Operator
        Operator whose grid, array library and precision the modes are for.
    contact : array of bool, shape (ny, nx)
        Cells in contact.
    """
    coarse, fine = guide.grid, operator.grid
    share = _overlap(coarse.y, coarse.spacing, fine.y, fine.spacing) @ to_numpy(contact).astype(float)
    share = share @ _overlap(coarse.x, coarse.spacing, fine.x, fine.spacing).T
    inside = share > 0
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    along_x, along_y = coarse.mirrored
    across = min(rows.size * (1 + along_y), columns.size * (1 + along_x))
    if np.count_nonzero(inside) * coarse.copies < _FEWEST * _ORDER.size or across <= _RESPONSE_DEGREE:
        return None
    box = _scaling(coarse.x[columns], along_x), _scaling(coarse.y[rows], along_y)
    even = ~((along_x & (_POWER_X % 2 == 1)) | (along_y & (_POWER_Y % 2 == 1)))
    powers = _POWER_X[even], _POWER_Y[even]
    count = int(np.count_nonzero(_ORDER[even] <= _DEGREE))
    inverse, response = _coarse_inverse(
        guide, share, _legendre(coarse.x, *box[0]).T[powers[0]], _legendre(coarse.y, *box[1]).T[powers[1]], count
    )
    # sums run over fine cells, and displacements are counted in them
    narrow = fine.spacing / coarse.spacing
    inverse *= narrow**2
    stiff, flexible = np.zeros((2, _SIZE**2, _SIZE**2))
    place = powers[1] * _SIZE + powers[0]
    stiff[np.ix_(place[:count], place[:count])] = inverse * narrow
    flexible[np.ix_(place, place[:count])] = response @ inverse
    return SmoothModes(
        along_x=operator.asarray(_legendre(fine.x, *box[0])),
        along_y=operator.asarray(_legendre(fine.y, *box[1])),
        flexible=operator.asarray(flexible),
        stiff=operator.asarray(stiff),
        xp=operator.xp,
    )


def _coarse_inverse(guide: Operator, share: Array, x: Array, y: Array, count: int) -> tuple[Array, Array]:
    """E^-1 and Y in the units of the coarse grid; of the products of polynomials x and y the first `count` are pressures."""
    # notation: P all products of polynomials, Z the first of them times the share of a cell in contact
    P = y[:, :, None] * x[:, None, :]
    Z = P[:count] * share
    inside = share > 0
    displaced = _convolve_all(guide, Z)[:, inside].T
    P, Z, share = P[:, inside], Z[:, inside], share[inside]
    gram = (P * share) @ P.T
    Y = np.linalg.lstsq(gram, (P * share) @ displaced, rcond=_SINGULAR)[0]
    return _inverse_of_told_apart(Z @ displaced, gram[:count, :count]), np.asarray(Y)


def _inverse_of_told_apart(E: Array, gram: Array) -> Array:
    """E^-1 on those combinations of pressures that are not all but dependent nor all but without effect."""
    size, shape = np.linalg.eigh(gram)
    kept = size > _SINGULAR * size[-1]
    unit = shape[:, kept] / np.sqrt(size[kept])
    softness, mode = np.linalg.eigh(unit.T @ ((E + E.T) / 2) @ unit)
    kept = softness > _STIFFEST * softness[-1]
    unit = unit @ (mode[:, kept] / np.sqrt(softness[kept]))
    return np.asarray(unit @ unit.T)


def _convolve_all(guide: Operator, loads: Array) -> Array:
    """Displacements [its cells] of a stack of pressures on the guide's grid."""
    usual = guide if guide.xp is np else replace(guide, spectrum=to_numpy(guide.spectrum), xp=np)
    # a few at a time, so that this takes less memory than the solve on the fine grid
    return np.concatenate([usual.apply(loads[i : i + _AT_ONCE]) for i in range(0, len(loads), _AT_ONCE)])


def _overlap(coarse: Array, wide: float, fine: Array, narrow: float) -> Array:
    """Share of each coarse cell that each fine cell covers, along one axis; shape (coarse, fine)."""
    low = np.maximum(coarse[:, None] - wide / 2, fine - narrow / 2)
    high = np.minimum(coarse[:, None] + wide / 2, fine + narrow / 2)
    return np.asarray(np.maximum(high - low, 0.0) / wide)


def _scaling(used: Array, mirrored: bool) -> tuple[float, float]:
    """Centre and half-width of a range of cells, or of what it is the positive half of."""
    if mirrored:
        return 0.0, float(used[-1])
    return float(used[0] + used[-1]) / 2, max(float(used[-1] - used[0]) / 2, float(np.finfo(float).tiny))


def _legendre(x: Array, centre: float, half: float) -> Array:
    return np.asarray(legvander(np.clip((x - centre) / half, -1.2, 1.2), _RESPONSE_DEGREE))
