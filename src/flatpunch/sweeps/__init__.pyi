from .study import sweep
from .table import save_table, table

__all__ = ["save_table", "sweep", "table"]
