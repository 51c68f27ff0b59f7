"""Layouts of instruments, as they are exported: every one is read as what it holds, in the order of time."""

import zipfile

import numpy as np
import openpyxl
import pytest

from flatpunch.fits import CurveError, read_curve
from flatpunch.fits.measured.files.readers import curves_in

N, K, SENSITIVITY = 60, 0.05, 60e-9
DEPTH = np.linspace(-3e-7, 2e-7, N)
FORCE = 1e-9 * (np.maximum(DEPTH, 0) / 1e-7) ** 1.5
BACK = 0.7 * FORCE[::-1]
DEFLECTION = FORCE / K
PIEZO = DEPTH + DEFLECTION
TIME = 0.01 * np.arange(N)
COLUMNS = {
    "d": DEPTH * 1e9,
    "D": DEPTH[::-1] * 1e9,
    "f": FORCE * 1e9,
    "F": BACK * 1e9,
    "z": PIEZO * 1e9,
    "Z": (DEPTH[::-1] + BACK / K) * 1e9,
    "v": DEFLECTION / SENSITIVITY,
    "V": BACK / K / SENSITIVITY,
    "c": DEFLECTION * 1e9,
    "C": BACK / K * 1e9,
    "t": TIME,
    "T": TIME[-1] + 0.01 + TIME,
    "i": np.arange(N),
    "0": np.zeros(N),
    "1": np.ones(N),
}
"""Columns of approach (small letters) and retract in the order of time: nm, nN, V, s."""


def rows(columns, sep="\t", decimal=".", turned=False):
    """Lines of columns that are named by their letters; "*word*" is a word in each row."""
    cells = [COLUMNS.get(c, [c.strip("*")] * N) for c in columns]
    lines = [
        sep.join(v if isinstance(v, str) else f"{v:.8g}".replace(".", decimal) for v in row)
        for row in zip(*cells, strict=True)
    ]
    return "\n".join(lines[:: -1 if turned else 1]) + "\n"


def written(path, text, encoding="utf-8"):
    path.write_bytes(text.encode(encoding))
    return path


def holds(curve, depth, force, tolerance=1e-6):
    """The curve has these positions, by whatever sign and from whatever zero, and these forces."""
    assert curve.force.size == force.size
    np.testing.assert_allclose(curve.force, force, rtol=tolerance, atol=tolerance * force.max())
    own, wanted = curve.depth - curve.depth[0], depth - depth[0]
    sign = np.sign(own @ wanted) or 1.0
    np.testing.assert_allclose(sign * own, wanted, atol=10 * tolerance * np.ptp(depth))


APPROACH = (DEPTH, FORCE)
CYCLE = (np.append(DEPTH, DEPTH[::-1]), np.append(FORCE, BACK))

TITLES = {
    # German, French, Spanish, Italian, Chinese, Japanese
    "Eindringtiefe [nm];Kraft [nN];Zeit [s]": ";",
    "Zeit in s;Weg in nm;Kraft in nN": ";",
    "Prüfzeit\tStandardweg\tStandardkraft\ns\tnm\tnN": "\t",
    "Eindringweg / nm\tPrüfkraft / nN": "\t",
    "Tiefe (nm)\tLast (nN)": "\t",
    "Temps (s);Enfoncement (nm);Force (nN)": ";",
    "temps [s]\tprofondeur [nm]\tcharge [nN]": "\t",
    "Déplacement (nm)\tForce normale (nN)": "\t",
    "Profundidad (nm)\tFuerza (nN)": "\t",
    "Profondità (nm)\tCarico (nN)": "\t",
    "压入深度 (nm)\t载荷 (nN)\t时间 (s)": "\t",
    "押し込み深さ[nm],荷重[nN]": ",",
    "深度（nm）\t力（nN）": "\t",
    # instruments
    "_Pd_ [nm]\t_Fn_ [nN]": "\t",
    "Time [s]\tPd [nm]\tFn [nN]": "\t",
    "depth_nm,load_nN,time_s": ",",
    "time_s,depth_nm,load_nN": ",",
    "Depth nm,Load nN": ",",
    '"Depth (nm)","Load (nN)"': ",",
    "Displacement Into Surface (nm)   Load On Sample (nN)": "   ",
    "Raw Displacement (nm)\tDisplacement Into Surface (nm)\tRaw Load (nN)\tLoad On Sample (nN)": "\t",
    "Depth (nm)\tLoad (nN)\tTime (s)\tDepth (V)\tLoad (V)": "\t",
    "Index;Time;Displacement;Force\n-;s;nm;nN\nSweep;;;": ";",
    "Tip Sample Separation (nm)\tForce (nN)": "\t",
    "Separation_nm\tForce_nN": "\t",
    "F\th\nnN\tnm": "\t",
    "Depth,Load\n(nm),(nN)": ",",
    "Disp.(nm)\tLoad(nN)": "\t",
    "# time depth load\n# s nm nN": " ",
    "Compressive extension (nm),Compressive load (nN)": ",",
    "Depth(nm) Load(nN) Phase": " ",
}


def _letters(titles):
    """Columns in the order of titles, and the head."""
    words = titles.split("\n")[0].lower()
    sep = TITLES[titles]
    letters = ""
    for title in words.replace("#", "").strip().split(sep):
        title = title.replace('"', "")
        if "raw" in title or "(v)" in title or "phase" in title:
            letters += "0"
        elif any(w in title for w in ("time", "zeit", "temps", "时间")):
            letters += "t"
        elif title.strip() in ("index",):
            letters += "i"
        elif any(
            w in title
            for w in ("load", "force", "kraft", "last", "fn", "charge", "fuerza", "carico", "载荷", "荷重", "力", "f ")
        ) or title in ("f",):
            letters += "f"
        else:
            letters += "d"
    return letters, sep


@pytest.mark.parametrize("titles", TITLES)
def test_titles(tmp_path, titles):
    letters, sep = _letters(titles)
    head = "Instrument 7\nOperator: X\n\n" if "#" not in titles else ""
    path = written(tmp_path / "c.txt", f"{head}{titles}\n{rows(letters, sep)}")
    holds(read_curve(path), *APPROACH)
    assert (read_curve(path).time is None) == ("t" not in letters)


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("Depth (µm)\tLoad (µN)", "utf-8"),
        ("Depth (µm)\tLoad (µN)", "utf-8-sig"),
        ("Depth (µm)\tLoad (µN)", "utf-16"),
        ("Depth (µm)\tLoad (µN)", "latin-1"),
        ("Depth (μm)\tLoad (μN)", "utf-8"),
        ("Depth (祄)\tLoad (礜)", "utf-8"),
        ("Depth (礜)\tLoad (礜)", "utf-8"),
        ("Depth (ｵm)\tLoad (ｵN)", "utf-8"),
        ("Depth (Âµm)\tLoad (ÂµN)", "utf-8"),
        ("Depth (?m)\tLoad (?N)", "utf-8"),
        ("Depth (\ufffdm)\tLoad (\ufffdN)", "utf-8"),
        ("Depth (um)\tLoad (uN)", "utf-8-sig"),
        ("Depth [祄]\tLoad [礜]", "utf-8"),
        ("Depth\tLoad\n祄\t礜", "utf-8"),
    ],
)
def test_letters_of_micro(tmp_path, text, encoding):
    lines = "".join(f"{d * 1e6:.8g}\t{f * 1e6:.8g}\n" for d, f in zip(*APPROACH, strict=True))
    holds(read_curve(written(tmp_path / "c.txt", f"{text}\n{lines}", encoding)), *APPROACH)


@pytest.mark.parametrize(
    ("titles", "encoding"),
    [
        ("时间(s)\t位移(nm)\t载荷(nN)", "gbk"),
        ("時間(s)\t変位(nm)\t荷重(nN)", "shift_jis"),
        ("Prüfzeit (s)\tEindringtiefe (nm)\tPrüfkraft (nN)", "latin-1"),
    ],
)
def test_encodings_of_titles(tmp_path, titles, encoding):
    holds(read_curve(written(tmp_path / "c.txt", f"{titles}\n{rows('tdf')}", encoding)), *APPROACH)


CANTILEVERS = {
    "ZSensor (nm)\tDefl (nm)": "zc",
    "Z Sensor_nm\tDeflection_nm": "zc",
    "Piezo Extension_nm\tDeflection_nm": "zc",
    "Height Sensor (nm)\tDeflection Error (nm)": "zc",
    "ZSnsr [nm]\tDefl [nm]": "zc",
    "Z-Axis Sensor (nm)\tDeflection (nN)": "zf",
    "Z Scan (nm)\tForce (nN)": "zf",
    "Z Detector(nm)\tForce(nN)": "zf",
    "Höhe (nm)\tAuslenkung (nm)": "zc",
    "Hauteur (nm)\tDéflexion (nm)": "zc",
    "Height (nm)\tDFL (V)": "zv",
    "Z Position (nm)\tVertical Deflection (V)": "zv",
    "Cantilever (nm)\tPiezo (nm)\tTime (s)": "czt",
    "Z (nm)\tVertical deflection (nN)\tLateral deflection (V)": "zf0",
}


@pytest.mark.parametrize("titles", CANTILEVERS)
def test_titles_behind_a_cantilever(tmp_path, titles):
    path = written(tmp_path / "c.txt", f"{titles}\n{rows(CANTILEVERS[titles])}")
    curve = read_curve(
        path,
        spring_constant=K,
        **({"sensitivity": SENSITIVITY} if "V)\t" in titles + "\t" and "v" in CANTILEVERS[titles] else {}),
    )
    # differences of sums of eight digits
    holds(curve, *APPROACH, tolerance=1e-5)


SEGMENTS = {
    "blocks, JPK": (
        "# segmentIndex: 0\n# segment: extend\n# columns: height vDeflection\n# units: nm nN\n#\n",
        "# segmentIndex: 1\n# segment: retract\n# columns: height vDeflection\n# units: nm nN\n#\n",
    ),
    "blocks, JPK 2011": (
        "# index: 0\n# direction: trace\n# columns: height vDeflection\n# units: nm nN\n#\n",
        "# index: 0\n# direction: retrace\n# columns: height vDeflection\n# units: nm nN\n#\n",
    ),
    "blocks, numbers": ("Segment 1\nZ (nm)\tForce (nN)\n", "Segment 2\nZ (nm)\tForce (nN)\n"),
    "blocks, words": ("[Approach]\nZ (nm)\tForce (nN)\n", "\n[Retract]\nZ (nm)\tForce (nN)\n"),
    "blocks, forward": ("Direction: Forward\nZ (nm)\tForce (nN)\n", "Direction: Backward\nZ (nm)\tForce (nN)\n"),
    "blocks, word alone": ("Z (nm)\tForce (nN)\n", "Retract\n"),
    "blocks, data": ("Approach data:\nZ (nm)\tForce (nN)\n", "Retract data:\nZ (nm)\tForce (nN)\n"),
    "blocks, ramp": ("Ramp direction: Extend\nZ (nm)\tForce (nN)\n", "Ramp direction: Retract\nZ (nm)\tForce (nN)\n"),
    "blocks, comments": ("## Trace ##\nZ (nm)\tForce (nN)\n", "## Retrace ##\nZ (nm)\tForce (nN)\n"),
    "blocks, German": ("Belastung\nZ (nm)\tKraft (nN)\n", "Entlastung\nZ (nm)\tKraft (nN)\n"),
}


@pytest.mark.parametrize("turned", [False, True], ids=["in time", "from free to deepest"])
@pytest.mark.parametrize("order", [1, -1], ids=["approach first", "retract first"])
@pytest.mark.parametrize("layout", SEGMENTS)
def test_segments_in_blocks(tmp_path, layout, turned, order):
    if order == -1 and "alone" in layout:
        return
    sep = " " if "JPK" in layout else "\t"
    parts = [
        head + rows(c, sep, turned=t)
        for head, c, t in zip(SEGMENTS[layout], ("zf", "ZF"), (False, turned), strict=True)
    ]
    path = written(tmp_path / "c.txt", "".join(parts[::order]))
    assert curves_in(path) == 1
    curve = read_curve(path, spring_constant=K)
    assert "segments from blocks of the file" in curve.meta["read"][0]
    holds(curve, *CYCLE)
    assert np.unique(curve.segment).tolist() == [0, 1]


@pytest.mark.parametrize("turned", [False, True], ids=["in time", "from free to deepest"])
@pytest.mark.parametrize(
    ("title", "names"),
    [
        ("Segment", "12"),
        ("SegmentID", "01"),
        ("Seg", "12"),
        ("Segment Type", ("approach", "retract")),
        ("Direction", ("trace", "retrace")),
        ("Phase", ("Loading", "Unloading")),
        ("Branch", ("extend", "retract")),
        ("Step", ("Belastung", "Entlastung")),
        ("Segment Name", ("Ramp up", "Ramp down")),
    ],
)
def test_segments_in_a_column(tmp_path, title, names, turned):
    parts = [rows(["d", "f", f"*{names[0]}*"]), rows(["D", "F", f"*{names[1]}*"], turned=turned)]
    path = written(tmp_path / "c.txt", f"depth (nm)\tforce (nN)\t{title}\n{''.join(parts)}")
    assert curves_in(path) == 1
    holds(read_curve(path), *CYCLE)
    assert read_curve(path).segment.tolist() == [0] * N + [1] * N
    # the retract first, where it has a name that says so
    if names[1] in ("retract", "retrace", "Unloading", "Entlastung"):
        path = written(tmp_path / "d.txt", f"depth (nm)\tforce (nN)\t{title}\n{''.join(parts[::-1])}")
        assert curves_in(path) == 1
        holds(read_curve(path), *CYCLE)


def test_words_at_the_first_reading_of_a_segment(tmp_path):
    """As nanoindenters mark them in a column of their workbooks."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Segment", "Displacement Into Surface", "Load On Sample"])
    sheet.append([None, "nm", "nN"])
    marks = {0: "Load Segment Type", N: "Hold Segment Type", N + 20: "Unload From Peak Segment Type"}
    depth = np.concatenate([DEPTH, np.full(20, DEPTH[-1]), DEPTH[::-1]])
    force = np.concatenate([FORCE, np.full(20, FORCE[-1]), BACK])
    for i in range(depth.size):
        sheet.append([marks.get(i), depth[i] * 1e9, force[i] * 1e9])
    sheet.append(["END"])
    book.save(tmp_path / "c.xlsx")
    curve = read_curve(tmp_path / "c.xlsx")
    holds(curve, depth, force)
    assert curve.segment.tolist() == [0] * N + [1] * 20 + [2] * N


SIDES = {
    "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm\tDefl_pN_Ex\tDefl_pN_Rt": "p",
    "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm\tDefl_nm_Ex\tDefl_nm_Rt": "c",
    "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm\tDefl_V_Ex\tDefl_V_Rt": "v",
    "Extend Z-Sense(nm)\tRetract Z-Sense(nm)\tExtend T-B(V)\tRetract T-B(V)": "v",
    "Z Approach (nm)\tZ Retract (nm)\tForce Approach (nN)\tForce Retract (nN)": "f",
    "Approach Z [nm]\tRetract Z [nm]\tApproach Force [nN]\tRetract Force [nN]": "f",
    "Z (Extend)_nm\tZ (Retract)_nm\tForce (Extend)_nN\tForce (Retract)_nN": "f",
    "Z trace (nm)\tZ retrace (nm)\tForce trace (nN)\tForce retrace (nN)": "f",
    "Z-Forward (nm)\tZ-Backward (nm)\tForce-Forward (nN)\tForce-Backward (nN)": "f",
    "Height_Sensor_nm_Ex\tHeight_Sensor_nm_Rt\tDefl_nm_Ex\tDefl_nm_Rt": "c",
    "Approach\t\tRetract\t\nZ (nm)\tZ (nm)\tForce (nN)\tForce (nN)": "x",
}


@pytest.mark.parametrize("turned", [False, True], ids=["in time", "from free to deepest"])
@pytest.mark.parametrize("titles", SIDES)
def test_approach_and_retract_side_by_side(tmp_path, titles, turned):
    kind = SIDES[titles]
    signals = {"p": "fF", "x": "fF"}.get(kind, kind + kind.upper())
    order = ["z", "Z", *signals] if kind != "x" else ["z", "f", "Z", "F"]
    if kind == "x":
        titles = "Approach\t\tRetract\t\nZ (nm)\tForce (nN)\tZ (nm)\tForce (nN)"
    columns = {
        c: COLUMNS[c][:: -1 if turned and c.isupper() else 1] * (1e3 if kind == "p" and c in "fF" else 1) for c in order
    }
    lines = "\n".join("\t".join(f"{v:.8g}" for v in row) for row in zip(*columns.values(), strict=True))
    path = written(tmp_path / "c.txt", f"{titles}\n{lines}\n")
    curve = read_curve(path, spring_constant=K, **({"sensitivity": SENSITIVITY} if kind == "v" else {}))
    holds(curve, *CYCLE, tolerance=1e-5)
    assert curve.segment.tolist() == [0] * N + [1] * N


TESTS = {
    "numbers behind": ("Depth 1 (nm)\tLoad 1 (nN)\tDepth 2 (nm)\tLoad 2 (nN)\tDepth 3 (nm)\tLoad 3 (nN)", "dfdfdf"),
    "numbers before": (
        "Test 1 Depth (nm)\tTest 1 Load (nN)\tTest 2 Depth (nm)\tTest 2 Load (nN)\tTest 3 Depth (nm)\tTest 3 Load (nN)",
        "dfdfdf",
    ),
    "underscores": ("depth_1_nm\tload_1_nN\tdepth_2_nm\tload_2_nN\tdepth_3_nm\tload_3_nN", "dfdfdf"),
    "same titles": ("Depth (nm)\tLoad (nN)\tDepth (nm)\tLoad (nN)\tDepth (nm)\tLoad (nN)", "dfdfdf"),
    "pandas": ("depth (nm)\tforce (nN)\tdepth (nm).1\tforce (nN).1\tdepth (nm).2\tforce (nN).2", "dfdfdf"),
    "sorted": ("Depth 1 (nm)\tDepth 2 (nm)\tDepth 3 (nm)\tLoad 1 (nN)\tLoad 2 (nN)\tLoad 3 (nN)", "dddfff"),
    "one time": ("Time (s)\tDepth (nm)\tLoad (nN)\tDepth (nm)\tLoad (nN)\tDepth (nm)\tLoad (nN)", "tdfdfdf"),
    "times": ("t (s)\th (nm)\tP (nN)\tt (s)\th (nm)\tP (nN)\tt (s)\th (nm)\tP (nN)", "tdftdftdf"),
    "two rows of titles": (
        "Test 1\t\tTest 2\t\tTest 3\t\nDepth\tLoad\tDepth\tLoad\tDepth\tLoad\nnm\tnN\tnm\tnN\tnm\tnN",
        "dfdfdf",
    ),
    "empty between": (
        "Depth (nm)\tLoad (nN)\t\tDepth (nm)\tLoad (nN)\t\tDepth (nm)\tLoad (nN)",
        ["d", "f", "**", "d", "f", "**", "d", "f"],
    ),
}


@pytest.mark.parametrize("form", ["text", "sheet"])
@pytest.mark.parametrize("ends", [(N, N, N), (N, 40, 55)], ids=["alike", "of different lengths"])
@pytest.mark.parametrize("layout", TESTS)
def test_tests_side_by_side(tmp_path, layout, ends, form):
    """Each is a curve, whatever their lengths."""
    head, letters = TESTS[layout]
    cells = [list(COLUMNS.get(c, [""] * N)) for c in letters]
    seen = {"d": 0, "f": 0, "t": 0}
    for letter, column in zip(letters, cells, strict=True):
        if letter in "df" or (letter == "t" and letters.count("t") > 1):
            end = ends[seen[letter]]
            seen[letter] += 1
            column[end:] = [""] * (N - end)
    lines = [[f"{v:.8g}" if v != "" else "" for v in row] for row in zip(*cells, strict=True)]
    if form == "text":
        path = written(tmp_path / "c.txt", head + "\n" + "\n".join("\t".join(row) for row in lines) + "\n")
    else:
        book = openpyxl.Workbook()
        for row in head.split("\n"):
            book.active.append([c or None for c in row.split("\t")])
        for row in lines:
            book.active.append([float(c) if c else None for c in row])
        path = tmp_path / "c.xlsx"
        book.save(path)
    assert curves_in(path) == 3
    for i, end in enumerate(ends):
        holds(read_curve(path, index=i), DEPTH[:end], FORCE[:end])


BLOCKS = {
    "same titles": "Depth (nm)\tLoad (nN)\n",
    "words": "Test {i}\nDepth (nm)\tLoad (nN)\n",
    "Fischer": "Sample A\nTest {i}\nBlock : {i}\nF\th\nnN\tnm\n",
    "CSM": "----- Indentation {i} -----\nDate: 1.2.2030\n\nPd [nm]\tFn [nN]\n",
    "approaches": "[Approach]\nDepth (nm)\tLoad (nN)\n",
}


@pytest.mark.parametrize("layout", BLOCKS)
@pytest.mark.parametrize("decimal", [".", ","])
def test_tests_one_below_the_other(tmp_path, layout, decimal):
    letters = "fd" if layout == "Fischer" else "df"
    text = "\n".join(BLOCKS[layout].format(i=i) + rows(letters, decimal=decimal) for i in (1, 2, 3))
    path = written(tmp_path / "c.txt", text)
    assert curves_in(path, decimal=decimal) == 3
    for i in range(3):
        holds(read_curve(path, index=i, decimal=decimal), *APPROACH)


def test_a_column_that_numbers_the_tests(tmp_path):
    text = "".join(rows([f"*{i}*", "d", "f"]) for i in (1, 2, 3))
    path = written(tmp_path / "c.csv", "Test\tDepth (nm)\tLoad (nN)\n" + text)
    assert curves_in(path) == 3
    holds(read_curve(path, index=1), *APPROACH)


def test_cycles_one_below_the_other(tmp_path):
    """Trace and retrace of each of three, retraces from free to deepest."""
    head = "# direction: {}\n# columns: height vDeflection\n# units: nm nN\n#\n"
    one = head.format("trace") + rows("zf", " ") + head.format("retrace") + rows("ZF", " ", turned=True)
    path = written(tmp_path / "c.txt", one * 3)
    assert curves_in(path) == 3
    for i in range(3):
        holds(read_curve(path, index=i, spring_constant=K), *CYCLE)


@pytest.mark.parametrize("last", ["Max\t5\t3\n", "END\n", "\n\n", "1.2\t3", "Mean: 7 nm\n"])
def test_what_follows_the_readings_is_none(tmp_path, last):
    path = written(tmp_path / "c.txt", "depth (nm)\tforce (nN)\ttime (s)\n" + rows("dft") + last)
    holds(read_curve(path), *APPROACH)


@pytest.mark.parametrize("turned", [False, True])
def test_a_time_that_counts_rows_does_not_turn_a_retract_into_an_approach(tmp_path, turned):
    """Retraces from free to deepest whose times go on."""
    head = "# direction: {}\n# columns: height vDeflection time\n# units: nm nN s\n#\n"
    lines = rows("ZFT", " ").splitlines()
    if turned:
        cells = [line.split() for line in lines]
        lines = [" ".join([*there[:2], here[2]]) for there, here in zip(cells[::-1], cells, strict=True)]
    path = written(
        tmp_path / "c.txt", head.format("trace") + rows("zft", " ") + head.format("retrace") + "\n".join(lines)
    )
    curve = read_curve(path, spring_constant=K)
    holds(curve, *CYCLE)
    assert (np.diff(curve.time) > 0).all()


def test_a_million_columns_are_refused(tmp_path):
    path = written(tmp_path / "c.csv", ",".join(["depth (nm)"] * 10_000) + "\n" + (",".join("1" * 10_000) + "\n") * 12)
    with pytest.raises(CurveError, match="10000 columns; at most 5000 are read"):
        read_curve(path)


def test_extend_pause_retract(tmp_path):
    head = "# segmentIndex: {}\n# segment: {}\n# columns: verticalTipPosition vDeflection time\n# units: nm nN s\n#\n"
    pause = "".join(f"{DEPTH[-1] * 1e9:.8g} {FORCE[-1] * 1e9:.8g} {0.01 * i:.8g}\n" for i in range(30))
    text = head.format(0, "extend") + rows("dft", " ") + head.format(1, "pause") + pause
    path = written(tmp_path / "c.txt", text + head.format(2, "retract") + rows("DFt", " "))
    assert curves_in(path) == 1
    curve = read_curve(path)
    assert curve.segment.tolist() == [0] * N + [1] * 30 + [2] * N
    np.testing.assert_allclose(curve.force, np.concatenate([FORCE, np.full(30, FORCE[-1]), BACK]), atol=1e-16)


def test_a_nanoscope_text_with_its_header(tmp_path):
    """The header of the binary file stands above the numbers."""
    head = '"\\*File list"\n"\\Version: 0x09700000"\n"\\Spring Constant: 0.05"\n"\\*File list end"\n'
    titles = "Calc_Ramp_Ex_nm\tCalc_Ramp_Rt_nm\tDefl_nm_Ex\tDefl_nm_Rt\n"
    path = written(tmp_path / "c.txt", head + titles + rows("zZcC"))
    holds(read_curve(path), *CYCLE, tolerance=1e-5)
    path = written(tmp_path / "d.txt", head.replace('"', "") + titles + rows("zZcC"))
    holds(read_curve(path), *CYCLE, tolerance=1e-5)


def test_a_depth_that_begins_at_the_contact_is_not_used_before_it(tmp_path):
    """The text of an interferometric nanoindenter: the depth is zero before the contact."""
    text = "k (N/m)\t0.05\n\nTime (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\n"
    columns = [TIME, FORCE * 1e6, np.maximum(DEPTH, 0) * 1e9, DEFLECTION * 1e9, PIEZO * 1e9]
    lines = "\n".join("\t".join(f"{v:.8g}" for v in row) for row in zip(*columns, strict=True))
    holds(read_curve(written(tmp_path / "c.txt", text + lines)), *APPROACH, tolerance=1e-5)


def _workbook(path, results):
    book = openpyxl.Workbook()
    book.remove(book.active)
    if results == "first":
        _results(book)
    for i in (1, 2, 3):
        sheet = book.create_sheet(f"Test {i:03d}")
        sheet.append(["Displacement Into Surface", "Load On Sample", "Time On Sample"])
        sheet.append(["nm", "mN", "s"])
        for row in zip(DEPTH * 1e9, i * FORCE * 1e3, TIME, strict=True):
            sheet.append([float(v) for v in row])
    if results == "last":
        _results(book)
    book.save(path)
    return path


def _results(book):
    sheet = book.create_sheet("Sheet9")
    sheet.append(["Test", "E", "H", "Displacement", "Load"])
    sheet.append([None, "GPa", "GPa", "nm", "mN"])
    for i in range(20):
        sheet.append([i + 1, 70.0 + i, 9.0, 200.0 + i, 1.0 + i])


@pytest.mark.parametrize("results", ["none", "first", "last"])
def test_workbook_of_tests(tmp_path, results):
    path = _workbook(tmp_path / "c.xlsx", results)
    assert curves_in(path) == 3
    for i in range(3):
        holds(read_curve(path, index=i), DEPTH, (i + 1) * FORCE)
    holds(read_curve(path, sheet="Test 002"), DEPTH, 2 * FORCE)


def test_archive_of_workbooks_and_texts(tmp_path):
    with zipfile.ZipFile(tmp_path / "c.zip", "w") as archive:
        archive.write(_workbook(tmp_path / "c.xlsx", "first"), "a.xlsx")
        archive.writestr("b.csv", "depth (nm)\tforce (nN)\n" + rows("df"))
        archive.writestr("notes.txt", "Four tests.\n")
    assert curves_in(tmp_path / "c.zip") == 4
    holds(read_curve(tmp_path / "c.zip", index=3), *APPROACH)


@pytest.mark.parametrize(
    ("titles", "letters", "message"),
    [
        ("Piezo (nm)\tTime (s)", "zt", r"no column of deflection recognised.*\[curve.columns\] deflection = '...'"),
        ("Height (nm)\tPhase (deg)\tTime (s)", "z0t", "no column of deflection"),
        ("Deflection (nm)\tTime (s)", "ct", "no column of piezo"),
        ("Depth (nm)\tTime (s)", "dt", "no column of force"),
        ("Load (nN)\tTime (s)", "ft", "no column of depth"),
    ],
)
def test_what_is_missing_is_named(tmp_path, titles, letters, message):
    path = written(tmp_path / "c.txt", f"{titles}\n{rows(letters)}")
    for k in (K, None):
        with pytest.raises(CurveError, match=message):
            read_curve(path, spring_constant=k)


@pytest.mark.parametrize(
    ("lines", "place"),
    [
        ("# xPosition: 1.5e-5\n# yPosition: -2e-06\n", (1.5e-5, -2e-6)),
        ("Stage X (mm): 3.5\nStage Y (mm): 0\n", (3.5e-3, 0.0)),
        ("Position X\t12.5 um\nPosition Y\t7 um\n", (1.25e-5, 7e-6)),
        ("X position: 3500\nY position: 12\n", None),  # no metres
    ],
)
def test_where_a_curve_was_taken(tmp_path, lines, place):
    path = written(tmp_path / "c.txt", f"{lines}depth (nm)\tforce (nN)\n{rows('df')}")
    known = read_curve(path).meta.get("metadata", {})
    assert (place is None and not known) or np.allclose([known["position x"], known["position y"]], place, rtol=1e-12)
    holds(read_curve(path), DEPTH, FORCE)
