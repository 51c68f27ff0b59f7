"""Case files with adhesion and with histories: what they build, what they refuse, and result files of both."""

import numpy as np
import pytest
import xarray as xr

import flatpunch as fp
from flatpunch.files import CaseError, describe, load, read_case, save, shipped_cases

BODY = """
[[layers]]
young = "2 kPa"
poisson = 0.5
thickness = "4 um"

[base]
kind = "rigid"

[indenter]
kind = "sphere"
radius = "2 um"
"""
STICKY = f"""
work_of_adhesion = "50 uJ/m^2"
range_of_action = "0.5 nm"
{BODY}
[control]
depth = {{ start = "100 nm", stop = "-60 nm", points = 9 }}
"""
SEGMENTS = """[history]
segments = [
    { kind = "ramp", depth = "500 nm", duration = "1 s", points = 4 },
    { kind = "hold", duration = "5 s", points = 2 },
    { kind = "retract", duration = "2 s", points = 4 },
]
"""
RELAXATION = """
[relaxation]
kind = "power-law"
exponent = 0.25
time = "1 s"

"""
RELAXING = BODY + RELAXATION + SEGMENTS


@pytest.fixture
def read(tmp_path):
    def read_text(text):
        path = tmp_path / "case.toml"
        path.write_text(text, encoding="utf-8")
        return read_case(path)

    return read_text


def test_adhesion(read):
    case = read(STICKY)
    assert (case.physics.work_of_adhesion, case.physics.range_of_action) == (5e-5, 5e-10)
    assert case.method == "second-order"
    # evenly spaced between two floats: a few roundings
    np.testing.assert_allclose(case.values, 1e-9 * np.linspace(100, -60, 9), rtol=1e-14, atol=1e-22)
    assert set(case.arguments) == {"depth", "method", "angles", "work_of_adhesion", "range_of_action"}
    in_tension = read(STICKY.replace('depth = { start = "100 nm", stop = "-60 nm", points = 9 }', 'force = "-50 pN"'))
    assert in_tension.values == [-5e-11]


def test_a_range_across_zero_has_a_step_at_zero(read):
    depth = np.asarray(read(STICKY.replace("points = 9", "points = 41")).values)
    assert depth[25] == 0.0
    assert np.count_nonzero(depth) == 40


@pytest.mark.parametrize("unit", ["mN/m", "mJ/m^2", "erg/cm^2", "fJ/um^2"])
def test_units_of_the_work_of_adhesion(read, unit):
    assert read(STICKY.replace('"50 uJ/m^2"', f'"2 {unit}"')).physics.work_of_adhesion == pytest.approx(2e-3, rel=1e-15)


def test_segments(read):
    case = read(RELAXING)
    assert (case.control, case.method) == ("depth", None)  # chosen when it is solved
    assert case.physics.relaxation == fp.PowerLawRelaxation(0.25, 1.0)
    # every one of these fractions but the length unit is exact in binary
    assert case.time.tolist() == [0, 0.25, 0.5, 0.75, 1, 3.5, 6, 6.5, 7, 7.5, 8]
    np.testing.assert_allclose(
        case.values, 5e-7 * np.array([0, 0.25, 0.5, 0.75, 1, 1, 1, 0.75, 0.5, 0.25, 0]), rtol=1e-15
    )


@pytest.mark.parametrize(
    ("history", "control", "time", "expected"),
    [
        ('time = ["0 s", "1 s", "3 s"]\nforce = ["1 nN", "1 nN", "0 nN"]', "force", [0, 1, 3], [1e-9, 1e-9, 0]),
        (
            'time = { start = "0 s", stop = "2 min", points = 3 }\ndepth = { start = "-1 um", stop = "1 um", points = 3 }',
            "depth",
            [0, 60, 120],
            [-1e-6, 0, 1e-6],
        ),
        (
            'segments = [{ kind = "ramp", force = "2 nN", duration = "1 s", points = 1 },'
            ' { kind = "retract", force = "1 nN", duration = "1 s", points = 1 }]',
            "force",
            [0, 1, 2],
            [0, 2e-9, 1e-9],
        ),
    ],
)
def test_histories(read, history, control, time, expected):
    case = read(f"{BODY}{RELAXATION}[history]\n{history}\n")
    assert case.control == control
    assert case.time.tolist() == time
    np.testing.assert_allclose(case.values, expected, rtol=1e-15, atol=1e-24)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ('kind = "prony"\nweights = [0.5, 0.25]\ntimes = ["1 s", "250 ms"]', fp.Prony([0.5, 0.25], [1, 0.25])),
        (
            'kind = "prony"\nweights = [2]\ntimes = ["1 s"]\nequilibrium = 1',
            fp.Prony([2.0], [1.0], 1.0),
        ),
        (
            'kind = "standard-linear-solid"\nequilibrium = 0.5\ntime = "0.5 s"',
            fp.StandardLinearSolid(0.5, 0.5),
        ),
    ],
)
def test_relaxations(read, table, expected):
    assert read(f"{BODY}[relaxation]\n{table}\n{SEGMENTS}").physics.relaxation == expected


STEPS = SEGMENTS[SEGMENTS.index("segments") :]
LISTS = 'time = ["0 s", "1 s"]\ndepth = ["0 nm", "10 nm"]\n'


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (STICKY, '"50 uJ/m^2"', '"50 uN"', "work_of_adhesion = '50 uN' has the dimension of a force; a work of adhesion"),
        (STICKY, '"50 uJ/m^2"', '"50 uJ"', "work_of_adhesion = '50 uJ' has the dimension"),
        (STICKY, '"50 uJ/m^2"', "50", "work_of_adhesion = 50 has no unit"),
        (STICKY, '"50 uJ/m^2"', '"0 uJ/m^2"', "work_of_adhesion = '0 uJ/m.2' must be finite and > 0"),
        (STICKY, '"0.5 nm"', '"-0.5 nm"', "range_of_action = '-0.5 nm' must be finite and > 0"),
        (STICKY, 'work_of_adhesion = "50 uJ/m^2"', "", r"control\.depth\[[56]\] = .* Below zero it takes a work_of_adhesion"),
        (STICKY, "work_of_adhesion", "work_of_adhesoin", "did you mean 'work_of_adhesion'"),
        (
            STICKY,
            "[control]",
            '[control]\nwork_of_adhesion = "1 J/m^2"',
            "'work_of_adhesion' belongs at the top of the file",
        ),
        (STICKY, "work_of", 'method = "bem"\nwork_of', "work_of_adhesion goes with the fast methods"),
        (STICKY, "[control]", f"{RELAXATION}[control]", r"\[history\] and \[relaxation\] go together: .* found \[relaxation\]"),
        (RELAXING, "\n[[layers]]", 'work_of_adhesion = "1 J/m^2"\n[[layers]]', "adhesion of viscoelastic bodies is not solved"),
        (RELAXING, "\n[[layers]]", 'range_of_action = "1 nm"\n[[layers]]', "no meaning without work_of_adhesion"),
        (RELAXING, "\n[[layers]]", 'method = "bem"\n[[layers]]', "method = 'bem' does not go with"),
        (RELAXING, RELAXATION, "\n", r"\[history\] and \[relaxation\] go together"),
        (RELAXING, SEGMENTS, "", r"give either a table \[control\] .* found none"),
        (RELAXING, SEGMENTS, SEGMENTS + '[control]\ndepth = "1 nm"', "found both"),
        (
            RELAXING,
            'kind = "rigid"',
            'kind = "half-space"\nyoung = "70 GPa"\npoisson = 0.2',
            "relaxation goes with a half-space or with layers on a RigidBase",
        ),
        (RELAXING, '"power-law"', '"power"', "relaxation.kind = 'power' is unknown; it is one of 'prony', 'standard"),
        (RELAXING, "0.25", "1.25", "relaxation.exponent = 1.25 must lie between 0"),
        (RELAXING, "0.25", '"0.25 s"', "relaxation.exponent = '0.25 s' must be a plain number"),
        (RELAXING, '"1 s"\n', '"1 nm"\n', "relaxation.time = '1 nm' has the dimension of a length; a time such as '0.5 s'"),
        (RELAXING, 'time = "1 s"\n', "", "relaxation.time is missing; it needs a time such as"),
        (RELAXING, '"hold", duration = "5 s"', '"wait", duration = "5 s"', r"segments\[1\].kind = 'wait' must be 'ramp', 'hold'"),
        (RELAXING, '"5 s"', '"0 s"', r"history.segments\[1\].duration = '0 s' must be finite and > 0"),
        (RELAXING, "points = 2", "points = 0", r"segments\[1\].points = 0 must be 1 or more"),
        (RELAXING, '"hold",', '"hold", depth = "1 nm",', r"history.segments\[1\]: a hold keeps the depth"),
        (RELAXING, 'depth = "500 nm", ', "", r"history.segments\[0\]: a ramp needs the depth or the force"),
        (RELAXING, '"retract",', '"retract", force = "0 N",', "lead to depths or to forces, found both"),
        (RELAXING, STEPS, "segments = []\n", "history.segments"),
        (RELAXING, STEPS, LISTS + STEPS, "give either segments, or time with depth or force"),
        (RELAXING, STEPS, 'depth = ["0 nm", "10 nm"]\n', "give either time with depth or force, or segments"),
        (RELAXING, STEPS, LISTS + 'force = ["0 N", "1 N"]\n', "exactly one of depth and force must be given, found depth and"),
        (RELAXING, STEPS, LISTS.replace('"1 s"', '"1 s", "2 s"'), "time has 3 values and depth 2"),
        (RELAXING, STEPS, LISTS.replace('"1 s"', '"0 s"'), r"history\.time\[1\] = '0 s' must be after time\[0\] = 0 s"),
        (RELAXING, STEPS, 'time = ["0 s", "1 s"]\nforce = ["0 nN", "-10 nN"]\n', r"history\.force\[1\] = '-10 nN' must be"),
    ],
)  # fmt: skip
def test_messages(read, text, old, new, message):
    assert old in text
    with pytest.raises(CaseError, match=message):
        read(text.replace(old, new, 1))


def test_negative_depths_need_adhesion(read):
    with pytest.raises(
        CaseError,
        match=r"control\.depth\[4\] = '-1 nm' must be finite and >= 0. Below zero it takes a work_of_adhesion",
    ):
        read(f'{BODY}[control]\ndepth = ["1 nm", "2 nm", "3 nm", "4 nm", "-1 nm"]\n')
    with pytest.raises(CaseError, match=r"control.radius = '-1 nm' must be finite and >= 0"):
        read(STICKY[: STICKY.index("depth")] + 'radius = "-1 nm"\n')


def test_descriptions(read):
    assert "Adhesion  work 50 µJ/m², range of action 500 pm" in list(describe(read(STICKY)))
    lines = list(describe(read(RELAXING)))
    assert "History   depth at 11 times over 8 s, up to 500 nm, at the end 0 m" in lines
    assert "Relaxes   PowerLawRelaxation exponent 0.25, time 1 s" in lines
    power = 'kind = "power-law"\nexponent = 0.25\ntime = "1 s"'
    prony = RELAXING.replace(power, 'kind = "prony"\nweights = [0.5, 0.2]\ntimes = ["1 s", "20 ms"]')
    assert "Relaxes   Prony weights (0.5, 0.2), times (1 s, 20 ms), equilibrium 0.3" in list(describe(read(prony)))


@pytest.mark.parametrize("ending", [".nc", ".csv"])
@pytest.mark.parametrize("text", [STICKY, RELAXING], ids=["adhesion", "history"])
def test_results_survive_their_files(read, tmp_path, text, ending):
    case = read(
        text.replace("work_of", "angles = 12\nwork_of").replace(
            "\n[[layers]]", "\nangles = 12\n[[layers]]", text is RELAXING
        )
    )
    result = fp.indent(case.medium, case.indenter, **case.arguments)
    back = load(save(result, tmp_path / f"result{ending}", outlines=True))
    xr.testing.assert_identical(back, result)
    assert back.attrs == result.attrs
    expected = {"work_of_adhesion", "range_of_action"} if text is STICKY else {"relaxation"}
    assert expected <= back.attrs.keys()
    assert {name: back[name].dtype for name in back.variables} == {
        name: result[name].dtype for name in result.variables
    }


def test_what_the_shipped_case_says_of_the_glass():
    """Numbers in the comment of the example: 13 % more force, 57 instead of 82 nm."""
    (path,) = [path for path in shipped_cases() if "sticking" in path.name]
    case = read_case(path)
    work = case.physics.work_of_adhesion
    layer = fp.pull_off(case.medium, case.indenter, work_of_adhesion=work)
    thick = fp.pull_off(fp.HalfSpace(3e3, 0.48), case.indenter, work_of_adhesion=work)
    assert layer.force / thick.force == pytest.approx(1.13, abs=0.005)
    assert layer.depth_minimum.depth == pytest.approx(-57e-9, abs=0.5e-9)
    assert thick.depth_minimum.depth == pytest.approx(-82e-9, abs=0.5e-9)


EACH = """
layers = [{ young = "5 kPa", poisson = 0.5, thickness = "2 um" }]
base = { kind = "half-space", young = "50 kPa", poisson = 0.3 }
indenter = { kind = "INDENTER" }
history = { segments = [{ kind = "ramp", depth = "300 nm", duration = "1 s", points = 4 }] }
relaxation = { kind = "each", bodies = [{ kind = "prony", weights = [0.5], times = ["2 s"] }BODIES] }
"""
BALL, ELASTIC = 'sphere", radius = "5 um', ', { kind = "elastic" }'


def _each(tmp_path, indenter=BALL, bodies=ELASTIC, more=""):
    path = tmp_path / "case.toml"
    path.write_text(more + EACH.replace("INDENTER", indenter).replace("BODIES", bodies), encoding="utf-8")
    return fp.read_case(path)


@pytest.mark.long
def test_relaxation_of_each_layer(tmp_path):
    case = _each(tmp_path)
    assert case.physics.relaxation == (fp.Prony([0.5], [2.0]), None)
    assert "Prony" in " ".join(fp.files.describe(case))
    direct = fp.indent(
        case.medium, case.indenter, depth=case.values, time=case.time, relaxation=[fp.Prony([0.5], [2.0]), None]
    )
    found = fp.indent(case.medium, case.indenter, **case.arguments)
    assert found.force.values.tolist() == direct.force.values.tolist()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"bodies": ""}, "relaxation has 1 entries for 1 layers and an elastic base; give 2"),
        (
            {"indenter": "vickers"},
            r"indenter = .* is not round, and relaxation for each layer is solved for round tips",
        ),
        ({"more": 'method = "second-order"\n'}, "method is not chosen with one relaxation for each layer"),
        ({"bodies": ', { kind = "power-law", exponent = 0.2, time = "1 s" }'}, "power-law"),
    ],
)
def test_relaxation_of_each_layer_is_checked_before_anything_is_solved(tmp_path, changed, message):
    with pytest.raises(ValueError, match=message):
        _each(tmp_path, **changed)
