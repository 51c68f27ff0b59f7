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
    files : tuple of str
        Kinds of files.
    details : mapping of str to str
        Functions for more of a result: (fields, kept, step) -> plain data.
    script : str
        Python lines, with {stem} for the name of the files.
    """

    name: str
    solve: str
    file: str
    files: tuple[str, ...]
    script: str
    details: Mapping[str, str] = field(default_factory=dict)


TABS = {
    tab.name: tab
    for tab in (
        Tab(
            "press",
            "press:press",
            "press:press_file",
            ("toml", "nc", "csv", "png", "svg", "py"),
            """\
import flatpunch as fp

case = fp.read_case("{stem}.toml")
curve = fp.indent(case.medium, case.indenter, **case.arguments)
fp.save(curve, "{stem}.csv")
""",
            {"pressure": "press:pressure_map"},
        ),
    )
}


def script(tab: Tab, fields: Mapping[str, str], stem: str) -> str:
    """Return Python lines that do the same as the page, with the case file of that name beside them."""
    case_data(fields, tab.name)
    return tab.script.format(stem=stem)
