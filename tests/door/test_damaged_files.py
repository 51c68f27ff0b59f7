"""Damaged result files are refused, every one of them, and never read as other numbers; caches and stores solve again."""

import io
import random
import re
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest

import flatpunch as fp
from flatpunch import atlas
from flatpunch._support.whole_file import BrokenSeal, sealed, unsealed
from flatpunch.atlas.library import folder
from flatpunch.files import ResultError

GEL = fp.Medium([fp.Layer(5e3, 0.45, 1e-6)], fp.RigidBase())


@pytest.fixture(scope="module")
def result():
    return fp.indent(GEL, fp.Paraboloid(5e-6), depth=np.linspace(0, 2e-7, 12), angles=24)


def damaged(whole: bytes, rng: random.Random) -> bytes:
    """Cut off, one bit turned, a piece replaced, something added, zeros."""
    found, kind = bytearray(whole), rng.randrange(5)
    at = rng.randrange(len(found))
    if kind == 0:
        del found[at:]
    elif kind == 1:
        found[at] ^= 1 << rng.randrange(8)
    elif kind == 2:
        found[at : at + rng.randint(1, 500)] = rng.randbytes(rng.randint(1, 500))
    elif kind == 3:
        found += rng.randbytes(rng.randint(1, 300))
    else:
        count = rng.randint(1, 64)
        found[at : at + count] = bytes(count)
    return bytes(found)


def spoilt(path, count):
    """Damage a file on the disk, `count` times anew; what happens to be whole still is left out."""
    whole, rng = path.read_bytes(), random.Random(count)
    for _ in range(count):
        content = damaged(whole, rng)
        if content != whole:
            path.write_bytes(content)
            yield


@pytest.mark.parametrize("ending", [".nc", ".csv"])
@pytest.mark.parametrize("count", [60, pytest.param(2000, marks=pytest.mark.slow)])
def test_damaged_results_are_refused(result, tmp_path, ending, count):
    path = fp.save(result, tmp_path / f"curve{ending}")
    for _ in spoilt(path, count):
        with pytest.raises(ResultError, match=rf"curve\{ending}: "):
            fp.load(path)


@pytest.mark.parametrize("count", [60, pytest.param(2000, marks=pytest.mark.slow)])
def test_damaged_tables_of_the_atlas_are_refused(tmp_path, count, capfd):
    path = Path(shutil.copy(folder() / "sliding-layer.nc", tmp_path / "own.nc"))
    for _ in spoilt(path, count):
        with pytest.raises(atlas.AtlasFileError, match=r"own\.nc is no table of the atlas: "):
            atlas.read_table(path)
    # HDF5 prints when a damaged file is closed
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("name", atlas.families())
def test_shipped_tables_are_sealed(name):
    assert unsealed((folder() / f"{name}.nc").read_bytes())[1]


def test_other_programs_read_sealed_files(result, tmp_path):
    import h5netcdf
    import xarray as xr

    path = fp.save(result, tmp_path / "curve.nc")
    assert xr.load_dataset(path, engine="h5netcdf")["force"].identical(result["force"])
    with h5netcdf.File(path, "r") as file:
        assert file.variables["force"]._h5ds.fletcher32


def test_files_of_earlier_versions_are_read(result, tmp_path):
    """They have no seal, and no digest."""
    path = tmp_path / "old.nc"
    result.to_netcdf(path, engine="h5netcdf")
    assert fp.load(path).identical(result)
    text = fp.save(result, tmp_path / "old.csv", outlines=True).read_text(encoding="utf-8")
    first, rest = text.split("\n", 1)
    assert first.startswith("# sha256")
    old = tmp_path / "older.csv"
    old.write_text(rest.replace('"content_sha256": true, ', ""), encoding="utf-8")
    assert fp.load(old).identical(result)


@pytest.mark.parametrize("size", [0, 1, 80, 5000])
def test_seals(size):
    content = random.Random(size).randbytes(size)
    assert unsealed(sealed(content)) == (content, True)
    assert unsealed(content) == (content, False)
    for i in range(len(sealed(content)) - 88, len(sealed(content))):
        spoilt = bytearray(sealed(content))
        spoilt[i] ^= 4
        with pytest.raises(BrokenSeal):
            unsealed(bytes(spoilt))


@pytest.mark.long
def test_a_damaged_cache_is_set_aside_and_solved_again(tmp_path):
    tip, folder = fp.Pyramid(4, 0.3), tmp_path / "cache"

    def solve():
        return float(fp.indent(GEL, tip, depth=1e-7, method=fp.Refined(cells=32, cache=folder, rtol=1e-4))["force"][0])

    first = solve()
    (path,) = folder.glob("*.npz")
    whole = path.read_bytes()
    for spoilt in (whole[:-300] + bytes([whole[-300] ^ 1]) + whole[-299:], b"", whole[:100]):
        path.write_bytes(spoilt)
        with pytest.warns(fp.FlatpunchWarning, match="damaged or changed.*set aside, and solved again"):
            _fresh(solve, first)
    np.savez(path, positions=np.array([0.0]), rows=np.full((1, 3), 7.0))
    with pytest.warns(fp.FlatpunchWarning, match="it has no seal"):
        _fresh(solve, first)
    assert path.exists()


def _fresh(solve, wanted):
    from flatpunch.contact.refined import method

    for name in vars(method).values():
        if hasattr(name, "cache_clear"):
            name.cache_clear()
    assert solve() == pytest.approx(wanted, rel=1e-12)


def test_a_full_disk_is_one_message(result, tmp_path, monkeypatch):
    def full(self, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    for ending in (".nc", ".csv"):
        with pytest.raises(ResultError, match=rf"curve\{ending}: cannot be written .No space left on device."):
            fp.save(result, tmp_path / f"curve{ending}")
    assert list(tmp_path.iterdir()) == []


def test_links_are_followed(result, tmp_path):
    (tmp_path / "there").mkdir()
    link = tmp_path / "curve.nc"
    link.symlink_to(tmp_path / "there" / "real.nc")
    fp.save(result, link)
    assert link.is_symlink()
    assert fp.load(tmp_path / "there" / "real.nc").identical(result)


def test_what_is_no_file_is_no_result(tmp_path):
    (tmp_path / "folder.nc").mkdir()
    for path in (tmp_path / "folder.nc", tmp_path / "none.csv"):
        with pytest.raises(ResultError, match="not readable"):
            fp.load(path)
    with pytest.raises(ResultError):
        fp.save(fp.indent(GEL, fp.Cone(0.1), depth=1e-9), tmp_path / "folder.nc")


def _zip_of_a_curve():
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as archive:
        archive.writestr("a.csv", "depth,force\n" + "1e-9,2e-9\n" * 30)
    return whole.getvalue()


def _workbook():
    whole = io.BytesIO()
    pytest.importorskip("pandas").DataFrame({"depth (nm)": range(30), "force (nN)": range(30)}).to_excel(
        whole, index=False
    )
    return whole.getvalue()


@pytest.mark.parametrize(("ending", "make"), [("zip", _zip_of_a_curve), ("xlsx", _workbook)])
def test_damaged_archives_of_curves_are_refused_in_our_words(tmp_path, capfd, ending, make):
    pytest.importorskip("afmformats")
    pytest.importorskip("openpyxl")
    whole, path, rng, messages = make(), tmp_path / f"curve.{ending}", random.Random(5), []
    for _ in range(40):
        path.write_bytes(damaged(whole, rng))
        try:
            fp.read_curve(path)
        except fp.CurveError as error:
            messages.append(str(error))
    # damage beside the cells of a workbook changes nothing
    assert len(messages) == 40 if ending == "zip" else len(messages) > 20
    for each in messages:
        assert re.search(r"curve\.(zip|xlsx)|a\.csv", each), each
        # the words of Python and of libraries
        assert not re.search(r"Errno|codec|Error|argument|BadZip", each), each
    assert "Traceback" not in capfd.readouterr().err


def test_zips_without_curves_and_with_names_that_are_no_text(tmp_path):
    pytest.importorskip("afmformats")
    path = tmp_path / "curve.zip"
    zipfile.ZipFile(path, "w").close()
    with pytest.raises(fp.CurveError, match=r"curve\.zip: the file holds no curve"):
        fp.read_curve(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("\u00e9.csv", "depth,force\n1e-9,2e-9\n")
    path.write_bytes(path.read_bytes().replace("\u00e9".encode(), b"\xff\xff", 1))
    with pytest.raises(fp.CurveError, match="cannot be unpacked"):
        fp.read_curve(path)


@pytest.mark.parametrize("damage", [np.nan, -np.inf, 1e300])
@pytest.mark.parametrize("column", ["force", "height (measured)"])
@pytest.mark.parametrize("k", [0.1, None])
def test_numbers_of_damaged_microscope_files_are_refused_with_the_file(tmp_path, column, k, damage):
    pytest.importorskip("afmformats")
    from afmformats.mod_force_distance import AFMForceDistance

    columns = {name: np.linspace(0, 1e-7, 20) for name in ("force", "height (measured)")}
    columns[column] = np.append(columns[column][1:], damage)
    path = tmp_path / "curve.h5"
    known = {"imaging mode": "force-distance", "enum": 0, "path": path, "point count": 20}
    AFMForceDistance(columns, known | ({} if k is None else {"spring constant": k})).export_data(path, fmt="hdf5")
    with pytest.raises(fp.CurveError, match=r"^curve\.h5, curve 0: "):
        fp.read_curve(path)


def test_names_that_are_too_long_are_no_files(tmp_path):
    name = "x" * 10_000
    with pytest.raises(fp.CurveError, match="no such file"):
        fp.read_curve(f"{name}.csv")
    with pytest.raises(ValueError, match="is no file"):
        fp.read_height_map(f"{name}.npz")
    with pytest.raises(FileNotFoundError, match="no such file"):
        atlas.read_table(tmp_path / f"{name}.nc")


def test_a_full_disk_costs_no_fit(tmp_path, monkeypatch):
    """Records of finished curves only serve the next run."""
    from flatpunch.fits.places import Records

    def full(*_):
        raise OSError(28, "No space left on device")

    records = Records(tmp_path / "table.records")
    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.warns(fp.FlatpunchWarning, match="cannot be kept .No space left on device."):
        records.keep(["a"], [{"points": 3}])
    # once only: warnings are errors here
    records.keep(["b"], [{"points": 4}])
    assert set(records.known) == {"a", "b"}
