"""Indenters given by a formula, one per file."""
