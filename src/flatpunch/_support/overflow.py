"""Numbers that overflow end in one refusal at the door, not in warnings and NaN.

Where NumPy would warn of an overflow, a division by zero or an invalid operation, a case has left what can be computed: the code
expects none outside the places that say so themselves.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np


@contextmanager
def refused_overflow() -> Iterator[None]:
    """Turn over- and underflows, and arrays beyond the memory, into a ValueError with the remedy; usable as a decorator."""
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except (ArithmeticError, MemoryError, np.linalg.LinAlgError) as error:
        raise ValueError(
            "The numbers of this case overflow, or differ by more than can be computed: moduli, lengths, or the depth against "
            "the tip. Check the units."
        ) from error
