"""Curves and pressures from a perturbation series, whatever its order and kind of profile."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import Protocol

import numpy as np

from flatpunch._validation import Array
from flatpunch.compliance import Kernel
from flatpunch.contact.axisymmetric import RoundProfile
from flatpunch.contact.checks import soundness
from flatpunch.contact.control import Loading, radius_for
from flatpunch.contact.curve import Control, Curve, check_reach, first_failure
from flatpunch.contact.expansion import PerturbedContact
from flatpunch.contact.flat_end import punch_stiffness
from flatpunch.contact.history import History, log_radii, spline, spline_outline, superpose
from flatpunch.contact.mean import half_space_radius, resolved_radius
from flatpunch.indenters.profile import Indenter

_OUTLINE_ANGLES = 720

LARGEST_SWING = 1.2
"""|ln a(phi)/abar| above which outlines were off by tens of per cent under stiff films."""


class Expansion(Hashable, Protocol):
    """Perturbation series of one indenter on one medium over its base radius."""

    @property
    def base(self) -> RoundProfile:
        """Profile of the round base contact."""

    def loading(self, radius: Array) -> Loading:
        """Depth, force and their derivatives at base radii, shape (n,)."""

    def evaluate(self, radius: Array) -> PerturbedContact:
        """Contacts at base radii, shape (n,)."""

    def outline(self, contact: PerturbedContact, phi: Array) -> Array:
        """Outlines a(phi), shape (n, p)."""


def controlled(kernel: Kernel, indenter: Indenter, expansion: Expansion, control: Control) -> PerturbedContact:
    """Contacts at the prescribed depths, forces or mean radii a0."""
    if control.name == "radius":
        check_reach(indenter, control.values)
        return expansion.evaluate(_base_radius(expansion, control.values))
    guess = half_space_radius(kernel, expansion.base, control, indenter.reach)
    resolved = resolved_radius(kernel)
    radius = radius_for(expansion.loading, control.name, control.values, guess, indenter.reach, resolved)
    contact = expansion.evaluate(radius)
    # what rounding leaves of the radius goes along the curve, so that the prescribed value is met exactly
    if control.name == "depth":
        rest = control.values - contact.depth
        return replace(contact, depth=control.values, force=contact.force + contact.stiffness * rest)
    rest = (control.values - contact.force) / np.where(contact.stiffness > 0, contact.stiffness, 1.0)
    return replace(contact, force=control.values, depth=contact.depth + np.where(contact.stiffness > 0, rest, 0.0))


def _base_radius(expansion: Expansion, mean_radius: Array) -> Array:
    """Base radii whose contacts have the mean radii a0; a0 over a varies slowly, so that plain iteration converges."""
    radius = mean_radius.copy()
    live = mean_radius > 0
    before = np.zeros(int(live.sum()))
    x, step = np.log(mean_radius[live]), before
    for count in range(60):
        ratio = np.log(expansion.evaluate(np.exp(x)).mean_radius / mean_radius[live])
        # secant in each point once two are known
        change = ratio - before
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.where((count > 0) & (np.abs(change) > 1e-14), change / step, 1.0)
        step = -ratio / np.where((slope > 0.3) & (slope < 3), slope, 1.0)
        x, before = x + step, ratio
        if not step.size or np.abs(step).max() < 1e-14:
            break
    radius[live] = np.exp(x)
    return radius


def solve_expansion(
    kernel: Kernel, indenter: Indenter, expansion: Expansion, control: Control, phi: Array
) -> tuple[Curve, PerturbedContact]:
    """A whole curve, and the contacts it was made from."""
    contact = controlled(kernel, indenter, expansion, control)
    valid, notes = soundness(kernel, expansion.loading, contact)
    wide = contact.swing > LARGEST_SWING
    notes += first_failure(
        wide,
        contact.depth,
        "the outline deviates so much from a circle (|ln a/abar| above 1.2) that outline and area are uncertain by ten per "
        "cent and more; the force is less affected. Refine outline and area with method='refined' or 'bem'.",
    )
    curve = Curve(
        depth=contact.depth,
        force=contact.force,
        radius=contact.mean_radius,
        area=contact.area,
        stiffness=contact.stiffness,
        contour=expansion.outline(contact, phi),
        valid=valid & (contact.stiffness >= 0),
        notes=notes,
    )
    return curve, contact


def superpose_expansion(
    kernel: Kernel, indenter: Indenter, expansion: Expansion, control: Control, r: Array, phi: Array
) -> Array:
    """Pressure at polar coordinates (r, phi), shape (n,) [Pa].

    Flat-punch pressures, stretched to the outline of the series, are superposed over the history; each increment of the depth
    carries the stiffness of the series, so that the pressure integrates to the force.
    """
    end = float(controlled(kernel, indenter, expansion, control).radius[0])
    if end == 0:
        return np.zeros_like(r)
    x = log_radii(end)
    contact = expansion.evaluate(np.exp(x))
    angles = np.linspace(-np.pi, np.pi, _OUTLINE_ANGLES, endpoint=False)
    relative = expansion.outline(contact, angles) / contact.radius[:, None]
    square = contact.area / (np.pi * contact.radius**2)
    share = contact.stiffness / (punch_stiffness(kernel, contact.radius) * square)
    history = History(
        radius=end,
        rate=spline(x, contact.depth_slope / contact.radius),
        outline=spline_outline(x, relative),
        share=spline(x, share),
    )
    return superpose(kernel, history, r, phi)
