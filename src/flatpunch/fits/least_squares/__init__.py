"""The least-squares problem and its solution."""
