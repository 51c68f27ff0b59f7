"""The rigorous reference: boundary elements in free space for any medium and indenter."""

from flatpunch.bem.bounding_box import ContactTouchesEdge
from flatpunch.bem.curves import solve
from flatpunch.bem.flat_punch import solve_punch
from flatpunch.bem.grid import Grid
from flatpunch.bem.outline import Outline, trace_outline
from flatpunch.bem.resources import required_bytes
from flatpunch.bem.solution import Solution

__all__ = [
    "ContactTouchesEdge",
    "Grid",
    "Outline",
    "Solution",
    "required_bytes",
    "solve",
    "solve_punch",
    "trace_outline",
]
