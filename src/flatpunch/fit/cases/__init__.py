"""Parts of a case file of fits: known values, tables, prior knowledge."""
