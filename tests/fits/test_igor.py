"""Headers of Igor binary waves: sizes that the file does not have are refused before the file's reader sees them."""

import random
import struct

import pytest

import flatpunch as fp
from flatpunch.fits.measured.files.afm import check_sizes

FORMS = {2: ("hiiih", 1, 3), 3: ("hiiiih", 1, 4), 5: ("hh15i", 2, 15)}


@pytest.fixture(params=[(version, order) for version in FORMS for order in "<>"], ids=str)
def wave(request, tmp_path):
    """A file of random bytes behind a header with random sizes that add up, and how to write another header."""
    version, order = request.param
    form, first, end = FORMS[version]
    rng = random.Random(str(request.param))
    fields = [0] * len(struct.unpack(f"{order}{form}", bytes(struct.calcsize(f"{order}{form}"))))
    fields[0] = version
    fields[first:end] = [rng.choice([0, rng.randrange(500)]) for _ in fields[first:end]]
    body = rng.randbytes(sum(fields[first:end]))
    path = tmp_path / "wave.ibw"

    def written(changed):
        path.write_bytes(struct.pack(f"{order}{form}", *changed) + body)
        return path

    return fields, range(first, end), written


def test_sizes_that_add_up_are_taken(wave):
    fields, _, written = wave
    check_sizes(written(fields))


@pytest.mark.parametrize("wrong", [-1, 2_000_000_000, -2_000_000_000, 20_000])
def test_each_wrong_size_is_refused(wave, wrong):
    fields, sizes, written = wave
    for i in sizes:
        path = written([wrong if j == i else field for j, field in enumerate(fields)])
        with pytest.raises(fp.CurveError, match=r"wave\.ibw: its header announces more than the \d+ bytes"):
            check_sizes(path)


@pytest.mark.parametrize("start", [b"", b"\5", b"\5\0\0", b"\4\0" + bytes(80), b"\0\7" + bytes(80)])
def test_other_files_are_refused(tmp_path, start):
    (tmp_path / "other.ibw").write_bytes(start)
    with pytest.raises(fp.CurveError, match="no Igor binary wave, or cut off"):
        check_sizes(tmp_path / "other.ibw")


def test_reading_a_curve_checks_the_header_first(tmp_path):
    pytest.importorskip("afmformats")
    (tmp_path / "long.ibw").write_bytes(struct.pack("<hh15i", 5, 0, *(2_000_000_000,) * 15))
    with pytest.raises(fp.CurveError, match="announces more than the 64 bytes"):
        fp.read_curve(tmp_path / "long.ibw")
