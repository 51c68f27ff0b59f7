"""Indenters given by a formula."""
