"""A force model for SoftMech 2: a module for its folder `softmech/plugins/force_models`, found when the program starts."""

from __future__ import annotations

from pathlib import Path

from flatpunch._support.whole_file import write_whole
from flatpunch.fits.parameters.settings import FitMethod
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.plugins.cases import entries_of, module_path, parts_of

_TEMPLATE = '''"""{title}

Exact contact of a tip with a layered sample, by flatpunch (method {method}); write the file anew for another sample or tip.
"""

import numpy as np
from flatpunch.fits import ForwardModel
{imports}
from scipy.optimize import curve_fit
from softmech.core.plugins import ForceModel as Base

NAME = {title!r}
DESCRIPTION = "Exact contact mechanics of a layered sample: modulus of the top layer"
VERSION = "1.0.0"
DOI = ""

_MODEL = ForwardModel(
    {medium},
    {indenter},
    {free},
    {method!r},
)


class ForceModel(Base):
    """{title}"""

{parameters}
    def theory(self, x, *params, curve=None):
        """Force [N] at indentations x [m] for a modulus [Pa]; the tip is that of the file."""
        (E,) = params
        {locals}
        return _MODEL.force(np.asarray(x, dtype=float), {{{values}}})

    def calculate(self, x, y, curve=None):
        """The modulus [Pa], in a list, or False if the fit fails."""
        x, y = self._get_fitting_region(x, y)
        known = np.isfinite(x) & np.isfinite(y) & (x >= 0)
        try:
            found, _ = curve_fit(lambda x, E: self.theory(x, E, curve=curve), x[known], y[known], p0=[{start!r}])
        except (RuntimeError, TypeError, ValueError):
            return False
        return list(found)
'''


def write_softmech_model(
    path: str | Path, medium: Body, indenter: Indenter, *, title: str = "", method: FitMethod = "auto"
) -> Path:
    """Write a force model for SoftMech.

    Parameters
    ----------
    path : path
        Target, a Python module such as "thin_gel.py".
    medium : Medium of homogeneous layers, or HalfSpace
        The sample; SoftMech fits the modulus of its top layer.
    indenter : Sphere, Paraboloid, Cylinder, Cone or Pyramid
        The tip. Its size and the thickness are parameters of the program.
    title : str
        Name shown in the program.
    method : str or method
        Contact method, or "auto".

    Returns
    -------
    Path
    """
    path = module_path(path, "thin_gel.py")
    entries = entries_of(medium, indenter)
    modulus, held = entries[0], entries[1:]
    # lengths in nm, as SoftMech's own parameters
    shown = [(entry, f"{entry.label.lower().replace(' ', '_')}{'_nm' * (entry.unit == 'm')}") for entry in held]
    scale = {"m": 1e9}
    text = _TEMPLATE.format(
        **parts_of(medium, indenter, entries, title, method),
        parameters="".join(f"    {name}: float = {e.value * scale.get(e.unit, 1):.12g}\n" for e, name in shown),
        locals="; ".join(f"{e.key} = self.{name} / {scale.get(e.unit, 1):g}" for e, name in shown),
        start=modulus.value,
    )
    write_whole(path, text.encode())
    return path
