"""Derivatives of contacts by everything that determines them: numbers of media and tips, moduli at every depth."""

from flatpunch._support.lazy import names_of

__getattr__, __dir__, __all__ = names_of(__name__, __file__)  # from __init__.pyi
