"""Force and contact depth of a row of springs, from the pulls of those in contact."""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import Array


class Lumps:
    """Springs at depths `touch` that make the elastic force exact for pulls Q linear between them."""

    def __init__(self, touch: Array, force: Array, stiffness: Array) -> None:
        self.touch, self.stiffness = touch, stiffness
        self.slope = np.diff(force) / np.diff(touch)
        self.lump = np.diff(self.slope, prepend=0.0, append=stiffness[-1])

    def force(self, pull: Array, extent: float) -> float:
        """Force [N] of springs pulled by Q [m], shape (n,), which reaches zero at the contact depth `extent`."""
        n = pull.size
        if not n:
            return 0.0
        total = float(self.lump[:n] @ pull)
        if n == self.touch.size:
            return total
        share = (extent - self.touch[n - 1]) / (self.touch[n] - self.touch[n - 1])
        # the lumps take Q as zero at the next spring and beyond
        return total + float(pull[n - 1] * (self.slope[n - 1] - self.stiffness[n - 1]) * (share - 1))

    def grown_to(self, contact: int, depth: float, height: Array) -> float:
        """Contact depth: where the heights of the springs ahead meet the tip, linear in between."""
        if not contact:
            return 0.0
        low = float(self.touch[contact - 1])
        if contact == self.touch.size:
            return low
        high = float(self.touch[contact])
        # beyond the last spring but one nothing was ever touched: heights rise as the depths of touch do
        last = height.size < 2 or height[1] <= height[0]
        slope = 1.0 if last else (height[1] - height[0]) / (self.touch[contact + 1] - high)
        return float(np.clip(high + (depth - height[0]) / slope, low, high))

    def shrunk_to(self, pull: Array) -> float:
        """Contact depth: where Q falls to zero, linear beyond the last springs in contact."""
        n = pull.size
        if not n:
            return 0.0
        low = float(self.touch[n - 1])
        if n == self.touch.size:
            return low
        high = float(self.touch[n])
        if n < 2 or pull[-2] <= pull[-1]:
            return high
        return float(np.clip(low + pull[-1] * (low - self.touch[n - 2]) / (pull[-2] - pull[-1]), low, high))
