"""Constants given in the place of a file's, and text exports of instruments: every layout gives the modulus that was put in."""

import zipfile

import numpy as np
import pytest

from flatpunch.contact import indent
from flatpunch.fits import Curve, CurveError, fit, read_curve
from flatpunch.fits.measured.calibration import constants_in
from flatpunch.fits.measured.files.readers import curves_in
from flatpunch.indenters import Paraboloid
from flatpunch.media import HalfSpace

K, SENSITIVITY, YOUNG = 0.06, 42e-9, 3e3
TIP = Paraboloid(4e-6)
BULK = HalfSpace(1e3, 0.5)
# piezo, force and depth of an approach, without noise
_DEPTH = np.linspace(-6e-7, 7e-7, 300)
FORCE = indent(HalfSpace(YOUNG, 0.5), TIP, depth=np.maximum(_DEPTH, 0), angles=8)["force"].values
DEPTH, PIEZO = _DEPTH, _DEPTH + FORCE / K


def _modulus(curve: Curve) -> float:
    return fit(curve, BULK, TIP, ["base.young"])["base.young"]


def _write(path, header, *blocks, sep="\t"):
    rows = ["\n".join(sep.join(f"{v:.7g}" for v in row) for row in np.transpose(block)) for block in blocks]
    path.write_text("\n".join(f"{h}\n{r}" for h, r in zip(header, rows, strict=True)) + "\n", encoding="utf-8")
    return path


def _jpk(name, columns="verticalTipPosition vDeflection strainGaugeHeight time", extra=""):
    return (
        f"# segmentIndex: {name}\n# segment: {name}\n# columns: {columns}\n# sensitivity: {SENSITIVITY}\n"
        f"# springConstant: {K}\n# units: m N m s\n{extra}#"
    )


def _chiaro(folder):
    return _write(
        folder / "c.txt",
        [
            f"sample\nk (N/m)\t{K}\nTip radius (um)\t4.000\n\nTime (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)"
        ],
        [np.arange(DEPTH.size), FORCE * 1e6, DEPTH * 1e9, FORCE / K * 1e9, PIEZO * 1e9],
    )


def _zipped(folder):
    with zipfile.ZipFile(folder / "c.zip", "w") as archive:
        archive.write(_chiaro(folder), "c.txt")
    return folder / "c.zip"


def _jpk_file(folder):
    time = np.arange(DEPTH.size) * 1e-3
    forth = [-DEPTH, FORCE, -PIEZO, time]
    return _write(
        folder / "c.txt", [_jpk("extend"), _jpk("retract")], forth, [c[::-1] for c in forth[:3]] + [time], sep=" "
    )


def _tab(folder):
    # the layout of afmformats
    return _write(
        folder / "c.tab",
        [
            "# BEGIN METADATA\n# {\n"
            f'#   "imaging mode": "force-distance",\n#   "sensitivity": {SENSITIVITY},\n#   "spring constant": {K}\n'
            "# }\n# END METADATA\n#\n# force\theight (measured)"
        ],
        [FORCE, -PIEZO],
    )


@pytest.mark.parametrize("make", [_chiaro, _zipped, _jpk_file, _tab])
def test_a_given_spring_constant_multiplies_forces_and_leaves_deflections(make, tmp_path):
    """F = k d: at the same depth three times the force, so three times the modulus."""
    path = make(tmp_path)
    if make in (_tab, _zipped):
        pytest.importorskip("afmformats")
    own, other = read_curve(path), read_curve(path, spring_constant=3 * K)
    # seven digits are printed
    np.testing.assert_allclose(other.force, 3 * own.force, rtol=1e-5, atol=1e-17)
    np.testing.assert_allclose(other.depth, own.depth, rtol=1e-12)
    assert own.spring_constant == K
    # a least-squares fit of a curve without noise
    assert _modulus(own) == pytest.approx(YOUNG, rel=1e-3)
    assert _modulus(other) == pytest.approx(3 * YOUNG, rel=1e-3)
    assert any(f"given; {K:g} from the file: its forces times 3" in line for line in other.meta["read"])


def test_a_given_sensitivity_leaves_the_position_of_the_piezo(tmp_path):
    pytest.importorskip("afmformats")
    own, other = (read_curve(_tab(tmp_path), **more) for more in ({}, {"sensitivity": 2 * SENSITIVITY}))
    np.testing.assert_allclose(other.force, 2 * own.force, rtol=1e-12)
    # sums of micrometres
    np.testing.assert_allclose(other.position, own.position, rtol=0, atol=1e-20)


def test_constants_that_cannot_act_are_refused(tmp_path):
    with pytest.raises(CurveError, match="the sensitivity cannot act"):
        read_curve(_chiaro(tmp_path), sensitivity=50e-9)


def test_the_ratio_of_force_and_deflection_is_the_constant_of_a_file(tmp_path):
    rows = [PIEZO * 1e9, FORCE / K * 1e9, FORCE * 1e9]
    path = _write(tmp_path / "c.csv", ["piezo (nm),deflection (nm),force (nN)"], rows, sep=",")
    assert read_curve(path).spring_constant == pytest.approx(K, rel=1e-5)
    assert _modulus(read_curve(path, spring_constant=2 * K)) == pytest.approx(2 * YOUNG, rel=1e-3)
    # forces that were made from something else: the deflections are what was measured
    rows[2] = rows[2] + np.linspace(0, 0.3 * rows[2].max(), DEPTH.size)
    path = _write(tmp_path / "d.csv", ["piezo (nm),deflection (nm),force (nN)"], rows, sep=",")
    assert _modulus(read_curve(path, spring_constant=K)) == pytest.approx(YOUNG, rel=1e-3)


@pytest.mark.parametrize(
    ("line", "spring", "sensitivity"),
    [
        ("# springConstant: 0.02", 0.02, None),
        ("k (N/m)\t0.019", 0.019, None),
        ("Cantilever spring constant (pN/nm): 30", 0.03, None),
        ("\\Spring Constant: 0.35", 0.35, None),
        ("# sensitivity: 5.0E-8", None, 5e-8),
        ("Deflection sensitivity = 61 nm/V", None, 61e-9),
        ("InvOLS (nm/V);48,5", None, 48.5e-9),
        # other constants, of other things
        ("k 0.02", None, None),
        ("Z sensitivity: 5 nm/V", None, None),
        ("Spring constant (kPa): 3", None, None),
    ],
)
def test_constants_above_the_numbers(line, spring, sensitivity):
    found = constants_in(["words", line])
    assert (found.spring_constant, found.sensitivity) == (pytest.approx(spring), pytest.approx(sensitivity))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("titles", ["Defl_{u}_Ex\tDefl_{u}_Rt", "Deflection Approach ({u})\tDeflection Retract ({u})"])
@pytest.mark.parametrize("unit", ["nm", "V", "pN"])
def test_approach_and_retract_side_by_side(tmp_path, titles, unit, turned):
    """Units inside the titles; the retract from its deep end or from its far one; the approach is fitted."""
    ramp = "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm" if "_Ex" in titles else "Ramp Approach (nm)\tRamp Retract (nm)"
    signal = {"nm": FORCE / K * 1e9, "V": FORCE / K / SENSITIVITY, "pN": FORCE * 1e12}[unit]
    # the retract of a sample that has not come back
    back = [np.sort(PIEZO)[:: -1 if turned else 1], (0.7 * signal)[:: -1 if turned else 1]]
    path = _write(
        tmp_path / "c.txt",
        [f"{ramp}\t{titles.format(u=unit)}"],
        [PIEZO * 1e9, back[0] * 1e9, signal, back[1]],
    )
    curve = read_curve(path, spring_constant=K, **({"sensitivity": SENSITIVITY} if unit == "V" else {}))
    assert curve.depth.size == 2 * DEPTH.size
    # one way after the other: no jump between them
    assert np.abs(np.diff(curve.position)).max() < 2 * np.abs(np.diff(PIEZO)).max()
    assert _modulus(curve) == pytest.approx(YOUNG, rel=1e-3)


def test_segments_of_a_text_export_may_have_their_columns_in_another_order(tmp_path):
    """Extend, pause, retract, each below its own header; the time of each begins at zero."""
    time = np.arange(DEPTH.size) * 1e-3
    forth = [-DEPTH, FORCE, -PIEZO, time]
    rest = [np.full(50, column[-1]) for column in forth[:3]] + [time[:50]]
    back = [column[::-1] for column in (FORCE, -PIEZO, -DEPTH)]
    other = "vDeflection strainGaugeHeight verticalTipPosition time"
    header = [_jpk("0"), _jpk("1"), _jpk("2", other).replace("m N m s", "N m m s")]
    path = _write(tmp_path / "c.txt", header, forth, rest, [*back, time], sep=" ")
    assert curves_in(path) == 1
    curve = read_curve(path)
    assert np.unique(curve.segment).tolist() == [0, 1, 2]
    np.testing.assert_allclose(curve.depth[-1], -DEPTH[0], rtol=1e-6)
    assert _modulus(curve) == pytest.approx(YOUNG, rel=1e-3)
    # without the position of the tip, and with that of the piezo: k of the header
    height = [*header][:1]
    height[0] = height[0].replace("verticalTipPosition", "smoothedStrainGaugeHeight")
    curve = read_curve(_write(tmp_path / "d.txt", height, forth, sep=" "))
    assert curve.meta["piezo"]
    assert _modulus(curve) == pytest.approx(YOUNG, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "header"),
    [
        ("c.asc", "Depth (nm)\tLoad (nN)\tTime (s)"),
        ("c", "Depth (nm)\tLoad (nN)\tTime (s)"),
        ("c.txt", "Depth (nm)\tLoad (nN)\tTime (s)\nthese are\tall\tmeasured"),
        ("c.txt", "Depth (nm)\tLoad (nN)\tTime (s)\nwords of the operator"),
        ("c.txt", "test 3\nPd\tFn\tTime\n[nm]\t[nN]\t[s]"),
        ("c.txt", "Displacement [nm]\tForce A [nN]\tTime [s]\nPhase\tApproach\tnone"),
        ("c.003", "Depth (nm)\tLoad (nN)\tTime (s)"),
    ],
)
def test_words_below_the_titles_and_other_endings(tmp_path, name, header):
    path = _write(tmp_path / name, [header], [DEPTH * 1e9, FORCE * 1e9, np.arange(DEPTH.size)])
    assert _modulus(read_curve(path)) == pytest.approx(YOUNG, rel=1e-3)


def test_words_between_the_parts_of_a_cycle_divide_nothing(tmp_path):
    parts = [[DEPTH * 1e9, FORCE * 1e9], [DEPTH[::-1] * 1e9, FORCE[::-1] * 1e9]]
    path = _write(tmp_path / "c.txt", ["Depth (nm)\tLoad (nN)", "Unloading"], *parts)
    assert curves_in(path) == 1
    path = _write(tmp_path / "d.txt", ["Depth (nm)\tLoad (nN)", "Next test"], parts[0], parts[0])
    assert curves_in(path) == 2


def test_binary_files_of_nanoscope_are_named(tmp_path):
    (tmp_path / "c.000").write_bytes(b"\\*Force file list\r\n\\Version: 1\r\n\x1a" + bytes(100))
    with pytest.raises(CurveError, match=r"binary file of Bruker's NanoScope.* Export"):
        read_curve(tmp_path / "c.000")


def _nid(path, unit, scale, order=-1):
    """Two curves in the layout of Nanosurf, integers of 32 bits below a header; order 1: the retract by position, not time."""
    channels = [("Z-Axis Sensor", "m", PIEZO), ("Deflection", unit, FORCE * scale)]
    sets, raw = [], b""
    lines = ["[DataSet]", "GroupCount=1", "Gr0-Name=Spec", "Gr0-Count=4"]
    for at, (frame, way) in enumerate((("Spec forward", 1), ("Spec backward", order))):
        for i, (name, own, values) in enumerate(channels):
            lines.append(f"Gr0-Ch{2 * at + i}=DataSet-{at}:{i}")
            low, span = values.min(), np.ptp(values)
            sets += [
                "",
                f"[DataSet-{at}:{i}]",
                *(
                    f"Frame={frame}",
                    f"Points={DEPTH.size}",
                    "Lines=2",
                    "SaveBits=32",
                    "Dim0Min=0",
                    "Dim0Range=1",
                    "Dim0Unit=m",
                ),
                *("Dim1Min=0", "Dim1Range=1", "Dim1Unit=m"),
                *(f"Dim2Min={low:.17g}", f"Dim2Range={span:.17g}", f"Dim2Unit={own}", f"Dim2Name={name}"),
            ]
            counts = np.round((values[::way] - low) / span * (2.0**32 - 1) - 2.0**31).astype("<i4").tobytes()
            raw += 2 * counts
    tip = ["", r"[DataSet\Calibration\Cantilever]", "Manufacturer=x", "Name=y", "PropCount=1", f"Prop0=D[{K}]*[N/m]"]
    text = "\r\n".join([*lines, *sets, *tip, "", "[DataSet-Info]", "Date=x", ""])
    path.write_bytes(text.encode("latin-1") + b"\n\r\n\r" + b"#!" + raw)
    return path


@pytest.mark.parametrize("order", [-1, 1])
@pytest.mark.parametrize(("unit", "scale"), [("N", 1.0), ("m", 1 / K), ("V", 1 / K / SENSITIVITY)])
def test_nanosurf_files_through_their_makers_reader(tmp_path, unit, scale, order):
    pytest.importorskip("NSFopen")
    path = _nid(tmp_path / "c.nid", unit, scale, order)
    assert curves_in(path, sensitivity=SENSITIVITY) == 2
    more = {"sensitivity": SENSITIVITY} if unit == "V" else {}
    own, other = (read_curve(path, index=1, **more, **k) for k in ({}, {"spring_constant": 2 * K}))
    # the tip does not leap between approach and retract
    assert np.abs(np.diff(own.position)).max() < 2 * np.diff(PIEZO).max()
    assert _modulus(own) == pytest.approx(YOUNG, rel=1e-3)
    assert _modulus(other) == pytest.approx(2 * YOUNG, rel=1e-3)
    if unit == "V":
        with pytest.raises(
            CurveError, match=r"'Deflection' \(deflection\) is a signal \(V\).* sensitivity = \"70 nm/V\""
        ):
            read_curve(path, index=1)
