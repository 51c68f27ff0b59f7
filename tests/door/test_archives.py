"""Archives that unpack to more than memory holds are refused before they are unpacked; damaged ones with one message."""

import random
import zipfile

import numpy as np
import pytest

import flatpunch as fp
from flatpunch._support import reading
from support.platforms import PEAK_IN_KILOBYTES

AXIS = np.linspace(-1e-6, 1e-6, 15)


@pytest.fixture
def npz(tmp_path):
    path = tmp_path / "tip.npz"
    np.savez_compressed(path, x=AXIS, y=AXIS, z=(AXIS[:, None] ** 2 + AXIS**2) / 2e-5)
    return path


def test_the_unpacked_size_is_bounded(npz, monkeypatch):
    fp.read_height_map(npz)
    monkeypatch.setattr(reading, "UNPACKED", 1000)
    with pytest.raises(ValueError, match=r"an archive that unpacks to .* MB, z.npy alone to .* MB"):
        fp.read_height_map(npz)


@pytest.mark.parametrize("ending", [".zip", ".jpk-force", ".xlsx"])
def test_so_are_archives_of_curves(ending, tmp_path, monkeypatch):
    path = tmp_path / f"bomb{ending}"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.txt", b"0" * 1_000_000)
    monkeypatch.setattr(reading, "UNPACKED", 100_000)
    with pytest.raises(
        fp.CurveError, match=rf"bomb{ending}: an archive that unpacks to 1 MB, a.txt alone to 1 MB; at most"
    ):
        fp.read_curve(path)
    # small files that are large together; the curves of force maps are read one by one
    monkeypatch.setattr(reading, "UNPACKED", 1_500_000)
    monkeypatch.setattr(reading, "MAP", 1_500_000)
    with pytest.warns(UserWarning, match="Duplicate"), zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.txt", b"0" * 1_000_000)
    with pytest.raises(
        fp.CurveError, match=rf"bomb{ending}: an archive that unpacks to 2 MB, a.txt alone to 1 MB; at most 1.5 MB"
    ):
        fp.read_curve(path)


@pytest.mark.long
@PEAK_IN_KILOBYTES
def test_the_largest_archive_is_one_that_a_laptop_bears(tmp_path):
    """Text takes fifteen times its size in memory; nothing is unpacked before it is refused."""
    import resource

    path = tmp_path / "large.zip"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("curve.csv", "w") as file,
    ):
        for _ in range(60):
            file.write(bytes(10_000_000))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(
        fp.CurveError, match=r"large.zip: an archive that unpacks to 600 MB, curve.csv alone to 600 MB; at most 250 MB"
    ):
        fp.read_curve(path)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # kilobytes
    text = tmp_path / "large.csv"
    with text.open("wb") as file:
        file.truncate(600_000_000)
    with pytest.raises(fp.CurveError, match=r"large.csv: larger than 200 MB"):
        fp.read_curve(text)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000


def test_many_small_files_are_no_archive_either(tmp_path, monkeypatch):
    path = tmp_path / "many.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for i in range(30):
            archive.writestr(f"{i}.txt", b"0")
    monkeypatch.setattr(reading, "FILES", 20)
    with pytest.raises(fp.CurveError, match="an archive of 30 files"):
        fp.read_curve(path)


@pytest.mark.long
def test_damaged_maps_end_in_one_message(npz):
    whole, rng, seen = npz.read_bytes(), random.Random(4), 0
    for _ in range(150):
        spoilt = bytearray(whole)
        at = rng.randrange(len(spoilt))
        if rng.random() < 0.3:
            del spoilt[at:]
        else:
            spoilt[at : at + 4] = rng.randbytes(4)
        npz.write_bytes(spoilt)
        try:
            fp.read_height_map(npz)
        except ValueError as error:
            seen += 1
            message = str(error)
        else:
            message = "read"
        assert len(message) < 600
    assert seen > 50


def test_headers_that_ask_for_all_memory(tmp_path):
    import io

    huge = io.BytesIO()
    np.lib.format.write_array_header_1_0(huge, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    with zipfile.ZipFile(tmp_path / "tip.npz", "w") as archive:
        for name in "xyz":
            archive.writestr(f"{name}.npy", huge.getvalue())
    with pytest.raises(ValueError, match="no readable NumPy archive"):
        fp.read_height_map(tmp_path / "tip.npz")
