"""Parameter studies: any values of a case file, varied over ranges or lists, solved as one data set."""

from flatpunch._support.lazy import names_of

__getattr__, __dir__, __all__ = names_of(__name__, __file__)  # from __init__.pyi
