"""Viscoelastic contact: growing (Lee and Radok), shrinking (Ting), and any history, built on any method's elastic curve."""

from flatpunch.contact.viscoelastic.history import check_each, check_history, check_medium, history_control, solve
from flatpunch.contact.viscoelastic.layered import solve_layered

__all__ = ["check_each", "check_history", "check_medium", "history_control", "solve", "solve_layered"]
