"""What every part uses and that knows no mechanics: checks of numbers, records, progress, threads, files written whole."""
