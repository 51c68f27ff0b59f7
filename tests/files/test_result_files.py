"""Result files are read back to the identical dataset, appear whole or not at all, and say why they cannot be read."""

import numpy as np
import pytest
import xarray as xr

import flatpunch as fp
from flatpunch.files import ResultError, load, save
from flatpunch.files.results import from_csv, to_csv

GEL = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1.2e-6)], base=fp.RigidBase())
KINDS = pytest.mark.parametrize("ending", [".nc", ".csv"])


@pytest.fixture(scope="module")
def result():
    return fp.indent(GEL, fp.Pyramid(sides=4, inclination=0.9), depth=np.linspace(0, 4e-7, 7), angles=24)


@KINDS
def test_round_trip_is_identical(result, tmp_path, ending):
    path = save(result, tmp_path / f"gel{ending}", outlines=True)
    back = load(path)
    xr.testing.assert_identical(back, result)
    assert {name: back[name].dtype for name in back.variables} == {
        name: result[name].dtype for name in result.variables
    }
    assert back.attrs == result.attrs


@KINDS
def test_round_trip_of_awkward_content(tmp_path, ending):
    """Not-a-number, infinity, signed zero, the smallest and largest floats, other alphabets, line breaks, one step only."""
    values = np.array([[np.nan, np.inf, -0.0, 5e-324, 1.7976931348623157e308, 1 / 3]])
    awkward = xr.Dataset(
        {
            "contour": (("step", "phi"), values, {"units": "m", "note": 'a, "quoted"\nline µ'}),
            "valid": ("step", [False]),
        },
        {"step": ("step", [0]), "phi": ("phi", np.linspace(0, 1, 6))},
        {"flatpunch_version": "0", "notes": "first\nsecond, with a comma # and a hash", "title": "Ünïcode"},
    )
    back = load(save(awkward, tmp_path / f"awkward{ending}", outlines=True))
    xr.testing.assert_identical(back, awkward)
    assert np.signbit(back["contour"].values[0, 2])


def test_csv_holds_the_curve_and_outlines_on_request(result, tmp_path):
    path = save(result, tmp_path / "gel.csv")
    back = load(path)
    xr.testing.assert_identical(back, result.drop_dims("phi"))
    assert back.attrs == result.attrs
    rows = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert max(len(row.split(",")) for row in rows) == len(back.data_vars) + 1 < 12
    assert load(save(result, path, outlines=True)).sizes["phi"] == 24


def test_csv_is_for_people_too(result, tmp_path):
    lines = save(result, tmp_path / "gel.csv").read_text(encoding="utf-8").splitlines()
    comments = [line for line in lines if line.startswith("#")]
    assert any(line.startswith("# medium: ") and "5000" in line for line in comments)
    assert "# depth [m]: indentation depth" in comments
    header = lines[len(comments)].split(",")
    assert header[:3] == ["step", "depth [m]", "force [N]"]
    table = np.loadtxt(lines[len(comments) + 1 :], delimiter=",", usecols=(0, 1, 2))
    np.testing.assert_array_equal(table[:, 1], result["depth"].values)


@KINDS
def test_older_file_survives_a_failed_write(result, tmp_path, ending, monkeypatch):
    path = save(result, tmp_path / f"gel{ending}")
    before = path.read_bytes()

    def half(target, content):
        with target.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise KeyboardInterrupt

    monkeypatch.setattr("pathlib.Path.write_bytes", half)
    with pytest.raises(KeyboardInterrupt):
        save(result, path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_new_files_get_the_usual_rights(result, tmp_path):
    ordinary = tmp_path / "ordinary"
    ordinary.touch()
    assert save(result, tmp_path / "gel.nc").stat().st_mode == ordinary.stat().st_mode


def test_refusals_when_writing(result, tmp_path):
    for name, message in (
        ("gel.xyz", "the ending '.xyz' is neither"),
        ("gel.txt", r"has no maps.*Write it as .nc \(NetCDF\) or .csv"),
        ("gel", "neither"),
        ("no/gel.nc", "cannot be written"),
    ):
        with pytest.raises(ResultError, match=message):
            save(result, tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.long
@pytest.mark.parametrize("ending", [".csv", ".nc"])
def test_every_dataset_is_read_back(tmp_path, ending):
    film = fp.Medium([fp.Layer(300e9, 0.25, 2e-6)], base=fp.HalfSpace(210e9, 0.3))
    tip, strengths = fp.Sphere(50e-6), [fp.Strength(tensile=2e9), fp.Strength(yield_stress=1e9)]
    line = np.linspace(0, 1e-6, 3)
    for found in (
        fp.fields(film, tip, line, 0.0, 1e-7, force=0.02),
        fp.fields(film, tip, line[:, None], 0.0, line, force=0.02),
        fp.sensitivity(film, tip, force=0.02),
        fp.energy_by_depth(film, tip, force=0.02),
        fp.peak_stresses(film, tip, force=0.02),
        fp.critical_loads(film, tip, strengths),
        xr.Dataset({"p": (("x", "step", "y"), np.zeros((2, 1, 2)))}, attrs={"flatpunch_version": "0"}),
    ):
        path = tmp_path / f"result{ending}"
        save(found, path, outlines=True)
        assert load(path).identical(found)


def test_refusals_when_reading(result, tmp_path):
    whole = save(result, tmp_path / "whole.nc").read_bytes()
    (tmp_path / "cut.nc").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.nc").write_text("no NetCDF")
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    text = to_csv(result)
    (tmp_path / "cut.csv").write_text(text[: text.rindex(",")])
    (tmp_path / "short.csv").write_text("\n".join(text.splitlines()[:-1]))
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe")
    xr.Dataset({"a": 1}).to_netcdf(tmp_path / "foreign.nc", engine="h5netcdf")
    cases = {
        "none.nc": "No such file",
        "whole.hdf": "neither",
        "cut.nc": "damaged",
        "text.nc": "damaged, or no NetCDF",
        "empty.csv": "no flatpunch result",
        "other.csv": "no flatpunch result",
        "cut.csv": "its text is not what was written",
        "short.csv": "its text is not what was written",
        "binary.csv": "damaged, or no CSV",
        "foreign.nc": "no flatpunch result",
    }
    for name, message in cases.items():
        with pytest.raises(ResultError, match=message) as caught:
            load(tmp_path / name)
        assert name in str(caught.value)


def test_csv_text_round_trip(result):
    xr.testing.assert_identical(from_csv(to_csv(result)), result)
