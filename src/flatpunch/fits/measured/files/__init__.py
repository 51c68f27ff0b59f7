"""Files of instruments, a module for each format; `readers` chooses."""
