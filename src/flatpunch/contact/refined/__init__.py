"""Round contacts corrected by a few boundary element solutions."""
