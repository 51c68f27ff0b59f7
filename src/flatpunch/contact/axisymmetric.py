"""Round contact under its former name; see `flatpunch.contact.round`."""

from flatpunch.contact.round.profile import Moments, PowerProfile, RoundProfile, SampledProfile
from flatpunch.contact.round.round_contact import RoundContact, round_contact

__all__ = ["Moments", "PowerProfile", "RoundContact", "RoundProfile", "SampledProfile", "round_contact"]
