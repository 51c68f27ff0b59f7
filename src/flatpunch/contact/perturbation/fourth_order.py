"""Fourth-order perturbation theory for power-law indenters, in its Pade form (T8.11), passing over to second order.

Where the fourth-order terms become too large for the series to hold, force and outline pass over to those of second order at the
same depth, smoothly over a range of contact sizes: neither force nor stiffness jumps, and the result at one depth does not depend
on the other depths of a curve.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import Array
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, Curve, first_failure
from flatpunch.contact.perturbation import first_order
from flatpunch.contact.perturbation.error import estimates, fourth_order_error, second_order_error
from flatpunch.contact.perturbation.perturbed_contact import PathPoint, PerturbedContact, selected
from flatpunch.contact.perturbation.power_law_series import power_expansion, same_depth
from flatpunch.contact.perturbation.second_order import solve_expansion
from flatpunch.contact.round.mean_profile import resolved_radius
from flatpunch.contact.round.radius_search import Loading
from flatpunch.indenters.geometry.angles import angular_rule
from flatpunch.indenters.profile import Indenter

_WIDTH = 0.5
"""Range of ln a within which fourth order passes over to second, on the side where it holds. In a narrower one the stiffness
departs farther from that of either: by 1.5 times their difference in force over this width."""

_SPACING = 0.05
"""Spacing, in ln a, of the radii at which fourth order is checked; the same ones for every curve. A wider one may miss a pole."""


class BlendedExpansion:
    """Fourth order where it holds, second order where it does not, over the base radius of second order.

    Parameters
    ----------
    kernel, indenter
        Medium and power-law indenter.
    """

    def __init__(self, kernel: Kernel, indenter: Indenter) -> None:
        self.kernel, self.indenter = kernel, indenter
        self._second, self._fourth = (power_expansion(kernel, indenter, order) for order in ("second", "fourth"))
        self.base = self._second.base
        self._ratio = (self.base.factor / self._fourth.base.factor) ** (1 / self.base.exponent)
        self._known: tuple[bytes, tuple[PerturbedContact, PerturbedContact, Array, Array]] | None = None

    def descent(self, radius: Array) -> Loading:
        """Depth and its derivative at base radii of shape (n,), >= 0 [m]."""
        return self._second.descent(radius)

    def loading(self, radius: Array) -> PathPoint:
        """Depth, force and their derivatives at base radii of shape (n,), >= 0 [m]."""
        weight, growth = self._weight(radius)
        second = self._second.loading(radius)
        if not (weight > 0).any():
            return second
        return self._path(second, self._fourth.loading(self._other(radius, second.depth)), weight, growth)

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at base radii, shape (n,), >= 0 [m]."""
        second, fourth, weight, growth = self.parts(radius)
        path = self._path(second, fourth, weight, growth)
        mixed = {
            name: _mean(getattr(second, name), getattr(fourth, name), weight)
            for name in ("size", "mean_radius", "area", "swing", "terms")
        }
        both = (weight > 0) & (weight < 1)
        if both.any():
            phi, share = angular_rule(self.indenter)
            mixed["area"][both] = np.pi * self._outline(radius[both], phi) ** 2 @ share
        return replace(second, force=path.force, stiffness=path.stiffness, **mixed)

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Contact outline a(phi), shape (n, p) [m]."""
        return self._outline(contact.radius, phi)

    def parts(self, radius: Array) -> tuple[PerturbedContact, PerturbedContact, Array, Array]:
        """Contacts of second and fourth order at the same depths, the weight of the fourth and its growth, shape (n,)."""
        key = radius.tobytes()
        if self._known is None or self._known[0] != key:
            second = self._second.evaluate(radius)
            fourth = self._fourth.evaluate(self._other(radius, second.depth))
            self._known = key, (second, fourth, *self._weight(radius))
        return self._known[1]

    def holds(self, contact: PerturbedContact) -> bool:
        """Whether contacts of fourth order need no second order at all."""
        return bool((self._weight(contact.radius / self._ratio)[0] == 1).all())

    def _outline(self, radius: Array, phi: Array) -> Array:
        second, fourth, weight, _ = self.parts(radius)
        outline = np.zeros((radius.size, phi.size))
        for expansion, contact, share in ((self._second, second, 1 - weight), (self._fourth, fourth, weight)):
            some = share > 0
            if some.any():
                outline[some] += share[some, None] * expansion.outline(selected(contact, some), phi)
        return outline

    def _other(self, radius: Array, depth: Array) -> Array:
        """Base radii of fourth order at the same depths, shape (n,)."""
        return same_depth(self.kernel, self.base, self._fourth.base, radius, depth)

    def _weight(self, radius: Array) -> tuple[Array, Array]:
        """Weight of the fourth order, smooth in the distance in ln a to where it fails, and its derivative; (n,) each."""
        weight, growth = np.ones_like(radius), np.zeros_like(radius)
        live = radius > 0
        if not live.any():
            return weight, growth
        x = np.log(radius[live])
        nodes, doubt = self._doubts(float(x.min()) - _WIDTH, float(x.max()) + _WIDTH)
        beyond = doubt >= 1
        change = np.flatnonzero(beyond[1:] != beyond[:-1])
        share = (1 - doubt[change]) / (doubt[change + 1] - doubt[change])
        ends = nodes[change] + _SPACING * share
        if not ends.size:
            weight[live] = 0.0 if beyond.any() else 1.0
            return weight, growth
        away = x[:, None] - ends
        nearest = np.take_along_axis(away, np.abs(away).argmin(axis=1)[:, None], axis=1)[:, 0]
        holds = np.interp(x, nodes, doubt) < 1
        t = np.where(holds, np.minimum(np.abs(nearest) / _WIDTH, 1.0), 0.0)
        weight[live], growth[live] = t * t * (3 - 2 * t), 6 * t * (1 - t) * np.sign(nearest) / _WIDTH
        return weight, growth

    def _doubts(self, low: float, high: float) -> tuple[Array, Array]:
        """Logarithms of base radii on a fixed grid that covers a range, and the doubt about fourth order there."""
        if self.kernel.homogeneous or self.kernel.exponent:
            nodes = np.array([low, high])
        else:
            last = np.log(resolved_radius(self.kernel) / max(self._ratio, 1.0))
            first, end = np.floor(low / _SPACING), min(np.ceil(high / _SPACING), np.floor(last / _SPACING))
            nodes = _SPACING * np.arange(min(first, end), end + 1)
        return nodes, self._fourth.doubt(np.exp(nodes) * self._ratio)

    def _path(
        self, second: PathPoint | PerturbedContact, fourth: PathPoint | PerturbedContact, weight: Array, growth: Array
    ) -> PathPoint:
        """Path whose ln F is the weighted mean; dF/dd = F (mean of dln F/dd + (dweight/dd) ln(F4/F2))."""
        both = (weight > 0) & (weight < 1) & (second.force > 0) & (fourth.force > 0) & (second.depth_slope > 0)
        force = np.where(weight == 1, fourth.force, second.force)
        stiffness = np.where(weight == 1, fourth.stiffness, second.stiffness)
        f2, f4, w = second.force[both], fourth.force[both], weight[both]
        force[both] = f2 ** (1 - w) * f4**w
        slope = _mean(second.stiffness[both] / f2, fourth.stiffness[both] / f4, w)
        slope += growth[both] / second.depth_slope[both] * np.log(f4 / f2)
        stiffness[both] = force[both] * slope
        return PathPoint(second.radius, second.depth, force, stiffness, second.depth_slope)


def solve(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """A whole curve; a note gives the depths at which it is second order."""
    if indenter.round:
        return first_order.solve(kernel, indenter, control, phi)
    check(indenter)
    expansion = _expansion(kernel, indenter)
    curve, contact = solve_expansion(kernel, indenter, power_expansion(kernel, indenter, "fourth"), control, phi)
    if expansion.holds(contact):
        return replace(curve, extra=estimates(*fourth_order_error(indenter, contact)))
    curve, contact = solve_expansion(kernel, indenter, expansion, control, phi)
    second, fourth, weight, _ = expansion.parts(contact.radius)
    errors = zip(second_order_error(indenter, second), fourth_order_error(indenter, fourth), strict=True)
    curve = replace(curve, extra=estimates(*(_mean(*pair, weight) for pair in errors)))
    note = first_failure(
        weight < 1,
        curve.depth,
        "the fourth-order term is too large, or changes too fast with the size of the contact (strong asymmetry or a stiff "
        "film), and the result passes over to second order. method='refined' holds there, at the cost of some seconds.",
    )
    return replace(curve, notes=tuple(dict.fromkeys((*curve.notes, *note))))


def check(indenter: Indenter) -> None:
    """Refuse shapes that are no power law."""
    if indenter.exponent is None:
        raise ValueError(
            f"method = 'fourth-order' needs a power-law shape f = r^n psi(phi); {type(indenter).__name__} is none. "
            "Choose 'second-order', 'refined' or 'bem'."
        )


@byte_cached
def _expansion(kernel: Kernel, indenter: Indenter) -> BlendedExpansion:
    """The blended series of a medium and an indenter."""
    return BlendedExpansion(kernel, indenter)


def _mean(second: Array, fourth: Array, weight: Array) -> Array:
    """Weighted mean, with the one or the other exactly where the weight is 0 or 1."""
    share = weight.reshape(-1, *(1,) * (second.ndim - 1))
    both = share * fourth + (1 - share) * second
    return np.where(share == 0, second, np.where(share == 1, fourth, both))
