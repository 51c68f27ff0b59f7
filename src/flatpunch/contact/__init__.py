"""Contact of indenters with media, by every method, and `indent` in front of them."""

from flatpunch.contact.indent import METHODS, indent, pressure

__all__ = ["METHODS", "indent", "pressure"]
