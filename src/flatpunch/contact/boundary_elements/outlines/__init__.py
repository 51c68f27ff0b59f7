"""Contact outlines a(phi) from boundary element solutions."""
