"""From measured curves to layer properties: readers, fits, hard films, corrections of reported moduli, batches."""

from flatpunch._support.lazy import names_of

__getattr__, __dir__, __all__ = names_of(__name__, __file__)  # from __init__.pyi
