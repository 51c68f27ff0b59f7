"""The job *Slip*: partial slip at the last step of a case, its first loading and the cycle of its largest displacement."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from dataclasses import asdict

from flatpunch._support.paths import Plain
from flatpunch.app.jobs.common import case_of, explained, short
from flatpunch.app.limits import DRAWN
from flatpunch.contact.slip.steps import loading_and_cycle
from flatpunch.files.descriptions import curve_table
from flatpunch.files.slip import slipping


def slip(fields: Mapping[str, str], run: bool) -> Plain:
    """Pull the tip of a form along the surface."""
    try:
        case = case_of(fields, "slip")
        if not run and any(getattr(given, "size", 1) > DRAWN.steps for given in (case.slip or {}).values()):
            return {"long": f"More than {DRAWN.steps} steps along the surface are prescribed."}
        result = slipping(case)
    except Exception as error:
        return explained(error, fields)
    first, cycle = loading_and_cycle(result)
    return {
        "title": case.title,
        "first": short(first),
        "cycle": short(cycle),
        "table": asdict(curve_table(result)),
        "notes": str(result.attrs["notes"]).splitlines(),
        "kept": pickle.dumps((case, result)),
    }
