"""Look of the figures, and writing them."""

from __future__ import annotations

import io
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flatpunch._support.whole_file import write_whole

THICKNESS_COLOURS = ("#440154", "#3b528b", "#21918c", "#5ec962", "#d9b400")
FIRST, SECOND, BEM = "#c1121f", "#1f4e79", "#4d4d4d"

_RC: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 10,
    "axes.linewidth": 0.7,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.4,
    "axes.unicode_minus": True,
    "mathtext.fontset": "stix",
    "font.family": "DejaVu Sans",
}
"""Settings of matplotlib within `look`."""


def look() -> AbstractContextManager[None]:
    """Fonts and lines of all figures, while they are made and written."""
    return mpl.rc_context(_RC)


def sheet(rows: int, columns: int, *, width: float = 4.0, height: float = 3.3) -> tuple[Figure, list[list[Axes]]]:
    """Figure of rows x columns panels, each of the given size in inches."""
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, [list(row) for row in axes]


def save(figure: Figure, folder: Path, name: str) -> None:
    """PNG and PDF; neither holds a date, so the same numbers make the same files."""
    for ending, metadata in (("png", {"Software": None}), ("pdf", {"CreationDate": None})):
        buffer = io.BytesIO()
        figure.savefig(buffer, format=ending, dpi=200, metadata=metadata)
        write_whole(folder / f"{name}.{ending}", buffer.getvalue())
        figure.set_layout_engine("none")  # found once, kept for the second format
