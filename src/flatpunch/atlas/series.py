"""Sparse Chebyshev series over ln beta and the parameters of a family, for many outputs at once.

Of the full tensor of coefficients only those above a cutoff are kept, each with its degrees: a list of products
T_i(ln beta) T_j(p1) T_k(p2). Parameters are put in first; what is left is a short series over ln beta for each output.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flatpunch._support.checks import Array, Indices
from flatpunch.numerics.chebyshev import NODES, polynomials


@dataclass(frozen=True, eq=False)
class SparseSeries:
    """Coefficients that matter, of `outputs` functions on one panel.

    Attributes
    ----------
    outputs : int
        Number of functions.
    value : ndarray, shape (entries,)
        Coefficients.
    output, beta_degree : ndarray of int, shape (entries,)
        Function and degree over ln beta of each.
    degrees : tuple of ndarray of int, shape (entries,) each
        Degree over each parameter.
    """

    outputs: int
    value: Array
    output: Indices
    beta_degree: Indices
    degrees: tuple[Indices, ...]
    _row: Indices = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_row", self.output.astype(np.int64) * NODES + self.beta_degree)

    @classmethod
    def from_dense(cls, dense: Array, cutoff: float) -> SparseSeries:
        """Keep what is above the cutoff of coefficients of shape (outputs, NODES, degrees of parameter 1, ...)."""
        kept = np.nonzero(np.abs(dense) >= cutoff)
        return cls(dense.shape[0], dense[kept], kept[0], kept[1], tuple(kept[2:]))

    def at(self, x: tuple[float, ...]) -> Array:
        """Series over ln beta at coordinates x in [-1, 1] of the parameters, shape (NODES, outputs)."""
        weight = self.value
        for degree, coordinate in zip(self.degrees, x, strict=True):
            weight = weight * polynomials(np.array([coordinate]), int(degree.max(initial=0)))[degree, 0]
        dense = np.bincount(self._row, weight, minlength=self.outputs * NODES)
        return np.ascontiguousarray(dense.reshape(self.outputs, NODES).T)

    def combined(self, weights: Array) -> Array:
        """Dense coefficients of a weighted sum of the functions, shape (NODES, degrees of parameter 1, ...).

        Parameters
        ----------
        weights : ndarray, shape (outputs,)
        """
        shape = (NODES, *(int(degree.max(initial=0)) + 1 for degree in self.degrees))
        index = np.ravel_multi_index((self.beta_degree, *self.degrees), shape)
        total = np.bincount(index, self.value * weights[self.output], minlength=int(np.prod(shape)))
        return np.asarray(total.reshape(shape), dtype=float)


def evaluate(dense: Array, x: Array, parameters: tuple[Array, ...]) -> Array:
    """Sum of a dense series at n points, given by coordinates of ln beta and of the parameters in [-1, 1]."""
    used = np.flatnonzero(np.abs(dense).reshape(NODES, -1).max(axis=1))
    last = int(used[-1]) if used.size else 0
    basis = polynomials(x, last)
    if not parameters:
        return np.asarray(dense[: last + 1] @ basis)
    # over the last parameter first: a product of matrices, then sums along the columns
    inner = dense[: last + 1].reshape(-1, dense.shape[-1]) @ polynomials(parameters[-1], dense.shape[-1] - 1)
    values = inner.reshape(*dense[: last + 1].shape[:-1], x.size)
    for coordinate in parameters[-2::-1]:
        other = polynomials(coordinate, values.shape[-2] - 1)
        values = np.einsum("...kn,kn->...n", values, other)
    return np.asarray(np.einsum("in,in->n", values, basis))
