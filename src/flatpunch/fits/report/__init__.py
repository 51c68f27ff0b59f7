"""What a fit found: intervals, notes, summary."""
