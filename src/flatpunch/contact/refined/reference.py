"""Round contact of the angular mean of a tip over x = ln d, which the solutions of boundary elements are divided by.

Over the depth the ratio of both forces changes by some per cent where the force itself changes by orders of magnitude, so that
few solutions determine it. Round contacts are taken on a lattice of depths and joined by cubic Hermite pieces: what matters is
that the same smooth function divides and multiplies.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from flatpunch._support.checks import Array
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, ControlName
from flatpunch.contact.round.mean_profile import mean_contact, resolved_radius
from flatpunch.contact.round.radius_search import PER_DECADE
from flatpunch.indenters.profile import Indenter

STEP = np.log(10) / PER_DECADE
"""Spacing of the lattice in ln d; twice as wide, forces of round contacts are off by 1e-5 between its points."""


class RoundReference:
    """Round contacts of the mean profile.

    Parameters
    ----------
    kernel, indenter
        Medium and indenter.
    """

    def __init__(self, kernel: Kernel, indenter: Indenter) -> None:
        self.kernel, self.indenter = kernel, indenter
        self._rows: dict[int | float, tuple[float, ...]] = {}
        self._end = np.inf

    def position(self, quantity: ControlName, logarithm: Array) -> Array:
        """ln d of the round contacts whose ln F/E* ("force"), ln a ("radius") or ln d has these values, shape (n,)."""
        scale = self.kernel.modulus if quantity == "force" else 1.0
        control = Control(quantity, scale * np.exp(logarithm))
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(mean_contact(self.kernel, self.indenter, control)[1].depth))

    def at(self, x: Array) -> tuple[Array, Array, Array]:
        """ln F/E*, dln F/dx and ln a at x = ln d, shape (n,) each."""
        table = self._table(float(x.min()), float(x.max()))
        force, radius = (CubicHermiteSpline(table[0], table[row], table[row + 1]) for row in (1, 3))
        return force(x), force(x, 1), radius(x)

    def smooth(self, low: float, high: float) -> bool:
        """Whether ln F has no jump between two positions: under stiff films the depth of round contacts may turn back."""
        nodes, force, growth, *_ = self._table(low, high)
        secant = np.diff(force) / np.diff(nodes)
        # difference between slope and secant of ln F above which the depth of round contacts has turned back
        return bool(np.isfinite(force).all() and np.abs(secant - (growth[1:] + growth[:-1]) / 2).max() < 0.3)

    def _table(self, low: float, high: float) -> Array:
        """Positions on the lattice around [low, high], ln F/E*, its slope, ln a and its slope, shape (5, points)."""
        numbers: list[int | float] = list(range(int(np.floor(low / STEP)) - 1, int(np.ceil(high / STEP)) + 2))
        if numbers[-1] * STEP > self._end or not self._known(numbers):
            # raises what is wrong with the depth, which would be taken for the end of the tip otherwise
            self.position("depth", np.array([high]))
            self._find_end(high)
            numbers = [number for number in numbers if number * STEP < self._end]
            if self._end <= high + STEP:
                numbers.append(self._end / STEP)
            if len(numbers) < 2 or not self._known(numbers):
                raise ValueError(
                    f"depth = {text(float(np.exp(high)), 'm')}: the contact radius changes too fast with the depth for method="
                    "'refined', which interpolates between depths. Check the shape of the tip, or choose method='second-order'."
                )
        rows = np.array([self._rows[number] for number in numbers])
        return np.column_stack([np.array(numbers) * STEP, rows]).T

    def _known(self, numbers: list[int | float]) -> bool:
        """Whether the contacts of these numbers are known, or could be found."""
        new = [number for number in numbers if number not in self._rows]
        if not new:
            return True
        depth = np.exp(np.array(new) * STEP)
        try:
            contact = mean_contact(self.kernel, self.indenter, Control("depth", depth))[1]
        except ValueError:
            return False
        with np.errstate(divide="ignore", invalid="ignore"):
            growth = contact.stiffness * depth / contact.force
            rows = (
                np.log(contact.force / self.kernel.modulus),
                growth,
                np.log(contact.radius),
                depth / contact.depth_slope,
            )
        self._rows.update(zip(new, zip(*(row.tolist() for row in rows), strict=True), strict=True))
        return True

    def _find_end(self, high: float) -> None:
        """ln d at which the tip, or what the medium resolves, ends."""
        if np.isfinite(self._end):
            return
        last = min(self.indenter.reach, resolved_radius(self.kernel))
        if np.isfinite(last):
            self._end = float(self.position("radius", np.log([last * (1 - 1e-9)]))[0])
        else:
            self._end = high
