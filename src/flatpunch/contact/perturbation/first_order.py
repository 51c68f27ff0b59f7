"""The paper's method for slightly non-axisymmetric indenters.

Force, depth and stiffness are those of the angular mean f0 of the profile (P18), (P19); the outline follows from the
deviation f - f0 by (P17). The pressure is the superposition of (P9) over the history. Exact for round indenters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import scipy

from flatpunch._support.checks import Array, Flags
from flatpunch.compliances import Kernel
from flatpunch.contact.curve import Control, Curve, Extra, first_failure
from flatpunch.contact.perturbation.error import estimates, first_order_error
from flatpunch.contact.perturbation.first_order_outline import area, growth_factor, outline
from flatpunch.contact.round.mean_profile import Evaluate, mean_contact, mean_profile
from flatpunch.contact.round.round_contact import RoundContact, quadrature_error
from flatpunch.contact.round.soundness import soundness
from flatpunch.contact.round.superposition import (
    History,
    grown_pressure,
    log_radii,
    round_history,
    spline,
    spline_outline,
    superpose,
)
from flatpunch.indenters._common import RAYS
from flatpunch.indenters.geometry.angles import angular_rule
from flatpunch.indenters.geometry.features import flat_radius
from flatpunch.indenters.profile import Indenter
from flatpunch.numerics.gauss import gauss
from flatpunch.punch.family import punch_family

Outline = Callable[[Array, Array], tuple[Array, Array]]


def solve(kernel: Kernel, indenter: Indenter, control: Control, phi: Array) -> Curve:
    """A whole curve by the paper's method; exact for round indenters."""
    evaluate, contact = mean_contact(kernel, indenter, control)
    valid, notes = soundness(kernel, evaluate, contact)
    contour = outline(kernel, indenter, contact, phi)
    enclosed = area(kernel, indenter, contact)
    lost = ~np.isfinite(enclosed)
    within = lost & (contact.depth == 0)
    notes += first_failure(
        within,
        contact.depth,
        "the radius lies within the flat end of the tip, which is in contact as a whole or not at all, so there is no outline.",
    )
    notes += first_failure(
        lost & ~within,
        contact.depth,
        "the first-order outline does not exist (the denominator of (P17) and (P23) has changed sign, or the outline would "
        "pass through the axis): the contact responds too strongly to the asymmetry, as under stiff films. Force, depth "
        "and stiffness are those of the mean profile.",
    )
    return Curve(
        depth=contact.depth,
        force=contact.force,
        radius=contact.radius,
        area=enclosed,
        stiffness=contact.stiffness,
        contour=contour,
        valid=valid & ~lost,
        notes=notes,
        extra=_trust(kernel, indenter, contact, lost, control),
    )


def _trust(kernel: Kernel, indenter: Indenter, contact: RoundContact, lost: Flags, control: Control) -> Extra:
    """Error estimates, infinite for lost outlines; round contact is exact up to quadrature and interpolation over the radius."""
    if not indenter.round:
        force, contour = first_order_error(kernel, indenter, contact)
        return estimates(force, np.where(lost, np.inf, contour))
    at_depth, size = (0.0, 0.0) if kernel.homogeneous else punch_family(kernel).error(contact.radius / kernel.length)
    if control.name == "radius":
        # the force of a cone is K d/2 and d is off by as much as the radius: twice that
        at_depth = max(at_depth, 2 * size)
    # rounding, and what more points change
    least = 1e-10 + quadrature_error(kernel, mean_profile(indenter), contact)
    return estimates(least + at_depth, least + size)


class NoSuperposition(ValueError):
    """The pressures of growing punches cannot be superposed for this contact; the message says why."""


def pressure(kernel: Kernel, indenter: Indenter, control: Control, r: Array, phi: Array) -> Array:
    """Pressure at polar coordinates (r, phi), each of shape (n,) [Pa]; its integral over the outline is the force.

    Raises
    ------
    NoSuperposition
        If the outline does not grow continuously, or the superposed pressure does not add up to the force.
    """
    evaluate, contact = mean_contact(kernel, indenter, control)
    if contact.radius[0] == 0:
        return np.zeros_like(r)
    history = round_history(evaluate, float(contact.radius[0]), kernel.exponent)
    if flat_radius(indenter) > 0:
        raise NoSuperposition(
            "the whole flat end of this tip is in contact at the first touch, so the outline does not grow "
            "continuously from a point"
        )
    history = _with_outline(kernel, indenter, evaluate, history)
    _check_force(kernel, indenter, history, float(contact.force[0]))
    return superpose(kernel, history, r, phi)


def round_pressure(kernel: Kernel, indenter: Indenter, control: Control, r: Array) -> tuple[Array, Array]:
    """Exact pressure of a round contact at distances r from the axis, and its estimated error, shape (n,) each [Pa]."""
    evaluate, contact = mean_contact(kernel, indenter, control)
    return grown_pressure(kernel, evaluate, float(contact.radius[0]), r)


def _check_force(kernel: Kernel, indenter: Indenter, history: History, force: float) -> None:
    """Refuse a superposed pressure whose integral over the contact is not the force."""
    phi, weights = angular_rule(indenter)
    # Gauss points along each ray for the integral of a pressure: 1e-3 for pressures that are singular at the apex
    t, weight = gauss(10)
    theta = np.pi / 4 * (t + 1)
    edge = history.radius * history.outline(np.full_like(phi, np.log(history.radius)), phi)[0]
    r = edge[:, None] * np.sin(theta)
    field = superpose(kernel, history, r.ravel(), np.repeat(phi, theta.size)).reshape(r.shape)
    total = 2 * np.pi * weights @ (edge**2 * (field @ (np.pi / 4 * weight * np.sin(theta) * np.cos(theta))))
    # relative difference between the integral of a pressure and the force that counts as agreement
    if not abs(total / force - 1) <= 0.02:
        raise NoSuperposition(
            f"the superposed pressure adds up to {total:.4g} N where the force is {force:.4g} N: the outline changes too fast "
            "while the contact grows"
        )


def _with_outline(kernel: Kernel, indenter: Indenter, evaluate: Evaluate, history: History) -> History:
    """A history with the outline of (P17) at each radius."""
    x = log_radii(history.radius)
    contact = evaluate(np.exp(x))
    angles, weights = angular_rule(indenter)
    relative = outline(kernel, indenter, contact, angles) / contact.radius[:, None]
    if not np.all(np.isfinite(relative)):
        raise NoSuperposition(
            "the first-order outline does not exist along the whole history of this contact, as the medium responds too "
            "strongly to the asymmetry (a stiff film)"
        )
    share = spline(x, 1 / (relative**2 @ weights))
    if indenter.exponent is not None:
        shape = _power_outline(indenter, spline(x, growth_factor(contact, indenter.exponent)))
    else:
        shape = _general_outline(kernel, indenter, contact, x)
    return replace(history, outline=shape, share=share)


def _power_outline(indenter: Indenter, growth: scipy.interpolate.BSpline) -> Outline:
    """s = 1 + q(x) (1 - psi/<psi>) with q of (P23)."""
    angles, weights = angular_rule(indenter)
    mean = float(weights @ indenter.height(np.ones_like(angles), angles))
    slope = growth.derivative()

    def shape(x: Array, phi: Array) -> tuple[Array, Array]:
        deviation = 1 - indenter.height(np.ones_like(phi), phi) / mean
        s = 1 + growth(x) * deviation
        return s, slope(x) * deviation / s

    return shape


def _general_outline(kernel: Kernel, indenter: Indenter, contact: RoundContact, x: Array) -> Outline:
    """Spline of (P17) over ln a and the polar angle."""
    angles = np.linspace(-np.pi, np.pi, RAYS, endpoint=False)
    return spline_outline(x, outline(kernel, indenter, contact, angles) / contact.radius[:, None])
