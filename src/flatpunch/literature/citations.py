"""What to cite for a result, from the references in `references.toml`."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files
from typing import cast

import numpy as np
import xarray as xr

from flatpunch._support.checks import shown
from flatpunch._support.readable import Table, readable, record
from flatpunch._version import __version__
from flatpunch.fits import Correction, FilmResult, FitResult, Posterior

_PLAIN = ("authors", "kind", "title", "formula")
"""Fields that BibTeX has under other names, in braces, or not at all: the name of a formula in comparisons."""


@readable
@dataclass(frozen=True, slots=True)
class Reference:
    """A work, and what of a result rests on it.

    Attributes
    ----------
    key : str
        Its name in BibTeX.
    entry : dict
        kind, authors ("family name, given names"), title, year, and where it was published.
    reason : str
        What it is cited for.

    See Also
    --------
    flatpunch.cite : Chooses them for a result.

    Examples
    --------
    >>> from flatpunch.literature import bibliography
    >>> print(bibliography()["lee1960"].text)
    E. H. Lee, J. R. M. Radok: The contact problem for viscoelastic bodies. Journal of Applied Mechanics 27 (1960) 438-444.
    """

    key: str
    entry: dict[str, str | int | list[str]]
    reason: str = ""

    @property
    def authors(self) -> list[str]:
        """Family name and given names of each."""
        # of the entries of a reference, authors alone are a list
        return list(cast("list[str]", self.entry["authors"]))

    @property
    def text(self) -> str:
        """One line for a list of references."""
        entry, names = self.entry, []
        for author in self.authors:
            family, _, given = author.strip("{}").partition(", ")
            initials = " ".join(part if part.endswith(".") else f"{part[0]}." for part in given.split())
            names.append(f"{initials} {family}".strip())
        where = f"{entry['journal']} {entry['volume']} ({entry['year']}) {entry['pages']}" if "journal" in entry else ""
        if not where:
            where = f"{entry.get('archiveprefix', 'Version')} {entry.get('eprint', entry.get('version', ''))}".strip()
            where = f"{where} ({entry['year']})"
        link = f", https://doi.org/{entry['doi']}" if "doi" in entry else ""
        return f"{', '.join(names)}: {entry['title']}. {where}{link}."

    @property
    def bibtex(self) -> str:
        """An entry of BibTeX."""
        fields = {"author": " and ".join(self.authors), "title": f"{{{self.entry['title']}}}"}
        fields |= {name: str(value) for name, value in self.entry.items() if name not in _PLAIN}
        fields["pages"] = fields.get("pages", "").replace("-", "--")
        lines = [f"  {name} = {{{value}}}," for name, value in fields.items() if value]
        return "\n".join([f"@{self.entry['kind']}{{{self.key},", *lines, "}"])


@readable
@dataclass(frozen=True, slots=True)
class Citations:
    """What to cite for a result.

    Attributes
    ----------
    entries : tuple of Reference
        In the order of their importance for the result.

    See Also
    --------
    flatpunch.cite : Makes it.

    Examples
    --------
    >>> found = fp.cite(fp.indent(fp.HalfSpace(5e3, 0.5), fp.Sphere(5e-6), depth=1e-7))
    >>> print(*(each.key for each in found.entries))
    flatpunch forsbach2023
    """

    entries: tuple[Reference, ...]

    def _line_(self) -> str:
        return f"Citations({', '.join(each.key for each in self.entries)})"

    def _table_(self) -> Table:
        rows = tuple((each.reason, each.text) for each in self.entries)
        return Table("To be cited", ("for", "work"), rows)

    @property
    def text(self) -> str:
        """Each work on a line, with what it is cited for."""
        return "\n".join(f"{each.reason[:1].upper()}{each.reason[1:]}: {each.text}" for each in self.entries)

    @property
    def bibtex(self) -> str:
        """All entries of BibTeX."""
        return "\n\n".join(each.bibtex for each in self.entries) + "\n"


def bibliography() -> dict[str, Reference]:
    """All works that results may rest on, by key.

    See Also
    --------
    flatpunch.cite : Those of one result.

    Examples
    --------
    >>> from flatpunch.literature import bibliography
    >>> print(bibliography()["johnson1971"].entry["journal"])
    Proceedings of the Royal Society of London A
    """
    text = (files("flatpunch.literature") / "references.toml").read_text(encoding="utf-8")
    return {key: Reference(key, entry) for key, entry in tomllib.loads(text).items()}


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
    if method in ("bem", "refined") or title.startswith(("Rough contact", "Stresses under a rough contact")):
        yield "polonsky1999", "boundary elements, the conjugate gradients that their solver extends"
    if '"PowerLawHalfSpace"' in parts:
        yield "giannakopoulos1997", "contacts on power-law graded half-spaces"
    if re.search(r'"young_axial": (?!null)', parts):
        yield "delafargue2004", "the surface modulus of transversely isotropic bodies"
    if facts.get("work_of_adhesion"):
        yield "johnson1971", "adhesion"
    if facts.get("range_of_action"):
        yield "maugis1992", "adhesion of finite range"
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
    if title.startswith("Partial slip"):
        yield "mindlin1949", "partial slip of spheres"
        yield "ciavarella1998", "partial slip as a difference of normal contacts"
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
