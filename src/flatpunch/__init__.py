"""Contact of layered and graded elastic bodies with round and non-round indenters.

Press an ever larger flat punch step by step and any contact has been built: the rigid cylindrical flat punch on a medium is
all that has to be known of that medium. Everything is in consistent units, SI recommended.
"""

from flatpunch._support.lazy import names_of

__getattr__, __dir__, __all__ = names_of(__name__, __file__)  # from __init__.pyi
