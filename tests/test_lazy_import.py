"""`import flatpunch` loads no physics; names come from their parts when first asked for."""

import subprocess
import sys
from types import ModuleType

import pytest

import flatpunch as fp


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()


def test_importing_loads_neither_scipy_nor_xarray():
    loaded = run("import sys, flatpunch; print(*sorted({m.split('.')[0] for m in sys.modules}))")
    assert not {"numpy", "scipy", "xarray", "pandas", "matplotlib"} & set(loaded)


def test_contact_loads_no_tables():
    """Data sets are made of results only: processes that help with boundary elements need none."""
    loaded = run("import sys, flatpunch as fp; fp.indent; print(*sorted({m.split('.')[0] for m in sys.modules}))")
    assert "scipy" in loaded
    assert not {"xarray", "pandas", "matplotlib"} & set(loaded)


def test_methods_are_loaded_when_asked_for():
    loaded = run("import sys, flatpunch as fp; fp.indent; print(*sorted(sys.modules))")
    assert not {"flatpunch.bem", "flatpunch.contact.refined.method", "flatpunch.contact.adhesion.method"} & set(loaded)


def test_helpers_load_no_more_of_scipy_than_they_need():
    """They are waited for."""
    loaded = run("import sys, flatpunch.contact.refined.sample; print(*sorted(sys.modules))")
    assert not {"scipy.interpolate", "scipy.integrate", "scipy.optimize", "scipy.sparse"} & set(loaded)


UNUSED = {
    "pint",
    "dask",
    "matplotlib",
    "h5py",
    "h5netcdf",
    "pydantic",
    "typer",
    "rich",
    "lmfit",
    "emcee",
    "openpyxl",
    "xlrd",
}
"""Libraries that are loaded by files, pictures, commands and fits only."""


@pytest.mark.long
@pytest.mark.parametrize(
    "call",
    [
        "fp.indent(gel, tip, depth=[0.1, 0.2])",
        "fp.indent(gel, fp.Pyramid(sides=4, inclination=0.3), depth=0.1)",
        "fp.indent(gel, fp.Cone(0.3), depth=[0.1, 0.2], time=[0.0, 1.0], relaxation=fp.StandardLinearSolid(0.5, 1.0))",
        "fp.adhesion_loop(gel, tip, depth=0.1, work_of_adhesion=0.01)",
    ],
)
def test_results_load_no_library_that_they_do_not_use(call):
    """xarray loads those of units and chunks itself, of arrays it converts: a third of a second of the first call."""
    code = f"import sys, flatpunch as fp; gel, tip = fp.HalfSpace(1.0, 0.3), fp.Paraboloid(1.0); {call}"
    loaded = run(f"{code}; print(*sorted({{m.split('.')[0] for m in sys.modules}}))")
    assert "xarray" in loaded
    assert not UNUSED & set(loaded)


@pytest.mark.long
def test_a_round_contact_loads_nothing_of_scipy():
    """The special functions take a quarter of the first call of a process to load, and few of their values are needed."""
    code = (
        "import sys, flatpunch as fp; gel, tip = fp.HalfSpace(1.0, 0.3), fp.Sphere(1.0); fp.indent(gel, tip, depth=0.1)"
    )
    layered = "fp.indent(fp.Medium([fp.Layer(1.0, 0.3, 1.0)], base=fp.RigidBase()), fp.Cone(0.3), depth=0.1)"
    loaded = run(f"{code}; {layered}; print(*sorted(sys.modules))")
    parts = ("special", "fft", "linalg", "interpolate", "integrate", "optimize", "sparse")
    assert not {f"scipy.{name}" for name in parts} & set(loaded)
    rooms = ("bem", "stresses", "files", "fits", "plots", "indenters.worn", "contact.refined", "contact.adhesion")
    assert not {f"flatpunch.{name}" for name in rooms} & set(loaded)


@pytest.mark.parametrize("name", fp.__all__)
def test_every_name_is_there(name):
    assert getattr(fp, name) is not None


def test_parts_are_modules():
    assert all(isinstance(getattr(fp, name), ModuleType) for name in ("atlas", "bem", "files", "indenters", "media"))


def test_a_name_that_is_not_there_is_told():
    with pytest.raises(AttributeError, match="indentt"):
        fp.__getattr__("indentt")


def test_the_command_line_is_there_without_physics():
    """Help, the version and mistakes in a command are answered at once."""
    loaded = run("import sys, flatpunch.cli; print(*sorted({m.split('.')[0] for m in sys.modules}))")
    assert not {"numpy", "scipy", "xarray", "matplotlib"} & set(loaded)


@pytest.mark.long
@pytest.mark.parametrize("name", ["unloading", "oliver_pharr"])
def test_functions_of_a_part_named_like_its_modules(name):
    code = f"import sys, flatpunch.fits.films.{name}; print(type(sys.modules['flatpunch.fits'].{name}).__name__)"
    assert run(code) == ["function"]
