from .family_file import family_from, read_family

__all__ = ["family_from", "read_family"]
