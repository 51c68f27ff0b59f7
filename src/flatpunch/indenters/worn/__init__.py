"""Real tips: rounded, cut off, tilted, and the standard tips of nanoindentation and AFM."""
