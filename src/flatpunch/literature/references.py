"""The bibliography of the package, `references.toml`: the one place of every reference, as text and BibTeX."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib.resources import files
from typing import cast

from flatpunch._support.readable import Table, readable

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
        """The keys."""
        return f"Citations({', '.join(each.key for each in self.entries)})"

    def _table_(self) -> Table:
        """A row for each work."""
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
