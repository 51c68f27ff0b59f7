"""Removing the gap on one contact after another: which way is taken follows from the contact and from how the last step went.

Few cells are solved directly (direct.py), where conjugate gradients (conjugate.py) would do worst.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatpunch._support.checks import Array
from flatpunch.bem.operator.convolution import Operator
from flatpunch.bem.solver.conjugate import remove_gap
from flatpunch.bem.solver.direct import Influence, affordable, influence, offsets

_SLOW = 40
"""Inner iterations in one step from which on larger contacts than before are solved directly."""

_MANY = 6
"""Inner iterations in one step from which on the next ones continue displacements beyond the contact."""

_FARTHER = 0.2
"""What these reduce a gap by over what is asked of others: their steps are few, and contacts settle in fewer turns."""

_LONGEST = 150
"""Most inner iterations in one step: what has not come to an end by then has met rounding, and starts anew from what it has."""


@dataclass(slots=True)
class Removal:
    """What is known about a contact while it is being found.

    Attributes
    ----------
    operator, inner : Operator
        Displacement from pressure in full precision, and in single for the iterations.
    direct : bool
        Whether contacts of few cells may be solved directly.
    once : bool
        Whether there is but one contact, on which one step is enough.
    directly : bool
        Whether the last step was a direct one.
    continued : bool
        Whether iterations continue displacements beyond the contact.
    """

    operator: Operator
    inner: Operator
    direct: bool = True
    once: bool = False
    directly: bool = False
    continued: bool = False
    _influence: Influence | None = None
    _table: Array | None = None
    _slow: bool = False

    def __call__(self, contact: Any, gap: Any, drop: float, limit: int) -> tuple[Any, int]:
        """Pressure on `contact` that reduces the gap there by about `drop`, with the iterations taken; see `remove_gap`."""
        cells = int(self.operator.xp.count_nonzero(contact))
        self.directly = False
        if self.direct and affordable(self.operator, cells, slow=self._slow, once=self.once):
            change = self._directly(contact, gap)
            if change is not None:
                self.directly = True
                return change, 1
            self.direct = False
        most = min(limit, _LONGEST)
        wanted = _FARTHER * drop if self.continued else drop
        change, count = remove_gap(self.inner, contact, gap, wanted, most, continued=self.continued)
        self._slow |= count >= _SLOW
        self.continued |= count >= _MANY
        return change, count

    def _directly(self, contact: Any, gap: Any) -> Any:
        if self._influence is None or not self._influence.covers(contact):
            self._table = offsets(self.operator) if self._table is None else self._table
            self._influence = influence(self.operator, contact, self._table)
        return self._influence.remove_gap(contact, gap)
