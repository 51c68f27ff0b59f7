"""`flatpunch app`: a page in the browser for the daily jobs, served on this machine."""
