"""Reading and writing: case files with units, result files. No mechanics here."""

from flatpunch.files.cases import Case, read_case
from flatpunch.files.descriptions import describe, describe_sample, shipped_cases
from flatpunch.files.height_maps import read_height_map, read_topography
from flatpunch.files.results import ResultError, load, save
from flatpunch.files.tables.fields import CaseError

__all__ = [
    "Case",
    "CaseError",
    "ResultError",
    "describe",
    "describe_sample",
    "load",
    "read_case",
    "read_height_map",
    "read_topography",
    "save",
    "shipped_cases",
]
