"""Indenters given by data: height maps, radial profiles, area functions."""
