"""Height maps: interpolation, apex, orientation, checks, files."""

import sys
import warnings
import zipfile

import numpy as np
import pytest

import flatpunch as fp

X, Y = np.linspace(-1e-6, 1e-6, 61), np.linspace(-0.8e-6, 0.9e-6, 52)
RADII, ANGLES = np.linspace(1e-9, 6e-7, 23)[:, None], np.linspace(0, 6, 17)


def paraboloid(x, y, radius=2e-6):
    return ((x[None, :] - 1.234e-7) ** 2 + (y[:, None] + 0.567e-7) ** 2) / (2 * radius)


@pytest.mark.long
def test_a_paraboloid_is_met_exactly_between_the_points():
    tip = fp.HeightMap(X, Y, 3e-7 + paraboloid(X, Y))
    assert tip.centre == pytest.approx((1.234e-7, -0.567e-7), rel=1e-11)
    assert tip.reach == pytest.approx(0.8e-6 - 0.567e-7, rel=1e-9)
    ball = fp.Paraboloid(2e-6)
    # cubics contain parabolas; heights over 1e-6 m differ from zero at the apex by rounding
    np.testing.assert_allclose(tip.height(RADII, ANGLES), ball.height(RADII, ANGLES), rtol=1e-10)
    np.testing.assert_allclose(tip.slope(RADII, ANGLES), ball.slope(RADII, ANGLES), rtol=1e-10)
    # also where heights would be differences of rounding
    np.testing.assert_allclose(tip.height(1e-15, ANGLES), ball.height(1e-15, ANGLES), rtol=1e-9)
    force = [
        float(fp.indent(fp.HalfSpace(1e9, 0.3), t, depth=2e-8, method="first-order")["force"][0]) for t in (tip, ball)
    ]
    assert force[0] == pytest.approx(force[1], rel=1e-8)  # tables of the method


def test_interpolation_converges_with_the_third_power_of_the_spacing():
    exact, errors = fp.Ellipsoid(1.4e-6, 1.1e-6, 1e-6), []
    for points in (32, 64, 128):
        x = 1.44e-6 / points * (np.arange(points) - points / 2 + 0.3)  # the apex lies at the same place between points
        r, phi = np.hypot(x, x[:, None]), np.arctan2(x[:, None], x)
        tip = fp.HeightMap(x, x, exact.height(r, phi))
        inner = RADII * 0.6
        errors.append(np.abs(tip.height(inner, ANGLES) - exact.height(inner, ANGLES)).max())
    # the heights of cubic splines are of fourth order, but their slopes of third, and so is the place of the apex
    assert errors[0] / errors[1] == pytest.approx(8, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(8, rel=0.05)


@pytest.mark.long
def test_orientation_and_order_of_axes_do_not_matter():
    z = paraboloid(X, Y)
    tip = fp.HeightMap(X, Y, z)
    for other in (
        fp.HeightMap(X, Y, 5e-7 - z, apex="highest"),
        fp.HeightMap(X[::-1], Y, z[:, ::-1]),
        fp.HeightMap(X, Y[::-1], z[::-1]),
    ):
        np.testing.assert_allclose(other.height(RADII, ANGLES), tip.height(RADII, ANGLES), rtol=1e-8)
    assert fp.HeightMap(X, Y, z) == tip
    assert hash(fp.HeightMap(X, Y, z)) == hash(tip)
    assert fp.HeightMap(X, Y, 2 * z) != tip
    assert fp.HeightMap(X, Y, z, reach=3e-7) != tip


def test_a_plane_is_taken_out_on_request():
    x = np.linspace(-1e-6, 1e-6, 61)
    z = (x[None, :] ** 2 + x[:, None] ** 2) / 4e-6
    tilt = 0.05 * x[None, :] - 0.03 * x[:, None] + 1e-7
    level = fp.HeightMap(x, x, z + tilt, level=True)
    # in the middle of a symmetric map the best plane is the tilt itself
    assert level.centre == pytest.approx((0, 0), abs=1e-16)
    leaning = fp.HeightMap(x, x, z + tilt)
    assert leaning.centre == pytest.approx((-2e-6 * 0.05, 2e-6 * 0.03), rel=1e-9)


def test_one_of_several_asperities():
    x = np.linspace(0, 6, 121)
    z = np.cos(np.pi * x[None, :]) + np.cos(np.pi * x[:, None])
    tip = fp.HeightMap(x, x, z, near=(3.3, 0.8), reach=0.9)
    assert tip.centre == pytest.approx((3, 1), abs=1e-9)
    # between the asperities the surface falls again: along the axes at a distance of 1, first of all directions
    with pytest.raises(ValueError, match=r"does not rise .* Set reach=0\.99"):
        fp.HeightMap(x, x, z, near=(2.9, 2.9), reach=1.05)
    usable = fp.HeightMap(x, x, z, near=(1.2, 0.9), reach="usable")
    assert usable.reach == pytest.approx(1.0, abs=0.01)


def test_noise_is_named_and_smoothed():
    rng = np.random.default_rng(7)
    z = paraboloid(X, Y) + 2e-9 * rng.standard_normal((Y.size, X.size))
    with pytest.raises(ValueError, match="smooth the map by `smoothing`"):
        fp.HeightMap(X, Y, z, reach=6e-7)
    tip = fp.HeightMap(X, Y, z, smoothing=8e-8, reach=6e-7)
    assert tip.height(5e-7, ANGLES) == pytest.approx(
        (5e-7) ** 2 / 4e-6, rel=0.1
    )  # noise over what a spot of 80 nm averages


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda z: fp.HeightMap(X, Y, z[:-1]), r"has shape \(51, 61\)"),
        (lambda z: fp.HeightMap(X, Y, np.where((z > 2e-8) & (z < 3e-8), np.nan, z)), "gaps .* inside"),
        (lambda z: fp.HeightMap(X, Y, np.full_like(z, np.nan)), "gaps"),
        (lambda z: fp.HeightMap(np.abs(X), Y, z), "increase or decrease strictly"),
        (lambda z: fp.HeightMap(X, Y, z, apex="up"), "'lowest'"),
        (lambda z: fp.HeightMap(X, Y, z, apex="highest"), "at the border"),
        (lambda z: fp.HeightMap(X, Y, z, reach=2e-6), "more than the map holds"),
        (lambda z: fp.HeightMap(X, Y, z, smoothing=-1), "HeightMap.smoothing"),
        (lambda z: fp.HeightMap(np.sinh(3e6 * X), Y, z, smoothing=1e-8), "evenly spaced"),
    ],
)
def test_bad_maps_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make(paraboloid(X, Y))


def test_archives_are_read(tmp_path):
    np.savez(tmp_path / "tip.npz", x=X, y=Y, z=paraboloid(X, Y))
    tip = fp.read_height_map(tmp_path / "tip.npz")
    assert tip == fp.HeightMap(X, Y, paraboloid(X, Y))
    twice = fp.read_height_map(tmp_path / "tip.npz", height_scale=2)
    np.testing.assert_allclose(twice.height(RADII, ANGLES), 2 * tip.height(RADII, ANGLES), rtol=1e-9)
    np.savez(tmp_path / "less.npz", x=X, y=Y)
    with pytest.raises(ValueError, match="no array z"):
        fp.read_height_map(tmp_path / "less.npz")
    (tmp_path / "bad.npz").write_text("nothing")
    with pytest.raises(ValueError, match="is damaged, or no NumPy archive"):
        fp.read_height_map(tmp_path / "bad.npz")
    with pytest.raises(ValueError, match="is no file"):
        fp.read_height_map(tmp_path / "none.npz")


def test_the_missing_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "SurfaceTopography", None)
    (tmp_path / "tip.gwy").write_bytes(b"")
    with pytest.raises(ImportError, match=r"flatpunch\[topography\]"):
        fp.read_height_map(tmp_path / "tip.gwy")


@pytest.fixture
def scans(measured):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its optional dependencies
        pytest.importorskip("SurfaceTopography", reason="the extra flatpunch[topography] is not installed")
    return measured / "surfacetopography"


def test_a_measured_map_with_a_unit(scans):
    tip = fp.read_height_map(scans / "top-1.top", apex="highest", level=True, smoothing=4e-9, reach="usable")
    assert tip.shape == (256, 256)
    assert tip.spacing == pytest.approx((600e-9 / 256, 600e-9 / 256), rel=1e-9)
    result = fp.indent(fp.HalfSpace(1e9, 0.3), tip, depth=[1e-10, 4e-10])
    assert result["valid"].all()
    assert (result["force"] > 0).all()


def test_a_measured_asperity_of_a_scan(scans, tmp_path):
    with zipfile.ZipFile(scans / "container-2.zip") as archive:
        name = next(n for n in archive.namelist() if n.endswith(".001"))
        archive.extract(name, tmp_path)
    settings = {"apex": "highest", "level": True, "height_scale": 0.112, "near": (5e-8, 5e-8)}
    rough = fp.read_height_map(tmp_path / name, **settings)
    assert not rough.rising
    with pytest.raises(ValueError, match="within two points of the apex"):
        fp.indent(fp.HalfSpace(1e9, 0.3), rough, depth=1e-9, method="first-order")
    tip = fp.read_height_map(tmp_path / name, smoothing=4e-9, reach="usable", **settings)
    assert tip.shape == (512, 512)
    assert 1e-8 < tip.reach < 5e-8
