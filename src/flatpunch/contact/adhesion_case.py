"""One medium, one round indenter and one work of adhesion: what every adhesive answer starts from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flatpunch._validation import Array, positive
from flatpunch.compliance import Kernel
from flatpunch.contact.adhesion_branch import Branch
from flatpunch.contact.adhesion_limits import Stability, stability
from flatpunch.contact.axisymmetric import Moments, RoundProfile, round_contact
from flatpunch.contact.mean import mean_profile
from flatpunch.indenters import Cylinder
from flatpunch.indenters.profile import Indenter


@dataclass(frozen=True, slots=True)
class FlatFace:
    """The flat end of a cylinder as a round profile: f = 0."""

    def moments(self, radius: Array, terms: int) -> Moments:
        """Zero."""
        return Moments(np.zeros((radius.size, terms)), np.zeros_like(radius), np.zeros_like(radius))


@dataclass(frozen=True, slots=True)
class AdhesiveCase:
    """One medium, one round indenter and one work of adhesion, with its branch and its stable parts."""

    kernel: Kernel
    indenter: Indenter
    branch: Branch
    stability: Stability

    @property
    def pinned(self) -> bool:
        """Whether the contact ends at a flat end's own edge."""
        return isinstance(self.indenter, Cylinder)


def adhesive_case(kernel: Kernel, indenter: Indenter, work: float) -> AdhesiveCase:
    """Check the input and find the instabilities.

    Raises
    ------
    ValueError
        If the indenter is not round, the work of adhesion not positive, or there is no stable contact.
    """
    work = positive("work_of_adhesion", work, "It is the energy per area gained by contact [J/m^2].")
    if not indenter.round:
        raise ValueError(
            f"{type(indenter).__name__} is not round: adhesive contact of non-round indenters is not available. The outline of "
            "constant edge intensity is known to first order in the asymmetry only; take the round indenter of the same mean "
            "profile, or leave work_of_adhesion out."
        )
    pinned = isinstance(indenter, Cylinder)
    profile: RoundProfile = FlatFace() if pinned else mean_profile(indenter)
    branch = Branch(kernel, lambda radius: round_contact(kernel, profile, radius), work)
    return AdhesiveCase(kernel, indenter, branch, stability(branch, profile, indenter.reach, pinned=pinned))
