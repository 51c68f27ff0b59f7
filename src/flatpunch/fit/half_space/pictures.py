"""Pictures of corrected moduli and of formulas against the exact contact."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from flatpunch.fit.half_space.correction import Correction
from flatpunch.fit.half_space.formulas import WITHIN
from flatpunch.plots.style import BLUE, GREEN, GREY, ORANGE, THIN, StyleName, panels, scale_of, styled

if TYPE_CHECKING:
    import xarray as xr

_LINES = ("--", ":", "-.", (0, (3, 1)))


def correction_figure(found: Correction, *, title: str = "", style: StyleName | str = "screen") -> Figure:
    """Moduli of the layer by the exact contact and by formulas; the half-space modulus over depth."""
    with styled(style) as chosen:
        drawn, (bars, curve) = panels(chosen, 2, title=title)
        young = {row.name: v for row in found.table().rows if np.isfinite(v := row.estimate.value)}
        factor, unit = scale_of([*young.values(), found.reported], "Pa")
        bars.barh(list(young), [each * factor for each in young.values()], color=[BLUE, *[GREY] * (len(young) - 1)])
        bars.invert_yaxis()
        bars.axvline(found.young * factor, color=BLUE, linewidth=THIN)
        # one formula far off must not hide the others
        bars.set_xlim(0, min(bars.get_xlim()[1], 3 * factor * max(found.young, found.reported)))
        bars.set_xlabel(f"Young's modulus of the layer ({unit})")
        length, length_unit = scale_of(found.depth, "m")
        curve.plot(
            found.depth * length, found.apparent * factor, color=ORANGE, label="half-space formula at each depth"
        )
        curve.axhline(found.young * factor, color=BLUE, label="layer")
        curve.plot([found.depth[-1] * length], [found.reported * factor], "o", color=ORANGE, label="reported")
        curve.set_ylim(bottom=0)
        curve.set_xlim(left=0)
        curve.set_xlabel(f"indentation depth ({length_unit})")
        curve.set_ylabel(f"Young's modulus ({unit})")
        curve.legend()
    return drawn


def comparison_figure(found: xr.Dataset, *, title: str = "", style: StyleName | str = "screen") -> Figure:
    """Force over that of the half-space formula, and the errors of the formulas, over depth."""
    with styled(style) as chosen:
        drawn, (factors, errors) = panels(chosen, 2, title=title)
        length, unit = scale_of(found["depth"].values, "m")
        depth, bare = found["depth"].values * length, found["formula_force"].values[0]
        factors.plot(depth, found["factor"].values, color=BLUE, linewidth=3 * THIN, alpha=0.5, label="exact")
        for i, name in enumerate(found["formula"].values):
            look: Any = {
                "color": (ORANGE, GREEN, GREY)[i % 3],
                "linestyle": _LINES[i // 3 % len(_LINES)],
                "label": str(name),
            }
            factors.plot(depth, found["formula_force"].values[i] / bare, **look)
            errors.plot(depth, 100 * found["deviation"].values[i], **look)
        top = float(np.nanmax(found["factor"].values))
        factors.set_ylim(0, 3 / 2 * top)
        for limit in WITHIN:
            errors.axhspan(-100 * limit, 100 * limit, color="black", alpha=0.1, linewidth=0)
        errors.set_ylim(-50, 50)
        for axes in (factors, errors):
            axes.set_xlabel(f"indentation depth ({unit})")
        factors.set_ylabel("force over that of the half-space formula")
        errors.set_ylabel("error of the formula (%)")
        factors.legend()
    return drawn
