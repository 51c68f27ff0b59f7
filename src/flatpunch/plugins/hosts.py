"""The programs that there are plug-ins for, and the file that each of them takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flatpunch._support.checks import one_of
from flatpunch._support.whole_file import write_whole
from flatpunch.plugins.cases import module_path

if TYPE_CHECKING:
    from flatpunch.fits.case import FitCase


@dataclass(frozen=True)
class Host:
    """A program: its name and version, what the file brings, and whether the file carries one case."""

    name: str
    brings: str
    case: bool = False


HOSTS = {
    "contactmechanics": Host(
        "ContactMechanics 1.8", "substrates, periodic, free and semi-periodic; surface Green's function"
    ),
    "micromechanics": Host("micromechanics 1.3", "the modulus of a film from an analysed indentation"),
    "nanite": Host("nanite 4, PyJibe", "model of force curves: modulus of the top layer", case=True),
    "slippy": Host("slippy 0.5", "material for contacts and stresses, without flatpunch in its environment", case=True),
    "softmech": Host("SoftMech 2", "force model: modulus of the top layer", case=True),
    "tamaas": Host("Tamaas 2.9", "integral operator and contact solver, periodic and free"),
}
"""By the name of the command, which is that of the module here as well."""


def write_plugin(host: str, path: str | Path, case: FitCase | None = None, **options: Any) -> Path:
    """Write the Python module of a host of `HOSTS`, with a case where it takes one and options of `write_slippy_material`."""
    one_of("HOST", host, tuple(HOSTS), "`flatpunch plugin list` describes them.")
    path = module_path(path, f"flatpunch_{host}.py")
    if HOSTS[host].case != (case is not None):
        raise ValueError(
            f"the file for {HOSTS[host].name} "
            + (
                "carries one case; give a case file after the host."
                if case is None
                else "takes any medium; leave the case out."
            )
        )
    if options and host != "slippy":
        raise ValueError(f"{', '.join(options)}: only the file for slippy has grids and depths of its own.")
    if case is None:
        write_whole(path, Path(__file__).with_name(f"{host}.py").read_bytes())
    elif host == "slippy":
        from flatpunch.plugins.slippy import write_slippy_material

        write_slippy_material(path, case.medium, title=case.title, **options)
    else:
        from flatpunch.plugins.force_models import write_nanite_model, write_softmech_model

        write = write_nanite_model if host == "nanite" else write_softmech_model
        write(path, case.medium, case.indenter, title=case.title, method=case.settings.method)
    return path
