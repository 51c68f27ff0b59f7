"""Many independent points, solved in parallel and kept: the engine behind tables of solutions and parameter studies.

`solve_points` works in this process, in processes of its own, or on a Dask cluster. Every finished point is on disk before it
counts, a point that fails becomes a record with its reason, and a second run solves only what is missing. No mechanics here.
"""

from flatpunch._support.threads import cores
from flatpunch.parallel.engine import Solved, point_keys, solve_points
from flatpunch.parallel.keys import content_key
from flatpunch.parallel.store import Folder
from flatpunch.parallel.threads import one_thread
from flatpunch.parallel.work import Outcome

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
