"""Contact of indenters with media, by every method, and `indent` in front of them."""

from flatpunch._support.lazy import names_of

__getattr__, __dir__, __all__ = names_of(__name__, __file__)  # from __init__.pyi
