"""Closed forms that judge the rest of the package; NumPy and SciPy only, nothing of the package itself."""
