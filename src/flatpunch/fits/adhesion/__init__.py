"""Adhesive models of measured curves."""
