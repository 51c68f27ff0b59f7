"""Indenters: shapes f(r, phi) >= 0 over the point of first touch, one per file."""

from flatpunch._support.lazy import names_of

__getattr__, __dir__, __all__ = names_of(__name__, __file__)  # from __init__.pyi
