"""Pull-off of adhesive contacts: the largest tension, and the furthest withdrawal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._support.checks import refused_overflow
from flatpunch._support.readable import readable
from flatpunch._support.threads import one_blas_thread
from flatpunch.compliances import compliance
from flatpunch.contact.adhesion.case import AdhesiveCase, adhesive_case
from flatpunch.contact.adhesion.stability import Stretch
from flatpunch.contact.physics import Physics
from flatpunch.indenters.profile import Indenter, check_indenter
from flatpunch.media import Body


@readable
@dataclass(frozen=True, slots=True)
class Instability:
    """State of the contact, such as the one just before it is lost.

    Attributes
    ----------
    force, depth, radius : float
        Force [N], depth [m] and mean contact radius [m]: 0 where adhesion holds surfaces that do not touch.
    force_error : float
        Estimated error of the force over its size; in JKR theory round contacts are exact.
    """

    force: float
    depth: float
    radius: float
    force_error: float = 0.0


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
    medium: Body,
    indenter: Indenter,
    *,
    work_of_adhesion: float,
    range_of_action: float | None = None,
    strength: float | None = None,
) -> PullOff:
    """Pull-off of an indenter from any medium, by JKR theory or with a range of action.

    Round indenters are exact, power laws of second order in their asymmetry.

    Parameters
    ----------
    medium : Medium, HalfSpace, ...
        The elastic body, or two of them.
    indenter : Indenter
        A round indenter, of which a Cylinder has a flat end (Kendall), or a power law such as a pyramid.
    work_of_adhesion : float
        Work of adhesion w [J/m^2], > 0.
    range_of_action : float, optional
        Largest gap z0 across which adhesion acts [m], with the constant stress w/z0 (Maugis-Dugdale), some 0.2 to 1 nm for van
        der Waals forces: between JKR theory, the limit of short ranges and the default, and that of rigid bodies (DMT, Bradley).
        Under round tips without a flat end, on all media but power-law half-spaces.
    strength : float, optional
        In its place the adhesive stress w/z0 [Pa].

    Returns
    -------
    PullOff

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
    >>> silica = fp.HalfSpace(young=70e9, poisson=0.17)
    >>> lost = fp.pull_off(silica, fp.Paraboloid(radius=20e-9), work_of_adhesion=0.1, range_of_action=0.3e-9)
    >>> print(f"{lost.force / (np.pi * 0.1 * 20e-9):.3f} pi w R")
    -1.932 pi w R
    """
    check_indenter(indenter)
    physics = Physics(work_of_adhesion, range_of_action, strength)
    with physics.named():
        case = adhesive_case(compliance(medium), indenter, work_of_adhesion, physics.within)
        depth, force = _instabilities(case, case.stability.depth), _instabilities(case, case.stability.force)
    return PullOff(
        force_minimum=min(force, key=lambda point: point.force),
        depth_minimum=min(depth, key=lambda point: point.depth),
        force_instabilities=force,
        depth_instabilities=depth,
    )


def _instabilities(case: AdhesiveCase, stretches: tuple[Stretch, ...]) -> tuple[Instability, ...]:
    """Lower ends of the stable stretches; at a flat end also the loss of its own edge.

    A stretch that begins at nothing fades out at the range of action.
    """
    radii = [stretch.start for stretch in stretches if stretch.start > 0]
    reach = case.indenter.reach
    if case.pinned and not any(s.start < reach <= s.end for s in stretches):
        radii.insert(0, reach)
    fading = tuple(Instability(0.0, -case.branch.range_of_action, 0.0) for stretch in stretches if stretch.start == 0)
    if not radii:
        return fading
    at = np.array(radii)
    contact, (mean_radius, _) = case.branch.at(at), case.branch.size(at)
    error = case.branch.error(at) / np.abs(contact.force)
    found = tuple(
        Instability(*(float(value) for value in state))
        for state in zip(contact.force, contact.depth, mean_radius, error, strict=True)
    )
    return found + fading
