"""The tabs of the page: which functions of workers solve, detail and write them, and the Python lines that do the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flatpunch.app.form import case_data


@dataclass(frozen=True)
class Tab:
    """One job.

    Parameters
    ----------
    name : str
        In addresses.
    solve, file : str
        Functions of workers, "module:name": (fields, run) -> result, and (fields, kept, kind) -> bytes.
    script : str
        Python lines, with {stem} for the name of the files and {curve} for that of the measured file.
    switched : mapping of str to str
        Python lines where a switch of the form is on, by its name.
    details : mapping of str to str
        Functions for more of a result: (fields, kept, step) -> plain data.
    previews : mapping of str to str
        Functions that need no result: (fields, upload) -> plain data.
    uploads : bool
        Whether `solve` takes the uploaded file as well.
    """

    name: str
    solve: str
    file: str
    script: str
    details: Mapping[str, str] = field(default_factory=dict)
    switched: Mapping[str, str] = field(default_factory=dict)
    previews: Mapping[str, str] = field(default_factory=dict)
    uploads: bool = False


TABS = {
    tab.name: tab
    for tab in (
        Tab(
            "press",
            "press:press",
            "press:press_file",
            """\
import flatpunch as fp

case = fp.read_case("{stem}.toml")
curve = fp.indent(case.medium, case.indenter, **case.arguments)
fp.save(curve, "{stem}.csv")
""",
            {"pressure": "press:pressure_map"},
        ),
        Tab(
            "fit",
            "fit:fit_curve",
            "fit:fit_file",
            """\
import flatpunch as fp
from flatpunch.fits.case import read_fit_case

case = read_fit_case("{stem}.toml")
found = fp.fit(fp.read_curve("{curve}", **case.reading), case.medium, case.indenter, case.free, **case.arguments)
print(found.summary())
""",
            {"drift": "fit:drift_over_depth"},
            {
                "all": """\
import flatpunch as fp
from flatpunch.fits.case import read_fit_case

case = read_fit_case("{stem}.toml")
how = {{**case.arguments, "quick": True, "reading": case.reading}}
fp.fit_batch(["{curve}"], case.medium, case.indenter, case.free, **how).save("{stem}.csv")
"""
            },
            previews={"preview": "fit:preview"},
            uploads=True,
        ),
        Tab(
            "correct",
            "formulas:correct_modulus",
            "formulas:correct_file",
            """\
import flatpunch as fp
from flatpunch.fits.case import read_fit_case

case = read_fit_case("{stem}.toml")
found = fp.correct(medium=case.medium, indenter=case.indenter, method=case.settings.method, **case.correct)
print(found)
""",
        ),
        Tab(
            "coating",
            "coating:coating",
            "coating:coating_file",
            """\
import flatpunch as fp
from flatpunch.files.analyses import stresses

found = stresses(fp.read_case("{stem}.toml"))
fp.save(found.fields, "{stem}.nc")
print(found.first)
""",
            {"quantity": "coating:quantity_map"},
            {
                "map": """\
import flatpunch as fp

study = fp.sweep("{stem}.toml")
fp.save(study, "{stem}.nc")
print(study["critical_force"].isel(step=0))
"""
            },
        ),
        Tab(
            "slip",
            "press:slip",
            "press:press_file",
            """\
import flatpunch as fp
from flatpunch.files.analyses import slipping

found = slipping(fp.read_case("{stem}.toml"))
fp.save(found, "{stem}.nc")
print(found["dissipated_energy"].values.max())
""",
        ),
        Tab(
            "compare",
            "formulas:compare",
            "formulas:compare_file",
            """\
import flatpunch as fp
from flatpunch.fits.half_space.formulas import compare_case

found = compare_case(fp.read_case("{stem}.toml"))
fp.save(found, "{stem}.nc")
print(found["valid_to"].to_pandas())
""",
        ),
    )
}

FILES = ("toml", "nc", "csv", "png", "svg", "py")
"""Kinds of files that every tab saves."""


def script(tab: Tab, fields: Mapping[str, str], stem: str) -> str:
    """Return Python lines that do the same as the page, with the case file of that name beside them."""
    case_data(fields, tab.name)
    lines = next((lines for name, lines in tab.switched.items() if fields.get(name) == "on"), tab.script)
    return lines.format(stem=stem, curve=fields.get("upload", "").rpartition("/")[2] or "curve.csv")
