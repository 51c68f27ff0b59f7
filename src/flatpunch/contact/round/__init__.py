"""Round contact, exact for every medium and round profile."""
