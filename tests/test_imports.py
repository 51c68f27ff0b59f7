"""The path of the physics is the path of the imports: a room imports only from the rooms below it."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "src" / "flatpunch"

_FLOORS = [
    {"_version", "_support", "reference"},
    {"numerics", "media", "parallel", "surfaces"},
    {"compliances", "indenters"},
    {"punch", "bem"},
    {"contact", "atlas", "kernels"},
    {"stresses", "rough"},
    {"sensitivities", "conduction"},
    {"designs"},
    {"files", "plots"},
    {"sweeps", "fits"},
    {"app", "literature", "plugins"},
    {"cli", "__main__"},
]
"""Packages from the ground up: a package imports from lower floors only."""

_INSIDE = {
    "indenters": [
        {"_common"},
        {"profile"},
        {"geometry"},
        {"shapes", "measured"},
        {"worn"},
        {"__init__"},
    ],
    "bem": [
        {"grid"},
        {"operator", "outline"},
        {"solver"},
        {"solution", "bounding_box"},
        {"curves", "flat_punch"},
        {"__init__"},
    ],
    "contact": [
        {"curve", "dataset", "physics"},
        {"round"},
        {"finite_strain"},
        {"limits"},
        {"perturbation", "exact"},
        {"boundary_elements", "adhesion", "viscoelastic", "receding"},
        {"refined"},
        {"methods"},
        {"default", "slip"},
        {"result"},
        {"histories"},
        {"indentation"},
        {"__init__"},
    ],
    "stresses": [
        {"bodies", "loads"},
        {"axisymmetric"},
        {"one_cell"},
        {"uniform_cells"},
        {"cells"},
        {"sources"},
        {"points", "energy"},
        {"failure"},
        {"peaks"},
        {"repeating"},
        {"__init__"},
    ],
    "app": [
        {"limits", "tables"},
        {"form"},
        {"store", "tabs"},
        {"jobs"},
        {"workers"},
        {"page"},
        {"server"},
        {"__init__"},
    ],
    "fits": [
        {"measured"},
        {"parameters"},
        {"least_squares"},
        {"judge"},
        {"elastic"},
        {"adhesion", "viscoelastic"},
        {"report"},
        {"fitting", "half_space", "plan"},
        {"together"},
        {"places"},
        {"films"},
        {"cases"},
        {"batch", "case"},
        {"description", "distributions", "reading"},
        {"pictures"},
        {"__init__"},
    ],
}
"""Rooms inside the larger packages, from the ground up. A new room needs a place here, and one in ARCHITECTURE.md."""

_ALONE = {"reference"}
"""Imports nothing of the package: it judges the rest."""

_WHOLE_PACKAGE = {"cli"}
"""`import flatpunch` loads all of it at once, which only the outermost package may do."""


def _modules() -> dict[str, Path]:
    """Dotted name below the package -> file."""
    found = {}
    for path in sorted(SOURCE.rglob("*.py")):
        parts = path.relative_to(SOURCE).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts)] = path
    return found


MODULES = _modules()


def _floor(floors, name):
    return next((height for height, names in enumerate(floors) if name in names), None)


def _imported(module):
    """Yield (module below the package, line) for all imports of a file: top level, in functions, under TYPE_CHECKING."""
    path = MODULES[module]
    here = path.relative_to(SOURCE.parent).with_suffix("").parts[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), filename=str(path))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = list(here[: len(here) - node.level + 1]) if node.level else []
            name = ".".join([*base, *([node.module] if node.module else [])])
            below = [f"{name}.{alias.name}" for alias in node.names]
            names = [full if full.removeprefix("flatpunch.") in MODULES else name for full in below]
        else:
            continue
        yield from ((name.removeprefix("flatpunch").lstrip("."), node.lineno) for name in names if _own(name))


def _own(name):
    return name.split(".")[0] == "flatpunch"


def _room(module):
    """Package and room inside it: ("contact", "round") for contact/round/profile.py."""
    package, *rest = module.split(".")
    return package, (rest[0] if rest else "__init__")


@pytest.mark.parametrize("module", sorted(set(MODULES) - {"__init__"}))
def test_import_directions(module):
    package, room = _room(module)
    for target, line in _imported(module):
        where = f"{MODULES[module].relative_to(SOURCE)}:{line} imports"
        if not target:
            assert package in _WHOLE_PACKAGE, f"{where} the whole package; import the part that is needed"
            continue
        other, inner = _room(target)
        if other != package:
            assert package not in _ALONE, f"{where} {target}; {package} judges the rest and shares nothing with it"
            assert _floor(_FLOORS, other) < _floor(_FLOORS, package), f"{where} {target}, which is not below {package}"
        elif package in _INSIDE and inner != room:
            floors = _INSIDE[package]
            assert _floor(floors, inner) < _floor(floors, room), (
                f"{where} {target}, which is not below {package}.{room}"
            )


def test_what_curves_are_knows_no_formats():
    """Readers of files, `fits/measured/files`, are above the rest of their room."""
    for module in MODULES:
        if module.startswith("fits.measured") and not module.startswith("fits.measured.files"):
            above = [name for name, _ in _imported(module) if name.startswith("fits.measured.files")]
            assert not above, f"{module} imports {above}"


def test_no_circles_between_modules():
    """Not even through imports inside functions: each module can be understood from what it imports."""
    arrows = {module: {target for target, _ in _imported(module) if target in MODULES} - {module} for module in MODULES}
    done, path = set(), []

    def visit(module):
        if module in done:
            return
        assert module not in path, " -> ".join([*path[path.index(module) :], module])
        path.append(module)
        for target in sorted(arrows[module]):
            visit(target)
        done.add(path.pop())

    for module in sorted(set(MODULES) - {"__init__"}):
        visit(module)


def test_every_room_has_a_floor():
    """Every file belongs to a room of the tables, and every room of the tables has files."""
    rooms = {_room(module) for module in MODULES} - {("__init__", "__init__")}
    assert {package for package, _ in rooms} == set().union(*_FLOORS)
    for package, floors in _INSIDE.items():
        assert {room for name, room in rooms if name == package} == set().union(*floors), package


@pytest.mark.parametrize("module", [name for name in MODULES if _room(name)[0] == "reference"])
def test_reference_uses_numpy_and_scipy_only(module):
    import sys

    for node in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        for name in names:
            top = name.split(".")[0]
            assert top in {"numpy", "scipy", "flatpunch"} or top in sys.stdlib_module_names, f"{module} imports {name}"


@pytest.mark.parametrize(
    "package", ["numerics", "media", "compliances", "punch", "indenters", "bem", "contact", "stresses"]
)
def test_mechanics_knows_no_files_and_pictures(package):
    """Units with names, file formats, pictures and terminals stay outside."""
    outside = {"pint", "pydantic", "typer", "rich", "matplotlib", "h5netcdf", "tomllib"}
    for module, path in MODULES.items():
        if _room(module)[0] != package:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            found = {name.split(".")[0] for name in names} & outside
            assert not found, f"{path.name} imports {found}"


def test_no_module_hides_behind_a_name_of_its_room():
    """`import flatpunch.fits.elastic.problem as problem` works for every module: none has the name of a public function."""
    hidden = []
    for module in sorted(name for name in MODULES if not name.endswith("__")):
        room, _, name = f"flatpunch.{module}".rpartition(".")
        try:
            loaded = import_module(f"flatpunch.{module}")
        except ModuleNotFoundError:  # a plug-in for a program that is not installed
            assert module.startswith("plugins.")
        else:
            hidden += [module] * (getattr(import_module(room), name) is not loaded)
    assert hidden == []
