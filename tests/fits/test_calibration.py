"""Titles of columns, units behind them, and spring constants and sensitivities with their uncertainty."""

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.fits import Curve, CurveError, fit, read_curve
from flatpunch.fits.case import read_fit_case
from flatpunch.indenters import Paraboloid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase

TIP = Paraboloid(5e-6)
CASE = """
[base]
kind = "half-space"
young = {{ fit = "1 MPa" }}
poisson = 0.5
[indenter]
kind = "paraboloid"
radius = "5 um"
[curve]
spring_constant = {constant}
"""


@pytest.mark.parametrize(
    ("titles", "depth", "force"),
    [
        ("depth_nm,load_uN", 1e-9, 1e-6),
        ("Time_s,Depth_nm,Load_µN", 1e-9, 1e-6),
        ("Displacement (nm),Load (mN)", 1e-9, 1e-3),
        ("Depth nm,Load uN", 1e-9, 1e-6),
        ("Indent Disp.(nm),Indent Load (uN),Indent Act. Load (uN)", 1e-9, 1e-6),
        ("Displ. [um],F [nN]", 1e-6, 1e-9),
        ("H (GPa),h (nm),P (mN)", 1e-9, 1e-3),
        ("Depth (nm),Load (uN),H (GPa)", 1e-9, 1e-6),
        ("Pd (nm),Fn (mN)", 1e-9, 1e-3),
        ("Separation (nm),Force (nN)", 1e-9, 1e-9),
        ("Raw Displacement (nm),Displacement Into Surface (nm),Raw Load (mN),Load On Sample (mN)", 1e-9, 1e-3),
        ("hc (nm),depth / um,Contact Depth (nm),force / pN", 1e-6, 1e-12),
    ],
)
def test_titles(tmp_path, titles, depth, force):
    """The column of depths counts 0, 1, 2, ..., that of forces three times as much; all others are negative."""
    names = titles.split(",")
    chosen = [name.split()[0].lower().strip("[(") for name in names]
    is_depth = {"depth", "depth_nm", "displacement", "displ.", "h", "pd", "separation"}
    is_force = {"load", "load_un", "load_µn", "f", "p", "fn", "force"}
    rows = []
    for i in range(20):
        row = []
        for name, word in zip(names, chosen, strict=True):
            deep = (word in is_depth or name.startswith("Indent Disp")) and "GPa" not in name
            loaded = word in is_force or name.startswith("Indent Load")
            row.append(str(i if deep else 3 * i if loaded else -i - 1))
        rows.append(",".join(row))
    (tmp_path / "c.csv").write_text("\n".join([titles, *rows]), encoding="utf-8")
    curve = read_curve(tmp_path / "c.csv")
    np.testing.assert_allclose(curve.depth, depth * np.arange(20), rtol=1e-12)
    np.testing.assert_allclose(curve.force, 3 * force * np.arange(20), rtol=1e-12)


@pytest.mark.parametrize(
    ("titles", "message"),
    [
        ("H (nm),P (mN)", r"no column of depth recognised.*\[curve.columns\] depth = '...'"),
        ("z (nm),F (nN)", r"\[curve\] spring_constant = .* the tip already, \[curve.columns\] depth = \"z\""),
        ("Depth (nm),Force A (nN),Force B (nN)", r"\[curve.columns\] force = \"Force A\" or force = \"Force B\""),
        ("depth,force (nN)", r"has no unit.*\[curve.units\] depth = \"nm\""),
        ("Depth (GPa),Force (nN)", "has the dimension of a"),
    ],
)
def test_what_is_missing_is_asked_for_in_the_words_of_the_case_file(tmp_path, titles, message):
    rows = [",".join(str(i + 1) for _ in titles.split(",")) for i in range(20)]
    (tmp_path / "c.csv").write_text("\n".join([titles, *rows]), encoding="utf-8")
    with pytest.raises(CurveError, match=message):
        read_curve(tmp_path / "c.csv")


def _curve(folder, spring):
    """Piezo and deflection of a half-space of 2 MPa, 0.5 % noise."""
    depth = np.linspace(-2e-7, 3e-7, 600)
    force = indent(HalfSpace(2e6, 0.5), TIP, depth=np.maximum(depth, 0), angles=8)["force"].values
    force = force + 0.005 * force.max() * np.random.default_rng(1).normal(size=600)
    rows = "\n".join(
        f"{p * 1e9:.6f},{d * 1e9:.6f}" for p, d in zip(depth + force / spring, force / spring, strict=True)
    )
    path = folder / "curve.csv"
    path.write_text("piezo (nm),deflection (nm)\n" + rows, encoding="utf-8")
    return path


@pytest.mark.parametrize("std", ['"10 %"', '"5 N/m"'])
def test_uncertain_spring_constant(tmp_path, std):
    """A stiff cantilever: the force is proportional to k at known depth, and the modulus is as uncertain as k."""
    path = _curve(tmp_path, 50.0)
    found = []
    for constant in ('"50 N/m"', f'{{ value = "50 N/m", std = {std} }}'):
        (tmp_path / "case.toml").write_text(CASE.format(constant=constant), encoding="utf-8")
        case = read_fit_case(tmp_path / "case.toml")
        curve = read_curve(path, **case.reading)
        found.append(fit(curve, case.medium, case.indenter, case.free, **case.arguments).estimates["base.young"])
    sure, unsure = found
    assert unsure.value == pytest.approx(sure.value, rel=1e-6)
    assert sure.stderr < 0.01 * sure.value
    # the deflection is 5 % of the depth: beside the force the depth depends on k a little
    assert unsure.stderr / unsure.value == pytest.approx(0.1, rel=0.1)
    assert np.log(unsure.high / unsure.low) == pytest.approx(2 * 1.96 * 0.1, rel=0.1)


@pytest.mark.parametrize("std", ['"110 %"', '"10 um"', '"some"', '"60 N/m"'])
def test_bad_uncertainties(tmp_path, std):
    (tmp_path / "case.toml").write_text(CASE.format(constant=f'{{ value = "50 N/m", std = {std} }}'), encoding="utf-8")
    with pytest.raises(ValueError, match="must be a percentage such as '10 %', or have the unit of the value"):
        read_fit_case(tmp_path / "case.toml")


def test_calibration_widens_profiles_too():
    """Modulus and thickness along a valley: ends of the profile, and in quadrature what the calibration adds."""
    gel = Medium([Layer(5e3, 0.5, 1e-6)], RigidBase())
    depth = np.linspace(-3e-7, 5e-7, 600)
    force = indent(gel, Sphere(3e-6), depth=np.maximum(depth, 0), angles=8)["force"].values
    force = force + 0.01 * force.max() * np.random.default_rng(2).normal(size=600)
    free = ["layers[0].young", "layers[0].thickness"]
    plain, unsure = (
        fit(
            Curve.from_piezo(depth + force / 2.0, force, 2.0, meta={"calibration": calibration}),
            gel,
            Sphere(3e-6),
            free,
            quick=True,
        ).estimates["layers[0].young"]
        for calibration in ({}, {"spring_constant": 0.3})
    )
    assert plain.by == unsure.by == "profile"
    # the force is proportional to k: ln E is uncertain by 0.3 more, as far as the cantilever is stiff
    for end in ("low", "high"):
        own = np.log(getattr(plain, end) / plain.value)
        both = np.log(getattr(unsure, end) / unsure.value)
        assert abs(both) == pytest.approx(np.hypot(own, 1.96 * 0.3), rel=0.15)
