"""Adhesive contact after Johnson, Kendall and Roberts (JKR) for every medium and indenter."""
