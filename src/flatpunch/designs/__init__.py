"""Design: numbers of media and tips that give a prescribed contact, or the largest load before failure."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # from __init__.pyi
