"""What a history brings, and how closely it is solved."""

from __future__ import annotations

from dataclasses import dataclass

from flatpunch._support.checks import Array

TOLERANCE = 2e-5
"""Error of the force over its largest value down to which springs are added and steps are halved."""

SECOND_ORDER = 2 / 3
"""Share of the change by twice as many springs or steps that is taken for the error left: it bounds orders from one to two."""


@dataclass(frozen=True, slots=True)
class Response:
    """Arrays of shape (n,): depth [m], force [N], contact depth [m], and the estimated error of the force [N].

    The contact depth is that of the elastic contact with the same extent. Where the force is prescribed the error is that of the
    force which the depth would need.
    """

    depth: Array
    force: Array
    contact: Array
    error: Array
