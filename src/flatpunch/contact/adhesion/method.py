"""Adhesive contact, exact for round indenters on every medium, of second order for power laws: curves and pressure.

By radius the whole branch of equilibria, by depth or force its stable part: what is seen while the tip is withdrawn. Where
the depth lies below the pull-off the surfaces have separated, radius and force are zero. See `adhesion_branch`.
"""

from __future__ import annotations

import numpy as np

from flatpunch._support.checks import ROUNDING, Array, BadValue, Flags, values
from flatpunch._support.prefixes import text
from flatpunch.compliances import Kernel
from flatpunch.contact.adhesion.branch import AdhesiveContact
from flatpunch.contact.adhesion.case import AdhesiveCase, adhesive_case, stable_radius
from flatpunch.contact.adhesion.maugis import MaugisBranch
from flatpunch.contact.adhesion.non_round import PerturbedBranch
from flatpunch.contact.adhesion.stability import QUANTITIES, Quantity
from flatpunch.contact.curve import UNITS, Control, Curve, Extra, check_reach, first_failure, prescribed
from flatpunch.contact.perturbation.second_order import LARGEST_SWING
from flatpunch.contact.round.soundness import soundness
from flatpunch.contact.round.superposition import flat_pressure, grown_pressure
from flatpunch.indenters.profile import Indenter


def adhesive_control(*, depth: object, force: object, radius: object) -> Control:
    """Exactly one of depth, force and radius; depth and force may be negative."""
    name, value = prescribed(depth=depth, force=force, radius=radius)
    least = {"strict": True} if name == "radius" else {"minimum": -np.inf}
    checked = values(name, value, unit=UNITS[name], **least)
    return Control(name, checked)


def solve(
    kernel: Kernel,
    indenter: Indenter,
    control: Control,
    phi: Array,
    work: float,
    range_of_action: float | None = None,
) -> Curve:
    """A whole adhesive curve.

    Parameters
    ----------
    kernel : Kernel
        Compliance of the medium.
    indenter : Indenter
        A round indenter, or a power law.
    control : Control
        Depths or forces (any sign), or contact radii.
    phi : ndarray, shape (p,)
        Polar angles of the outline [rad].
    work : float
        Work of adhesion w [J/m^2].
    range_of_action : float, optional
        Largest gap across which the adhesive stress acts [m] (Maugis-Dugdale); JKR without it.

    Returns
    -------
    Curve
        With the extra arrays `retraction`, `stable_depth` and `stable_force`, and `adhesive_radius` with a range of action.
    """
    case = adhesive_case(kernel, indenter, work, range_of_action)
    radius = _radius(case, control)
    touching = radius > 0
    contact = case.branch.at(np.where(touching, radius, _anchor(case)))
    depth, force, stiffness, pinned = _answers(case, control, contact, touching)
    valid, notes = _sound(case, contact, touching)
    lost = ~touching & (control.name == "force")
    mean_radius, area, contour, more, doubts = _shape(case, radius, phi)
    by_depth, by_force = (touching & (pinned | _within(case, quantity, contact.radius)) for quantity in QUANTITIES)
    return Curve(
        depth=depth,
        force=force,
        radius=mean_radius,
        area=area,
        stiffness=stiffness,
        contour=contour,
        valid=valid & ~lost & ~doubts,
        notes=notes + _separation(case, control, touching) + first_failure(doubts, depth, _UNSTABLE_OUTLINE),
        extra={
            "retraction": (("step",), np.where(touching, contact.plain.depth - depth, 0.0), "m", _RETRACTION),
            "stable_depth": (("step",), by_depth, "", "whether the contact is stable under prescribed depth"),
            "stable_force": (("step",), by_force, "", "whether the contact is stable under prescribed force"),
            **more,
        },
        pressing=np.where(touching, contact.plain.force, 0.0),
    )


_UNSTABLE_OUTLINE = (
    "a harmonic of the outline is unstable or the outline deviates too much from a circle for second-order theory."
)

_RETRACTION = "distance by which adhesion draws the tip in, against the contact without adhesion of the same radius"


def pressure(
    kernel: Kernel, indenter: Indenter, control: Control, r: Array, work: float, range_of_action: float | None = None
) -> tuple[Array, Array]:
    """Pressure at distances r from the axis, and its error; shape (n,) each [Pa].

    By JKR theory it is minus infinity at the edge and zero outside; with a range of action it is minus the adhesive stress from
    the edge on, across the gap.
    """
    if not indenter.round:
        raise ValueError("The adhesive pressure is available under round indenters only.")
    case = adhesive_case(kernel, indenter, work, range_of_action)
    if isinstance(case.branch, MaugisBranch):
        outer = float(_radius(case, control)[0])
        return case.branch.pressure(outer, r) if outer > 0 else (np.zeros_like(r), np.zeros_like(r))
    curve = solve(kernel, indenter, control, np.zeros(1), work)
    a = float(curve.radius[0])
    if not a > 0:
        return np.zeros_like(r), np.zeros_like(r)
    field, error = np.zeros_like(r), np.zeros_like(r)
    if not case.pinned:
        field, error = grown_pressure(kernel, case.branch.evaluate, a, r)
    pulled, unsure = flat_pressure(kernel, a, float(curve.extra["retraction"][1][0]), r)
    return field - pulled, error + unsure


def _shape(case: AdhesiveCase, radius: Array, phi: Array) -> tuple[Array, Array, Array, Extra, Flags]:
    """Mean radius, area, outline, error estimates, and where the outline does not hold, at radii of the branch."""
    branch, touching = case.branch, radius > 0
    sound = np.zeros(radius.shape, dtype=bool)
    at = np.where(touching, radius, _anchor(case))
    contact = branch.at(at)
    terms = np.maximum(contact.plain.force + contact.plain.stiffness * contact.retraction, np.abs(contact.force))
    error = (("step",), np.where(touching, branch.error(at) / terms, 0.0), "1", _ERROR)
    if not isinstance(branch, PerturbedBranch):
        inner = np.where(touching, branch.size(at)[0], 0.0)
        outline = np.repeat(inner[:, None], phi.size, axis=1)
        finite: Extra = {"adhesive_radius": (("step",), radius, "m", _OUTER), "force_error": error}
        return inner, np.pi * inner**2, outline, finite if branch.range_of_action > 0 else {}, sound
    contour, mean_radius, area = branch.shape(at, phi)
    doubts = touching & (
        (branch.weakest(at) <= 0) | (np.abs(np.log(contour / at[:, None])).max(axis=1) > LARGEST_SWING)
    )
    return (
        np.where(touching, mean_radius, 0.0),
        np.where(touching, area, 0.0),
        np.where(touching[:, None], contour, 0.0),
        {"force_error": error},
        doubts,
    )


_OUTER = "radius within which adhesion acts, in the contact and across the gap beside it"

_ERROR = "estimated error of the force over the sum of its two terms, that without adhesion and that of adhesion"


def _anchor(case: AdhesiveCase) -> float:
    """Radius used where there is no contact."""
    return max((stretch.start for stretch in case.stability.force), default=0.0) or case.indenter.reach


def _radius(case: AdhesiveCase, control: Control) -> Array:
    if control.name == "radius":
        check_reach(case.indenter, control.values)
        found = case.branch.base_radius(control.values)
        if not np.isfinite(found).all():
            first = text(float(control.values[~np.isfinite(found)][0]), "m")
            why = "is so large that adhesion acts beyond the end of the tip, or of what is solved on this medium. Ask for less."
            raise BadValue("radius", first, why)
        return found
    return stable_radius(case, control.name, control.values)


def _answers(
    case: AdhesiveCase, control: Control, contact: AdhesiveContact, touching: Flags
) -> tuple[Array, Array, Array, Flags]:
    """Depth, force and stiffness, and where the contact is pinned at the edge of a flat end."""
    depth, force = np.where(touching, contact.depth, np.nan), np.where(touching, contact.force, 0.0)
    stiffness = np.where(touching, contact.stiffness, 0.0)
    pinned = np.zeros_like(touching)
    if control.name == "depth":
        # F is stationary in a at given d apart from the adhesion itself: what rounding leaves of the radius is harmless
        depth = control.values
    elif control.name == "force":
        force = control.values
    if case.pinned and control.name != "radius":
        pinned = touching & (contact.radius >= case.indenter.reach)
        line = contact.plain.stiffness
        held = control.values if control.name == "depth" else control.values / line
        depth = np.where(pinned, held, depth)
        force = np.where(pinned, line * depth, force)
        stiffness = np.where(pinned, line, stiffness)
    return depth, force, stiffness, pinned


def _within(case: AdhesiveCase, quantity: Quantity, radius: Array) -> Flags:
    inside = [
        (radius >= s.start * (1 - ROUNDING)) & (radius <= s.end * (1 + ROUNDING)) for s in case.stability.of(quantity)
    ]
    return np.any(inside, axis=0) if inside else np.zeros(radius.shape, dtype=bool)


def _sound(case: AdhesiveCase, contact: AdhesiveContact, touching: Flags) -> tuple[Flags, tuple[str, ...]]:
    """Where the contact without adhesion of the same radius is a disc under pressure throughout."""
    if case.pinned:
        return np.ones_like(touching), ()
    valid, notes = soundness(case.kernel, case.branch.evaluate, contact.plain)
    said = tuple(
        "Adhesion was added to a contact that is not sound without it (depths below are those without adhesion): "
        + note
        for note in notes
    )
    return valid | ~touching, said if (touching & ~valid).any() else ()


def _separation(case: AdhesiveCase, control: Control, touching: Flags) -> tuple[str, ...]:
    if touching.all():
        return ()
    if control.name == "depth":
        limit = float(control.values[~touching].max())
        return (
            f"At depths up to {text(float(limit), 'm')} the surfaces have separated: pull-off under prescribed depth lies above.",
        )
    limit = float(control.values[~touching].max())
    return (f"Forces up to {limit:.4g} N are beyond the pull-off force: no contact can carry such a tension.",)
