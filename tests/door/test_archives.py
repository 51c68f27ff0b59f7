"""Archives that unpack to more than memory holds are refused before they are unpacked; damaged ones with one message."""

import random
import re
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
    with pytest.raises(
        ValueError, match=r"an archive that unpacks to .* MB, its file z.npy alone to .* MB; at most 0.001 MB"
    ):
        fp.read_height_map(npz)


@pytest.mark.parametrize("ending", [".zip", ".jpk-force", ".xlsx"])
def test_so_are_archives_of_curves(ending, tmp_path, monkeypatch):
    path = tmp_path / f"bomb{ending}"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.txt", b"0" * 1_000_000)
    monkeypatch.setattr(reading, "UNPACKED", 100_000)
    with pytest.raises(
        fp.CurveError, match=rf"bomb{ending}: an archive that unpacks to 1 MB, its file a.txt alone to 1 MB; at most"
    ):
        fp.read_curve(path)
    # small files that are large together; the curves of force maps are read one by one
    monkeypatch.setattr(reading, "UNPACKED", 1_500_000)
    with pytest.warns(UserWarning, match="Duplicate"), zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.txt", b"0" * 1_000_000)
    words = "unpacks to 2 MB, its file a.txt alone to 1 MB; at most 1.5 MB"
    with pytest.raises(fp.CurveError, match="afmformats" if ending == ".jpk-force" else words):
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
        fp.CurveError,
        match=r"large.zip: an archive that unpacks to 600 MB, its file curve.csv alone to 600 MB; at most 250 MB",
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
@pytest.mark.parametrize("kind", ["stored", "deflated", "npy"])
def test_damaged_maps_end_in_one_message(kind, tmp_path):
    """Bytes anywhere and in the heads, and ends that are cut off. Archives carry checksums: what is read is what was written."""
    z, rng, refused = (AXIS[:, None] ** 2 + AXIS**2) / 2e-5, random.Random(4), 0
    path = tmp_path / ("map.npy" if kind == "npy" else "map.npz")
    given = {"spacing": 1e-7, "unit": "m"} if kind == "npy" else {}
    if kind == "npy":
        np.save(path, z)
    else:
        (np.savez if kind == "stored" else np.savez_compressed)(path, x=AXIS, y=AXIS, z=z)
    whole = path.read_bytes()
    signs = (b"PK\x03\x04", b"PK\x01\x02", b"PK\x05\x06", b"\x93NUMPY")
    heads = [
        at
        for sign in signs
        for found in re.finditer(re.escape(sign), whole)
        for at in range(found.start(), min(found.start() + 60, len(whole)))
    ]
    for i in range(170):
        spoilt = bytearray(whole)
        if i % 4 == 0:
            del spoilt[rng.randrange(len(spoilt)) :]
        for at in rng.sample(heads if i % 2 else range(len(whole)), 1 + i % 3):
            if at < len(spoilt):
                spoilt[at] ^= 1 << rng.randrange(8) if i % 3 else rng.randrange(1, 256)
        path.write_bytes(spoilt)
        try:
            found = fp.read_topography(path, **given)
        except ValueError as error:
            refused += 1
            message = str(error)
        else:
            message = "map.npz"
            assert kind == "npy" or np.array_equal(found.heights, z)
        assert "map.np" in message or "Topography" in message
        assert len(message) < 600
    assert refused > 50


def test_headers_that_ask_for_all_memory(tmp_path):
    import io

    huge = io.BytesIO()
    np.lib.format.write_array_header_1_0(huge, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    with zipfile.ZipFile(tmp_path / "tip.npz", "w") as archive:
        for name in "xyz":
            archive.writestr(f"{name}.npy", huge.getvalue())
    with pytest.raises(ValueError, match="damaged, or no array of NumPy"):
        fp.read_height_map(tmp_path / "tip.npz")
