"""Fields as VTK files, read back by the libraries that other programs use."""

import meshio
import numpy as np
import pytest

import flatpunch as fp

BODY, TIP = fp.Medium([fp.Layer(10e9, 0.3, 1e-6)], base=fp.HalfSpace(100e9, 0.2)), fp.Sphere(10e-6)
X, Y, Z = (np.linspace(0, 2e-6, n) for n in (4, 3, 5))


def solved(x, y, z):
    return fp.fields(BODY, TIP, x, y, z, radius=1e-6, friction=0.2)


@pytest.mark.parametrize(
    ("points", "kind", "cells"),
    [
        ((X[:, None, None], Y[:, None], Z), "hexahedron", 3 * 2 * 4),
        ((X, 0.1e-6, Z[:, None]), "quad", 3 * 4),
        ((X[:, None], [[0.0]], 0.5e-6), "line", 3),
        ((X, 0.0, 0.5e-6), "vertex", 4),
        ((0.1e-6, 0.0, 0.5e-6), "vertex", 1),
    ],
    ids=["volume", "section", "column", "list", "one point"],
)
def test_unstructured(tmp_path, points, kind, cells):
    """Values at points in their order, and cells that fill the grid."""
    found = solved(*points)
    mesh = meshio.read(fp.save(found, tmp_path / "fields.vtu"))
    assert [(block.type, len(block.data)) for block in mesh.cells] == [(kind, cells)]
    np.testing.assert_array_equal(mesh.points, np.stack([found[name].values.ravel() for name in "xyz"], axis=1))
    tensor = mesh.point_data["stress"].reshape(-1, 3, 3)
    for component, (i, j) in {"xx": (0, 0), "zz": (2, 2), "xz": (0, 2), "yz": (1, 2), "xy": (1, 0)}.items():
        np.testing.assert_array_equal(tensor[:, i, j], found.stress.sel(component=component).values.ravel())
    np.testing.assert_array_equal(
        mesh.point_data["displacement"][:, 2], found.displacement.sel(axis="z").values.ravel()
    )
    np.testing.assert_array_equal(mesh.point_data["principal"][:, 0], found.principal.sel(order=1).values.ravel())
    np.testing.assert_array_equal(mesh.point_data["von_mises"], found.von_mises.values.ravel())
    np.testing.assert_array_equal(mesh.point_data["layer"], found.layer.values.ravel())


@pytest.mark.parametrize("ending", [".vtu", ".vts"])
def test_cells_fill_the_volume(tmp_path, ending):
    """The volume of all bricks, each with the right orientation, is that of the box."""
    pyvista = pytest.importorskip(
        "pyvista", reason="pyvista, which loads all of VTK, is not installed (make integrations)"
    )
    found = solved(X[:, None, None], Y[:, None], Z)
    grid = pyvista.read(fp.save(found, tmp_path / f"fields{ending}"))
    sizes = grid.compute_cell_sizes()["Volume"]
    assert grid.n_cells == 3 * 2 * 4
    np.testing.assert_allclose(np.abs(sizes).sum(), (2e-6) ** 3, rtol=1e-6)
    place = grid.find_closest_point((X[1], Y[2], Z[3]))
    assert grid["von_mises"][place] == found.von_mises.values[1, 2, 3]


def test_structured_section(tmp_path):
    pyvista = pytest.importorskip(
        "pyvista", reason="pyvista, which loads all of VTK, is not installed (make integrations)"
    )
    found = solved(X, 0.1e-6, Z[:, None])
    grid = pyvista.read(fp.save(found, tmp_path / "fields.vts"))
    assert grid.dimensions == (4, 5, 1)
    np.testing.assert_array_equal(grid["von_mises"], found.von_mises.values.ravel())


def test_refusals(tmp_path):
    with pytest.raises(fp.files.ResultError, match=r"curve.vtu: .vtu files hold fields"):
        fp.save(fp.indent(BODY, TIP, depth=1e-8), tmp_path / "curve.vtu")
    with pytest.raises(fp.files.ResultError, match=r"a .vts file holds a grid"):
        fp.save(solved(X, 0.0, 0.5e-6), tmp_path / "fields.vts")
    with pytest.raises(fp.files.ResultError, match=r"results are kept as .nc"):
        fp.load(fp.save(solved(X, 0.0, 0.5e-6), tmp_path / "fields.vtu"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["fields.vtu"]
