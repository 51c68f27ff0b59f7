"""The rigorous reference: boundary elements in free space for any medium and indenter."""

from flatpunch.bem.bounding_box import ContactTouchesEdge, NotConverged
from flatpunch.bem.curves import solve
from flatpunch.bem.flat_punch import solve_punch
from flatpunch.bem.grid import Grid
from flatpunch.bem.outline import Outline, trace_outline
from flatpunch.bem.solution import Solution
from flatpunch.bem.solver.levels import required_bytes

__all__ = [
    "ContactTouchesEdge",
    "Grid",
    "NotConverged",
    "Outline",
    "Solution",
    "required_bytes",
    "solve",
    "solve_punch",
    "trace_outline",
]
