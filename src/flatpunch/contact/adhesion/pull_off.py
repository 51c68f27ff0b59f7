"""Pull-off of adhesive contacts, and how far JKR theory holds.

JKR takes the range of the adhesive traction as zero. That is sound while the surface is drawn up by far more than the range z0
over which the traction acts. Tabor's parameter measures just this: on a half-space the retraction D of a paraboloid at
its largest tension is

    D = (2 pi)^(1/2) (9 pi/8)^(1/6) (R w^2/E*^2)^(1/3) = 3.0937 mu z0,      mu = (R w^2/(E*^2 z0^3))^(1/3).

On any medium and for any round tip mu = D/(3.0937 z0) is taken with the retraction D at the force minimum, which contains the
local compliance: on a thin layer it is the stretch of the whole layer under the edge, on a stiff film that of film
and base together. Above 5 JKR holds; below 0.1 the traction acts as if the bodies were rigid (DMT; Bradley for the tip),

    F = -(w/z0) pi r0^2,      f(r0) = z0     (a constant traction w/z0 over gaps below z0),

which is -2 pi w R for a paraboloid whatever the law of the traction.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import scipy

from flatpunch._support.checks import FlatpunchWarning, positive, refused_overflow
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.compliances import compliance
from flatpunch.contact.adhesion.case import AdhesiveCase, adhesive_case
from flatpunch.contact.adhesion.stability import Stretch
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body


@readable
@dataclass(frozen=True, slots=True)
class Instability:
    """State of the contact, such as the one just before it is lost.

    Attributes
    ----------
    force, depth, radius : float
        Force [N], depth [m] and mean contact radius [m].
    force_error : float
        Estimated error of the force over its size; round contacts are exact.
    """

    force: float
    depth: float
    radius: float
    force_error: float = 0.0


@readable
@dataclass(frozen=True, slots=True)
class Tabor:
    """Range of validity.

    Attributes
    ----------
    parameter : float
        mu [-].
    dmt_force : float
        Pull-off force of rigid bodies [N].
    regime : str
        "JKR", "transition" or "DMT".
    note : str
        A sentence for the user; empty in the JKR regime.
    """

    parameter: float
    dmt_force: float
    regime: str
    note: str


@readable
@dataclass(frozen=True, slots=True)
class PullOff:
    """Where an adhesive contact is lost.

    Attributes
    ----------
    force_minimum : Instability
        Under a prescribed force (soft machine): the largest tension.
    depth_minimum : Instability
        Under a prescribed depth (stiff machine): the furthest withdrawal.
    force_instabilities, depth_instabilities : tuple of Instability
        All of them, outermost first. Films and layers can have several: the contact then jumps to a smaller radius before it
        is lost.
    tabor : Tabor or None
        Range of validity, if the range of action was given.

    See Also
    --------
    flatpunch.pull_off : Makes it.
    flatpunch.adhesion_loop : The whole cycle.

    Examples
    --------
    >>> gel = fp.HalfSpace(young=5e3, poisson=0.5)
    >>> found = fp.pull_off(gel, fp.Paraboloid(radius=5e-6), work_of_adhesion=1e-3)
    >>> print(f"{found.force_minimum.force * 1e9:.2f} nN")  # -3/2 pi w R
    -23.56 nN
    """

    force_minimum: Instability
    depth_minimum: Instability
    force_instabilities: tuple[Instability, ...]
    depth_instabilities: tuple[Instability, ...]
    tabor: Tabor | None = None

    @property
    def force(self) -> float:
        """Pull-off force, the minimum of F [N]; negative."""
        return self.force_minimum.force

    @property
    def depth(self) -> float:
        """Depth at the force minimum [m]."""
        return self.force_minimum.depth

    @property
    def radius(self) -> float:
        """Contact radius at the force minimum [m]."""
        return self.force_minimum.radius


@one_blas_thread()
@refused_overflow()
def pull_off(
    medium: Body, indenter: Indenter, *, work_of_adhesion: float, range_of_action: float | None = None
) -> PullOff:
    """Pull-off of an indenter from any medium by JKR theory: round ones exactly, power laws to second order in their asymmetry.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them.
    indenter : Indenter
        A round indenter, of which a Cylinder has a flat end (Kendall), or a power law such as a pyramid.
    work_of_adhesion : float
        Work of adhesion w [J/m^2], > 0.
    range_of_action : float, optional
        Largest gap z0 of the adhesive traction [m], some 0.2 to 1 nm for van der Waals forces. With it the result holds
        Tabor's parameter and the pull-off force of rigid bodies.

    Returns
    -------
    PullOff

    Warns
    -----
    FlatpunchWarning
        If a range of action is given and JKR theory does not hold for it.

    Raises
    ------
    ValueError
        On bad input, and if the indenter has no pull-off.

    See Also
    --------
    adhesion_loop : The whole cycle.

    Examples
    --------
    >>> lost = fp.pull_off(fp.HalfSpace(young=5e3, poisson=0.5), fp.Paraboloid(radius=5e-6), work_of_adhesion=1e-4)
    >>> print(f"{lost.force * 1e9:.3f} nN")
    -2.356 nN
    """
    check_indenter(indenter)
    case = adhesive_case(compliance(medium), indenter, work_of_adhesion)
    result = pull_off_of(case)
    if range_of_action is None:
        return result
    tabor = tabor_of(case, result, range_of_action)
    if tabor.note:
        warnings.warn(tabor.note, FlatpunchWarning, stacklevel=2)
    return PullOff(
        result.force_minimum, result.depth_minimum, result.force_instabilities, result.depth_instabilities, tabor
    )


def pull_off_of(case: AdhesiveCase) -> PullOff:
    """Pull-off of a case already prepared."""
    depth, force = _instabilities(case, case.stability.depth), _instabilities(case, case.stability.force)
    return PullOff(
        force_minimum=min(force, key=lambda point: point.force),
        depth_minimum=min(depth, key=lambda point: point.depth),
        force_instabilities=force,
        depth_instabilities=depth,
    )


def _instabilities(case: AdhesiveCase, stretches: tuple[Stretch, ...]) -> tuple[Instability, ...]:
    """Lower ends of the stable stretches; at a flat end also the loss of its own edge."""
    radii = [stretch.start for stretch in stretches if stretch.start > 0]
    reach = case.indenter.reach
    if case.pinned and not any(s.start < reach <= s.end for s in stretches):
        radii.insert(0, reach)
    at = np.array(radii)
    contact, (mean_radius, _) = case.branch.at(at), case.branch.size(at)
    # the estimate refers to both terms of the force, which may cancel
    terms = contact.plain.force + contact.plain.stiffness * contact.retraction
    error = case.branch.error(at) * terms / np.abs(contact.force)
    return tuple(
        Instability(*(float(value) for value in state))
        for state in zip(contact.force, contact.depth, mean_radius, error, strict=True)
    )


def tabor_of(case: AdhesiveCase, result: PullOff, range_of_action: float) -> Tabor:
    """Tabor's parameter with the retraction at the force minimum, and the pull-off force of rigid bodies."""
    z0 = positive(
        "range_of_action",
        range_of_action,
        "It is the largest gap across which the adhesive traction acts [m].",
        unit="m",
    )
    contact = case.branch.at(case.branch.base_radius(np.array([result.radius])))
    # (T11.4)
    mu = float(contact.retraction[0]) / ((3 * np.pi**2) ** (1 / 3) * z0)
    dmt = -case.branch.work / z0 * np.pi * _radius_of_gap(case.indenter, z0) ** 2
    # above 5 the pull-off force of JKR is within a few per cent, below 0.1 that of rigid bodies (Johnson and Greenwood 1997)
    rigid, soft = 0.1, 5.0
    if mu >= soft:
        return Tabor(mu, dmt, "JKR", "")
    if mu > rigid:
        note = (
            f"Tabor's parameter is {mu:.3g}, between {rigid:g} and {soft:g}: neither JKR theory (pull-off force "
            f"{result.force:.4g} N) nor that of rigid bodies ({dmt:.4g} N) holds; expect a value between the two."
        )
        return Tabor(mu, dmt, "transition", note)
    note = (
        f"Tabor's parameter is {mu:.3g}, below {rigid:g}: the bodies act as rigid ones and JKR theory does not hold. Take "
        f"the pull-off force {dmt:.4g} N of rigid bodies instead of {result.force:.4g} N."
    )
    return Tabor(mu, dmt, "DMT", note)


def _radius_of_gap(indenter: Indenter, gap: float) -> float:
    zero = np.zeros(1)

    def rise(x: float) -> float:
        return float(indenter.height(np.array([np.exp(x)]), zero)[0]) - gap

    high = np.log(min(indenter.reach, 1e9))
    if rise(high) <= 0:
        return float(np.exp(high))
    low = np.log(np.finfo(float).tiny)
    return float(np.exp(scipy.optimize.brentq(rise, low, high)))
