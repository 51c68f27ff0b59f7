"""Any history, contact growing and shrinking as often as it likes: a row of independent viscoelastic springs.

A round contact on any medium is a superposition of flat punches, p = int q(x) p_x dx, p_x the pressure of a punch of radius
x. In the contact the displacement d - f(r) for r < x fixes the deflection w(x) = d - d_n(x), d_n(x) the depth at which an elastic
contact has radius x, and the force is int w dK(x); outside no pressure means q = 0 there. Both maps are triangular in x, so
that with time each x is a spring of stiffness dK(x) with the relaxation of the medium: pushed where it would otherwise be
penetrated, free (q = 0) where not. For half-spaces this is the method of dimensionality reduction (Popov and Hess; Argatov and
Popov 2016); here K and d_n are those of the medium, taken from its elastic curve alone.

Each step is implicit: a spring moves by the larger of what keeps it free and what the tip demands, linear over the step.
Second order in the steps and in the number of springs.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.blas import dger

from flatpunch._support.checks import Array
from flatpunch.contact.viscoelastic.elastic import ElasticCurve
from flatpunch.contact.viscoelastic.series import ExponentialSeries, mean_decay

SPRINGS = 400
"""Springs, spaced by the square of their number in depth: they reproduce the elastic force to about 1e-5."""

_ITERATIONS = 50

_FADED = 1e-60
"""Share down to which a term's memory waits to be multiplied by it; far from the smallest float even after one more step."""

_GONE = 40.0
"""Rate times step from which on exp(-z) is below rounding."""


class Springs:
    """Row of springs for contacts up to the depth `deepest` (at which an elastic contact has the largest radius needed)."""

    def __init__(self, elastic: ElasticCurve, series: ExponentialSeries, deepest: float) -> None:
        self.touch = deepest * np.linspace(0, 1, SPRINGS + 1) ** 2
        # with these stiffnesses the elastic force is exact whenever the depth reaches a spring
        slopes = np.diff(elastic.force(self.touch)) / np.diff(self.touch)
        self.stiffness = np.append(np.diff(slopes, prepend=0.0), 0.0)
        self.series = series

    def follow(self, time: Array, target: Array, *, by_force: bool) -> tuple[Array, Array, Array]:
        """Depth [m], force [N] and contact depth [m] along a history of depths or forces, shape (n,) each.

        The first time is a jump from rest.
        """
        series = self.series
        step = np.concatenate([[0.0], np.diff(time)])
        z = step[:, None] * series.rates
        decay, gain = np.exp(-z), mean_decay(z) * series.weights
        total = series.constant + gain.sum(axis=1)
        # rates ascend: terms that are gone after one step need no memory, unless a shorter step follows
        lasting = [int(count) for count in np.sum(z < _GONE, axis=1)]
        deflection = np.zeros_like(self.touch)
        # memory of term j is faded[j] memory[:, j]: fading all of it costs no pass over the springs
        memory = np.zeros((self.touch.size, series.rates.size), order="F")
        faded = np.ones(series.rates.size)
        result = np.zeros((3, time.size))
        depth = 0.0
        for n in range(time.size):
            k = lasting[n]
            faded[:k] *= decay[n, :k]
            # what each spring does by itself, and the depth from which on the tip pushes it
            free = (series.constant * deflection + memory[:, :k] @ faded[:k]) / -total[n]
            threshold = self.touch + deflection + free
            depth = self._depth(threshold, total[n], target[n], depth) if by_force else float(target[n])
            pushed = np.maximum(depth - threshold, 0.0)
            moved = free + pushed
            deflection += moved
            following = max(k, lasting[min(n + 1, time.size - 1)])
            memory[:, k:following], faded[k:following] = 0.0, 1.0
            weak = np.flatnonzero(faded[:following] < _FADED)
            if weak.size:
                memory[:, weak] *= faded[weak]
                faded[weak] = 1.0
            # in place: leading columns of an array in Fortran's order
            dger(1.0, moved, gain[n, :following] / faded[:following], a=memory[:, :following], overwrite_a=1)
            result[:, n] = depth, total[n] * (self.stiffness @ pushed), self._extent(depth - threshold)
        return result[0], result[1], result[2]

    def _depth(self, threshold: Array, total: float, force: float, guess: float) -> float:
        """Depth at which the pushed springs carry a force: Newton on a convex, piecewise linear function."""
        depth = max(guess, float(threshold[0]))
        if force <= 0:
            return float(threshold.min())
        for _ in range(_ITERATIONS):
            pushed = depth - threshold
            active = pushed > 0
            slope = total * float(self.stiffness @ active)
            if slope <= 0:
                depth = float(np.sort(threshold)[1])
                continue
            change = (force - total * float(self.stiffness @ np.where(active, pushed, 0))) / slope
            depth += change
            # the function is piecewise linear: at the right piece Newton is exact
            if abs(change) <= 1e-14 * abs(depth):
                break
        return depth

    def _extent(self, pushed: Array) -> float:
        """Contact depth: where the deflection forced on the springs reaches zero, linear between springs."""
        if pushed[0] <= 0:
            return 0.0
        last = int(np.flatnonzero(pushed > 0)[-1])
        if last + 1 == pushed.size:
            return float(self.touch[-1])
        share = pushed[last] / (pushed[last] - pushed[last + 1])
        return float(self.touch[last] + share * (self.touch[last + 1] - self.touch[last]))
