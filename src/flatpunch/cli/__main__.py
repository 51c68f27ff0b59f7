"""`python -m flatpunch.cli` runs the command line."""

from flatpunch.cli import main

main()
