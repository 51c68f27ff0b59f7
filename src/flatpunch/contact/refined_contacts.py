"""What `refined` says of contacts: force and stiffness, radius, area and outline, and how far to trust them."""

from __future__ import annotations

from dataclasses import dataclass

from flatpunch._validation import Array, Flags


@dataclass(frozen=True, slots=True)
class Refined:
    """Refined contacts, shape (n,) each; `shape` has the columns of a solution from RADIUS on, shape (n, 2 + angles).

    `error` and `shape_error` are the estimates of force and outline; `traced` is False beside a solution whose contact has no
    outline.
    """

    force: Array
    stiffness: Array
    shape: Array
    error: Array
    shape_error: Array
    traced: Flags
