"""`python -m flatpunch`: the command, where its script is not on the path."""

from _flatpunch_command import main

main()
