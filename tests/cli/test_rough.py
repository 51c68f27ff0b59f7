"""`flatpunch rough`: case files of surfaces and of asperities, their refusals, results and pictures."""

import matplotlib.image
import meshio
import numpy as np
import pytest

import flatpunch as fp
from flatpunch.files import exports as vtk
from flatpunch.files.rough import read_rough_case
from support.commands import run

BODY = 'layers = [{ young = "5 kPa", poisson = 0.45, thickness = "5 um" }]\nbase = { kind = "rigid" }\n'
SURFACE = '[surface]\nkind = "self-affine"\ncells = 32\nspacing = "100 nm"\nrms_slope = 0.1\ncut_off = "800 nm"\n'
BEADS = '[asperities]\ntip = { kind = "sphere", radius = "5 um" }\npositions = [["0 um", "0 um"], ["8 um", "0 um"]]\n'


@pytest.fixture
def case(tmp_path):
    def written(text):
        path = tmp_path / "case.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return written


@pytest.mark.long
def test_a_surface_is_solved_written_and_drawn(case, tmp_path):
    path = case(f'title = "Gel"\n{BODY}{SURFACE}[control]\npressure = ["10 Pa", "100 Pa"]\n')
    nc, png = tmp_path / "out.nc", tmp_path / "out.png"
    done = run("rough", path, "-o", nc, "--plot", png)
    assert done.exit_code == 0, done.output
    medium = fp.Medium([fp.Layer(5e3, 0.45, 5e-6)], base=fp.RigidBase())
    rough = fp.self_affine(32, 100e-9, rms_slope=0.1, cut_off=800e-9)
    direct = fp.rough_contact(medium, rough, pressure=[10.0, 100.0])
    np.testing.assert_allclose(fp.load(nc).area.values, direct.area.values)
    assert '"rms_slope"' in fp.load(nc).attrs["topography"]
    height, width, _ = matplotlib.image.imread(png).shape
    assert width > 2 * height > 800
    assert "patches" in done.output


@pytest.fixture
def gel(case):
    return case(f'{BODY}{SURFACE}[control]\npressure = ["10 Pa", "100 Pa"]\n')


@pytest.mark.long
def test_maps_of_the_last_step(gel, tmp_path):
    maps, points, text = (tmp_path / f"maps{ending}" for ending in (".NPZ", ".vtu", ".txt"))
    for path in (maps, points, text):
        run("rough", gel, "-o", path, exits=0)
    direct = read_rough_case(gel).solve(last=True).isel(step=0)
    with np.load(maps) as found:
        for name in ("x", "y", "pressure", "gap", "displacement"):
            np.testing.assert_array_equal(found[name], direct[name].values)
        assert found["pressure"].mean() == pytest.approx(100.0)
        np.testing.assert_array_equal(meshio.read(points).point_data["gap"], found["gap"].ravel())
        heights = fp.read_topography(text).heights
        # pandas reads to the last digit but one
        np.testing.assert_allclose(heights, found["gap"], rtol=1e-15, atol=0)


def test_maps_are_refused_before_the_surface_is_solved(gel, case, tmp_path, monkeypatch):
    monkeypatch.setattr(type(read_rough_case(gel)), "solve", lambda self, last=False: pytest.fail("solved"))
    monkeypatch.setattr(vtk, "find_spec", lambda name: None)
    (tmp_path / "map.npz").symlink_to(gel)
    (tmp_path / "folder.npz").mkdir()
    for name, words in (
        ("maps.gwy", "the ending must be .nc"),
        ("maps.vtu", ".vtu files need meshio: pip install 'flatpunch[vtk]'"),
        ("map.npz", "an input of the command"),
        ("folder.npz", "is a folder"),
        ("none/maps.txt", "does not exist. Make it first"),
    ):
        done = run("rough", gel, "-o", tmp_path / name, exits=2, columns=300)
        assert words in done.output
    beads = case(f'{BODY}{BEADS}[control]\ndepth = "1 nm"\n')
    assert "asperities have no maps" in run("rough", beads, "-o", tmp_path / "beads.vtu", exits=2, columns=300).output


@pytest.mark.long
@pytest.mark.parametrize("periodic", ['"x"', '"y"', "false", "true"])
def test_borders_of_a_surface(case, periodic):
    path = case(f'{BODY}{SURFACE}periodic = {periodic}\n[control]\ndepth = "50 nm"\n')
    wanted = {'"x"': (True, False), '"y"': (False, True), "false": (False, False), "true": (True, True)}[periodic]
    assert read_rough_case(path).surface.periodic == wanted
    assert run("rough", path, "--plot", path.with_suffix(".png")).exit_code == 0


def test_asperities(case, tmp_path):
    path = case(
        f'{BODY}{BEADS}heights = ["0 nm", "-20 nm"]\n[control]\nforce = {{ start = "10 pN", stop = "1 nN", points = 3 }}\n'
    )
    done = run("rough", path, "--plot", tmp_path / "beads.pdf")
    assert done.exit_code == 0, done.output
    assert "contacts" in done.output
    assert (tmp_path / "beads.pdf").stat().st_size > 1000
    assert read_rough_case(path).solve().force.values == pytest.approx(np.linspace(10e-12, 1e-9, 3), rel=1e-6)


def test_a_measured_surface(case, tmp_path):
    x = np.arange(16) * 1e-7
    z = 1e-8 * np.random.default_rng(0).random((16, 16))
    np.savez(tmp_path / "scan.npz", x=x, y=x, z=z)
    path = case(f'{BODY}[surface]\nkind = "file"\nfile = "scan.npz"\npeaks = "lowest"\n[control]\npressure = "1 Pa"\n')
    surface = read_rough_case(path).surface
    np.testing.assert_allclose(surface.heights, -z)
    assert surface.spacing == pytest.approx(1e-7)
    np.savez(tmp_path / "scan.npz", x=x, y=2 * x, z=z)
    with pytest.raises(ValueError, match="square cells"):
        fp.read_topography(tmp_path / "scan.npz")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f'{BODY}{SURFACE}{BEADS}[control]\ndepth = "1 nm"\n', "found both"),
        (
            f'{BODY}{BEADS.replace("kind = ", "shape = ")}[control]\ndepth = "1 nm"\n',
            "tip.kind is missing; it is one of '",
        ),
        (f'{BODY}[surface]\nkind = "rough"\n[control]\ndepth = "1 nm"\n', "surface.kind"),
        (f'{BODY}{BEADS}[control]\npressure = "1 Pa"\n', "belongs to a [surface]"),
        (f"{BODY}{SURFACE}[control]\n", "exactly one of pressure, force and depth"),
        (f'{BODY}{SURFACE}rms_height = "1 nm"\n[control]\npressure = "1 Pa"\n', "exactly one"),
        (f'{BODY}{SURFACE}[control]\npressure = "1 nm"\n', "dimension of a length"),
        (
            f'{BODY}indenter = {{ kind = "cone", inclination = "20 deg" }}\n[control]\ndepth = "1 nm"\n',
            "flatpunch solve",
        ),
    ],
)
def test_refusals(case, text, words):
    done = run("rough", case(text), exits=2, columns=120)
    assert words in " ".join(done.output.split()), done.output


def test_check_reports_surfaces_and_asperities(case, tmp_path):
    x = np.arange(16) * 1e-7
    np.savez(tmp_path / "scan.npz", x=x, y=x, z=0.01 * x + 1e-10 * np.random.default_rng(0).random((16, 16)))
    measured = '[surface]\nkind = "file"\nfile = "scan.npz"\nperiodic = false\n'
    for table, words in (
        (SURFACE, ("32 x 32 cells of 100 nm, repeats along x and y", "rms slope 0.1")),
        (BEADS, ("2 times Sphere radius 5 µm",)),
        (measured, ("ends at its border", "A plane of slopes 0.01 along x")),
    ):
        done = run("check", case(f'{BODY}{table}[control]\nforce = "1 nN"\n'))
        assert done.exit_code == 0, done.output
        assert all(each in done.output for each in (*words, "force 1 nN")), done.output
    levelled = read_rough_case(case(f'{BODY}{measured}level = true\n[control]\nforce = "1 nN"\n')).surface
    assert levelled.rms_height < 1e-10


def test_other_commands_name_this_one(case):
    path = case(f'{BODY}{SURFACE}[control]\npressure = "1 Pa"\n')
    for command in ("solve", "stress"):
        done = run(command, path)
        assert done.exit_code == 2
        assert f"flatpunch rough {path}" in done.output.replace("\n", "")


def test_hardness_of_a_surface_in_a_case_file(case):
    path = case(f'hardness = "2 kPa"\n{BODY}{SURFACE}[control]\npressure = "100 Pa"\n')
    read = read_rough_case(path)
    assert read.hardness == 2e3
    assert float(read.solve().max_pressure[0]) <= 2e3
    done = run("rough", case(f'hardness = "2 kPa"\n{BODY}{BEADS}[control]\nforce = "1 nN"\n'))
    assert done.exit_code == 2
    assert "asperities are elastic" in done.output
