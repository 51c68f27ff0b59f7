"""Parameter studies: any values of a case file, varied over ranges or lists, solved as one data set."""

from flatpunch.sweeps.study import sweep
from flatpunch.sweeps.table import save_table, table

__all__ = ["save_table", "sweep", "table"]
