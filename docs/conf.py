"""How the documentation is built: `make docs`. No network is needed to build the pages, and none to read them."""

from __future__ import annotations

import os
import re
import tomllib
import warnings
from dataclasses import fields
from importlib import import_module
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from numpydoc.docscrape import FunctionDoc
from PIL import Image
from sphinx.application import Sphinx
from sphinx.domains.math import MathDomain
from sphinx.util.docutils import SphinxDirective

# small matrices: a second thread costs more than it brings
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

from flatpunch import __version__  # noqa: E402
from flatpunch.files.tables.indenters import WornTable, kinds  # noqa: E402
from flatpunch.files.tables.made import own_fields  # noqa: E402
from flatpunch.literature import bibliography  # noqa: E402

project = "flatpunch"
author = "The flatpunch developers"
copyright = author
version = release = __version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_parser",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",  # links to the source
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx-mathjax-offline",  # formulas without a network
    "sphinx_gallery.gen_gallery",
]
templates_path = ["_templates"]
exclude_patterns = ["_build", "examples"]
nitpicky = True
myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "attrs_inline", "colon_fence"]
myst_heading_anchors = 3

autosummary_generate = True
autodoc_typehints = "none"
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": "plot_",
    "thumbnail_size": (600, 420),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "capture_repr": (),
    "write_computation_times": False,
    "remove_config_comments": True,
    "within_subsection_order": "FileNameSortKey",
}

html_theme = "pydata_sphinx_theme"
html_title = f"flatpunch {version}"
html_favicon = "_static/logo.svg"
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = {
    "logo": {"image_light": "_static/logo.svg", "image_dark": "_static/logo.svg", "text": f"flatpunch {version}"},
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button"],
    "header_links_before_dropdown": 7,
    "show_prev_next": False,
    "secondary_sidebar_items": ["page-toc"],
}
html_sidebars: dict[str, list[str]] = {name: [] for name in ("index", "tutorial", "developer", "changelog", "cite")}
html_show_sourcelink = False
toc_object_entries_show_parents = "hide"
math_eqref_format = "({number})"
mathjax3_config = {"chtml": {"scale": 0.9}}


class SettingsTable(SphinxDirective):
    """`settings` with the name of a class: its fields with default and meaning, from the class itself."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Rows from the fields of the dataclass and the parameters of its docstring."""
        part, _, name = self.arguments[0].rpartition(".")
        described = getattr(import_module(part), name)
        defaults = {one.name: one.default for one in fields(described)}
        rows = ["| setting | default | meaning |", "|---|---|---|"]
        for setting in FunctionDoc(described)["Parameters"]:
            meaning = " ".join(setting.desc)
            rows += [f"| `{word}` | `{defaults[word]!r}` | {meaning} |" for word in setting.name.split(", ")]
        box = nodes.container()
        self.state.nested_parse(StringList(rows, source=self.arguments[0]), 0, box)
        return box.children


def _listed(names: list[str]) -> str:
    """Names of fields with commas between them."""
    return ", ".join(f"`{name}`" for name in names)


class TipsTable(SphinxDirective):
    """`tips`: every kind of tip in case files with its fields, from the classes themselves."""

    def run(self) -> list[nodes.Node]:
        """What must be given comes first; what is done with the tip is in the text below the table."""
        rows = ["| `kind` | fields | shape |", "|---|---|---|"]
        for kind, table in kinds().items():
            known = {
                name: info for name, info in table.model_fields.items() if name not in (*WornTable.model_fields, "kind")
            }
            ways = [names for names in own_fields(getattr(table, "ways", ())) if names]
            either = [name for names in ways for name in names]
            needed = [name for name, info in known.items() if info.is_required()]
            more = [name for name in known if name not in (*needed, *either)]
            parts = [_listed(needed), " or ".join(map(_listed, ways)), _listed(more)]
            listed = "; ".join(part for part in parts if part)
            about = " ".join((table.__doc__ or "").split()).replace("|", r"\|")
            rows.append(f'| `"{kind}"` | {listed} | {about} |')
        box = nodes.container()
        self.state.nested_parse(StringList(rows, source="tips"), 0, box)
        return box.children


class NamesTable(SphinxDirective):
    """`names`: every public name with the version in which it came (public_names.toml), and what it is."""

    def run(self) -> list[nodes.Node]:
        """Rows in the order of the alphabet, the first line of each docstring beside them."""
        versions = tomllib.loads(Path(self.env.srcdir, "public_names.toml").read_text(encoding="utf-8"))
        rows = ["| name | since | what it is |", "|---|---|---|"]
        for name, since in sorted((name, since) for since, names in versions.items() for name in names):
            room, _, last = f"flatpunch.{name}".rpartition(".")
            text = (getattr(import_module(room), last, None) or import_module(f"{room}.{last}")).__doc__.split("\n\n")[
                0
            ]
            rows.append(f"| `{name}` | {since} | {' '.join(text.split())} |")
        box = nodes.container()
        self.state.nested_parse(StringList(rows, source="names"), 0, box)
        return box.children


class ReferencesTable(SphinxDirective):
    """`references`: every work of the bibliography, from the package itself."""

    def run(self) -> list[nodes.Node]:
        """A line for each work, with its key."""
        lines = [f"- `{key}`: {each.text}" for key, each in bibliography().items()]
        box = nodes.container()
        self.state.nested_parse(StringList(lines, source="references"), 0, box)
        return box.children


class TheoryMath(MathDomain):
    """Equations keep the number that they are written with, (T3.2), so that the code can cite them."""

    def note_equation(self, docname: str, labelid: str, location: Any = None) -> None:
        """Give an equation its label as its number."""
        super().note_equation(docname, labelid, location)
        self.equations[labelid] = docname, labelid

    def get_equation_number_for(self, labelid: str) -> Any:
        """The number printed beside an equation."""
        return labelid if labelid in self.equations else None


def crop_thumbnails(app: Sphinx) -> None:
    """Show the first panel of wide pictures in the gallery; the whole would be too small to show anything."""
    size = width, height = sphinx_gallery_conf["thumbnail_size"]
    for thumbnail in Path(app.srcdir, "gallery").glob("*/images/thumb/sphx_glr_*_thumb.png"):
        with Image.open(thumbnail.parents[1] / thumbnail.name.replace("_thumb", "_001")) as image:
            if image.width > 1.7 * image.height:
                # panels are about a tenth wider than high
                panel = image.convert("RGB").crop((0, 0, round(1.1 * image.height), image.height))
                panel = panel.resize((round(1.1 * height), height))
                card = Image.new("RGB", size, "white")
                card.paste(panel, ((width - panel.width) // 2, 0))
                card.save(thumbnail)


def link_equations(app: Sphinx, docname: str, source: list[str]) -> None:
    """Turn each mention of an equation, (T3.2), into a link."""
    if not docname.startswith("generated/"):
        source[0] = re.sub(r"(?<!\$\$ )\((T\d+\.\d+)\)", r"{eq}`\1`", source[0])


def setup(app: Sphinx) -> None:
    """Equations and their numbers."""
    app.add_directive("settings", SettingsTable)
    app.add_directive("tips", TipsTable)
    app.add_directive("names", NamesTable)
    app.add_directive("references", ReferencesTable)
    app.connect("source-read", link_equations)
    app.connect("builder-inited", crop_thumbnails, priority=900)  # after the gallery is made
    app.add_domain(TheoryMath, override=True)
    # matplotlib cannot show figures here, and need not
    warnings.filterwarnings("ignore", message="FigureCanvasAgg is non-interactive")
