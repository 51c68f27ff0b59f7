"""Real files, where they are at hand: they load, they fit, and the control gives its known modulus."""

import pytest

from flatpunch.fits import CurveError, fit, fit_film, read_curve, read_nanoindentation, tip_in_workbook
from flatpunch.indenters import Paraboloid, Sphere
from flatpunch.media import HalfSpace, Layer, Medium, RigidBase

BULK = HalfSpace(1e3, 0.5)


@pytest.fixture
def curves(measured):
    return measured / "afmformats"


@pytest.fixture
def workbook(measured):
    return measured / "micromechanics" / "Example.xls"


def test_chiaro_ball_on_soft_sample(curves):
    """The instrument's own Hertz fit says 117 Pa (header of the file); the whole approach with its contact point gives 123 Pa."""
    curve = read_curve(next(curves.glob("*.zip")))
    assert curve.spring_constant == 0.019
    whole = float(curve.depth.max())
    result = fit(curve, BULK, Sphere(27.5e-6), ["base.young"], baseline="constant", depth_to=whole)
    assert result["base.young"] == pytest.approx(117, rel=0.07)
    # its force drops in the middle: a slip
    assert any("Within the fitted range the force jumps" in note for note in result.notes)
    # a soft biological sample: the model is not the whole truth, and that is said
    assert any("Neighbouring residuals" in note for note in result.notes)


def test_another_file_of_the_same_name_is_read_anew(curves, tmp_path):
    """afmformats keeps archives open by their names."""
    path = tmp_path / "curve.jpk-force"
    lengths = []
    for name in ("*spot3*.jpk-force", "*flipsign*.jpk-force"):
        new = tmp_path / "new"
        new.write_bytes(next(curves.glob(name)).read_bytes())
        # as programs do that write whole files
        new.replace(path)
        lengths.append(read_curve(path).depth.size)
    assert lengths == [4000, 14000]


@pytest.mark.long
@pytest.mark.parametrize("pattern", ["*.jpk-force", "*.tab"])
def test_jpk_and_tab(pattern, curves):
    curve = read_curve(next(curves.glob(pattern.replace("*.", "*spot3*.") if "jpk" in pattern else pattern)))
    assert curve.depth.size > 3000
    for medium, name in ((BULK, "base.young"), (Medium([Layer(1e3, 0.5, 5e-6)], RigidBase()), "layers[0].young")):
        result = fit(curve, medium, Sphere(10e-6), [name])
        estimate = result.estimates[name]
        assert 0 < estimate.low < estimate.value < estimate.high
    # a base below makes the same curve the work of a softer layer
    assert result["layers[0].young"] < fit(curve, BULK, Sphere(10e-6), ["base.young"])["base.young"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("pattern", "moduli"),
    [
        ("*flipsign_2015*", [7000]),
        ("*2020.02.07*", [1403, 3512, 1712, 1183]),
        ("*pr14-brain*", [54]),
    ],
    ids=["approach", "map", "creep"],
)
def test_independent_answers(pattern, moduli, curves):
    """A scan of contact points over the tip's positions, and nanite 4.2.3, paraboloid of 5 um: within 5 %."""
    path = next(curves.glob(pattern))
    for index, modulus in enumerate(moduli):
        result = fit(
            read_curve(path, index=index),
            BULK,
            Paraboloid(5e-6),
            ["base.young"],
            quick=True,
            baseline="constant",
        )
        assert result["base.young"] == pytest.approx(modulus, rel=0.05)


def test_ntmdt_with_decimal_commas(curves):
    """No header: spring constant and sensitivity come from the user."""
    path = next(curves.glob("*ntmdt*"))
    assert read_curve(path, spring_constant=0.05, sensitivity=70.0).depth.size > 100
    with pytest.raises(CurveError, match=r"Pass spring_constant=... \[N/m\] and sensitivity"):
        read_curve(path, height="height (measured)")


def test_the_tip_is_pulled_in(curves):
    """Which is refused unless asked for."""
    curve = read_curve(next(curves.glob("*ntmdt*")), spring_constant=0.05, sensitivity=70.0)
    with pytest.raises(CurveError, match="the tip is pulled in"):
        fit(curve, BULK, Sphere(10e-6), ["base.young"])


@pytest.mark.parametrize("test", ["Test 001", "Test 002"])
def test_fused_silica_control(test, workbook):
    """72 to 75 GPa for fused silica, from 100 nm to 2 um with the frame's compliance fitted, which the file has set to zero."""
    curve, tip = read_nanoindentation(workbook, test), tip_in_workbook(workbook)
    result = fit_film(curve, HalfSpace(60e9, 0.18), tip, ["base.young", "frame"], depths=(100e-9, 2e-6))
    assert 72e9 < result["base.young"] < 75e9
    # a few hundred nm/N is what nanoindenters have if nobody takes it out
    assert 1e-7 < result["frame"] < 3e-7


def test_the_files_own_modulus(workbook):
    """With the file's settings (beta = 1, no frame, 100 to 200 nm) its own averages come out: 76.318 and 77.749 GPa, to 0.5 %."""
    tip = tip_in_workbook(workbook, beta=1.0)
    for test, modulus in (("Test 001", 76.318e9), ("Test 002", 77.749e9)):
        result = fit_film(read_nanoindentation(workbook, test), HalfSpace(60e9, 0.18), tip, depths=(100e-9, 200e-9))
        assert result["base.young"] == pytest.approx(modulus, rel=0.005)
