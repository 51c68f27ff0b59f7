"""Files: identical when read back, readable by h5py alone, refused when they are something else."""

import h5py
import numpy as np
import pytest

import atlas_tables
from flatpunch import atlas
from flatpunch._support.whole_file import sealed
from flatpunch.atlas.library import folder


def test_written_and_read_back(tmp_path):
    table = atlas.table("sliding-layer")
    path = atlas_tables.write_table(table, tmp_path / "again.nc")
    again = atlas.read_table(path)
    assert (again.name, again.title, again.parameters, again.bound) == (
        table.name,
        table.title,
        table.parameters,
        table.bound,
    )
    assert again.attributes == table.attributes
    beta = np.geomspace(1e-3, 100, 60)
    # whole numbers of a step, which a second writing does not change but for its own rounding
    np.testing.assert_allclose(again.at().normalized_stiffness(beta), table.at().normalized_stiffness(beta), rtol=1e-11)
    for old, new in zip(table.panels, again.panels, strict=True):
        np.testing.assert_array_equal(old.orders, new.orders)


@pytest.mark.parametrize("name", atlas.families())
def test_files_say_what_they_are(name):
    with h5py.File(folder() / f"{name}.nc") as file:
        told = dict(file.attrs)
        assert np.ravel(told["flatpunch_atlas_schema"])[0] == 1
        for key in ("title", "description", "evaluation", "license", "created", "created_by", "tolerance"):
            assert key in told, key
        assert told["license"] == "CC-BY-4.0"
        assert np.ravel(told["relative_error_bound"])[0] == atlas.table(name).bound
        for parameter in str(file["parameters"].attrs["names"]).split():
            about = file["parameters"][parameter].attrs
            assert about["long_name"]
            assert about["units"]


def test_h5py_alone():
    """What a reader in another language does; the documentation shows the same."""
    beta, nu = 2.5, 0.47
    with h5py.File(folder() / "bonded-layer.nc") as file:
        low, high = file["panels/beta_low"][:], file["panels/beta_high"][:]
        panel = int(np.searchsorted(high, beta))
        flat = {
            key: file["flat"][key][:] for key in ("value", "panel_index", "output", "beta_degree", "degree_poisson")
        }
        step = float(np.ravel(file["flat/value"].attrs["scale_factor"])[0])
        p = dict(file["parameters/poisson"].attrs)
    entries = flat["panel_index"] == panel
    x = (2 * np.log(beta) - np.log(low[panel] * high[panel])) / np.log(high[panel] / low[panel])
    v = [-np.log(p["shift"] + (p["high"] - value) / (p["high"] - p["low"])) for value in (p["low"], nu, p["high"])]
    y = float(np.ravel((2 * v[1] - v[0] - v[2]) / (v[2] - v[0]))[0])
    terms = step * flat["value"][entries] * np.cos(flat["beta_degree"][entries] * np.arccos(x))
    output = np.bincount(flat["output"][entries], terms * np.cos(flat["degree_poisson"][entries] * np.arccos(y)))
    expected = atlas.table("bonded-layer").stiffness_and_moments(beta, poisson=nu)[0]
    assert np.exp(output[0]) == pytest.approx(float(expected), rel=1e-12)


def test_what_is_no_table(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such file"):
        atlas.read_table(tmp_path / "none.nc")
    text = tmp_path / "text.nc"
    text.write_text("no table", encoding="utf-8")
    with pytest.raises(atlas.AtlasFileError, match="is no table of the atlas"):
        atlas.read_table(text)
    whole = (folder() / "sliding-layer.nc").read_bytes()
    (tmp_path / "half.nc").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(atlas.AtlasFileError):
        atlas.read_table(tmp_path / "half.nc")
    later = tmp_path / "later.nc"
    later.write_bytes(whole)
    with h5py.File(later, "a") as file:
        file.attrs["flatpunch_atlas_schema"] = 99
    later.write_bytes(sealed(later.read_bytes()))
    with pytest.raises(atlas.AtlasFileError, match="its layout is version 99"):
        atlas.read_table(later)
    other = tmp_path / "other.nc"
    with h5py.File(other, "w") as file:
        file.attrs["title"] = "something else"
    with pytest.raises(
        atlas.AtlasFileError,
        match=r"no line of its checksum at the end; scripts/atlas_tables of the repository makes it",
    ):
        atlas.read_table(other)
    other.write_bytes(sealed(other.read_bytes()))
    with pytest.raises(atlas.AtlasFileError, match="does not say which layout"):
        atlas.read_table(tmp_path / "other.nc")
