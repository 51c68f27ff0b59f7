"""Design: numbers of media and tips that give a prescribed contact, or the largest load before failure."""

from flatpunch._support.lazy import names_of

__getattr__, __dir__, __all__ = names_of(__name__, __file__)  # from __init__.pyi
