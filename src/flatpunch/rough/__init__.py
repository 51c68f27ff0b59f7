"""Contact of rough surfaces with any body, and theories of it."""

from flatpunch.rough.asperity_contacts import asperities
from flatpunch.rough.contact import rough_contact
from flatpunch.rough.theories import FullContact, full_contact, rough_theories

__all__ = ["FullContact", "asperities", "full_contact", "rough_contact", "rough_theories"]
