"""Derivatives of contacts by everything that determines them: numbers of media and tips, moduli at every depth."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # from __init__.pyi
