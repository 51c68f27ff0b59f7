"""[slip] of case files, `flatpunch check` and `flatpunch slip`."""

import numpy as np
import pytest
from typer.testing import CliRunner

import flatpunch as fp
from flatpunch.cli.app import app
from flatpunch.files import CaseError, describe, load, read_case, shipped_cases
from flatpunch.files.analyses import slipping
from flatpunch.literature import cite

BODY = """
title = "Gel"
[[layers]]
young = "5 MPa"
poisson = 0.4
thickness = "20 um"
[base]
kind = "half-space"
young = "1 MPa"
poisson = 0.3
"""
TIP = '[indenter]\nkind = "sphere"\nradius = "100 um"\n'
DEPTHS = '[control]\ndepth = ["1 um", "3 um"]\n'
CASE = BODY + TIP + DEPTHS


def written(tmp_path, text):
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("seed", range(6))
def test_random_cases_are_those_of_python(tmp_path, seed):
    """Half-spaces, films and pairs under two tips, each quantity along the surface, to the last bit."""
    random = np.random.default_rng(seed)
    young = float(10 ** random.uniform(3, 6))
    poisson, thickness, friction, depth = random.uniform([0, 5, 0.1, 1], [0.5, 40, 1, 5]).tolist()
    half_space = f'base = {{ kind = "half-space", young = "{young!r} kPa", poisson = {poisson!r} }}\n'
    film = f'layers = [{{ young = "5 MPa", poisson = 0.4, thickness = "{thickness!r} um" }}]\n'
    base, layer = fp.HalfSpace(float(f"{young!r}e3"), poisson), fp.Layer(5e6, 0.4, float(f"{thickness!r}e-6"))
    text, medium = (
        (half_space, base),
        (film + half_space, fp.Medium([layer], base)),
        (f"[upper]\n{half_space}[lower]\n{film}{half_space}", fp.TwoBodies(base, fp.Medium([layer], base))),
    )[seed % 3]
    tip, indenter = (
        ('{ kind = "sphere", radius = "0.1 mm" }', fp.Sphere(1e-4)),
        ('{ kind = "cone", inclination = "0.35 rad" }', fp.Cone(0.35)),
    )[seed % 2]
    kinds = (
        ("stick_radius", "um", 1, "e-6"),
        ("displacement", "nm", 300, "e-9"),
        ("tangential_force", "nN", 300, "e-9"),
    )
    along, unit, most, power = kinds[seed // 2 % 3]
    given = [0.0, *random.uniform(0, most, 2).tolist()]
    slip = f"[slip]\nfriction = {friction!r}\n{along} = {[f'{each!r} {unit}' for each in given]}\n"
    head = f'indenter = {tip}\ncontrol = {{ depth = ["0.1 um", "{depth!r} um"] }}\n'
    found = slipping(read_case(written(tmp_path, head + text + slip)))
    wanted = [float(f"{each!r}{power}") for each in given]
    same = fp.partial_slip(medium, indenter, friction=friction, depth=float(f"{depth!r}e-6"), **{along: wanted})
    assert found.identical(same)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[slip]\n", "slip.friction is missing; it needs a number such as 0.3"),
        ("[slip]\nfriction = 0\n", "slip.friction = 0 must be finite and > 0. It is the coefficient of friction."),
        ("[slip]\nfriction = '0.3'\n", "slip.friction = '0.3' must be a plain number"),
        (
            "[slip]\nfriction = 0.3\nforce = '1 N'\n",
            "slip.force is no known field; known here: friction, tangential_force, stick_radius",
        ),
        ("[slip]\nfriction = 0.3\ndisplacement = 5\n", "slip.displacement = 5 has no unit; a length such as"),
        ("[slip]\nfriction = 0.3\ndisplacement = '5 N'\n", "slip.displacement = '5 N' has the dimension of a force"),
        ("[slip]\nfriction = 0.3\ndisplacement = ['1 nm', '-2 nm']\n", "slip.displacement[1] = '-2 nm' must be"),
        (
            "[slip]\nfriction = 0.3\ntangential_force = { start = '0 N', stop = '1 N', points = 1 }\n",
            "points = 1 must be 2",
        ),
        ("[slip]\nfriction = 0.3\ndisplacement = '1 nm'\nstick_radius = '1 nm'\n", "stick_radius and displacement."),
        ("[[slip]]\nfriction = 0.3\n", "slip: must be a table with the fields friction"),
    ],
)
def test_bad_tables(tmp_path, text, words):
    with pytest.raises(CaseError) as caught:
        read_case(written(tmp_path, CASE + text))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BODY.replace("[base]", "bonded = false\n[base]") + TIP + DEPTHS, "slides without friction on what lies below"),
        (BODY + TIP.replace("sphere", "cylinder") + DEPTHS, "indenter = Cylinder has a flat end"),
        (BODY + '[indenter]\nkind = "berkovich"\n' + DEPTHS, "is not round: partial slip is solved under round tips"),
        ("work_of_adhesion = '50 mJ/m^2'\n" + CASE, "[slip] and work_of_adhesion do not go together"),
        (
            BODY + TIP + "[history]\ntime = ['0 s', '1 s']\ndepth = ['0 um', '1 um']\n"
            "[relaxation]\nkind = 'power-law'\nexponent = 0.2\ntime = '1 s'\n",
            "[slip] and [history] do not go together",
        ),
        (CASE + "[material]\nfinite_strain = 'neo-hookean'\n", "finite_strain does not go with slip"),
        (BODY.replace("[base]", "lifts_off = true\n[base]") + TIP + DEPTHS, "slip"),
    ],
    ids=["nothing holds it", "flat", "pyramid", "adhesion", "history", "large strain", "lifts off"],
)
def test_cases_without_partial_slip_are_refused_when_they_are_read(tmp_path, text, words):
    with pytest.raises(CaseError) as caught:
        read_case(written(tmp_path, text + "[slip]\nfriction = 0.3\n"))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("", 'the case has no table [slip]; write one with the coefficient of friction, "friction = 0.3"'),
        (
            "tangential_force = ['1 nN', '9 N']\n",
            "slip.tangential_force[1] = 9 N exceeds friction times the normal force",
        ),
        ("stick_radius = '1 mm'\n", "slip.stick_radius[0] = 1 mm exceeds the radius of the contact"),
    ],
)
def test_what_no_contact_bears_is_refused_by_its_place(tmp_path, table, words):
    case = written(tmp_path, CASE + ("[slip]\nfriction = 0.3\n" if table else "") + table)
    done = CliRunner().invoke(app, ["slip", str(case), "-o", str(tmp_path / "x.nc")])
    assert done.exit_code == 2
    assert words in " ".join(done.output.split())
    assert not (tmp_path / "x.nc").exists()


def test_a_table_without_steps_goes_from_stick_to_sliding(tmp_path):
    case = read_case(written(tmp_path, CASE + "[slip]\nfriction = 0.3\n"))
    found = slipping(case)
    assert float(found.depth[0]) == pytest.approx(3e-6, rel=1e-12)
    assert float(found.stick_radius[0]) == pytest.approx(float(found.radius[0]), rel=1e-12)
    assert float(found.tangential_force[-1]) == pytest.approx(0.3 * float(found.force[-1]), rel=1e-12)
    assert bool((np.diff(found.displacement) > 0).all())
    assert (
        list(describe(case))[-1] == "Slip      friction 0.3, at the last step, from full stick until the contact slides"
    )


def test_the_last_step_may_have_no_contact(tmp_path):
    case = read_case(written(tmp_path, BODY + TIP + "[control]\nforce = '0 N'\n[slip]\nfriction = 0.3\n"))
    assert float(abs(slipping(case).displacement).max()) == 0


def test_other_commands_leave_the_table_to_this_one(tmp_path):
    """`solve` has the same curve with and without it."""
    plain, with_slip = (
        CliRunner().invoke(app, ["solve", str(written(tmp_path, CASE + table))], env={"COLUMNS": "200"})
        for table in ("", "[slip]\nfriction = 0.3\n")
    )
    assert plain.exit_code == 0
    assert plain.output == with_slip.output


def test_studies_refuse_what_changes_no_normal_contact(tmp_path):
    with pytest.raises(ValueError, match=r"slip\.friction changes no normal contact"):
        fp.sweep(written(tmp_path, CASE + "[slip]\nfriction = 0.3\n"), {"slip.friction": "0.1,0.2"}, workers=1)


@pytest.mark.long
def test_the_command_prints_and_writes(tmp_path):
    (source,) = (path for path in shipped_cases() if path.stem == "sphere_fretting_on_coating")
    targets = [tmp_path / name for name in ("x.nc", "x.csv", "x.png")]
    for target in targets[:2]:
        more = ["--plot", str(targets[2])] if target.suffix == ".nc" else []
        done = CliRunner().invoke(app, ["slip", str(source), "-o", str(target), *more], env={"COLUMNS": "80"})
        assert done.exit_code == 0, done.output
    assert targets[2].stat().st_size > 10000
    found, table = load(targets[0]), load(targets[1])
    assert found.identical(table)
    assert found.identical(slipping(read_case(source)))
    assert "10 of 41 steps, friction 0.4, normal force 5 N, contact radius 51.83 µm" in done.output
    assert "displacement" in done.output
    assert "…" not in done.output
    assert "Mindlin" in cite(found).text
    for wrong in (["-o", "x.txt"], ["--plot", "x.gif"], ["-o", str(source.with_suffix(".toml"))]):
        assert CliRunner().invoke(app, ["slip", str(source), *wrong]).exit_code == 2
