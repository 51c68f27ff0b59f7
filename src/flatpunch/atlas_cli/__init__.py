"""The command `flatpunch atlas`, and families of media described by files."""

from flatpunch.atlas_cli.family_file import family_from, read_family

__all__ = ["family_from", "read_family"]
