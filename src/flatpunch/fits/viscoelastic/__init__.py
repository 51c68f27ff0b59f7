"""Relaxing models of measured curves."""
