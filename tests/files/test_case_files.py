"""Case files: what they build, and what they say when they cannot."""

import math

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.files import CaseError, describe, read_case, shipped_cases
from flatpunch.media import ExponentialModulus, GradedLayer, PowerLawHalfSpace, PowerModulus, TwoBodies

GOOD = """
title = "gel"

[[layers]]
young = "5 kPa"
poisson = 0.5
thickness = "1.2 um"

[base]
kind = "rigid"

[indenter]
kind = "pyramid"
sides = 4
half_opening_angle = "35 deg"

[control]
depth = { start = "1 nm", stop = "400 nm", points = 41, spacing = "log" }
"""
LAYERS = GOOD[GOOD.index("[[layers]]") : GOOD.index("[indenter]")]
INDENTER = GOOD[GOOD.index("[indenter]") : GOOD.index("[control]")]
DEPTH = GOOD[GOOD.index("depth =") :]


@pytest.fixture
def read(tmp_path):
    def read_text(text):
        path = tmp_path / "case.toml"
        path.write_text(text, encoding="utf-8")
        return read_case(path)

    return read_text


def close(value):
    """Unit conversion is one multiplication: a few roundings."""
    return pytest.approx(value, rel=1e-14)


def test_whole_case(read):
    case = read(GOOD)
    assert case.title == "gel"
    assert case.medium == fp.Medium([fp.Layer(5e3, 0.5, 1.2e-6)], base=fp.RigidBase())
    assert case.indenter.sides == 4
    assert case.indenter.inclination == close(math.radians(55))
    assert (case.control, case.method, case.angles) == ("depth", None, 360)  # the method is chosen when it is solved
    np.testing.assert_allclose(case.values, np.geomspace(1e-9, 4e-7, 41), rtol=1e-13)  # 41 powers of one ratio


@pytest.mark.parametrize(
    ("control", "name", "expected"),
    [
        ('depth = "200 nm"', "depth", [2e-7]),
        ('force = ["1 nN", "2 nN"]', "force", [1e-9, 2e-9]),
        ('radius = { start = "0 nm", stop = "300 nm", points = 4 }', "radius", [0, 1e-7, 2e-7, 3e-7]),
    ],
)
def test_controls(read, control, name, expected):
    case = read(GOOD.replace(DEPTH, control))
    assert case.control == name
    np.testing.assert_allclose(case.values, expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ('kind = "paraboloid"\nradius = "5 um"', fp.Paraboloid(5e-6)),
        ('kind = "sphere"\nradius = "5 um"', fp.Sphere(5e-6)),
        ('kind = "cylinder"\nradius = "5 um"', fp.Cylinder(5e-6)),
        ('kind = "cone"\ninclination = "0.5 rad"', fp.Cone(0.5)),
        ('kind = "pyramid"\nsides = 3\ninclination = "0.5 rad"', fp.Pyramid(3, 0.5)),
        ('kind = "elliptic-paraboloid"\nA = "2 1/m"\nB = "3 1/m"', fp.EllipticParaboloid(2.0, 3.0)),
        ('kind = "elliptic-paraboloid"\nradius_x = "0.25 m"\nradius_y = "0.125 m"', fp.EllipticParaboloid(2.0, 4.0)),
        ('kind = "power-law"\nexponent = 2\nradius = "2 m"\nheight = "8 m"', fp.PowerLaw(2.0, 2.0)),
        (
            'kind = "power-law"\nexponent = 2\nradius = "1 m"\nheight = "2 m"\nangles = ["0 rad", "2 rad", "4 rad"]\n'
            "factors = [1.0, 1.5, 1.25]",
            fp.PowerLaw(2.0, ([0.0, 2.0, 4.0], [2.0, 3.0, 2.5])),
        ),
        (
            'kind = "radial-profile"\nr = ["0 m", "1 m", "2 m"]\nf = ["0 m", "1 m", "3 m"]\nkinks = ["1 m"]',
            fp.RadialProfile([0, 1, 2], [0, 1, 3], [1]),
        ),
    ],
)
def test_indenters(read, table, expected):
    """Every number here is exact in binary, so the indenters are equal, not merely close."""
    assert read(GOOD.replace(INDENTER, f"[indenter]\n{table}\n")).indenter == expected


@pytest.mark.parametrize("heading", ["r [um], f [nm]", "radius (um), height (nm)"])
def test_profile_from_a_csv_beside_the_case(read, tmp_path, heading):
    (tmp_path / "tip.csv").write_text(f"# measured\n{heading}\n0, 0\n1, 50\n2, 200\n", encoding="utf-8")
    indenter = read(GOOD.replace(INDENTER, '[indenter]\nkind = "radial-profile"\nfile = "tip.csv"\n')).indenter
    assert indenter.r == close((0, 1e-6, 2e-6))
    assert indenter.f == close((0, 5e-8, 2e-7))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("r, f\n0, 0\n1, 50\n2, 200\n", "column heading 'r'"),
        ("r [um), f [nm]\n0, 0\n1, 50\n2, 200\n", "column heading"),
        ("r [um], f [s]\n0, 0\n1, 50\n2, 200\n", r"'f \[s\]', whose unit has the dimension of a time"),
        ("r [um], f [nm]\n0, 0\n1\n2, 200\n", "1 columns in line 3"),
        ("r [um], f [nm]\n0, 0\n1, x\n2, 200\n", "no two numbers in line 3: '1, x'"),
        ("r [um], f [nm]\n", "a header and two or more points"),
        ("r [um], f [nm]\n0, 0\n1, 50\n2, 20\n", "f"),
    ],
)
def test_bad_profiles(read, tmp_path, text, message):
    (tmp_path / "tip.csv").write_text(text, encoding="utf-8")
    with pytest.raises(CaseError, match=message):
        read(GOOD.replace(INDENTER, '[indenter]\nkind = "radial-profile"\nfile = "tip.csv"\n'))


def test_sliding_layer_and_elastic_base(read):
    base = 'kind = "half-space"\nyoung = "70 GPa"\npoisson = 0.25'
    case = read(GOOD.replace('kind = "rigid"', base).replace("poisson = 0.5", "poisson = 0.5\nbonded = false"))
    assert case.medium == fp.Medium([fp.Layer(5e3, 0.5, 1.2e-6, bonded=False)], base=fp.HalfSpace(70e9, 0.25))


def test_bare_half_spaces(read):
    homogeneous = '[base]\nkind = "half-space"\nyoung = "1 GPa"\npoisson = 0.25\n'
    graded = '[base]\nkind = "power-law-half-space"\nmodulus = "1 GPa"\ndepth = "1 m"\nexponent = 0.5\npoisson = 0.25\n'
    assert read(GOOD.replace(LAYERS, homogeneous)).medium == fp.HalfSpace(1e9, 0.25)
    assert read(GOOD.replace(LAYERS, graded)).medium == PowerLawHalfSpace(1e9, 1.0, 0.5, 0.25)


def test_two_bodies(read):
    two = (
        '[upper]\nbase = { kind = "rigid" }\n[lower]\nbase = { kind = "half-space", young = "1 GPa", poisson = 0.25 }\n'
    )
    assert read(GOOD.replace(LAYERS, two)).medium == TwoBodies(fp.RigidBase(), fp.HalfSpace(1e9, 0.25))


@pytest.mark.parametrize(
    ("young", "expected"),
    [
        ('{ law = "exponential", top = "5 kPa", bottom = "9 kPa" }', ExponentialModulus(5e3, 9e3, 1.2e-6)),
        ('{ law = "power", top = "5 kPa", bottom = "9 kPa", exponent = 2 }', PowerModulus(5e3, 9e3, 1.2e-6, 2.0)),
    ],
)
def test_named_laws(read, young, expected):
    layer = read(GOOD.replace('"5 kPa"', young)).medium.layers[0]
    assert isinstance(layer, GradedLayer)
    assert layer.young(np.array([0.0, 1e-6])) == close(expected(np.array([0.0, 1e-6])))


def test_formulas_and_tables_give_the_same_line(read):
    z = np.linspace(0, 1.2e-6, 7)
    formula = '{ formula = "5 + 2*z", unit = "kPa", depth_unit = "um" }'
    table = '{ depths = ["0 um", "1.2 um"], values = ["5 kPa", "7.4 kPa"] }'
    for young in (formula, table):
        layer = read(GOOD.replace('"5 kPa"', young)).medium.layers[0]
        np.testing.assert_allclose(layer.young_at(z), 5e3 + 2e9 * z, rtol=1e-14)  # a straight line, a few roundings
    graded_poisson = GOOD.replace("poisson = 0.5", 'poisson = { formula = "0.2 + 0.1*z", depth_unit = "um" }')
    np.testing.assert_allclose(read(graded_poisson).medium.layers[0].poisson_at(z), 0.2 + 1e5 * z, rtol=1e-14)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            '"1.2 um"',
            '"5 kPa"',
            r"layers\[0\].thickness = '5 kPa' has the dimension of a pressure; a length such as '1.2 um'",
        ),
        ('"1.2 um"', '"-1.2 um"', r"layers\[0\].thickness = '-1.2 um' must be finite and > 0"),
        ('"1.2 um"', '"0 um"', r"layers\[0\].thickness = '0 um' must be finite and > 0"),
        ('"5 kPa"', '"-5 kPa"', r"layers\[0\].young = '-5 kPa' must be finite and > 0"),
        ("0.5", "0.51", r"layers\[0\].poisson = 0.51 must lie in -1 < poisson <= 0.5"),
        ("0.5", '"0.5"', r"layers\[0\].poisson = '0.5' must be a plain number"),
        ('young = "5 kPa"\n', "", r"layers\[0\].young is missing; it needs a pressure such as '5 kPa'"),
        ("thickness", "thicknes", r"layers\[0\].thicknes is no known field; did you mean 'thickness'\?"),
        ("poisson", "x", r"layers\[0\].x is no known field; known here: young, poisson, thickness, bonded"),
        ('"5 kPa"', '{ formula = "5*y" }', r"layers\[0\].young.formula '5\*y': found 'y' at character 3"),
        (
            '"5 kPa"',
            '{ formula = "1-z", depth_unit = "um" }',
            r"layers\[0\].young = .* at depth z = .* must be finite and > 0",
        ),
        (
            '"5 kPa"',
            '{ law = "cubic", top = "5 kPa", bottom = "9 kPa" }',
            "law = 'cubic' must be 'linear', 'exponential' or",
        ),
        ('"5 kPa"', '{ law = "power", top = "5 kPa", bottom = "9 kPa" }', "exponent belongs to law = 'power'"),
        (
            '"rigid"',
            '"rigd"',
            "base.kind = 'rigd' is unknown; it is one of 'half-space', 'power-law-half-space', 'rigid'",
        ),
        ('kind = "rigid"', "", "base.kind is missing; it is one of 'half-space'"),
        ('[base]\nkind = "rigid"', "", r"give either one body \(\[\[layers\]\] and \[base\]\)"),
        (LAYERS, '[base]\nkind = "rigid"\n', "empty on a rigid base"),
        ("[[layers]]", "[layers]", r"layers must be a list: write \[\[layers\]\]"),
        ("[base]", "[[base]]", r"base must be one table: write \[base\]"),
        ("sides = 4", "sides = 2", "indenter.sides = 2 must be a whole number of at least 3"),
        ("sides = 4", "sides = 4.5", "indenter.sides = 4.5 must be a valid integer"),
        ('"35 deg"', '"95 deg"', "half_opening_angle = '95 deg' must lie between 0 and 90 degrees"),
        (
            'half_opening_angle = "35 deg"',
            'inclination = "95 deg"',
            "inclination = '95 deg' must lie in 0 < inclination",
        ),
        ('"35 deg"', '"35 deg"\ninclination = "55 deg"', "give either inclination .* or half_opening_angle"),
        (INDENTER, "", r"indenter is missing; it needs a table \[indenter\]"),
        (
            INDENTER,
            '[indenter]\nkind = "elliptic-paraboloid"\nA = "1 1/m"\nradius_x = "1 m"\n',
            "either A and B .* or radius_x",
        ),
        (
            INDENTER,
            '[indenter]\nkind = "elliptic-paraboloid"\nradius_x = "1 m"\nradius_y = "-1 m"\n',
            "radius_y = '-1 m' must be",
        ),
        (INDENTER, '[indenter]\nkind = "radial-profile"\nfile = "none.csv"\n', "file = 'none.csv' is not readable"),
        (INDENTER, '[indenter]\nkind = "radial-profile"\n', "give either file .* or both lists r and f"),
        (
            "[control]",
            '[control]\nforce = "1 nN"',
            "exactly one of depth, force and radius must be given, found depth and force",
        ),
        (DEPTH, "", "exactly one of depth, force and radius must be given, found none"),
        ("depth =", "force =", "control.force.start = '1 nm' has the dimension of a length; a force such as"),
        (DEPTH, 'depth = "-1 nm"', "control.depth = '-1 nm' must be finite and >= 0"),
        (DEPTH, "depth = []", "control.depth has shape|depth has shape"),
        ('"1 nm"', '"0 nm"', "control.depth.start = '0 nm' must be finite and > 0. spacing = 'log' has no zero"),
        ("points = 41", "points = 1", "control.depth.points = 1 must be 2 or more"),
        ('"log"', '"lg"', "control.depth.spacing = 'lg' must be 'linear' or 'log'"),
        (
            "[control]",
            '[control]\nmethod = "bem"',
            "control.method is no known field; 'method' belongs at the top of the file",
        ),
        ('title = "gel"', 'method = "magic"', "method = 'magic' is unknown; it is one of 'exact'"),
        ('title = "gel"', "angles = 3", "angles = 3 must be a whole number of at least 8"),
        ('title = "gel"', "title = gel", "not valid TOML"),
        ('"5 kPa"', "5 kPa", 'Write young = "5 kPa", in quotation marks'),
        ('"5 kPa"', "5,3 kPa  # soft", 'Write young = "5.3 kPa", in quotation marks; the decimal sign is a point'),
        ('"5 kPa"', '"5,3 kPa"', "layers.0..young = '5,3 kPa' has a decimal comma; write '5.3 kPa'"),
        ("sides = 4", "sides = 4,0", "Write sides = 4.0; the decimal sign is a point"),
        ("poisson = 0.5", 'poisson = "0,5"', "layers.0..poisson = '0,5' has a decimal comma; write 0.5"),
    ],
)
def test_messages(read, old, new, message):
    assert old in GOOD
    with pytest.raises(CaseError, match=message):
        read(GOOD.replace(old, new, 1))


def test_all_problems_are_listed_with_the_file(read):
    with pytest.raises(CaseError) as caught:
        read(GOOD.replace('"5 kPa"', '"5 um"').replace("sides = 4", "sides = 2"))
    lines = str(caught.value).splitlines()
    assert [line.split(": ")[1].split(" ")[0] for line in lines] == ["layers[0].young", "indenter.sides"]
    assert all("case.toml: " in line for line in lines)


def test_unreadable_files(tmp_path):
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    for path, message in (
        (tmp_path, "not readable"),
        (tmp_path / "no.toml", "No such file"),
        (tmp_path / "binary.toml", "not a text"),
    ):
        with pytest.raises(CaseError, match=message):
            read_case(path)


@pytest.mark.long
def test_shipped_cases_are_read_and_described():
    cases = shipped_cases()
    assert len(cases) >= 3
    for path in cases:
        case = read_case(path)
        lines = list(describe(case))
        assert lines[0].endswith(case.title)
        assert any(line.startswith("Indenter") for line in lines)


def test_description_of_a_case(read):
    lines = list(describe(read(GOOD)))
    assert "Body      Layer young 5 kPa, poisson 0.5, thickness 1.2 µm, bonded to the base" in lines
    assert "Indenter  Pyramid sides 4, inclination 55 deg" in lines
    assert "Control   depth, 41 steps from 1 nm to 400 nm" in lines


@pytest.mark.long
def test_check_says_that_steep_gradings_take_longer(read):
    # the power 0.1 is infinitely steep at the surface: 256 terms, 8 s for a first contact
    law = '{ law = "power", top = "375 GPa", bottom = "279 GPa", exponent = EXPONENT }'
    takes = {}
    for exponent in ("2", "0.1"):
        text = GOOD.replace('"5 kPa"', law.replace("EXPONENT", exponent)).replace(
            "title", "method = 'second-order'\ntitle"
        )
        lines = list(describe(read(text)))
        takes[exponent] = next(line.partition(";")[0] for line in lines if line.startswith("Takes"))
    assert takes["2"].endswith("about a second")
    assert takes["0.1"].endswith("some seconds")


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("elliptic_tip_on_graded_nitride", "about a second; its stresses about a minute"),
        ("knee_insert_sliding_on_tray", "about a second; its stresses some seconds"),
        ("coating_for_a_stiffness", "Design    1 number varied from 4 starts, about a second"),
    ],
)
def test_times_of_stresses_and_designs_are_described(name, line):
    (path,) = [each for each in shipped_cases() if each.stem == name]
    assert line in "\n".join(describe(read_case(path)))


@pytest.mark.parametrize(
    ("indenter", "message"),
    [
        (
            "kind = 'radial-profile', r = ['0 um', '1 um', '2 um'], f = ['0 nm', '9 nm', '1 nm']",
            r"indenter\.f\[2\] = '1 nm' after indenter",
        ),
        (
            "kind = 'radial-profile', r = ['0 um', '1 um', '2 um'], f = ['0 nm', '1 nm', '9 nm'], kinks = ['9 um']",
            "indenter.kinks contains",
        ),
        (
            "kind = 'power-law', exponent = 2, radius = '1 um', height = '1 nm', angles = ['0 deg', '9 deg', '90 deg'], "
            "factors = [1.0, 1.1, 1.2], "
            "corners = ['5 deg']",
            "indenter.corners contains",
        ),
    ],
)
def test_messages_of_objects_name_the_keys_of_the_file(tmp_path, indenter, message):
    path = tmp_path / "case.toml"
    path.write_text(
        f"base = {{ kind = 'rigid' }}\nindenter = {{ {indenter} }}\ncontrol = {{ depth = '1 nm' }}\n", encoding="utf-8"
    )
    with pytest.raises(CaseError, match=message) as caught:
        read_case(path)
    assert "RadialProfile" not in str(caught.value)
    assert "PowerLaw" not in str(caught.value)
