"""The path of the physics is the path of the imports: a package imports only what stands above it."""

import ast
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "src" / "flatpunch"

_GROUND = {"_lazy", "_validation", "_quadrature", "_record", "_version", "_progress", "_threads", "_whole_file"}
_MEDIA = _GROUND | {"media"}
_PUNCH = _MEDIA | {"compliance", "punch"}
_BEM = _PUNCH | {"indenters", "bem", "parallel"}
_CONTACT = _BEM | {"contact"}
_FILES = _CONTACT | {"files"}
_PLOTS = _FILES | {"plots", "plots_adhesion", "plots_history", "plots_medium"}

ALLOWED = {
    "_validation": set(),
    "_quadrature": {"_validation"},
    "_record": set(),
    "_progress": set(),
    "_terminal": set(),
    "_lazy": set(),
    "_threads": set(),
    "_version": set(),
    "_whole_file": set(),
    "parallel": _GROUND | {"parallel"},
    "reference": {"reference"},
    "media": _MEDIA,
    "compliance": _MEDIA | {"compliance"},
    "punch": _PUNCH,
    "indenters": _MEDIA | {"indenters"},
    "bem": _BEM,
    "contact": _CONTACT,
    "atlas": _CONTACT | {"atlas", "parallel"},
    "paper": _CONTACT | {"_terminal", "atlas", "paper", "parallel", "reference"},
    "files": _FILES,
    "plots": _PLOTS,
    "plots_adhesion": _PLOTS,
    "plots_history": _PLOTS,
    "plots_medium": _MEDIA | {"files"},
    "plots_indenter": _FILES | {"plots", "plots_indenter"},
    "fit": _FILES | {"_terminal", "fit", "parallel", "plots", "reference"},
    "atlas_cli": _FILES | {"_terminal", "parallel", "atlas", "atlas_cli", "sweeps"},
    "sweeps": _FILES | {"_terminal", "parallel", "plots", "sweeps"},
    "cli": _FILES | {"_terminal", "plots", "cli", "sweeps", "atlas_cli", "paper", "fit"},
}
"""What each part may import from the package, itself included. A new part needs a line here, and one in ARCHITECTURE.md."""

# `import flatpunch` brings all of it at once, which only the outermost layers may do.
_WHOLE_PACKAGE = {"cli", "__init__"}


def modules():
    return sorted(path for path in SOURCE.rglob("*.py") if "__pycache__" not in path.parts)


def part(path):
    """First name below the package: "media" for media/bodies.py, "cli" for cli.py."""
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def imported(path):
    """Yield all imports of a file, wherever they stand: top level, inside functions, under TYPE_CHECKING."""
    here = path.relative_to(SOURCE.parent).with_suffix("").parts[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), filename=str(path))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = list(here[: len(here) - node.level + 1]) if node.level else []
            name = ".".join([*base, *([node.module] if node.module else [])])
            if name == "flatpunch":
                # `from flatpunch import indenters`: a part if there is one of that name, otherwise the whole package
                known = {part(other) for other in modules()}
                yield from (
                    (f"flatpunch.{alias.name}" if alias.name in known else "flatpunch", node.lineno)
                    for alias in node.names
                )
            else:
                yield name, node.lineno


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(SOURCE)))
def test_import_directions(path):
    own = part(path)
    for name, line in imported(path):
        top, _, rest = name.partition(".")
        if top != "flatpunch":
            continue
        target = rest.split(".")[0]
        if not target:
            assert own in _WHOLE_PACKAGE, (
                f"{path.name}:{line} imports the whole package; import the part that is needed"
            )
        elif own != "__init__":
            assert own in ALLOWED, f"{own} is a new part of the package: say in ALLOWED what it may import"
            assert target in ALLOWED[own], f"{path.name}:{line} imports flatpunch.{target}, but {own} stands below it"


@pytest.mark.parametrize(
    "path", [p for p in modules() if part(p) == "reference"], ids=lambda path: str(path.relative_to(SOURCE))
)
def test_reference_stands_alone(path):
    """The judge of the rest shares nothing with what it judges: standard library, NumPy and SciPy only."""
    import sys

    for name, line in imported(path):
        top = name.split(".")[0]
        assert top in {"numpy", "scipy"} or name.startswith("flatpunch.reference") or top in sys.stdlib_module_names, (
            f"{path.name}:{line} imports {name}"
        )


@pytest.mark.parametrize("part_name", ["media", "compliance", "punch", "indenters", "bem", "contact"])
def test_mechanics_knows_no_files_and_pictures(part_name):
    """Units with names, file formats, pictures and terminals stay outside."""
    outside = {"pint", "pydantic", "typer", "rich", "matplotlib", "h5netcdf", "tomllib"}
    for path in modules():
        if part(path) == part_name:
            found = {name.split(".")[0] for name, _ in imported(path)} & outside
            assert not found, f"{path.name} imports {found}"


def test_no_part_is_forgotten():
    """Every part named in the table that exists has files, and every file belongs to a part of the table."""
    assert {part(path) for path in modules()} - {"__init__"} <= set(ALLOWED)
