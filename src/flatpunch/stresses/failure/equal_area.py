"""Round tip with the level areas of another one, by which contacts are counted while a load is searched.

Contacts of tips that rise from their apex are counted by the radius of the round contact of their angular mean. Maps of several
summits have none; of these the round tip of equal area at every height takes the place. Rollers and rounded punches are refused:
their highest stresses lie at edges and ends that the cells of the search do not resolve.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch.bem.bounding_box import Extent
from flatpunch.bem.height import IndenterHeight
from flatpunch.indenters import RadialProfile
from flatpunch.indenters.profile import Indenter, NotRising


@byte_cached
def counted_by(indenter: Indenter) -> Indenter:
    """The tip itself, or the round one of equal level areas."""
    if not indenter.has_parts:
        return indenter
    if not indenter.cut:
        raise NotRising(
            f"indenter = {type(indenter).__name__}: its highest stresses lie along edges and ends that the cells of the search "
            "do not resolve. `fields` gives the stresses at points, with their error; a crowned Roller is searched."
        )
    box: Any = indenter
    height = IndenterHeight(indenter)

    def area(depth: float) -> float:
        # cells over the box of a depth; any length that grows with the depth serves the search
        grid = Extent(*box.box(depth)).grid(96)
        return float(np.count_nonzero(height(grid) < depth)) * grid.cell_area

    heights = height(Extent(*box.box(np.inf)).grid(96))
    depths = heights[np.isfinite(heights)].max() * np.geomspace(1e-8, 1.0, 49)
    radii = np.sqrt(np.array([area(float(depth)) for depth in depths]) / np.pi)
    # radii that grow by a hundredth at least; where they do not at first, the end is flat
    kept = [int(np.argmax(radii > 0))]
    for i, radius in enumerate(radii):
        if radius > 1.01 * radii[kept[-1]]:
            kept.append(i)
    levels, radii = depths[kept], radii[kept]
    flat = kept[1] - kept[0] > 2 if len(kept) > 1 else True
    levels[0] *= not flat
    return RadialProfile(np.append(0.0, radii), np.append(0.0, levels), kinks=radii[:1] if flat else ())
