"""Inside the bodies: stresses, displacements, sliding, first failure, energy by depth."""

from flatpunch._support.lazy import names_of

__getattr__, __dir__, __all__ = names_of(__name__, __file__)  # from __init__.pyi
