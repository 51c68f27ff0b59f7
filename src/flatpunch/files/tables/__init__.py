"""Tables of case files: each builds one object."""
