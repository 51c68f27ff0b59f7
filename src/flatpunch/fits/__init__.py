"""From measured curves to layer properties: readers, fits, hard films, corrections of reported moduli, batches."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # from __init__.pyi
