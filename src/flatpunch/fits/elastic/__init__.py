"""Elastic models of measured curves."""
