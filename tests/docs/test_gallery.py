"""Scripts of the gallery draw a figure in the block that makes it: after the block it is saved and closed."""

import ast
import re
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).resolve().parents[2] / "docs" / "examples").glob("*/plot_*.py"))


def drawn_too_late(text):
    """Names of figures and axes that a block uses without having made them."""
    made, late = set(), []
    for block in re.split(r"(?m)^# %%.*$", text):
        here = set()
        for statement in ast.parse(block).body:
            names = [node for node in ast.walk(statement) if isinstance(node, ast.Name)]
            late += sorted({node.id for node in names if isinstance(node.ctx, ast.Load)} & (made - here))
            if isinstance(statement, ast.Assign) and re.search(r"\.(subplots|figure)\(", ast.unparse(statement.value)):
                here |= {node.id for node in names if isinstance(node.ctx, ast.Store)}
        made |= here
    return late


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_figures_are_drawn_where_they_are_made(script):
    assert drawn_too_late(script.read_text(encoding="utf-8")) == []


def test_what_is_drawn_too_late_is_found():
    text = "_, (left, right) = plt.subplots(1, 2)\nleft.plot([1])\n\n# %%\n# More.\n\nright.plot([2])\n"
    assert drawn_too_late(text) == ["right"]
