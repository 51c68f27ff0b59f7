"""Maps of rough contacts in files for other programs: the values of the last step, and what has none."""

import meshio
import numpy as np
import pytest

import flatpunch as fp

ROUGH = fp.Topography(1e-8 * np.random.default_rng(0).random((12, 16)), 1e-7)
STEEL = fp.HalfSpace(210e9, 0.3)
KINDS = [".npz", ".txt", ".vtu"]


@pytest.fixture(scope="module")
def contact():
    return fp.rough_contact(STEEL, ROUGH, pressure=[1e8, 1e9], fields=True)


def test_points_and_cells(contact, tmp_path):
    mesh, last = meshio.read(fp.save(contact, tmp_path / "maps.vtu")), contact.isel(step=-1)
    assert [(block.type, len(block.data)) for block in mesh.cells] == [("quad", 11 * 15)]
    for name in ("pressure", "gap", "displacement"):
        np.testing.assert_array_equal(mesh.point_data[name].reshape(12, 16), last[name].values)
    x, y, z = mesh.points.T.reshape(3, 12, 16)
    np.testing.assert_array_equal(x[3], last.x.values)
    np.testing.assert_array_equal(y[:, 3], last.y.values)
    assert not z.any()


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_that_was_chosen(contact, tmp_path, kind):
    chosen, alone = (fp.save(each, tmp_path / f"{i}{kind}") for i, each in enumerate((contact, contact.isel(step=1))))
    assert chosen.read_bytes() == alone.read_bytes()


@pytest.mark.parametrize("kind", [*KINDS, ".vts"])
def test_results_without_maps(tmp_path, kind):
    for result in (
        fp.rough_contact(STEEL, ROUGH, pressure=1e9),
        fp.asperities(STEEL, fp.Sphere(1e-6), [[0, 0]], force=1e-6),
        fp.indent(STEEL, fp.Sphere(1e-6), depth=1e-9),
    ):
        with pytest.raises(fp.files.ResultError, match=f"maps{kind}: .*(fields|flatpunch.vtk)"):
            fp.save(result, tmp_path / f"maps{kind}")
    assert not list(tmp_path.iterdir())


def test_gaps_in_surface_topography(contact, tmp_path):
    surfaces = pytest.importorskip("SurfaceTopography", reason="the extra flatpunch[topography] is not installed")
    found = surfaces.read_topography(str(fp.save(contact, tmp_path / "gap.txt")))
    np.testing.assert_array_equal(found.heights(), contact.gap.values[-1].T)
    np.testing.assert_allclose(found.physical_sizes, ROUGH.size, rtol=1e-14)
    assert found.unit == "m"
    ours = fp.read_topography(tmp_path / "gap.txt")
    assert ours.spacing == pytest.approx(ROUGH.spacing)
    np.testing.assert_allclose(ours.heights, contact.gap.values[-1], rtol=1e-15, atol=0)
