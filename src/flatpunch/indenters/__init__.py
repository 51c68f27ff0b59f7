"""Indenters: shapes f(r, phi) >= 0 over the point of first touch."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # from __init__.pyi
