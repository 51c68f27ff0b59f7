"""Contact of indenters with media, by every method, and `indent` in front of them."""

from flatpunch.contact.adhesion_cycle import adhesion_loop
from flatpunch.contact.adhesion_pull_off import PullOff, pull_off
from flatpunch.contact.indent import METHODS, default_method, indent, pressure

__all__ = ["METHODS", "PullOff", "adhesion_loop", "default_method", "indent", "pressure", "pull_off"]
