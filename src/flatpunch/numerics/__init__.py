"""Gauss points and interpolants that the mechanics is built on."""
