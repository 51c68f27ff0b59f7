"""Maps of heights from texts, matrices and channels of microscopes: what they mean, and what is no height."""

import sys
from contextlib import contextmanager
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.files import scans

RANDOM = np.random.default_rng(0)
Z = RANDOM.random((24, 20))
POINTS = np.column_stack([each.ravel() for each in (*np.meshgrid(0.1 * np.arange(20), 0.1 * np.arange(24)), Z)])
GIVEN = {"spacing": 1e-7, "unit": "nm"}
GWYDDION = "# Channel: {}\n# Width: 2.0 µm\n# Height: 2.4 µm\n# Value units: {}\n"


def rows(table, separator, mark="."):
    return "\n".join(separator.join(f"{value:.6g}".replace(".", mark) for value in row) for row in table)


@pytest.mark.parametrize(
    ("head", "table", "separator", "mark", "given"),
    [
        ("X [µm]\tY [µm]\tZ [nm]\n", POINTS, "\t", ".", {}),
        ("X(um),Y(um),Z(nm)\n", RANDOM.permutation(POINTS), ",", ".", {}),
        ("# a scan in mm\nx/um;y/um;z/nm\n", POINTS, ";", ",", {}),
        ("", POINTS * [1, 1, 1e-3], " ", ".", {"unit": "um"}),
        (GWYDDION.format("Height", "nm"), Z, "\t", ".", {}),
        ("", Z, "  ", ".", GIVEN),
        ("\ufeff", Z, ",", ".", GIVEN),
        ("", Z, "\t", ",", GIVEN),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_texts(tmp_path, head, table, separator, mark, given, encoding):
    path = tmp_path / "scan.txt"
    path.write_text(head + rows(table, separator, mark), encoding="utf-8" if "\ufeff" in head else encoding)
    found = fp.read_topography(path, **given)
    assert found.spacing == pytest.approx(1e-7)
    # six digits are written
    np.testing.assert_allclose(found.heights, 1e-9 * Z, atol=1e-14)


def test_matrices_of_numpy(tmp_path):
    np.save(tmp_path / "scan.npy", Z)
    np.testing.assert_allclose(fp.read_topography(tmp_path / "scan.npy", **GIVEN).heights, 1e-9 * Z)


@pytest.mark.parametrize(
    ("text", "given", "words"),
    [
        (rows(Z, " "), {"unit": "nm"}, "does not state the distance of its points"),
        (rows(Z, " "), {"spacing": 1e-7}, "does not state the unit"),
        ("X;Y;Phase [deg]\n" + rows(POINTS, ";"), {}, "names 'phase' above its numbers, and does not state the unit"),
        (rows(Z, " "), {"spacing": 1e-7, "unit": "s"}, "unit = '1 s' has the dimension of a time"),
        ("X [um] Y [um] Z [nm]\n" + rows(POINTS, " "), {"unit": "nm"}, "is not needed"),
        ("X [um] Y [um] Z [deg]\n" + rows(POINTS, " "), {}, "'deg', which has the dimension of an angle"),
        (GWYDDION.format("Phase", "deg") + rows(Z, " "), {}, "'deg', which has the dimension of an angle"),
        (rows(RANDOM.random((500, 3)), " "), {"unit": "nm"}, "no grid of columns and rows|no grid, or"),
        (rows(np.repeat(POINTS, 2, axis=0), " "), {"unit": "nm"}, "several heights at one point"),
    ],
)
def test_texts_that_lack_something_are_refused(tmp_path, text, given, words):
    (tmp_path / "scan.txt").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        fp.read_topography(tmp_path / "scan.txt", **given)


def test_holes_and_oblong_cells(tmp_path):
    """A paraboloid with holes of widths h: linear interpolation errs by h^2/8 R along each axis, splines by nothing."""
    x, y, radius = 1e-7 * np.arange(40), 1.25e-7 * np.arange(36), 1e-4
    z = ((x - 2e-6) ** 2 + (y[:, None] - 2e-6) ** 2) / (2 * radius)
    holes = z.copy()
    holes[tuple(RANDOM.integers(1, 35, (2, 30)))] = np.nan
    holes[10:13, 20:24] = np.nan
    np.savez(tmp_path / "scan.npz", x=x, y=y, z=holes)
    for given, words in (
        ({"resample": True}, r"missing heights of 1440.*fill=True"),
        ({"fill": True}, "resample=True"),
    ):
        with pytest.raises(ValueError, match=words):
            fp.read_topography(tmp_path / "scan.npz", **given)
    found = fp.read_topography(tmp_path / "scan.npz", fill=True, resample=True)
    assert found.spacing == pytest.approx(1e-7)
    assert found.shape == (44, 40)
    exact = ((x - 2e-6) ** 2 + (1e-7 * np.arange(44)[:, None] - 2e-6) ** 2) / (2 * radius)
    np.testing.assert_allclose(found.heights, exact, atol=2 * (5e-7) ** 2 / (8 * radius))
    np.savez(tmp_path / "scan.npz", x=x, y=y, z=z)
    np.testing.assert_allclose(fp.read_topography(tmp_path / "scan.npz", resample=True).heights, exact, atol=1e-16)


@pytest.fixture
def channels(monkeypatch):
    """SurfaceTopography with a file of these channels: name, kind, unit of the values."""
    kinds = [
        ("Phase", "phase", "deg"),
        ("Height", "height", "um"),
        ("Deflection", "height", "um"),
        ("Piezo", "voltage", "V"),
    ]

    def channel(index, name, kind, unit):
        found = SimpleNamespace(
            unit="um", physical_sizes=(2.0, 2.4), nb_grid_pts=(20, 24), heights=lambda: np.ma.masked_less(1e-3 * Z.T, 0)
        )
        return SimpleNamespace(
            **{
                **vars(found),
                "index": index,
                "name": name,
                "data_kind": SimpleNamespace(value=kind),
                "data_unit": unit,
            },
            dim=2,
            topography=lambda physical_sizes, unit: found,
        )

    @contextmanager
    def open_topography(path):
        yield SimpleNamespace(channels=[channel(i, *each) for i, each in enumerate(kinds)])

    package, errors = ModuleType("SurfaceTopography"), ModuleType("SurfaceTopography.Exceptions")
    package.open_topography = open_topography
    errors.CannotDetectFileFormat = errors.CorruptFile = KeyError
    monkeypatch.setitem(sys.modules, "SurfaceTopography", package)
    monkeypatch.setitem(sys.modules, "SurfaceTopography.Exceptions", errors)


def test_only_channels_of_heights_are_read(channels, tmp_path):
    (tmp_path / "scan.gwy").write_bytes(b"\0")
    np.testing.assert_allclose(fp.read_topography(tmp_path / "scan.gwy").heights, 1e-9 * Z)
    for index, words in (
        (0, "'Phase', holds no heights but the kind 'phase' in deg"),
        (2, "'deflection'"),
        (3, "'voltage' in V"),
        (4, "not in"),
    ):
        with pytest.raises(ValueError, match=f"{words}.*Channels of heights: 1 .Height."):
            fp.read_topography(tmp_path / "scan.gwy", channel=index)


def test_maps_that_unpack_to_too_much_are_refused_before_they_are_read(channels, tmp_path, monkeypatch):
    (tmp_path / "scan.h5").write_bytes(b"\0")
    monkeypatch.setattr(scans, "UNPACKED", 3000)
    with pytest.raises(ValueError, match=r"scan.h5: channel 1, 'Height', unpacks to 0.00384 MB; at most 0.003 MB"):
        fp.read_topography(tmp_path / "scan.h5")
