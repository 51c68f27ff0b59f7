"""Parameter studies: any values of a case file, varied over ranges or lists, solved as one data set."""

from flatpunch.sweeps.study import sweep

__all__ = ["sweep"]
