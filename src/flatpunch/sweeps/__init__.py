"""Parameter studies: any values of a case file, varied over ranges or lists, solved as one data set."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # from __init__.pyi
