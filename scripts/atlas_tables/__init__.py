"""Makes the tables of the atlas: the shipped ones, and those of families of your own. See `python -m atlas_tables --help`."""

from atlas_tables.build import build
from atlas_tables.verify import Verification, verified, verify

__all__ = ["Verification", "build", "verified", "verify"]
