"""Contact of layered and graded elastic bodies with round and non-round indenters.

Press an ever larger flat punch step by step and any contact has been built: the rigid cylindrical flat punch on a medium is
all that has to be known of that medium. Everything is in consistent units, SI recommended.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # names and rooms from __init__.pyi
