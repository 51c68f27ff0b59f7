"""Tips as the search for the first failure sees them: where the pressure is infinite, and how contacts are counted.

The pressure is infinite at apexes and edges, at the border of a flat end, under the rim of a punch.

Contacts of tips that rise from their apex are counted by the radius of the round contact of their angular mean. Maps of several
summits have none; of these the round tip of equal area at every height takes the place. Rollers and rounded punches are refused:
their highest stresses lie at edges and ends that the cells of the search do not resolve.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from flatpunch._support.byte_cache import byte_cached
from flatpunch._support.checks import ROUNDING, Array
from flatpunch.bem.bounding_box import Extent
from flatpunch.bem.grid import Grid, IndenterHeight
from flatpunch.compliances.stack import plane_at
from flatpunch.indenters import RadialProfile
from flatpunch.indenters._common import SCATTERED
from flatpunch.indenters.profile import Indenter, NotRising
from flatpunch.media import Stack
from flatpunch.stresses.failure.events import Event, Judged

_POINTED = 0.5
"""Slope at the apex over the mean slope up to the first point of a table from which the tip is a cone there rather than a
paraboloid, whose ratio is zero: splines of measured heights leave small slopes."""


_CELLS = 96
"""Cells along a side of the box around what is lower than a depth, two for each depth whose area is counted."""


def infinite(bodies: Sequence[Judged], indenter: Indenter, radius: float, friction: float) -> list[Event]:
    """Infinite stresses in the layers at the surface: at the rim of a flat end, under apex and edges of sharp tips, at kinks.

    There the pressure is infinite, and so are shear and von Mises stress: at kinks unless the material is incompressible and
    nothing slides. Behind the rim of a sliding `Cylinder` the surface is pulled as strongly as it is pressed inside.
    """
    found: list[Event] = []
    place, rim = singular_place(indenter, radius), indenter.flat
    if place is None:
        return found
    for each in bodies:
        strength = each.strengths[0]
        if not rim and (each.body.power_law or not (friction > 0 or _sheared(each.body))):
            continue
        kinds = [("yield", strength.yield_stress), ("shear", strength.shear)]
        if rim and friction > 0:
            kinds.insert(1, ("tensile", strength.tensile))
        found += [Event(kind, 0, np.inf, (*place, 0.0), each.name) for kind, value in kinds if value is not None]
    return found


def _sheared(body: Stack) -> bool:
    """Whether infinite pressure shears the surface: material that is isotropic and incompressible has it on all sides."""
    if body.power_law:
        return True
    plane = plane_at(body, np.zeros(1), np.zeros(1, dtype=int))
    compressible, sheared = plane.oedometric[0] * plane.across[0], plane.shear[0] * plane.across[0] - 1
    return bool(max(compressible / 2, abs(sheared)) >= ROUNDING)


def singular_place(indenter: Indenter, radius: float) -> tuple[float, float] | None:
    """Place (x, y) of infinite pressure in contacts of that radius [m]; None if there is none."""
    if indenter.flat:
        return indenter.reach, 0.0
    if (indenter.exponent is not None and indenter.exponent <= 1) or is_pointed(indenter, radius):
        return 0.0, 0.0
    if indenter.round:
        return _kink(indenter, radius)
    if border := _border(indenter):
        return border
    if indenter.corners:
        return radius / 2 * float(np.cos(indenter.corners[0])), radius / 2 * float(np.sin(indenter.corners[0]))
    return None


def is_pointed(indenter: Indenter, radius: float) -> bool:
    """Whether a tip that is no power law begins like a cone or a wedge."""
    if indenter.exponent is not None:
        return False
    ends = [*indenter.rings, *indenter.scales, indenter.reach]
    first = min([each for each in ends if 0 < each < np.inf], default=radius)
    # round tips have a slope at the apex; that of others depends on the direction, beside it
    beside = 0.0 if indenter.round else 1e-3 * first
    slope = np.asarray(indenter.slope(np.full(SCATTERED.shape, beside), SCATTERED)).max()
    return bool(
        slope > _POINTED * np.asarray(indenter.height(np.full(SCATTERED.shape, first), SCATTERED)).max() / first
    )


def pointed_table(indenter: Indenter) -> tuple[str, ...]:
    """Note on a load of zero under a tip whose slope at its apex comes from a table."""
    if not (indenter.round and indenter.tabulated):
        return ()
    slope = float(np.asarray(indenter.slope(np.zeros(1), np.zeros(1)))[0])
    if slope == 0:
        return ()
    return (
        f"The table of the tip begins with a slope of {slope:.2g}, like a cone, so that stresses at the apex are large under any "
        "load. If the tip is round there, give more points below the first radius, at heights that grow like its square.",
    )


def _kink(indenter: Indenter, radius: float) -> tuple[float, float] | None:
    """Ring of a round tip at which its slope jumps."""
    rings = np.array([ring for ring in indenter.rings if ring < radius * (1 - 1e-9)])
    if not rings.size:
        return None
    inside, outside = (indenter.slope(rings * (1 + side), np.zeros(1)) for side in (-1e-9, 1e-9))
    # jump of the slope over the slope from which a ring of the tip is an edge
    sharp = np.flatnonzero(np.abs(outside - inside) > 1e-6 * np.abs(outside))
    return (float(rings[sharp[0]]), 0.0) if sharp.size else None


def _border(indenter: Indenter) -> tuple[float, float] | None:
    """Nearest place on the border of a flat end, which is in contact as a whole; None if the tip rises from its apex."""
    if not indenter.rings:
        return None
    low, high = (
        np.full(SCATTERED.shape, ring) for ring in (indenter.rings[0] * (1 - 1e-9), indenter.rings[-1] * (1 + 1e-9))
    )
    if np.any(indenter.slope(low, SCATTERED)):
        return None
    for _ in range(50):
        middle = (low + high) / 2
        flat = np.asarray(indenter.slope(middle, SCATTERED)) == 0
        low, high = np.where(flat, middle, low), np.where(flat, high, middle)
    i = int(np.argmin(high))
    return float(high[i] * np.cos(SCATTERED[i])), float(high[i] * np.sin(SCATTERED[i]))


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

    def on_cells(depth: float) -> tuple[Grid, Array]:
        # any length that grows with the depth serves the search
        grid = Extent(*box.box(depth)).grid(_CELLS)
        return grid, height(grid)

    def area(depth: float) -> float:
        grid, heights = on_cells(depth)
        return float(np.count_nonzero(heights < depth)) * grid.cell_area

    _, heights = on_cells(np.inf)
    depths = heights[np.isfinite(heights)].max() * np.geomspace(1e-8, 1.0, _CELLS // 2)
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
