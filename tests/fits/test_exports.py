"""Titles and segments of curves, as instruments export them: each is read as what it holds, in the order of time."""

import numpy as np
import openpyxl
import pytest

from flatpunch.fits import read_curve
from flatpunch.fits.measured.files.readers import curves_in
from support.exported_curves import (
    APPROACH,
    BACK,
    COLUMNS,
    CYCLE,
    DEPTH,
    FORCE,
    SENSITIVITY,
    K,
    N,
    holds,
    rows,
    written,
)

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
