"""Force models for programs that fit force curves already: files with the exact thin-layer contact of one case.

nanite and PyJibe load single files that say which parameters a model has and how the force follows from the tip position.
SoftMech 2 has a folder `softmech/plugins/force_models`, whose modules are found when the program starts. The files need flatpunch
where they run, that of nanite lmfit as well; neither they nor this package need the programs to be written.
"""

from __future__ import annotations

from pathlib import Path
from types import NoneType

from flatpunch._support.checks import instance
from flatpunch._support.whole_file import write_whole
from flatpunch.fits.parameters.settings import FitMethod
from flatpunch.indenters.profile import Indenter
from flatpunch.media import Body
from flatpunch.plugins.cases import Entry, entries_of, module_path, parts_of

_NANITE = '''"""{title}

Exact contact of a tip with a layered sample, by flatpunch (method {method}). Layers, base and tip other than the parameters are
as written below; write the file anew for another sample.
"""

import lmfit
import numpy as np

from flatpunch.fits import ForwardModel
{imports}

_MODEL = ForwardModel(
    {medium},
    {indenter},
    {free},
    {method!r},
)


def get_parameter_defaults():
    """Parameters in the order of `parameter_keys`."""
    params = lmfit.Parameters()
{defaults}
    params.add("contact_point", value=0)
    params.add("baseline", value=0)
    return params


def flatpunch_layers(delta, {arguments}, contact_point=0, baseline=0):
    """{title}

    Exact contact mechanics of the layered sample; delta is the tip position [m], falling into the sample.
    """
    values = {{{values}}}
    return _MODEL.force(contact_point - np.asarray(delta, dtype=float), values) + baseline


model_doc = flatpunch_layers.__doc__
model_func = flatpunch_layers
model_key = {key!r}
model_name = {title!r}
parameter_keys = {keys!r}
parameter_names = {names!r}
parameter_units = {units!r}
valid_axes_x = ["tip position"]
valid_axes_y = ["force"]
'''


def write_nanite_model(
    path: str | Path,
    medium: Body,
    indenter: Indenter,
    *,
    title: str = "",
    key: str | None = None,
    method: FitMethod = "auto",
) -> Path:
    """Write a model file for nanite.

    Parameters
    ----------
    path : path
        Target, a Python module such as "model_thin_gel.py".
    medium : Medium of homogeneous layers, or HalfSpace
        The sample; the modulus of its top layer is what nanite fits.
    indenter : Sphere, Paraboloid, Cylinder, Cone or Pyramid
        The tip; its radius or half opening angle becomes a parameter that is held, like the thickness. With several layers
        only those become parameters whose tables are quick to make.
    title : str
        Name shown in the programs.
    key : str, optional
        Identifier; from the file's name if left out.
    method : str or method
        Contact method, or "auto"; the model file keeps its short name.

    Returns
    -------
    Path
    """
    path = module_path(path, "model_thin_gel.py")
    instance("key", key, (str, NoneType), "a text, or None")
    entries = entries_of(medium, indenter)
    text = _NANITE.format(
        **parts_of(medium, indenter, entries, title, method),
        defaults="\n".join(_default(entry) for entry in entries),
        arguments=", ".join(entry.key for entry in entries),
        key=key or f"flatpunch_{path.stem}",
        keys=[*(entry.key for entry in entries), "contact_point", "baseline"],
        names=[*(entry.label for entry in entries), "Contact Point", "Force Baseline"],
        units=[*(entry.unit for entry in entries), "m", "N"],
    )
    write_whole(path, text.encode())
    return path


def _default(entry: Entry) -> str:
    limits = "min=0" if entry.most is None else f"min=0, max={entry.most:g}"
    return f'    params.add("{entry.key}", value={entry.value!r}, {limits}, vary={entry.fitted})'


_SOFTMECH = '''"""{title}

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
    text = _SOFTMECH.format(
        **parts_of(medium, indenter, entries, title, method),
        parameters="".join(f"    {name}: float = {e.value * scale.get(e.unit, 1):.12g}\n" for e, name in shown),
        locals="; ".join(f"{e.key} = self.{name} / {scale.get(e.unit, 1):g}" for e, name in shown),
        start=modulus.value,
    )
    write_whole(path, text.encode())
    return path
