"""What several test files share: independent solutions, cases, synthetic curves."""
