"""Flexibility carried up through graded layers.

What lies below a depth enters through its flexibility H, (u_r, u_z) = H (s_rz, s_zz)/k (see `layered`). In a graded
layer H obeys a Riccati equation in the height t = k z upwards, here written for H = [[a, b], [b, c]], or, where the lower
face slides or is much softer (a is large or infinite there), for (s_rz, u_z) = [[p, r], [-r, w]] (u_r, s_zz):

    a' = m a^2 - 2 b - 1/mu,        b' = a (nu/(1 - nu) + m b) - c,     c' = b (2 nu/(1 - nu) + m b) - g
    p' = p^2/mu - 2 p r - m,        r' = p (r/mu + w) - r^2 - nu/(1 - nu),      w' = -r^2/mu - 2 r w - g

with m = 2 mu/(1 - nu), g = (1 - 2 nu)/(2 mu (1 - nu)): finite at nu = 1/2, no pole, errors decay upwards like
exp(-2 k z). Runge-Kutta steps of order 8 (Dormand and Prince), each wavenumber with its own step and error control: the
deeper, the looser, and nothing below k z = 25 is touched. Transversely isotropic layers obey the same equations, with their
coefficients of plane strain in the place of nu/(1 - nu), 1/mu, g and m, and with the integral of the slower of their two rates of
decay in the place of z.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy

from flatpunch._support.checks import ROUNDING, TINY, Array
from flatpunch._support.prefixes import text
from flatpunch.compliances.layered import SATURATION
from flatpunch.compliances.stack import Decay
from flatpunch.compliances.transverse import flexibility_of
from flatpunch.media import AnyLayer
from flatpunch.media.plane import over

TOLERANCE = 1e-12
"""Estimated relative error of one step, as it arrives at the surface."""


Rates = Callable[[Array, Sequence[Array]], Array]
"""Slopes of a state under the coefficients of plane strain at one depth per wavenumber."""


def carry_through_graded(layer: AnyLayer, below: Array, k: Array, scale: float) -> Array:
    """Flexibility at the upper face of `layer` from `below`, the one at its lower face; shape (2, 2, n)."""
    decay = Decay.of(layer)
    depth = decay.depth_of(SATURATION / k)
    start = below.copy()
    hidden = depth < layer.thickness
    if hidden.any():
        start[:, :, hidden] = flexibility_of(over(scale, layer.plane_at(depth[hidden])))
    bottom = over(scale, layer.plane_at(np.array([layer.thickness])))
    mixed = ~hidden & (np.abs(below[0, 0]) > 3.0 * bottom.shear)
    if not layer.bonded:
        mixed = ~hidden
    above = np.empty_like(below)
    for chosen, enter, rates, leave in (
        (~mixed, _enter_flexibility, _flexibility_rates, _leave_flexibility),
        (mixed, _enter_mixed, _mixed_rates, _leave_mixed),
    ):
        if chosen.any():
            state = enter(start[:, :, chosen], bool(layer.bonded))
            above[:, :, chosen] = leave(_integrate(layer, decay, rates, state, k[chosen], depth[chosen], scale))
    return above


def _integrate(
    layer: AnyLayer, decay: Decay, rates: Rates, state: Array, k: Array, depth: Array, scale: float
) -> Array:
    """State (3, n) at the upper face from the state at `depth`."""
    breaks = np.array([0.0, *layer.breaks])
    result = state.copy()
    step = np.minimum(depth, 0.25 / k)
    active = np.flatnonzero(depth > 0)
    depth = depth.copy()
    # steps are as short as the faster rate wants, and reach as deep as the slower one
    for _ in range(int(5000 * float(decay.fast.max() / decay.slow.min()))):
        if active.size == 0:
            return result
        z, q, wanted = depth[active], k[active], step[active]
        floor = breaks[np.searchsorted(breaks, z * (1 - ROUNDING)) - 1]
        left = z - floor
        # what is less than two steps is halved, so that no sliver is left before the next break
        d = np.where(wanted >= left, left, np.where(wanted > left / 2, left / 2, wanted))
        y, error = _runge_kutta(layer, rates, result[:, active], q, z, d, scale)
        shallow = q * decay.down_to(z - d)
        allowed = TOLERANCE * np.exp(np.minimum(2 * shallow, 18.0)) / (1 + shallow) ** 2
        good = error <= allowed
        growth = 0.9 * (allowed / np.maximum(error, TINY)) ** 0.125
        step[active] = d * np.clip(growth, 0.2, 5.0)
        moved = active[good]
        depth[moved] = np.where(d[good] == left[good], floor[good], (z - d)[good])
        result[:, moved] = y[:, good]
        _check_step(layer, z[~good], d[~good])
        active = active[depth[active] > 0]
    raise ValueError("The grading of a layer needs more steps than are allowed: its law oscillates too fast in depth.")


def _check_step(layer: AnyLayer, z: Array, d: Array) -> None:
    tiny = d < 10 * ROUNDING * z
    if tiny.any():
        raise ValueError(
            f"The grading of a layer cannot be resolved near its depth z = {text(float(z[tiny][0]), 'm')} "
            f"(thickness {layer.thickness:g} m): it jumps there. Split the layer at the jump."
        )


def _runge_kutta(
    layer: AnyLayer, rates: Rates, y: Array, k: Array, z: Array, d: Array, scale: float
) -> tuple[Array, Array]:
    """One step of order 8 from z to z - d, and its relative error."""
    rule = scipy.integrate.DOP853
    stages = rule.n_stages
    coefficients = np.stack(over(scale, layer.plane_at(z - rule.C[:stages, None] * d))[:4], axis=1)
    t = k * d
    slopes = np.empty((stages + 1, *y.shape))
    flat = slopes.reshape(stages + 1, -1)
    # a step that is far too long overflows and is refused by its error
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        slopes[0] = rates(y, coefficients[0])
        for stage in range(1, stages):
            increment = (rule.A[stage, :stage] @ flat[:stage]).reshape(y.shape)
            slopes[stage] = rates(y + t * increment, coefficients[stage])
        new = y + t * (rule.B @ flat[:stages]).reshape(y.shape)
        # the thirteenth slope is taken at the end of the step, like the twelfth
        slopes[stages] = rates(new, coefficients[stages - 1])
        fifth, third = (rule.E5 @ flat).reshape(y.shape), (rule.E3 @ flat).reshape(y.shape)
        blend = fifth**2 / np.sqrt(fifth**2 + 0.01 * third**2)
        error = t * np.where(fifth == 0, 0.0, np.abs(blend))
        relative = np.maximum(error[0] / np.abs(new[0]), error[2] / np.abs(new[2]))
        relative = np.maximum(relative, error[1] / np.maximum(np.abs(new[1]), np.sqrt(np.abs(new[0] * new[2]))))
    return new, np.where(np.isfinite(relative), relative, np.inf)


def _flexibility_rates(y: Array, at: Sequence[Array]) -> Array:
    a, b, c = y
    coupling, shear, oedometric, stiffness = at
    rates = np.empty_like(y)
    mb = stiffness * b
    coupled = coupling + mb
    rates[0] = stiffness * a * a - 2 * b - shear
    rates[1] = a * coupled - c
    rates[2] = b * (coupling + coupled) - oedometric
    return rates


def _mixed_rates(y: Array, at: Sequence[Array]) -> Array:
    p, r, w = y
    coupling, shear, oedometric, stiffness = at
    rates = np.empty_like(y)
    soft_p, twice_r = shear * p, 2 * r
    rates[0] = p * (soft_p - twice_r) - stiffness
    rates[1] = soft_p * r + p * w - r * r - coupling
    rates[2] = -twice_r * w - shear * r * r - oedometric
    return rates


def _enter_flexibility(start: Array, bonded: bool) -> Array:
    return np.stack([start[0, 0], start[0, 1], start[1, 1]])


def _leave_flexibility(y: Array) -> Array:
    return np.array([[y[0], y[1]], [y[1], y[2]]])


def _enter_mixed(start: Array, bonded: bool) -> Array:
    if not bonded:
        zero = np.zeros_like(start[1, 1])
        return np.stack([zero, zero, start[1, 1]])
    a, b, c = start[0, 0], start[0, 1], start[1, 1]
    return np.stack([1 / a, -b / a, c - b * b / a])


def _leave_mixed(y: Array) -> Array:
    p, r, w = y
    return np.array([[1 / p, -r / p], [-r / p, w + r * r / p]])
