from .study import sweep
from .tables import save_table, table

__all__ = ["save_table", "sweep", "table"]
