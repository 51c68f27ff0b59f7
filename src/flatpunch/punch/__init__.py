"""The rigid cylindrical flat punch on a medium: one small matrix per harmonic, from which everything else follows."""

from flatpunch.punch.family import PunchFamily, UnresolvedLayer, punch_family
from flatpunch.punch.solution import FlatPunch, flat_punch, solved_punch

__all__ = ["FlatPunch", "PunchFamily", "UnresolvedLayer", "flat_punch", "punch_family", "solved_punch"]
