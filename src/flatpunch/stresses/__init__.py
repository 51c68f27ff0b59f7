"""Inside the bodies: stresses, displacements, sliding, first failure, energy by depth."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # from __init__.pyi
