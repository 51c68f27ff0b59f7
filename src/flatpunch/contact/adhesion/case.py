"""One medium, one indenter and one work of adhesion: what every adhesive result starts from."""

from __future__ import annotations

from dataclasses import dataclass

from flatpunch._support.checks import BadValue, positive
from flatpunch.compliances import Kernel
from flatpunch.contact.adhesion.branch import Branch, Equilibria
from flatpunch.contact.adhesion.non_round import PerturbedBranch
from flatpunch.contact.adhesion.stability import Stability, stability, steady_radius
from flatpunch.contact.round.mean_profile import mean_profile
from flatpunch.contact.round.profile import PowerProfile
from flatpunch.contact.round.round_contact import round_contact
from flatpunch.indenters.profile import Indenter, check_indenter


@dataclass(frozen=True, slots=True)
class AdhesiveCase:
    """One medium, one indenter and one work of adhesion, with its branch and its stable parts."""

    kernel: Kernel
    indenter: Indenter
    branch: Equilibria
    stability: Stability

    @property
    def pinned(self) -> bool:
        """Whether the contact ends at a flat end's own edge."""
        return self.indenter.flat


def adhesive_case(kernel: Kernel, indenter: Indenter, work: float) -> AdhesiveCase:
    """Check the input and find the instabilities; ValueError where there is no theory or no stable contact."""
    work = positive("work_of_adhesion", work, "It is the energy per area gained by contact [J/m^2].", unit="J/m**2")
    # products of both stay representable
    largest = 1e60
    for name, value, unit in (("work_of_adhesion", work, "J/m^2"), ("modulus", kernel.modulus, "Pa")):
        if not 1 / largest <= value <= largest:
            raise BadValue(
                name,
                f"{value:.6g} {unit}",
                f"is beyond what adhesion is computed for, {1 / largest:g} to {largest:g} {unit}. Check the "
                "units; all quantities are in SI.",
            )
    check_indenter(indenter)
    if not indenter.round:
        if indenter.exponent is None:
            raise ValueError(
                f"{type(indenter).__name__} is neither round nor a power law r^n psi(phi): adhesive contact is exact for round "
                "indenters and known to second order for power laws. Take an elliptic paraboloid or a pyramid that resembles it, "
                "or leave work_of_adhesion out."
            )
        perturbed = PerturbedBranch(kernel, indenter, work)
        # the round contact costs little: it is refused for the same reasons, and says how far the correction can turn the branch
        mean = stability(perturbed.base, perturbed.profile, indenter.reach)
        steady = steady_radius(perturbed.base, mean)
        found = stability(perturbed, perturbed.profile, indenter.reach, steady=steady)
        return AdhesiveCase(kernel, indenter, perturbed, found)
    pinned = indenter.flat
    # a flat face: f = 0
    profile = PowerProfile(exponent=2.0, factor=0.0) if pinned else mean_profile(indenter)
    branch = Branch(kernel, lambda radius: round_contact(kernel, profile, radius), work)
    return AdhesiveCase(kernel, indenter, branch, stability(branch, profile, indenter.reach, pinned=pinned))
