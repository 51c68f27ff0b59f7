"""Makes the tables of the atlas: the shipped ones, and those of families of your own. See `python -m atlas_tables --help`."""

from atlas_tables.build import build
from atlas_tables.families import FAMILIES, Family
from atlas_tables.verify import Verification, verified, verify
from atlas_tables.writing import write_table
from flatpunch.atlas.panel import Parameter

__all__ = ["FAMILIES", "Family", "Parameter", "Verification", "build", "verified", "verify", "write_table"]
