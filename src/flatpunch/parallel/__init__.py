"""Many independent calls in worker processes: sweeps, tables of solutions, batches of fits, boundary elements.

`map_calls` makes them, by loky or on a Dask cluster. `solve_points` keeps what they return: every finished point is on disk
before it counts, a point that fails becomes a record with its reason, and a second run solves only what is missing. No mechanics
here.
"""

from flatpunch._support.threads import cores, one_thread
from flatpunch.parallel.engine import Solved, point_keys, solve_points
from flatpunch.parallel.store import Folder, Outcome, content_key

__all__ = [
    "Folder",
    "Outcome",
    "Solved",
    "content_key",
    "cores",
    "one_thread",
    "point_keys",
    "solve_points",
]
