"""Removing the gap on one contact after another: which way is taken follows from the contact and from how the last step went.

Few cells are solved directly (direct.py), where conjugate gradients (conjugate.py) would do worst. Elsewhere they have the
help of smooth modes (smooth.py) where these pay, and do without where they are found to do harm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flatpunch._validation import Array
from flatpunch.bem.conjugate import remove_gap
from flatpunch.bem.direct import Influence, affordable, influence, offsets
from flatpunch.bem.operator import Operator
from flatpunch.bem.smooth import SmoothModes, smooth_modes

_HARD = 8
"""Inner iterations in one step from which on the smooth part is worth its price, some tens of them on small grids."""

_SUSPECT = 16
"""Iterations at which a step with the smooth part is ended and one without is tried: it takes no more where it helps."""

_SLOW = 40
"""The same after that trial; and the iterations from which on larger contacts than before are solved directly."""

_LONGEST = 150
"""Most inner iterations in one step: what has not come to an end by then has met rounding, and starts anew from what it has."""

_STALE = 0.02
"""Change of the contact's area from which on the smooth part of the approximate inverse is made anew."""


@dataclass(slots=True)
class Removal:
    """What is known about a contact while it is being found.

    Attributes
    ----------
    operator, inner : Operator
        Displacement from pressure in full precision, and in single for the iterations.
    guide : Operator, optional
        The medium's operator on a coarse grid that covers this one, for the smooth part of the approximate inverse.
    eager : bool
        Whether that part is made at once; else only when a step turns out to be slow.
    direct : bool
        Whether contacts of few cells may be solved directly.
    once : bool
        Whether there is but one contact, on which one step is enough.
    directly : bool
        Whether the last step was a direct one.
    """

    operator: Operator
    inner: Operator
    guide: Operator | None = None
    eager: bool = False
    direct: bool = True
    once: bool = False
    directly: bool = False
    _modes: SmoothModes | None = None
    _known: int = 0
    _trying: bool = False
    _compared: bool = False
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
        modes = self._modes_for(contact, cells)
        if modes is None:
            longest = min(limit, _SUSPECT if self._trying else _LONGEST)
        else:
            longest = min(limit, _SLOW if self._compared else _SUSPECT)
        change, count, reached = remove_gap(self.inner, contact, gap, drop, longest, modes)
        if modes is not None and not reached and count < longest:
            # polynomials do not suit every contact: needles and crosses under stiff films leave them to rounding
            self.guide = self._modes = None
            change, more, _ = remove_gap(self.inner, contact, gap, drop, min(limit - count, _LONGEST))
            return change, count + more
        self._learn(modes is not None, count, reached)
        return change, count

    def _learn(self, smooth: bool, count: int, reached: bool) -> None:
        """Draw the lesson of a step with or without the smooth part: it is kept where it saves iterations."""
        self._slow |= count >= _SLOW
        self.eager |= count > _HARD
        if smooth and not reached:
            # given up at the second time
            self._trying, self.guide = True, None if self._compared else self.guide
        elif self._trying:
            self._trying, self._compared = False, True
            self.guide = None if reached else self.guide

    def _directly(self, contact: Any, gap: Any) -> Any:
        if self._influence is None or not self._influence.covers(contact):
            self._table = offsets(self.operator) if self._table is None else self._table
            self._influence = influence(self.operator, contact, self._table)
        return self._influence.remove_gap(contact, gap)

    def _modes_for(self, contact: Any, cells: int) -> SmoothModes | None:
        """Smooth modes of a contact, unless they are not wanted or a step without is being tried."""
        if self.guide is None or not self.eager or self._trying:
            return None
        if abs(cells - self._known) > _STALE * self._known:
            self._modes, self._known = smooth_modes(self.guide, self.inner, contact), cells
        return self._modes
