"""The atlas: an open library of flat-punch solutions.

Tables of the flat punch over its radius and the parameters of whole families of media. `tabulated(medium)` is the medium with
its solution at hand; `table(name)` gives values for many media and radii at once. The programs that make tables are in the
folder `scripts/atlas_tables` of the repository.
"""

from flatpunch.atlas.family import FAMILIES, Family, dundurs
from flatpunch.atlas.library import families, tabulated
from flatpunch.atlas.library import find_table as table
from flatpunch.atlas.parameter import Parameter
from flatpunch.atlas.solution import Solution
from flatpunch.atlas.storage import AtlasFileError, read_table, write_table
from flatpunch.atlas.table import Table

__all__ = [
    "FAMILIES",
    "AtlasFileError",
    "Family",
    "Parameter",
    "Solution",
    "Table",
    "dundurs",
    "families",
    "read_table",
    "table",
    "tabulated",
    "write_table",
]
