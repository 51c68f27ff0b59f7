"""`cite`: the references of one result, found from what the result records of itself."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from flatpunch._support.checks import shown
from flatpunch._support.readable import record
from flatpunch._version import __version__
from flatpunch.fits import Correction, FilmResult, FitResult, Posterior
from flatpunch.literature.references import Citations, bibliography


def cite(result: xr.Dataset | FitResult | Posterior | FilmResult | Correction) -> Citations:
    """What to cite for a result: this package, its method, what its medium, adhesion, relaxation or fit rest on, and formulas.

    Parameters
    ----------
    result : xarray.Dataset, FitResult, Posterior, FilmResult or Correction
        What a function of the package returned, or `load` read from a file.

    Returns
    -------
    Citations
        `print` shows them as a table; `text` and `bibtex` are strings.

    Raises
    ------
    TypeError
        If it is no result of this package.

    See Also
    --------
    flatpunch.literature.bibliography : All works.

    Examples
    --------
    >>> gel = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=2e-6)], base=fp.RigidBase())
    >>> sticky = fp.indent(gel, fp.Sphere(radius=5e-6), depth=1e-7, work_of_adhesion=1e-4)
    >>> for each in fp.cite(sticky).entries:
    ...     print(f"{each.key}: {each.reason}")
    flatpunch: computed with
    forsbach2023: the method, contacts as a succession of flat punches
    johnson1971: adhesion
    """
    known = bibliography()
    reasons: dict[str, str] = {}
    version = __version__
    for facts in _facts(result):
        reasons |= dict(_reasons(facts))
        compared = json.loads(str(facts.get("formulas", "[]")))
        reasons |= {
            k: f"the formula {e.entry['formula']}" for k, e in known.items() if e.entry.get("formula") in compared
        }
        version = str(facts.get("flatpunch_version", version))
    known["flatpunch"] = replace(known["flatpunch"], entry={**known["flatpunch"].entry, "version": version})
    return Citations(tuple(replace(known[key], reason=reason) for key, reason in reasons.items()))


def _facts(result: object) -> Iterator[Mapping[str, object]]:
    """What the result records of itself, for each of its parts."""
    if isinstance(result, FitResult) and len(result.results) > 1:
        for each in result.results:
            yield from _facts(each)
    elif isinstance(result, (FitResult, Posterior, Correction)):
        yield from _facts(result.dataset())
    elif isinstance(result, FilmResult):
        yield {"title": "Film", "medium": json.dumps(record(result.case)), "formulas": json.dumps(list(result.others))}
    elif isinstance(result, xr.Dataset) and (
        "flatpunch_version" in result.attrs or str(result.attrs.get("title", "")) == "Theories of rough contact"
    ):
        shrinks = "area" in result and bool((np.diff(result["area"].values) < 0).any())
        formulas = result["formula"].values.tolist() if "formula" in result.coords else []
        yield {**result.attrs, "shrinks": shrinks, "formulas": json.dumps(formulas)}
    else:
        raise TypeError(
            f"result = {shown(result)} must be a result of this package, such as indent, fit or load return."
        )


def _reasons(facts: Mapping[str, object]) -> Iterator[tuple[str, str]]:
    """Keys of the bibliography, each with what it is cited for."""
    title, method = str(facts.get("title", "")), str(facts.get("method", ""))
    parts = " ".join(str(facts.get(name, "")) for name in ("medium", "indenter", "load", "tips"))
    fitted = title.startswith(("Fit of", "Film"))
    yield "flatpunch", "computed with"
    yield "forsbach2023", "the method, contacts as a succession of flat punches"
    if method in ("bem", "refined") or title.startswith("Rough contact"):
        yield "polonsky1999", "boundary elements, the conjugate gradients that their solver extends"
    if '"PowerLawHalfSpace"' in parts:
        yield "giannakopoulos1997", "contacts on power-law graded half-spaces"
    if re.search(r'"young_axial": (?!null)', parts):
        yield "delafargue2004", "the surface modulus of transversely isotropic bodies"
    if facts.get("work_of_adhesion"):
        yield "johnson1971", "adhesion"
    if facts.get("relaxation"):
        yield "lee1960", "viscoelastic contacts that grow"
        if fitted or facts.get("shrinks"):
            yield "ting1966", "viscoelastic contacts that shrink"
    if title.startswith(("Fields", "Largest stresses", "Critical loads")):
        discs = '"DiscLoad"' in parts or (method == "exact" and '"EllipticParaboloid"' not in parts)
        if discs:
            yield "eason1955", "stresses under pressure on discs"
        if not discs or '"PatchLoad"' in parts:
            yield "love1929", "stresses under pressure on rectangles"
    if title.startswith("Sensitivities"):
        yield "barber1974", "derivatives at a contact area that makes the force largest"
    if title.startswith("Rough contact"):
        yield "yastrebov2017", "the true contact area from cells"
    if title == "Theories of rough contact":
        yield "persson2001", "Persson's theory of rough contact"
        yield "greenwood1966", "the theory of Greenwood and Williamson"
    if title.startswith("Fit of"):
        yield "transtrum2012", "least squares with geodesic acceleration"
    if title.startswith("Film"):
        yield "oliver1992", "contact area and depth of nanoindentation tests"
    if title.startswith("Posterior"):
        yield "foremanmackey2013", "draws from the posterior"
        yield "goodman2010", "moves of the sampler by stretches"
        yield "terbraak2006", "moves of the sampler by differential evolution"
