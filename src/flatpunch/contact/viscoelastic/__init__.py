"""Viscoelastic contact: growing (Lee and Radok), shrinking (Ting), and any history, built on any method's elastic curve."""

from flatpunch.contact.viscoelastic.solve import check_medium, history_control, solve

__all__ = ["check_medium", "history_control", "solve"]
