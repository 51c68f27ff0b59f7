"""The atlas: an open library of flat-punch solutions.

Tables of the flat punch over its radius and the parameters of whole families of media. `tabulated(medium)` is the medium with
its solution at hand; `table(name)` gives values for many media and radii at once. The programs that make tables are in the
folder `scripts/atlas_tables` of the repository.
"""

from flatpunch.atlas.library import AtlasFileError, dundurs, families, read_table, tabulated
from flatpunch.atlas.library import find_table as table
from flatpunch.atlas.tables import Solution, Table

__all__ = ["AtlasFileError", "Solution", "Table", "dundurs", "families", "read_table", "table", "tabulated"]
