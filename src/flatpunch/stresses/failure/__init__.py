"""Strengths, and the load at which the first of them is exceeded."""
