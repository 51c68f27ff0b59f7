"""Matrices of flat punches on layers, which the package only uses inside its solutions."""

from __future__ import annotations

import numpy as np

from flatpunch.compliances import Kernel
from flatpunch.punch.basis import half_space_diagonal
from flatpunch.punch.graded import graded_matrices
from flatpunch.punch.matrix import remainder_rule


def kernel_matrix(kernel: Kernel, beta: np.ndarray, terms: int, parity: int = 0) -> np.ndarray:
    """B_pq for p, q = parity, parity + 2, ... at radii beta, shape (nb, terms, terms)."""
    if kernel.graded:
        return np.asarray(graded_matrices(kernel, beta, terms, parity)[0])
    return remainder_rule(kernel, beta, terms, parity).matrix() - np.diag(half_space_diagonal(parity, terms))
