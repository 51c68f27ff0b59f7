from .study import save_table, sweep, table

__all__ = ["save_table", "sweep", "table"]
